"""What columns a result file is expected to have."""

from collections.abc import Sequence
from dataclasses import dataclass

LEFT_OUT = ("-", "skip")
"""What `--columns` has in place of the name of a column that is not used."""

OPTION, ARGUMENT = "--columns", "columns="
"""How the columns are told, on the command line and in Python."""


@dataclass(frozen=True, slots=True)
class Expected:
    """The columns of a reference with so many maneuvers, or those that were told.

    Attributes
    ----------
    count
        Number of maneuvers of the reference.
    names : tuple of str or None
        What the columns are, whatever the file says; None if it is to be seen from the file.
    option
        How the user tells these, `OPTION` or `ARGUMENT`.
    """

    count: int
    names: tuple[str, ...] | None = None
    option: str = OPTION

    @property
    def widths(self) -> tuple[int, ...]:
        """Numbers of columns that mean something without names."""
        if self.names is not None:
            return (len(self.names),)
        return tuple(sorted({9, 1 + 8 * self.count}))

    @property
    def in_words(self) -> str:
        """The numbers of columns, for a message."""
        return widths_in_words(self.widths)


def how_to_tell(option: str) -> str:
    """What to say where names are not understood."""
    said = '"time,roll_angle,..."' if option == ARGUMENT else " time,roll_angle,..."
    return f"{option}{said} tells what they are"


def widths_in_words(widths: Sequence[int]) -> str:
    """Numbers of columns for a message."""
    return " or ".join(str(n) for n in widths)


def wrong_width(width: int, rows: int, expected: Expected) -> str:
    """What to say of columns without names of which there are too many or too few."""
    found = f"found {width} columns, expected {expected.in_words}"
    if expected.names is not None:
        return f'{found} as {expected.option} tells; there "-" stands for one that is left out'
    names = "a line of column names such as time, roll_angle, roll_rate"
    return f"{found}, or {names}{what_may_be_wrong(width, rows, expected.widths)}"


def what_may_be_wrong(width: int, rows: int, widths: Sequence[int]) -> str:
    """The likely reason for another number of columns, to be put behind a message; or nothing."""
    if width + 1 in widths:
        return "; is the time missing?"
    if rows + 1 in widths:
        return f"; are the {rows} rows columns, and is the time missing?"
    if rows in widths:
        return f"; are the {rows} rows columns? the first does not ascend as times do"
    return ""
