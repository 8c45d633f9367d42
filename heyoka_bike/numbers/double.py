"""Double-double numbers: sums, products, quotients, roots, functions; and the median (NumPy only).

A double-double number is the exact sum hi + lo of two binary64 ones, about 32 digits. Error-free
sums and products: Dekker (1971), doi:10.1007/BF01397083.

A formula that takes its functions from ``a`` is evaluated with ``a = np`` in plain binary64, and
with ``a = Doubles`` to about 31 digits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, wraps
from math import factorial
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

Double = tuple[Array, Array]
"""hi and lo, of the same shape."""

SMALL_STEP = 2.0**-26
"""Step in a quantity of size one for a slope by a difference: the square root of binary64's
roundoff, for which curvature and roundoff cause equal errors."""

STEP_OF_SECOND = 2.0**-13
"""Step for second differences, and for central differences used with them: the fourth root of the
roundoff."""

ROUNDS_OF_NEWTON = 5
"""Rounds of Newton's method with such slopes: three rounds take one correct digit to all of
binary64, and two more allow for a start that is farther away."""

_SPLITTER = 2.0**27 + 1.0
# The argument of sine and cosine is halved this many times, so that the truncation error of the
# series is below 1e-33.
_HALVINGS_OF_ARGUMENT = 4
_TERMS_OF_SERIES = 18
PI = Fraction("3.14159265358979323846264338327950288419716939937510582")
"""Pi with more digits than a double-double number has."""


_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")


def with_usual_errors(function: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
    """Run a function with NumPy's default error settings, and without errors for underflow.

    Users who make NumPy raise floating-point errors want this for their own computations only.
    """

    @wraps(function)
    def called(*args: _Given.args, **kwargs: _Given.kwargs) -> _Found:
        with np.errstate(divide="warn", over="warn", under="ignore", invalid="warn"):
            return function(*args, **kwargs)

    return called


def median(x: ArrayLike) -> Array:
    """Return the median along the last axis of finite numbers.

    NumPy's median imports masked arrays, which takes a tenth of the time of importing NumPy.
    """
    values = np.asarray(x, dtype=np.float64)
    low, high = (values.shape[-1] - 1) // 2, values.shape[-1] // 2
    ordered = np.partition(values, (low, high), axis=-1)
    return np.asarray((ordered[..., low] + ordered[..., high]) / 2)


def two_sum(a: Array, b: Array) -> Double:
    """Return the exact sum of two binary64 numbers."""
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


def fast_two_sum(a: Array, b: Array) -> Double:
    """Return the exact sum of two binary64 numbers, of which the first must be the larger one."""
    s = a + b
    return s, b - (s - a)


def split(a: Array) -> Double:
    """Split a binary64 number into the sum of two with 26 bits each, by Dekker's method."""
    c = _SPLITTER * a
    high = c - (c - a)
    return high, a - high


def two_product(a: Array, b: Array) -> Double:
    """Return the exact product of two binary64 numbers (no overflow or underflow)."""
    p = a * b
    ah, al = split(a)
    bh, bl = split(b)
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


def add(x: Double, y: Double) -> Double:
    """Return the sum, to about 2^-104 of the larger term."""
    s, e = two_sum(x[0], y[0])
    t, f = two_sum(x[1], y[1])
    s, e = fast_two_sum(s, e + t)
    return fast_two_sum(s, e + f)


def multiply(x: Double, y: Double) -> Double:
    """Return the product, to about 2^-103."""
    p, e = two_product(x[0], y[0])
    return fast_two_sum(p, e + (x[0] * y[1] + x[1] * y[0]))


def divide(x: Double, y: Array, y_lo: Array | float = 0.0) -> Double:
    """Return x divided by y + y_lo, to about 2^-103."""
    q = x[0] / y
    p, e = two_product(q, y)
    rest = ((x[0] - p) - e + (x[1] - q * y_lo)) / y
    return fast_two_sum(q, rest)


def root(x: Double) -> Double:
    """Return the square root of x, to about 2^-103."""
    r = np.sqrt(x[0])
    p, e = two_product(r, r)
    rest = (x[0] - p) - e + x[1]
    # The square root of zero is zero, so divide by one instead of by zero.
    return fast_two_sum(r, rest / np.where(r == 0, 1.0, 2 * r))


@dataclass(frozen=True, eq=False, slots=True)
class Doubles:
    """The exact sums hi + lo of two arrays, or of two floats."""

    hi: Array
    lo: Array

    @classmethod
    def of(cls, value: Fraction | int) -> Doubles:
        """Convert a number, to twice the digits of binary64."""
        hi = float(value)
        return cls(np.asarray(hi), np.asarray(float(value - Fraction(hi))))

    def __add__(self, other: Doubles) -> Doubles:
        return Doubles(*add((self.hi, self.lo), (other.hi, other.lo)))

    def __neg__(self) -> Doubles:
        return Doubles(-self.hi, -self.lo)

    def __sub__(self, other: Doubles) -> Doubles:
        return self + -other

    def __mul__(self, other: Doubles) -> Doubles:
        return Doubles(*multiply((self.hi, self.lo), (other.hi, other.lo)))

    def __truediv__(self, other: Doubles) -> Doubles:
        return Doubles(*divide((self.hi, self.lo), other.hi, other.lo))

    def sqrt(self) -> Doubles:
        return Doubles(*root((self.hi, self.lo)))

    def sin(self) -> Doubles:
        return _sin_cos(self)[0]

    def cos(self) -> Doubles:
        return _sin_cos(self)[1]

    def arctan2(self, x: Doubles) -> Doubles:
        """Return the angle of the point (x, self)."""
        near = np.arctan2(self.hi, x.hi)
        angle = Doubles(near, np.zeros_like(near))
        sin, cos = _sin_cos(angle)
        # The remaining angle is so small that its sine equals the angle to working precision.
        rest = (self * cos - x * sin) / (x * cos + self * sin)
        return Doubles(*fast_two_sum(near, rest.hi))


@lru_cache(maxsize=4)
def _sin_cos(angle: Doubles) -> tuple[Doubles, Doubles]:
    """Return sine and cosine, cached for the latest arguments because most formulas need both."""
    quarters = np.rint(angle.hi / float(PI / 2))
    x = angle - Doubles(quarters, np.zeros_like(quarters)) * Doubles.of(PI / 2)
    x = Doubles(x.hi / 2**_HALVINGS_OF_ARGUMENT, x.lo / 2**_HALVINGS_OF_ARGUMENT)
    one = Doubles.of(1)
    square, sin, cos = x * x, Doubles.of(0), Doubles.of(0)
    for n in range(_TERMS_OF_SERIES, 0, -2):
        sign = (-1) ** (n // 2)
        cos = cos * square + Doubles.of(Fraction(sign, factorial(n)))
        sin = sin * square + Doubles.of(Fraction(-sign, factorial(n - 1)))
    sin, less = sin * x, -(cos * square)
    for _ in range(_HALVINGS_OF_ARGUMENT):
        # Double the angle by means of 1 - cos, which remains accurate where the cosine is near one.
        double = sin * (one - less)
        sin, less = double + double, (sin * sin) + (sin * sin)
    cos = one - less
    turned = [(sin, cos), (cos, -sin), (-sin, -cos), (-cos, sin)]
    which = quarters.astype(int) % 4
    return tuple(
        Doubles(*(np.choose(which, [getattr(x, p) for x in of]) for p in ("hi", "lo")))
        for of in zip(*turned, strict=True)
    )  # type: ignore[return-value]
