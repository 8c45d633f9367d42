"""Four complex linear systems side by side, in the places of half a vector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.workbench.fast.vector_code import POINTS, Register, fused

Numbers = np.ndarray[Any, np.dtype[np.object_]]
"""Arrays of `Complex`."""


@dataclass(frozen=True, slots=True)
class Complex:
    """Four complex numbers: real and imaginary parts."""

    re: Register
    im: Register

    @staticmethod
    def of_halves(x: Register) -> Complex:
        """A vector's first half and its second."""
        return Complex(x.places(range(POINTS // 2)), x.places(range(POINTS // 2, POINTS)))

    def joined(self) -> Register:
        """Real and imaginary parts as one vector."""
        return self.re.places(range(POINTS), self.im)

    def __mul__(self, other: Complex) -> Complex:
        return Complex(
            fused(self.re, other.re, -(self.im * other.im)),
            fused(self.re, other.im, self.im * other.re),
        )

    def inverse(self) -> Complex:
        over = 1.0 / fused(self.re, self.re, self.im * self.im)
        return Complex(self.re * over, -(self.im * over))

    def without(self, x: Complex, y: Complex) -> Complex:
        """The difference between this number and the product of two others."""
        minus = -x.re
        return Complex(
            fused(x.im, y.im, fused(minus, y.re, self.re)),
            fused(-x.im, y.re, fused(minus, y.im, self.im)),
        )


_without = np.frompyfunc(Complex.without, 3, 1)


def factor(m: Numbers) -> None:
    """Factors of four complex matrices in their place; inverses on the diagonal.

    Without exchanges: a short step makes the diagonal large, and where the iteration does not
    converge the step is made shorter.
    """
    for k in range(len(m)):
        m[k, k] = m[k, k].inverse()
        rest = slice(k + 1, None)
        m[rest, k] *= m[k, k]
        m[rest, rest] = _without(m[rest, rest], m[rest, k : k + 1], m[k, rest])


def solve(m: Numbers, x: Numbers) -> Numbers:
    """Solutions of four complex systems in place of the right sides, from what `factor` left."""
    for k in range(len(m)):
        x[k + 1 :] = _without(x[k + 1 :], m[k + 1 :, k], x[k])
    for k in reversed(range(len(m))):
        x[k] *= m[k, k]
        x[:k] = _without(x[:k], m[:k, k], x[k])
    return x
