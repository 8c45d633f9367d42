"""Tables: the common form in which all formats are read, with columns of the same length."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.reading.names.heading import Heading, parse_heading
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.results import Quantum


@dataclass(frozen=True, eq=False, slots=True)
class ReadColumn:
    """A column as it was read, with its resolution.

    Attributes
    ----------
    values : ndarray, shape (n,)
    lo : ndarray, shape (n,) or None
        The low parts of values with more digits than binary64; None if there are none.
    quantum : Quantum
    digits : int or None
        Significant decimal digits; None if the values do not show them.
    significant : int or None
        Largest number of significant digits in a text; 0 for binary numbers, None if hi + lo is
        already exact.
    """

    values: Array
    lo: Array | None
    quantum: Quantum
    digits: int | None
    significant: int | None = 0

    def of_rows(self, rows: NDArray[np.bool_]) -> ReadColumn:
        """Return the column with some of its rows."""
        lo = None if self.lo is None else self.lo[rows]
        return replace(self, values=self.values[rows], lo=lo)


@dataclass(frozen=True, eq=False, slots=True)
class ReadTable:
    """Columns of the same length, with their names if they have any.

    Attributes
    ----------
    columns : list of ReadColumn
    names : list of str or None
        Names of the columns; None if they have none.
    lines : ndarray of int, shape (n,), or None
        Line number of each row in a text, from 1.
    heading : int or None
        Line number of the names in a text.
    is_ordered : bool
        True if the order of the columns is meaningful.
    maneuver : int or None
        Number of the maneuver that the file gives for these columns.
    commented : int or None
        Number of the maneuver in the comments above the table, if they name only one.
    seen : tuple of Evidence
    """

    columns: list[ReadColumn]
    names: list[str] | None = None
    lines: NDArray[np.int64] | None = None
    heading: int | None = None
    is_ordered: bool = True
    maneuver: int | None = None
    commented: int | None = None
    seen: tuple[Evidence, ...] = ()

    def headings(self, request: Request) -> list[Heading]:
        """Return the headings that the user gave, or else those in the file; empty without any."""
        return [parse_heading(name) for name in request.names or self.names or ()]

    def place(self, row: int) -> tuple[str, int]:
        """Return the word ``row`` or ``line`` for messages, and the number of this row."""
        return ("row", row + 1) if self.lines is None else ("line", int(self.lines[row]))

    def error(
        self, request: Request, row: int, message: str, column: int | None = None
    ) -> InputError:
        """Return an error whose message begins with the place of the row."""
        counted_by, number = self.place(row)
        if counted_by == "line":
            return request.error(message, number, column)
        return request.error(f"row {number}: {message}")

    def of_rows(self, rows: NDArray[np.bool_], maneuver: int | None) -> ReadTable:
        """Return the table with some of its rows, and with this maneuver number."""
        columns = [column.of_rows(rows) for column in self.columns]
        lines = None if self.lines is None else self.lines[rows]
        return replace(self, columns=columns, lines=lines, maneuver=maneuver)
