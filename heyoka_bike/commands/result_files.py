"""Read result files, and parse the command-line options about them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import InputError, printable, quoted
from heyoka_bike.system.console import notice_if_slow, patience

if TYPE_CHECKING:
    from heyoka_bike.reference.load import Reference
    from heyoka_bike.scoring.diagnosis.budget import Budget
    from heyoka_bike.scoring.reading.results import Results

STANDARD_INPUT = "-"

_BYTES_OF_LONG_FILE = 20_000_000  # [bytes], size from which a spinner is shown while a file is read
# Waiting time after which a notice is printed [s]: a pipe that nobody writes to looks like a hang.
_SECONDS_OF_SILENCE = 5.0


def maneuvers_of(text: str | None, count: int, reference: Reference) -> Sequence[int | None]:
    """Return the maneuver of each file that ``--maneuver`` states; None without the option."""
    if text is None:
        return [None] * count
    parts = text.split(",")
    for part in parts:
        if not (part.isascii() and part.isdigit() and int(part[:9]) in reference):
            raise InputError(f"--maneuver: found '{part:.40}', expected 1 to {len(reference)}")
    if len(parts) not in (1, count):
        from heyoka_bike.scoring.evidence.words import counted

        raise InputError(
            f"--maneuver: found {counted(len(parts), 'number')} for {counted(count, 'file')}, "
            "expected one for each file"
        )
    return [int(part) for part in parts] * (count if len(parts) == 1 else 1)


def parse_max_bytes(text: str) -> int:
    """Parse the value of ``--max-bytes``.

    Raises
    ------
    InputError
        The text is not a whole number above zero.
    """
    if not (text.isascii() and text.isdigit() and int(text)):
        raise InputError(f"--max-bytes: found {text:.40}, expected a whole number above zero")
    return int(text)


def parse_budget(text: str | None, is_thorough: bool) -> Budget:
    """Return the budget of a diagnosis from the values of ``--budget`` and ``--thorough``.

    Raises
    ------
    InputError
        The text is not a number above zero.
    """
    from heyoka_bike.numbers.exact import positive_numbers
    from heyoka_bike.scoring.diagnosis.budget import Budget

    if text is None:
        return Budget(is_thorough=is_thorough)
    seconds, *more = positive_numbers("--budget", text)
    if more:
        raise InputError(f"--budget: found {quoted(text)}, expected one number")
    return Budget(seconds, is_thorough=is_thorough)


def _waiting(file: str) -> AbstractContextManager[Any]:
    """Return a context that shows a notice while a long file or a pipe is read."""
    if os.path.isfile(file):
        is_long = os.path.getsize(file) > _BYTES_OF_LONG_FILE
        return patience(f"reading {file}") if is_long else nullcontext()
    what = "standard input" if file == STANDARD_INPUT else printable(file)
    return notice_if_slow(
        _SECONDS_OF_SILENCE, f"heyoka-bike: still reading {what}, waiting for its end"
    )


def read(
    file: str, maneuver: int | None, reference: Reference, columns: str | None = None,
    max_bytes: str | None = None,
) -> Results:  # fmt: skip
    """Read a result file, with a notice on the terminal if that takes long."""
    from heyoka_bike.scoring.reading.request import MOST_UNPACKED
    from heyoka_bike.scoring.reading.source import read_results

    with _waiting(file):
        names = None if columns is None else columns.split(",")
        results = read_results(
            file, maneuver=maneuver, count=len(reference), columns=names,
            max_bytes=MOST_UNPACKED if max_bytes is None else parse_max_bytes(max_bytes),
        )  # fmt: skip
    held = [rows.maneuver for rows in results.maneuvers]
    if maneuver is not None and held != [maneuver]:
        shown = f"maneuver{'s' if len(held) > 1 else ''} {', '.join(map(str, held))}"
        raise InputError(
            f"--maneuver {maneuver} does not fit: the file contains {shown}. The option "
            "is only for files of a single maneuver",
            file=file,
        )
    return results
