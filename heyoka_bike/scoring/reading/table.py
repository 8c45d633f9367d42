"""Columns of the same length as they were read: what every format is read as."""

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
    """A column as it was read.

    Attributes
    ----------
    values : ndarray, shape (n,)
    lo : ndarray, shape (n,) or None
        The rest beyond binary64; None if there is none.
    quantum : Quantum
    digits : int or None
        Significant decimal digits, None if the values do not tell.
    significant : int or None
        The most digits of a number of a text; 0 for binary numbers, None for hi + lo that is exact
        already.
    """

    values: Array
    lo: Array | None
    quantum: Quantum
    digits: int | None
    significant: int | None = 0

    def of_rows(self, rows: NDArray[np.bool_]) -> ReadColumn:
        """The values of some of the rows."""
        lo = None if self.lo is None else self.lo[rows]
        return replace(self, values=self.values[rows], lo=lo)


@dataclass(frozen=True, eq=False, slots=True)
class ReadTable:
    """Columns of the same length, by name where they have names: what every format is read as.

    Attributes
    ----------
    columns : list of ReadColumn
    names : list of str or None
        Of the columns, if they have any.
    lines : ndarray of int, shape (n,), or None
        Number of each row's line in a text, from 1.
    heading : int or None
        Number of the line of the names in a text.
    is_ordered : bool
        True if the place of a column means anything.
    maneuver : int or None
        What the file itself says about these columns.
    commented : int or None
        The only maneuver that comments above them speak of.
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
        """The headings of the columns, as the user or the file has them; empty without any."""
        return [parse_heading(name) for name in request.names or self.names or ()]

    def place(self, row: int) -> tuple[str, int]:
        """Return the word that rows are counted by, ``row`` or ``line``, and the number of one."""
        return ("row", row + 1) if self.lines is None else ("line", int(self.lines[row]))

    def error(
        self, request: Request, row: int, message: str, column: int | None = None
    ) -> InputError:
        """The error that says in which row, what was found and what was expected."""
        counted_by, number = self.place(row)
        if counted_by == "line":
            return request.error(message, number, column)
        return request.error(f"row {number}: {message}")

    def of_rows(self, rows: NDArray[np.bool_], maneuver: int | None) -> ReadTable:
        """The rows that are of this maneuver."""
        columns = [column.of_rows(rows) for column in self.columns]
        lines = None if self.lines is None else self.lines[rows]
        return replace(self, columns=columns, lines=lines, maneuver=maneuver)
