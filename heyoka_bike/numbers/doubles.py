"""Arrays of double-double numbers with the signs and functions of formulas (NumPy only).

A formula that takes its functions from ``a`` is evaluated with ``a = np`` in plain binary64, and
with ``a = Doubles`` to about 31 digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import factorial

import numpy as np

from heyoka_bike.numbers.double import Array, add, divide, fast_two_sum, multiply, root

# The argument is halved so often, and the series of what is left ends below 1e-33.
_HALVINGS = 4
_TERMS = 18
PI = Fraction("3.14159265358979323846264338327950288419716939937510582")
"""To more digits than a double-double number has."""


@dataclass(frozen=True, eq=False, slots=True)
class Doubles:
    """The exact sums hi + lo of two arrays, or of two floats."""

    hi: Array
    lo: Array

    @classmethod
    def of(cls, value: Fraction | int) -> Doubles:
        """A number, to twice the digits of binary64."""
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
        return self._sin_cos()[0]

    def cos(self) -> Doubles:
        return self._sin_cos()[1]

    def arctan2(self, x: Doubles) -> Doubles:
        """The angle of (x, self)."""
        near = np.arctan2(self.hi, x.hi)
        angle = Doubles(near, np.zeros_like(near))
        sin, cos = angle._sin_cos()
        # What is left is an angle of the last digit, which is its own sine.
        rest = (self * cos - x * sin) / (x * cos + self * sin)
        return Doubles(*fast_two_sum(near, rest.hi))

    def _sin_cos(self) -> tuple[Doubles, Doubles]:
        quarters = np.rint(self.hi / float(PI / 2))
        x = self - Doubles(quarters, np.zeros_like(quarters)) * Doubles.of(PI / 2)
        x = Doubles(x.hi / 2**_HALVINGS, x.lo / 2**_HALVINGS)
        one = Doubles.of(1)
        square, sin, cos = x * x, Doubles.of(0), Doubles.of(0)
        for n in range(_TERMS, 0, -2):
            sign = (-1) ** (n // 2)
            cos = cos * square + Doubles.of(Fraction(sign, factorial(n)))
            sin = sin * square + Doubles.of(Fraction(-sign, factorial(n - 1)))
        sin, less = sin * x, -(cos * square)
        for _ in range(_HALVINGS):
            # Of 1 - cos, which keeps its digits where the cosine is near one.
            double = sin * (one - less)
            sin, less = double + double, (sin * sin) + (sin * sin)
        cos = one - less
        turned = [(sin, cos), (cos, -sin), (-sin, -cos), (-cos, sin)]
        which = quarters.astype(int) % 4
        return tuple(
            Doubles(*(np.choose(which, [getattr(x, p) for x in of]) for p in ("hi", "lo")))
            for of in zip(*turned, strict=True)
        )  # type: ignore[return-value]
