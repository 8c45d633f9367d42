"""A request to read a file: the names that its columns may have, and the place for errors."""

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
"""Default limit on the size of an unpacked file [bytes]: a million rows of 25 numbers."""

OPTION, ARGUMENT = "--columns", "columns="
"""How a user names the columns: on the command line, and in Python."""

NAMES = ", ".join(("time", *BENCHMARK_COLUMNS))
"""The names of the benchmark's columns, for messages."""


@dataclass(frozen=True, slots=True)
class Request:
    """A request to read a file or arrays that contain results for `count` maneuvers.

    Attributes
    ----------
    path
        Name of the file, for errors.
    count
        Number of maneuvers of the reference.
    maneuver
        Number of the maneuver of columns that do not name one; None if unknown.
    names : tuple of str or None
        Names of the columns, which override those in the file; None to use those in the file.
    option
        How the user gives these names, `OPTION` or `ARGUMENT`.
    part
        Beginning of messages: the part of the file that they are about.
    known : callable or None
        True for the names of columns in a table without times; None for results.
    group
        Number of the maneuver of this part of the file; None if the part does not name one.
    is_ordered
        True if the order of named arrays is meaningful.
    most_bytes
        Largest size of an unpacked file [bytes].
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
        """Return the request for a part of the file; the same request if the part has no name."""
        return replace(self, part=f"{self.part}{part}: ") if part else self

    def of_maneuver(self, number: int) -> Request:
        """Return the request for a part of the file that contains only this maneuver."""
        return replace(self.within(f"maneuver {number}"), count=1, group=number)

    def error(self, message: str, line: int | None = None, column: int | None = None) -> InputError:
        """Return an error whose message begins with the file and the part of the file."""
        return InputError(f"{self.part}{message}", file=self.path, line=line, column=column)

    @contextmanager
    def damage(self, expected: str) -> Iterator[None]:
        """Convert any exception that a library raises for a damaged file into an `InputError`."""
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
        """The numbers of columns for which the columns need no names."""
        if self.known is not None:
            return ()
        if self.names is not None:
            return (len(self.names),)
        return tuple(sorted({9, 1 + 8 * self.count}))

    @property
    def columns_hint(self) -> str:
        """The end of a message about unknown names, with the option that names the columns."""
        said = '"time,roll_angle,..."' if self.option == ARGUMENT else " time,roll_angle,..."
        return f"to name the columns, use {self.option}{said}"

    def by_name(self, members: Iterable[tuple[str, Any]]) -> dict[str, Any]:
        """Return pairs of a name and an object as a mapping; raise an error if a name occurs twice.

        Raises
        ------
        InputError
            A name occurs twice.
        """
        found: dict[str, Any] = {}
        for name, x in members:
            if name in found:
                raise self.error(f"found {quoted(name)} twice, expected each name once")
            found[name] = x
        return found

    def too_long(self, unpacked: int | None = None) -> InputError:
        """Return the error for a file that is too large after unpacking."""
        allowed = "max_bytes=" if self.option == ARGUMENT else "--max-bytes "
        found = f"{unpacked} bytes" if unpacked else f"more than {self.most_bytes} bytes"
        return self.error(
            f"found {found} after unpacking, expected at most {self.most_bytes}; "
            f"{allowed}N allows more"
        )

    def not_columns(
        self, found: str, line: int | None = None, column: int | None = None
    ) -> InputError:
        """Return the error that other contents than the expected columns were found."""
        widths = " or ".join(map(str, self.widths))
        said = f"{widths} columns, or columns named {NAMES}; {self.columns_hint}"
        if self.known is not None:
            said = "columns by name"
        elif self.names is not None:
            said = f'{len(self.names)} columns as in {self.option} (use "-" to skip a column)'
        return self.error(f"found {found}, expected {said}", line, column)

    def wrong_width(self, width: int, rows: int, line: int | None = None) -> InputError:
        """Return the error that columns without names are too many or too few."""
        likely, widths = "", self.widths if self.names is None else ()
        if width + 1 in widths:
            likely = " (is the time missing?)"
        elif rows + 1 in widths:
            likely = f" (are the {rows} rows columns, and is the time missing?)"
        elif rows in widths:
            likely = f" (are the {rows} rows columns? the first does not ascend as times do)"
        return self.not_columns(f"{width} columns{likely}", line)


def maneuver_number(maneuver: Any, count: int) -> int:
    """Return the number of a maneuver as an integer after checking that it is from 1 to `count`.

    Raises
    ------
    InputError
        The number is not an integer from 1 to `count`.
    """
    is_number = isinstance(maneuver, Integral) and not isinstance(maneuver, bool)
    if not (is_number and 1 <= maneuver <= count):
        raise InputError(f"found maneuver {maneuver!r:.40}, expected 1 to {count}")
    return int(maneuver)
