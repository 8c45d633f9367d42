"""The results in a file as they are written: not converted, and without assumed definitions."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, Double
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Finding


@dataclass(frozen=True, slots=True)
class Quantum:
    """The resolution of a column: the number of digits or places of its values.

    Attributes
    ----------
    base
        10 for decimal digits, 2 for binary ones.
    digits
        Significant digits in that base; None if the number of places after the point is fixed.
    places
        Number of places after the point; None if that is not fixed.
    step
        Factor of the spacing: with a step of 0.5 and no places, values are multiples of 0.5.
    """

    base: int
    digits: int | None = None
    places: int | None = None
    step: float = 1.0

    def at(self, values: Array) -> Array:
        """Return the distance between neighbouring numbers at each value, in the values' unit."""
        if self.digits is None:
            assert self.places is not None
            return np.full(np.shape(values), self.step * float(self.base) ** -self.places)
        size = np.abs(np.nan_to_num(values, posinf=0.0, neginf=0.0))
        smallest = np.finfo(np.float64).tiny
        exponent = np.floor(np.log(np.maximum(size, smallest)) / np.log(self.base))
        # The computed logarithm of a power may be rounded to just below its integer value. Then add
        # 1.
        exponent += np.power(float(self.base), exponent + 1) <= size
        spacing = np.power(float(self.base), exponent - self.digits + 1)
        return np.where(size < smallest, 0.0, spacing)


@dataclass(frozen=True, eq=False, repr=False)
class Rows:
    """The columns of one maneuver as they are written: not converted, no definition assumed.

    Attributes
    ----------
    maneuver
        Number of the maneuver from 1; None if the file does not contain it.
    time, time_lo : ndarray, shape (n,)
        Times [s] in ascending order, as hi + lo: the decimals written, to 32 digits.
    values : mapping of str to ndarray, shape (n,)
        Values of each column, by key of `columns.COMPARED`; any column may be absent. A number
        that is missing or not finite is NaN.
    lo : mapping of str to ndarray, shape (n,)
        The low parts of columns with more digits than binary64.
    quantum : mapping of str to Quantum
        The resolution of each column, including ``time``.
    units : mapping of str to str
        The unit that the heading of a column names, if any, spelt as in `units`; including
        ``time``, if its unit is not the second.
    may_be : mapping of str to tuple of str
        All keys that a column with an ambiguous name may have, including its present one.
    """

    maneuver: int | None
    time: Array
    time_lo: Array
    values: Mapping[str, Array]
    lo: Mapping[str, Array] = field(default_factory=dict)
    quantum: Mapping[str, Quantum] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    may_be: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def written(self, key: str) -> Double:
        """Return the values of a column as hi + lo; lo is zero without digits beyond binary64."""
        hi = self.values[key]
        return hi, self.lo.get(key, np.broadcast_to(0.0, hi.shape))

    def spacing(self, key: str, values: Array) -> Array:
        """Return the distance between neighbouring written numbers at some values; 0 if unknown."""
        quantum = self.quantum.get(key)
        return np.zeros(np.shape(values)) if quantum is None else quantum.at(values)

    def only(self, keys: Collection[str]) -> Self:
        """Return the rows with only these columns."""
        return replace(self, values={key: x for key, x in self.values.items() if key in keys})

    def without(self, keys: Collection[str]) -> Self:
        """Return the rows without these columns."""
        return self.only(self.values.keys() - {*keys})

    def rewritten(self, values: Mapping[str, Array]) -> Self:
        """Return the rows with other values of some columns, without their low parts."""
        lo = {key: x for key, x in self.lo.items() if key not in values}
        return replace(self, values={**self.values, **values}, lo=lo)

    def at(self, rows: slice | NDArray[Any]) -> Self:
        """Return some of the rows, by a mask or by their indices."""
        values, lo = ({k: x[rows] for k, x in of.items()} for of in (self.values, self.lo))
        return replace(self, time=self.time[rows], time_lo=self.time_lo[rows], values=values, lo=lo)

    def __repr__(self) -> str:
        what = "unknown maneuver" if self.maneuver is None else f"maneuver {self.maneuver}"
        return f"<{what}: {len(self.time)} rows of {', '.join(self.values)}>"


AnyRows = TypeVar("AnyRows", bound=Rows)


def renamed(rows: AnyRows, names: Mapping[str, str | None]) -> AnyRows:
    """Return the rows with new keys for some columns; drop columns whose key becomes None."""

    def of(columns: Mapping[str, Any]) -> dict[str, Any]:
        named = {names.get(key, key): x for key, x in columns.items()}
        return {key: x for key, x in named.items() if key is not None}

    return replace(
        rows, values=of(rows.values), lo=of(rows.lo), quantum=of(rows.quantum), units=of(rows.units)
    )


@dataclass(frozen=True, eq=False, repr=False)
class Results:
    """The results in a file, or in arrays.

    Attributes
    ----------
    path
        Name of the file (``-`` for standard input).
    format
        Format of the file: a name in `formats.FORMATS`, such as ``text``, or ``array``.
    maneuvers : tuple of Rows
    significant_digits
        Decimal digits of the column written with the fewest digits; None if unknown.
    seen : tuple of Evidence
        Evidence of anything unusual that was found on reading the file.
    """

    path: str
    format: str
    maneuvers: tuple[Rows, ...]
    significant_digits: int | None = None
    seen: tuple[Evidence, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings: a message for each piece of evidence, with its numbers."""
        return tuple(e.finding() for e in self.seen)

    def __repr__(self) -> str:
        return f"<results of {self.path}: {', '.join(repr(rows) for rows in self.maneuvers)}>"
