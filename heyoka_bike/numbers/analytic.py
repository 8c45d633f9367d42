"""Number types for functions that are analytic on a disc: Taylor series, and values on its rim.

Cauchy's estimate bounds the omitted terms of a Taylor series by the size of the function on a
circle, where `Rim` evaluates it. For this the function must be analytic inside the circle. `Rim`
therefore watches every division and square root. If the real part of the divisor (or the radicand)
has one sign on the whole circle, it has this sign inside, too, because the real part of an analytic
function takes its extremes on the boundary. Applied in the order of evaluation, this proves that
each intermediate result is analytic.

`Samples` are values on the unit circle, from which Taylor coefficients follow. A product of two
series of n coefficients takes about n^2 products, but a product of two functions at n points takes
n. With w a primitive n-th root of unity, the mean of f(w^j) w^(-jk) over j is c_k + c_(k + n) +
c_(k + 2n) + ..., the Taylor coefficient c_k of f with the terms folded onto it. If f is analytic
for abs(s) <= R, R > 1, and at most M there, Cauchy's estimate bounds the folded terms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from math import ceil, log2
from typing import Any

import flint
import numpy as np

from heyoka_bike.numbers.arithmetic import Balls, Number
from heyoka_bike.numbers.ball_matrices import total


class AtPoints(Balls):
    """Arithmetic of function values at some points: a number is an array of balls."""

    def elementary(self, name: str, x: Number) -> Number:
        """Apply the function to each value. Square roots need radicands with positive real part."""
        return each(lambda z: getattr(z, name)(), x)

    def atan2(self, y: Number, x: Number) -> Number:
        """Return the angle of a point with positive x, computed as an arc tangent."""
        return self.elementary("atan", y / x)

    def sum(self, terms: Iterable[Number]) -> Number:
        # Add the terms to each other: adding them to an array of zeros would cost as much as one
        # more term.
        return sum(terms)


class Samples(AtPoints):
    """Values at the roots of unity of functions that are real on the real line, as balls.

    A number is an array of complex balls. Conjugate points have conjugate values, so the points of
    the upper half circle are enough. Constants may be real or complex balls; products with complex
    ones are faster.

    Parameters
    ----------
    bits : int
        Working precision.
    length : int
        Number of Taylor coefficients.
    radius : int
        Radius R.
    folded_bits : int
        Negative binary logarithm of the largest folded term, relative to the remainder of a series
        of the same length.
    """

    def __init__(self, bits: int, length: int, radius: int, *, folded_bits: int = 64) -> None:
        super().__init__(bits)
        self.length, self.radius = length, radius
        half = (length + ceil(folded_bits / log2(radius)) + 1) // 2
        count = 2 * half
        with self.precision():
            angles = [flint.fmpq(2 * j, count) for j in range(count)]
            cos = [flint.arb.cos_pi_fmpq(x) for x in angles]
            sin = [flint.arb.sin_pi_fmpq(x) for x in angles]
            self._cos, self._sin = (
                flint.arb_mat([[x[j * k % count] for j in range(half + 1)] for k in range(count)])
                for x in (cos, sin)
            )
            # Each end of the half circle counts once. Every other point counts twice: for itself
            # and for its complex conjugate.
            shares = [flint.arb(1 if j % half == 0 else 2) / count for j in range(half + 1)]
            self._mean = flint.arb_mat(
                [
                    [share * x[j * k % count] for k in range(length)]
                    for x in (cos, sin)
                    for j, share in enumerate(shares)
                ]
            )

    @classmethod
    @cache
    def of(cls, bits: int, length: int, radius: int) -> Samples:
        """Return samples from a cache, because functions along many pieces use the same ones."""
        return cls(bits, length, radius)

    @property
    def left_out(self) -> flint.arb:
        """Largest error of the polynomial for abs(s) <= 1, divided by the function's bound M."""
        return geometric(self.radius, self.length) + folded(self.radius, self._cos.nrows())

    def polynomials(self, rows: Sequence[Sequence[flint.arb]]) -> list[Number]:
        """Evaluate polynomials of any degree at the points, from their coefficients."""
        count = self._cos.nrows()
        folded = flint.arb_mat([[total(row[k::count]) for k in range(count)] for row in rows])
        parts = (folded * self._cos).table(), (folded * self._sin).table()
        return [array(map(flint.acb, re, im)) for re, im in zip(*parts, strict=True)]

    def coefficients(self, values: Sequence[Number]) -> list[list[flint.arb]]:
        """Return the first Taylor coefficients of functions, with other terms folded onto them."""
        count = self._cos.ncols()
        rows = [x if isinstance(x, np.ndarray) else array([flint.acb(x)] * count) for x in values]
        table = flint.arb_mat([[*(z.real for z in x), *(z.imag for z in x)] for x in rows])
        found: list[list[flint.arb]] = (table * self._mean).table()
        return found

    def matrices(self, table: Sequence[Sequence[Number]]) -> list[flint.arb_mat]:
        """Return the Taylor coefficients of a matrix, by power; an entry may be the integer 0."""
        flat = [x for row in table for x in row]
        places = [i for i, x in enumerate(flat) if not (isinstance(x, int) and x == 0)]
        by_power = zip(*self.coefficients([flat[i] for i in places]), strict=True)
        found = []
        for terms in by_power:
            entries = [flint.arb(0)] * len(flat)
            for i, x in zip(places, terms, strict=True):
                entries[i] = x
            found.append(flint.arb_mat(len(table), len(table[0]), entries))
        return found


def geometric(radius: int, length: int) -> flint.arb:
    """Return the sum of R^-m for m >= length: the terms that `length` coefficients leave out."""
    ratio = flint.arb(1) / radius
    return ratio**length / (1 - ratio)


def folded(radius: int, count: int) -> flint.arb:
    """Return the sum of R^-(k + m count) for k >= 0, m >= 1: all terms folded onto others."""
    ratio = flint.arb(1) / radius
    return ratio**count / (1 - ratio**count) / (1 - ratio)


def each(function: Callable[[Number], Number], x: Number) -> Number:
    """Apply a function to every number of an array, or to one number."""
    return array(map(function, x)) if isinstance(x, np.ndarray) else function(x)


def array(values: Iterable[Number]) -> Any:
    """Return a NumPy array of balls or other numbers."""
    return np.array(list(values), dtype=object)


class NotAnalyticError(ArithmeticError):
    """A divisor or radicand whose real part could not be shown to keep its sign."""


class Rim(Balls):
    """Complex balls on arcs of a circle, with a record of the sign of every divisor and radicand.

    The signs must be the same on all arcs of a circle: use one `Rim` for the circle and call
    `start` before each evaluation on some arcs. A number is an array with a ball for each of them,
    or one ball for all.

    Attributes
    ----------
    clear : ndarray of bool
        The arcs on which all signs are clear so far.
    reason : str
        Reason why the first unclear arc was rejected.
    """

    def __init__(self, bits: int) -> None:
        super().__init__(bits)
        self._signs: list[int] = []

    def start(self, arcs: int) -> None:
        """Begin an evaluation on this many arcs."""
        self.clear, self.reason = np.ones(arcs, dtype=bool), ""
        self._position = 0

    def watch(self, x: Number) -> None:
        """Record the sign of the real part of a divisor or radicand, for each arc.

        Raises
        ------
        NotAnalyticError
            The sign is positive on one clear arc and negative on another.
        """
        signs = np.array([1 if z.real > 0 else -1 if z.real < 0 else 0 for z in _all(x)])
        self._require(signs != 0, "a divisor may vanish")
        if self._position == len(self._signs):
            self._signs.append(0)
        seen = {*(signs * self.clear).tolist(), self._signs[self._position]} - {0}
        if len(seen) == 2:
            raise NotAnalyticError("a divisor changes the sign of its real part")
        self._signs[self._position] = sum(seen)
        self._position += 1

    def _require(self, is_clear: Any, reason: str) -> None:
        if not np.all(is_clear):
            self.clear, self.reason = self.clear & is_clear, self.reason or reason

    def value(self, x: Number) -> Value:
        """Return a complex ball, or an array of them, as a number whose divisions are recorded."""
        return Value(x, self)

    def elementary(self, name: str, x: Number) -> Number:
        if not isinstance(x, Value):
            return getattr(x, name)()
        return Value(each(getattr(flint.acb, name), x.x), self)

    def sqrt(self, x: Number) -> Number:
        if isinstance(x, Value):
            self._require(_is_positive(x.x), "a radicand may be negative")
        return super().sqrt(x)

    def atan2(self, y: Number, x: Number) -> Number:
        """Return atan(y / x); analytic if x and 1 + (y / x)^2 have positive real parts."""
        ahead = x.x if isinstance(x, Value) else flint.acb(x)
        self._require(_is_positive(ahead), "an angle may pass a quarter turn")
        ratio = (y / x).x
        is_off = _is_positive(1 + ratio * ratio)
        self._require(is_off, "an arc tangent may meet its branch point")
        return Value(each(flint.acb.atan, ratio), self)

    def sum(self, terms: Iterable[Number]) -> Number:
        # Add the terms to each other: adding them to an array of zeros would cost as much as one
        # more term.
        return sum(terms)


def _all(x: Number) -> Iterable[flint.acb]:
    """Return the numbers of an array, or a single number in a sequence."""
    return x if isinstance(x, np.ndarray) else (x,)


def _is_positive(x: Number) -> Any:
    """Return, for each number, whether its real part is positive."""
    return np.array([z.real > 0 for z in _all(x)])


class Value:
    """A complex ball, or an array of them, whose divisions are recorded."""

    __slots__ = ("rim", "x")

    def __init__(self, x: Number, rim: Rim) -> None:
        self.x, self.rim = x, rim

    def __add__(self, other: Number) -> Value:
        return Value(self.x + (other.x if isinstance(other, Value) else other), self.rim)

    def __sub__(self, other: Number) -> Value:
        return Value(self.x - (other.x if isinstance(other, Value) else other), self.rim)

    def __rsub__(self, other: Number) -> Value:
        return Value(other - self.x, self.rim)

    def __mul__(self, other: Number) -> Value:
        return Value(self.x * (other.x if isinstance(other, Value) else other), self.rim)

    def __neg__(self) -> Value:
        return Value(-self.x, self.rim)

    def __truediv__(self, other: Number) -> Value:
        if isinstance(other, Value):
            self.rim.watch(other.x)
            return Value(self.x / other.x, self.rim)
        return Value(self.x / other, self.rim)

    def __rtruediv__(self, other: Number) -> Value:
        self.rim.watch(self.x)
        return Value(other / self.x, self.rim)

    __radd__ = __add__
    __rmul__ = __mul__
