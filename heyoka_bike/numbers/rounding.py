"""Correct rounding: from an enclosure to the one binary64 or decimal it decides.

An enclosure is a ball [m - r, m + r], given as integers on a common power of two. A rounding is
accepted only where both of its ends round to the same number.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from math import ceil, frexp, inf, ldexp, nextafter

import flint

from heyoka_bike.errors import UndecidedError

Value = flint.arb | Fraction
"""A value of a column: enclosed, or known exactly."""


@dataclass(frozen=True, slots=True)
class Enclosure:
    """The interval [low, high] 2^-grid."""

    low: int
    high: int
    grid: int

    @classmethod
    def of(cls, x: flint.arb) -> Enclosure:
        """The interval of a ball, exactly."""
        middle, radius = x.mid().man_exp(), x.rad().man_exp()
        grid = max(-int(middle[1]), -int(radius[1]), 0)
        m, r = int(middle[0]) << (grid + int(middle[1])), int(radius[0]) << (grid + int(radius[1]))
        return cls(m - r, m + r, grid)

    def binary64(self) -> float | None:
        """The binary64 nearest to every number of the enclosure; None if there is not just one."""
        # A quotient of integers is correctly rounded.
        low, high = self.low / (1 << self.grid), self.high / (1 << self.grid)
        return low if low == high else None

    def minus(self, x: float) -> Enclosure:
        """The enclosure of the number minus `x`."""
        n, d = x.as_integer_ratio()
        shift = d.bit_length() - 1
        up = max(shift - self.grid, 0)
        grid = self.grid + up
        offset = n << (grid - shift)
        return Enclosure((self.low << up) - offset, (self.high << up) - offset, grid)

    def size(self) -> float:
        """The smallest binary64 that is not below any absolute value of the enclosure."""
        return _upward(max(abs(self.low), abs(self.high)), 1 << self.grid)

    def decimal(self, digits: int) -> str | None:
        """Return the number to significant digits; None if the enclosure does not decide them."""
        low, high = (_decimal(end, 1 << self.grid, digits) for end in (self.low, self.high))
        return low if low == high else None


def hi_lo(x: Enclosure | Fraction, name: str) -> tuple[float, float]:
    """The correctly rounded binary64, and the correctly rounded rest.

    Raises
    ------
    UndecidedError
        The enclosure contains a number halfway between two binary64 ones; `name` says which.
    """
    if isinstance(x, Fraction):
        hi = x.numerator / x.denominator
        rest = x - Fraction(hi)
        return hi + 0.0, rest.numerator / rest.denominator + 0.0
    rounded = x.binary64()
    if rounded is None:
        raise UndecidedError(f"{name}: the digits at hand do not decide its nearest binary64")
    rest_rounded = x.minus(rounded).binary64()
    if rest_rounded is None:
        raise UndecidedError(f"{name}: the digits at hand do not decide the rest of its binary64")
    return rounded + 0.0, rest_rounded + 0.0


def decimal_digits(x: Enclosure | Fraction, digits: int, name: str) -> str:
    """The number with `digits` significant digits, correctly rounded; zero is ``0``.

    Raises
    ------
    UndecidedError
        The enclosure does not decide the last digit.
    """
    if isinstance(x, Fraction):
        return _decimal(x.numerator, x.denominator, digits)
    text = x.decimal(digits)
    if text is None:
        raise UndecidedError(f"{name}: the digits at hand do not decide {digits} decimal digits")
    return text


def _decimal(n: int, d: int, digits: int) -> str:
    """Return a quotient to significant digits, by one rounding, as ``1.50e+00``; ``0`` for zero."""
    context = Context(prec=digits, rounding=ROUND_HALF_EVEN, Emin=-9999, Emax=9999)
    x = context.divide(Decimal(n), Decimal(d))
    return f"{x:.{digits - 1}e}" if x else "0"


def upward(x: Fraction) -> float:
    """The smallest binary64 that is not below a nonnegative number."""
    return _upward(x.numerator, x.denominator)


def upward_ball(x: flint.arb) -> float:
    """The smallest binary64 that is not below any number of a nonnegative ball."""
    man, exp = map(int, x.upper().man_exp())
    return _upward(man << max(exp, 0), 1 << max(-exp, 0))


def _upward(n: int, d: int) -> float:
    nearest = n / d
    p, q = nearest.as_integer_ratio()
    return nearest if p * d >= n * q else nextafter(nearest, inf)


def few_bits(bound: float) -> float:
    """A bound rounded up to 8 bits: at most 1/128 more, and such bounds compress well."""
    mantissa, exponent = frexp(bound)
    return ldexp(ceil(ldexp(mantissa, 8)), exponent - 8)


def decimal_above(x: Fraction) -> str:
    """A short decimal that is not below a nonnegative number."""
    context = Context(prec=3, rounding=ROUND_CEILING, Emin=-99999, Emax=99999)
    return f"{context.divide(Decimal(x.numerator), Decimal(x.denominator)):e}"
