"""A request to read a file: what its columns may be, and how an error says where it is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from numbers import Integral
from typing import Any
from warnings import catch_warnings, simplefilter

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import BicycleError, InputError, printable, quoted

LEFT_OUT = ("-", "skip")
"""Words of `--columns` for a column that is not used."""

MOST_UNPACKED = 500_000_000
"""Bytes that a packed file may unpack to, unless more are allowed: a million rows of 25 numbers."""

OPTION, ARGUMENT = "--columns", "columns="
"""Ways to tell the columns: on the command line, and in Python."""

NAMES = ", ".join(("time", *BENCHMARK_COLUMNS))
"""The names of the benchmark's columns, for messages."""


@dataclass(frozen=True, slots=True)
class Request:
    """A file or arrays to read, for a reference of so many maneuvers.

    Attributes
    ----------
    path
        Name of the file, for errors.
    count
        Number of maneuvers of the reference.
    maneuver
        Number of the maneuver of columns that do not tell; None if that is not known.
    names : tuple of str or None
        What the columns are, whatever the file says; None if it is to be seen from the file.
    option
        How the user tells these, `OPTION` or `ARGUMENT`.
    part
        What messages begin with: of which part of the file they speak.
    known : callable or None
        True for the names of columns in a table without times; None of results.
    group
        Number of the maneuver that this part of the file is of; None if it tells of none.
    is_ordered
        True if the order of arrays by name means anything.
    most_bytes
        What a packed file may unpack to.
    """

    path: str
    count: int
    maneuver: int | None = None
    names: tuple[str, ...] | None = None
    option: str = OPTION
    part: str = ""
    known: Callable[[str], bool] | None = None
    group: int | None = None
    is_ordered: bool = True
    most_bytes: int = MOST_UNPACKED

    def within(self, part: str) -> Request:
        """The request for a part of the file; for all of it if that has no name."""
        return replace(self, part=f"{self.part}{part}: ") if part else self

    def of_maneuver(self, number: int) -> Request:
        """The request for the part of the file that is of one maneuver."""
        return replace(self.within(f"maneuver {number}"), count=1, group=number)

    def error(self, message: str, line: int | None = None, column: int | None = None) -> InputError:
        """The error that says where, what was found and what was expected."""
        return InputError(f"{self.part}{message}", file=self.path, line=line, column=column)

    @contextmanager
    def damage(self, expected: str) -> Iterator[None]:
        """Turn what libraries raise for damaged files, which may be anything, into an error."""
        try:
            with catch_warnings():
                simplefilter("ignore")
                yield
        except (BicycleError, ImportError):
            raise
        except Exception as e:
            said = re.sub(r" at 0x[0-9a-f]+", "", " ".join(str(e).split()))
            reason = printable(said)[:100] or type(e).__name__
            if "unable to lock" in said or "already open" in said:
                raise self.error(
                    f"found a file that another program has open ({reason}), expected one that is "
                    "closed"
                ) from None
            raise self.error(f"found a damaged file ({reason}), expected {expected}") from None

    @property
    def widths(self) -> tuple[int, ...]:
        """Numbers of columns that mean something without names."""
        if self.known is not None:
            return ()
        if self.names is not None:
            return (len(self.names),)
        return tuple(sorted({9, 1 + 8 * self.count}))

    @property
    def columns_hint(self) -> str:
        """The words on what to do where names are not understood."""
        said = '"time,roll_angle,..."' if self.option == ARGUMENT else " time,roll_angle,..."
        return f"{self.option}{said} tells what they are"

    def by_name(self, members: Iterable[tuple[str, Any]]) -> dict[str, Any]:
        """Members by their names, of which each is there once.

        Raises
        ------
        InputError
            A name is there twice: no one of them is meant more than the other.
        """
        found: dict[str, Any] = {}
        for name, x in members:
            if name in found:
                raise self.error(f"found {quoted(name)} twice, expected each name once")
            found[name] = x
        return found

    def too_long(self, unpacked: int | None = None) -> InputError:
        """The error for a file that unpacks to too many bytes, so many if that is known."""
        allowed = "max_bytes=" if self.option == ARGUMENT else "--max-bytes "
        found = (
            f"{unpacked} bytes packed" if unpacked else f"more than {self.most_bytes} bytes packed"
        )
        return self.error(
            f"found {found}, expected at most {self.most_bytes}; {allowed}N allows more"
        )

    def not_columns(
        self, found: str, line: int | None = None, column: int | None = None
    ) -> InputError:
        """The error that says what there is in the place of columns, and which were expected."""
        widths = " or ".join(map(str, self.widths))
        said = f"{widths} columns, or columns named {NAMES}; {self.columns_hint}"
        if self.known is not None:
            said = "columns by name"
        elif self.names is not None:
            said = f'{len(self.names)} as {self.option} tells; there "-" stands for one left out'
        return self.error(f"found {found}, expected {said}", line, column)

    def wrong_width(self, width: int, rows: int, line: int | None = None) -> InputError:
        """The error for columns without names of which there are too many or too few."""
        likely, widths = "", self.widths if self.names is None else ()
        if width + 1 in widths:
            likely = " (is the time missing?)"
        elif rows + 1 in widths:
            likely = f" (are the {rows} rows columns, and is the time missing?)"
        elif rows in widths:
            likely = f" (are the {rows} rows columns? the first does not ascend as times do)"
        return self.not_columns(f"{width} columns{likely}", line)


def maneuver_number(maneuver: Any, count: int) -> int:
    """The number of a maneuver, from 1 to `count`.

    Raises
    ------
    InputError
        It is none.
    """
    is_number = isinstance(maneuver, Integral) and not isinstance(maneuver, bool)
    if not (is_number and 1 <= maneuver <= count):
        raise InputError(f"found maneuver {maneuver!r:.40}, expected 1 to {count}")
    return int(maneuver)
