"""The number types in which the model is evaluated.

The equations in `model` and `outputs` are written once. They use ``+ - * /`` on their numbers, and
an `Arithmetic` supplies everything else: constants made from exact numbers, and the elementary
functions. Python integers are the only literals in the equations; every number type here takes
them exactly.
"""

from collections.abc import Iterable
from contextlib import AbstractContextManager
from fractions import Fraction
from typing import Any

import flint
import mpmath
import numpy as np

from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.working import working_bits

Number = Any
"""A value of one of the number types: an expression, a ball, an mpf, a dual number ..."""


class Arithmetic:
    """The operations of the equations in addition to ``+ - * /``.

    Most number types evaluate all functions of one variable in the same way, by `elementary`.
    """

    def number(self, value: Exact | Fraction | int) -> Number:
        """Convert an exact value to this number type."""
        raise NotImplementedError

    def elementary(self, name: str, x: Number) -> Number:
        """Apply the function ``sin``, ``cos`` or ``sqrt``, chosen by name."""
        raise NotImplementedError

    def sin(self, x: Number) -> Number:
        return self.elementary("sin", x)

    def cos(self, x: Number) -> Number:
        return self.elementary("cos", x)

    def sqrt(self, x: Number) -> Number:
        return self.elementary("sqrt", x)

    def atan2(self, y: Number, x: Number) -> Number:
        """Return the angle of the point (x, y)."""
        raise NotImplementedError

    def sum(self, terms: Iterable[Number]) -> Number:
        """Return the sum of the terms (one operation in a heyoka decomposition)."""
        return sum(terms)


class Balls(Arithmetic):
    """Ball arithmetic (Arb, through python-flint) with a working precision in bits.

    flint keeps its precision in a global context. Set it around whole formulas with
    ``with balls.precision():``. Outside that block every method raises, so that no formula is
    evaluated at another precision unnoticed.
    """

    def __init__(self, bits: int) -> None:
        self.bits = bits

    def precision(self) -> AbstractContextManager[None]:
        """Return a context manager that sets flint's working precision to `bits`."""
        context: AbstractContextManager[None] = working_bits(self.bits)
        return context

    def _check(self) -> None:
        if flint.ctx.prec != self.bits:
            raise RuntimeError(f"flint works at {flint.ctx.prec} bits, expected {self.bits}")

    def number(self, value: Exact | Fraction | int) -> flint.arb:
        self._check()
        exact = value if isinstance(value, Exact) else Exact(Fraction(value))
        x = exact_ball(exact.rational)
        if not exact.is_rational:
            x += exact_ball(exact.pi_multiple) * flint.arb.pi()
        return x

    def elementary(self, name: str, x: flint.arb) -> Number:
        self._check()
        return getattr(x, name)()

    def atan2(self, y: flint.arb, x: flint.arb) -> flint.arb:
        self._check()
        return flint.arb.atan2(y, x)

    def sum(self, terms: Iterable[flint.arb]) -> flint.arb:
        return sum(terms, flint.arb(0))


class Multiprecision(Arithmetic):
    """mpmath at a number of decimal digits, in a context of its own."""

    def __init__(self, digits: int) -> None:
        self.context = mpmath.mp.clone()
        self.context.dps = digits

    def number(self, value: Exact | Fraction | int) -> mpmath.mpf:
        exact = value if isinstance(value, Exact) else Exact(Fraction(value))
        mp = self.context
        x = mp.mpf(exact.rational.numerator) / exact.rational.denominator
        if not exact.is_rational:
            x += mp.pi * exact.pi_multiple.numerator / exact.pi_multiple.denominator
        return x

    def elementary(self, name: str, x: mpmath.mpf) -> mpmath.mpf:
        return getattr(self.context, name)(x)

    def atan2(self, y: mpmath.mpf, x: mpmath.mpf) -> mpmath.mpf:
        return self.context.atan2(y, x)

    def sum(self, terms: Iterable[mpmath.mpf]) -> mpmath.mpf:
        return sum(terms, self.context.zero)


class Arrays(Arithmetic):
    """NumPy arrays of binary64; constants come from `Constants.convert`."""

    def number(self, value: Exact | Fraction | int) -> float:
        return float(value)

    def elementary(self, name: str, x: Any) -> Any:
        return getattr(np, name)(x)

    def atan2(self, y: Any, x: Any) -> Any:
        return np.arctan2(y, x)


class Differentiated:
    """A number that carries derivatives in addition to its value, see `dual`."""

    __slots__ = ()
    value: Number


def value_of(x: Number) -> Number:
    """Return the number without its derivatives."""
    return x.value if isinstance(x, Differentiated) else x


def exact_ball(value: Fraction) -> flint.arb:
    """Return a rational number as a ball at flint's precision; exact if it fits."""
    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def span_ball(low: Fraction, high: Fraction) -> flint.arb:
    """Return a ball that contains all numbers between `low` and `high`."""
    return flint.arb(exact_ball((low + high) / 2), exact_ball((high - low) / 2).upper())


def midpoint(x: flint.arb) -> tuple[int, int]:
    """Return the midpoint of a ball exactly, as (n, grid) with the value n 2^-grid."""
    man, exp = x.mid().man_exp()
    return int(man), -int(exp)


def to_grid(x: flint.arb, grid: int) -> int:
    """Round the midpoint of a ball to an integer times 2^-grid; return the integer."""
    n, own = midpoint(x)
    drop = own - grid
    return (n + (1 << (drop - 1))) >> drop if drop > 0 else n << -drop


def upper_fraction(x: flint.arb) -> Fraction:
    """Return an upper bound of a ball as a fraction."""
    return dyadic(x.upper())


def dyadic(x: flint.arb) -> Fraction:
    """Return the value of a ball of radius zero as a fraction."""
    man, exp = map(int, x.man_exp())
    return Fraction(man << max(exp, 0), 1 << max(-exp, 0))


def sign_of(x: flint.arb) -> int:
    """Return 1 if all numbers of a ball are positive, -1 if all are negative, else 0."""
    return int(bool(x > 0)) - int(bool(x < 0))
