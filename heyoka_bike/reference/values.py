"""Columns at some times, and as piecewise Chebyshev polynomials, in computed or stored form.

The derivatives with respect to the unknowns (26 parameters of the bicycle and five initial
conditions) are here too; the module `variation` computes and proves them. Evaluating needs NumPy
only. `Numbered` contains values by the numbers of the maneuvers.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heyoka_bike.display import Displayed, IdentityMapping
from heyoka_bike.errors import InputError, unknown_word
from heyoka_bike.numbers.chebyshev import argument, clenshaw, double_sums, locate, plain_sums
from heyoka_bike.numbers.double import Array, Double

if TYPE_CHECKING:
    import pandas

T = TypeVar("T")


@dataclass(frozen=True, eq=False, repr=False)
class Values(Displayed, IdentityMapping[str, Array]):
    """Columns at some times: ``values["roll_angle"]`` is hi, ``values.lo["roll_angle"]`` is lo.

    They print as a table; ``{"time": values.time, **values}`` is a dictionary of their arrays.

    Attributes
    ----------
    hi, lo : mapping of str to ndarray
        SI units, of the shape of the times; the value is their exact sum.
    bound : mapping of str to ndarray
        Certified bound on abs(exact - (hi + lo)) of a row, or on the distance of a dense piece from
        the exact column; empty for evaluated values, and before it is proved.
    time : ndarray or None
        The times, to binary64 [s], of evaluated values.
    undecided : mapping of str to ndarray
        Numbers of the rows whose rounding the proof does not decide, by column; other columns are
        missing. In these rows hi and lo are candidates, within their bound of the exact value.
    """

    hi: Mapping[str, Array]
    lo: Mapping[str, Array]
    bound: Mapping[str, Array] = field(default_factory=dict)
    time: Array | None = field(default=None, kw_only=True)
    undecided: Mapping[str, NDArray[np.int64]] = field(default_factory=dict, kw_only=True)

    _view: ClassVar[str] = "values"

    def __getitem__(self, name: str) -> Array:
        try:
            return self.hi[name]
        except (KeyError, TypeError):
            raise KeyError(unknown_word(name, list(self.hi), "column ")) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.hi)

    def __len__(self) -> int:
        return len(self.hi)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the values (hi) as a pandas DataFrame with one row per time.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        from heyoka_bike.showing.formats import csv

        return csv.of_columns(self.time, self.hi)

    def scale(self, name: str) -> float:
        """Return the largest absolute value of a column."""
        return float(np.max(np.abs(self[name])))

    @property
    def ambiguous(self) -> int:
        """Number of entries whose rounding the proof does not decide."""
        return sum(rows.size for rows in self.undecided.values())

    @property
    def candidates(self) -> frozenset[tuple[Any, ...]]:
        """The undecided entries, each as (column, row, hi, lo)."""
        return frozenset(
            (name, i, self.hi[name][i], self.lo[name][i])
            for name, rows in self.undecided.items()
            for i in rows.tolist()
        )


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RoundedRows(Values):
    """The correctly rounded rows of a maneuver.

    Attributes
    ----------
    hi, lo : mapping of str to ndarray, shape (rows,)
        The binary64 nearest to the exact value, and the binary64 nearest to the difference.
    bound : mapping of str to ndarray, shape (rows,)
        Certified bound on abs(exact - (hi + lo)).
    text : mapping of str to tuple of str
        The benchmark's columns with 50 significant digits, correctly rounded.
    undecided_text : mapping of str to tuple of int
        Numbers of the rows with fewer digits in the text, because the proof does not decide 50.
    """

    text: Mapping[str, tuple[str, ...]]
    undecided_text: Mapping[str, tuple[int, ...]] = field(default_factory=dict)

    @property
    def ambiguous(self) -> int:
        """Number of entries, including numbers in the text, whose rounding is undecided."""
        return super().ambiguous + sum(map(len, self.undecided_text.values()))

    @property
    def candidates(self) -> frozenset[tuple[Any, ...]]:
        """The undecided entries, including those of the text other than zeros."""
        texts = (
            (name, i, self.text[name][i]) for name, x in self.undecided_text.items() for i in x
        )
        return super().candidates | {x for x in texts if not x[-1].startswith("0e")}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Dense(Values):
    """Columns as piecewise Chebyshev polynomials, evaluated at times of shape (n,).

    Times are not checked. The last piece is analytic, so it may be continued by a tiny fraction of
    its length.

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
        """Evaluate columns to about 31 digits of their scales."""
        piece = locate(self.breaks, t)
        x = argument(self.breaks, piece, t)
        return _named(names, *clenshaw(*self._stacked(names), piece, x))

    def evaluate_many(self, t: Double, names: Sequence[str]) -> Values:
        """Evaluate columns at sorted times several times faster, to about 27 digits."""
        return _named(names, *double_sums(self.breaks, self._stacked(names), t))

    def approximate(self, t: Double, names: Sequence[str]) -> Values:
        """Evaluate columns at the hi of sorted times, in plain binary64; there is no lo."""
        c = np.stack([self.hi[name] for name in names])
        return Values(dict(zip(names, plain_sums(self.breaks, c, t[0]), strict=True)), {})

    def _stacked(self, names: Sequence[str]) -> Double:
        return (
            np.stack([self.hi[name] for name in names]),
            np.stack([self.lo[name] for name in names]),
        )


def _named(names: Sequence[str], hi: Array, lo: Array) -> Values:
    return Values(dict(zip(names, hi, strict=True)), dict(zip(names, lo, strict=True)))


class Numbered(IdentityMapping[int, T]):
    """A mapping whose keys are the numbers of maneuvers: 1, 2, ...

    Attributes
    ----------
    maneuvers : tuple
        The maneuvers in order; the first has number 1.
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


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity:
    """Derivatives of columns with respect to parameters and initial values, in Chebyshev pieces.

    Attributes
    ----------
    breaks : ndarray, shape (P + 1,)
        Ends of the pieces [s], exact.
    coefficients : mapping of str to ndarray, shape (P, N, U)
        Coefficients of T_0 .. T_(N-1) in x = 2 (t - a) / (b - a) - 1 on the piece [a, b], c_0 not
        halved, by column; the unknowns are in the order of `structure.UNKNOWNS`. The unit is that
        of the column over that of the unknown. Here and below, NaN means that a column does not
        depend smoothly on an unknown.
    bound : mapping of str to ndarray, shape (P, U)
        Certified bound on the distance of a piece from the exact derivative, by column.
    time : ndarray, shape (R,)
        Times of every tenth row of the maneuver [s].
    values, values_bound : mapping of str to ndarray, shape (R, U)
        Derivatives of the benchmark's columns at these times, correctly rounded to binary64, and
        the certified bound on their distance from the exact ones.
    ambiguous : int
        Coefficients and values whose rounding the proof does not decide.
    """

    breaks: Array
    coefficients: Mapping[str, Array]
    bound: Mapping[str, Array] = field(default_factory=dict)
    time: Array = field(default_factory=lambda: np.empty(0))
    values: Mapping[str, Array] = field(default_factory=dict)
    values_bound: Mapping[str, Array] = field(default_factory=dict)
    ambiguous: int = 0

    def __repr__(self) -> str:
        return f"<derivatives of {len(self.coefficients)} columns, {len(self.breaks) - 1} pieces>"

    @property
    def orders(self) -> int:
        """Number of Chebyshev coefficients of a piece."""
        return int(next(iter(self.coefficients.values())).shape[1])

    def evaluate(self, times: ArrayLike, names: Sequence[str] | None = None) -> Mapping[str, Array]:
        """Evaluate the derivatives with respect to the unknowns at given times.

        Parameters
        ----------
        times : array_like, shape (n,)
            Times within the run [s].
        names
            Columns; by default all.

        Returns
        -------
        mapping of str to ndarray, shape (n, U)

        Raises
        ------
        InputError
            A time is outside the run.
        """
        t = np.asarray(times, dtype=np.float64).ravel()
        if len(t) and not (t.min() >= self.breaks[0] and t.max() <= self.breaks[-1]):
            raise InputError(
                f"time: found {t.min():g} to {t.max():g} s, expected 0 to {self.breaks[-1]:g} s"
            )
        piece = locate(self.breaks, (t, np.zeros_like(t)))
        a, b = self.breaks[piece], self.breaks[piece + 1]
        x = 2.0 * (t - a) / (b - a) - 1.0
        basis = np.polynomial.chebyshev.chebvander(x, self.orders - 1)
        found = {}
        for name in self.coefficients if names is None else names:
            coefficients = self.coefficients[name]
            found[name] = np.empty((len(t), coefficients.shape[2]))
            for p in np.unique(piece):
                found[name][piece == p] = basis[piece == p] @ coefficients[p]
        return found


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Numbered[Sensitivity]):
    """Sensitivities of all maneuvers of a dataset; ``sensitivities[2]`` is maneuver 2.

    Attributes
    ----------
    maneuvers : tuple of Sensitivity
    """

    maneuvers: tuple[Sensitivity, ...]

    def __repr__(self) -> str:
        return f"<derivatives of {len(self)} maneuvers>"
