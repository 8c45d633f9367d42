"""Columns at some times, and as piecewise Chebyshev polynomials: as they are made, kept and read.

Evaluating needs NumPy only. `Numbered` is what holds them, by the numbers of the maneuvers.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, TypeVar

import numpy as np

from heyoka_bike.display import Displayed, Held, shown_by
from heyoka_bike.errors import unknown_word
from heyoka_bike.numbers.chebyshev import argument, clenshaw, double_sums, locate, plain_sums
from heyoka_bike.numbers.double import Array, Double

if TYPE_CHECKING:
    import pandas

T = TypeVar("T")


@dataclass(frozen=True, eq=False, repr=False)
class Values(Displayed, Held[str, Array]):
    """Columns at some times: ``values["roll_angle"]`` is hi, ``values.lo["roll_angle"]`` the rest.

    Printed they are a table; ``{"time": values.time, **values}`` are their arrays.

    Attributes
    ----------
    hi, lo : mapping of str to ndarray
        SI units, of the shape of the times; the value is their exact sum.
    bound : mapping of str to ndarray
        Certified bound on abs(exact - (hi + lo)) of a row, or on the distance of a dense piece from
        the exact column; empty for evaluated values, and before it is proved.
    time : ndarray or None
        The times, to binary64 [s], of evaluated values.
    """

    hi: Mapping[str, Array]
    lo: Mapping[str, Array]
    bound: Mapping[str, Array] = field(default_factory=dict)
    time: Array | None = field(default=None, kw_only=True)

    _view: ClassVar[str] = "values"

    def __getitem__(self, name: str) -> Array:
        if name not in self.hi:
            raise KeyError(unknown_word(name, list(self.hi), "column "))
        return self.hi[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.hi)

    def __len__(self) -> int:
        return len(self.hi)

    def to_pandas(self) -> "pandas.DataFrame":
        """Hi of each column by time.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        return shown_by("formats.csv").of_columns(self.time, self.hi)

    def scale(self, name: str) -> float:
        """Largest absolute value of a column."""
        return float(np.max(np.abs(self[name])))


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RoundedRows(Values):
    """The correctly rounded rows of a maneuver.

    Attributes
    ----------
    hi, lo : mapping of str to ndarray, shape (rows,)
        The binary64 nearest to the exact value, and the binary64 nearest to the rest.
    bound : mapping of str to ndarray, shape (rows,)
        Certified bound on abs(exact - (hi + lo)).
    text : mapping of str to tuple of str
        The benchmark's columns with 50 significant digits, correctly rounded.
    """

    text: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Dense(Values):
    """Columns as piecewise Chebyshev polynomials; they are evaluated at times of shape (n,).

    Times are not checked. The last piece is analytic: it may be continued by a tiny part of its
    length.

    Attributes
    ----------
    breaks : ndarray, shape (P + 1,)
        Ends of the pieces [s], exact.
    hi, lo : mapping of str to ndarray, shape (P, N)
        Coefficients of T_0 .. T_(N-1) by column, c_0 not halved, in the column's unit.
    bound : mapping of str to ndarray, shape (P,)
    """

    breaks: Array

    def evaluate(self, t: Double, names: Sequence[str]) -> Values:
        """Columns to about 31 digits of their scales."""
        piece = locate(self.breaks, t)
        x = argument(self.breaks, piece, t)
        return _named(names, *clenshaw(*self._stacked(names), piece, x))

    def evaluate_many(self, t: Double, names: Sequence[str]) -> Values:
        """Columns at sorted times, to about 27 digits of their scales: several times faster."""
        return _named(names, *double_sums(self.breaks, self._stacked(names), t))

    def approximate(self, t: Double, names: Sequence[str]) -> Values:
        """Columns at sorted times, of which hi counts, in plain binary64; there is no lo."""
        c = np.stack([self.hi[name] for name in names])
        return Values(dict(zip(names, plain_sums(self.breaks, c, t[0]), strict=True)), {})

    def _stacked(self, names: Sequence[str]) -> Double:
        return (
            np.stack([self.hi[name] for name in names]),
            np.stack([self.lo[name] for name in names]),
        )


def _named(names: Sequence[str], hi: Array, lo: Array) -> Values:
    return Values(dict(zip(names, hi, strict=True)), dict(zip(names, lo, strict=True)))


class Numbered(Held[int, T]):
    """A mapping of the numbers of maneuvers.

    Attributes
    ----------
    maneuvers : tuple
        Number 1 goes first.
    """

    maneuvers: tuple[T, ...]

    def __getitem__(self, number: int) -> T:
        if number not in self:
            raise KeyError(f"found maneuver {number!r}, expected 1 to {len(self.maneuvers)}")
        return self.maneuvers[number - 1]

    def __contains__(self, number: object) -> bool:
        return isinstance(number, int) and 1 <= number <= len(self.maneuvers)

    def __iter__(self) -> Iterator[int]:
        return iter(range(1, len(self.maneuvers) + 1))

    def __len__(self) -> int:
        return len(self.maneuvers)
