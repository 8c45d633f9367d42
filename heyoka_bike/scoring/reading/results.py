"""Another program's results, as its file gives them, and the columns that they are made of."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.display import shown_by
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence import Evidence
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.reading.request import Request


@dataclass(frozen=True, slots=True)
class Quantum:
    """The resolution of a column: how finely its values are written.

    Attributes
    ----------
    base
        10 for decimal digits, 2 for binary ones.
    digits
        Significant digits in that base; None if the number of places after the point is fixed.
    places
        Digits after the point, if that is fixed.
    step
        Of which the numbers are multiples, if it is not 1.
    """

    base: int
    digits: int | None = None
    places: int | None = None
    step: float = 1.0

    def at(self, values: Array) -> Array:
        """Distance of neighbouring written numbers at each of the values, in their unit."""
        if self.digits is None:
            assert self.places is not None
            return np.full(np.shape(values), self.step * float(self.base) ** -self.places)
        size = np.abs(np.nan_to_num(values, posinf=0.0, neginf=0.0))
        smallest = np.finfo(np.float64).tiny
        exponent = np.floor(np.log(np.maximum(size, smallest)) / np.log(self.base))
        # The logarithm may be a last digit short of an integer.
        exponent += np.power(float(self.base), exponent + 1) <= size
        spacing = np.power(float(self.base), exponent - self.digits + 1)
        return np.where(size < smallest, 0.0, spacing)


@dataclass(frozen=True, eq=False, repr=False)
class Rows:
    """Columns of one maneuver, as written: nothing converted, no definition assumed.

    Attributes
    ----------
    maneuver
        Number of the maneuver from 1, None if the file does not tell.
    time, time_lo : ndarray, shape (n,)
        Times [s] in ascending order, hi + lo; a written decimal is kept exactly (to 32 digits).
    values : mapping of str to ndarray, shape (n,)
        By key of `columns.COMPARED`; any of them may be absent. A number that is missing
        or not finite is NaN.
    lo : mapping of str to ndarray, shape (n,)
        The rest beyond binary64, for columns with more digits than that.
    quantum : mapping of str to Quantum
        How finely each column is written, ``time`` included.
    units : mapping of str to str
        The unit that the heading of a column names, as `units` has it, where it names one.
    may_be : mapping of str to tuple of str
        All keys that a column may have, this one among them, where its name means several.
    """

    maneuver: int | None
    time: Array
    time_lo: Array
    values: Mapping[str, Array]
    lo: Mapping[str, Array] = field(default_factory=dict)
    quantum: Mapping[str, Quantum] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    may_be: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def only(self, keys: Collection[str]) -> Self:
        """The same rows with the values of these columns alone."""
        return replace(self, values={key: x for key, x in self.values.items() if key in keys})

    def at(self, rows: slice | NDArray[Any]) -> Self:
        """Some of the rows, by a mask or by their indices."""
        values, lo = ({k: x[rows] for k, x in of.items()} for of in (self.values, self.lo))
        return replace(self, time=self.time[rows], time_lo=self.time_lo[rows], values=values, lo=lo)

    def __repr__(self) -> str:
        what = "unknown maneuver" if self.maneuver is None else f"maneuver {self.maneuver}"
        return f"<{what}: {len(self.time)} rows of {', '.join(self.values)}>"


@dataclass(frozen=True, eq=False, repr=False)
class Results:
    """A result file.

    Attributes
    ----------
    path
        Name of the file (``-`` for standard input).
    format
        What it was: a name of `formats.FORMATS`, such as ``text``, or ``array``.
    maneuvers : tuple of Rows
    significant_digits
        Of the column written with the fewest, in decimal digits; None if unknown.
    seen : tuple of Evidence
        How it was read, where that is not as usual.
    """

    path: str
    format: str
    maneuvers: tuple[Rows, ...]
    significant_digits: int | None = None
    seen: tuple[Evidence, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """How it was read, in words, with the numbers behind it."""
        found: tuple[Finding, ...] = shown_by("sayings").findings(self.seen)
        return found

    def __repr__(self) -> str:
        return f"<results of {self.path}: {', '.join(repr(rows) for rows in self.maneuvers)}>"


@dataclass(frozen=True, eq=False, slots=True)
class Vector:
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

    def of_rows(self, rows: NDArray[np.bool_]) -> "Vector":
        """The values of some of the rows."""
        lo = None if self.lo is None else self.lo[rows]
        return replace(self, values=self.values[rows], lo=lo)


@dataclass(frozen=True, eq=False, slots=True)
class Vectors:
    """Columns of the same length, by name where they have names: what every format is read as.

    Attributes
    ----------
    columns : list of Vector
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
    seen : tuple of Evidence
    """

    columns: list[Vector]
    names: list[str] | None = None
    lines: NDArray[np.int64] | None = None
    heading: int | None = None
    is_ordered: bool = True
    maneuver: int | None = None
    seen: tuple[Evidence, ...] = ()

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

    def of_rows(self, rows: NDArray[np.bool_], maneuver: int | None) -> "Vectors":
        """The rows that are of this maneuver."""
        columns = [column.of_rows(rows) for column in self.columns]
        lines = None if self.lines is None else self.lines[rows]
        return replace(self, columns=columns, lines=lines, maneuver=maneuver)
