"""Correct rounding: the binary64 or decimal number that an enclosure determines.

A rounding is determined if both ends of the enclosure round to the same number. If they do not, the
candidate is zero if the enclosure contains zero, else the midpoint rounded.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from math import ceil, frexp, inf, ldexp, nextafter

import flint

from heyoka_bike.errors import UndecidedError
from heyoka_bike.numbers.arithmetic import dyadic, upper_fraction

Value = flint.arb | Fraction
"""A value of a column: a ball that encloses it, or the exact number."""


@dataclass(frozen=True, slots=True)
class Enclosure:
    """An interval that contains a number; both ends are equal if the number is known exactly."""

    low: Fraction
    high: Fraction

    @classmethod
    def of(cls, x: Value) -> Enclosure:
        """Return the exact interval of a ball or of a number."""
        if isinstance(x, Fraction):
            return cls(x, x)
        middle, radius = dyadic(x.mid()), dyadic(x.rad())
        return cls(middle - radius, middle + radius)

    @property
    def holds_zero(self) -> bool:
        return self.low <= 0 <= self.high

    def binary64(self) -> float | None:
        """Return the binary64 nearest to all numbers of the enclosure; None if they differ."""
        low, high = float(self.low), float(self.high)
        return low + 0.0 if low == high else None

    def nearest(self) -> tuple[float, bool]:
        """Return the binary64 (the candidate if undecided), and whether it is decided."""
        found = self.binary64()
        if found is not None:
            return found, True
        return (0.0 if self.holds_zero else float((self.low + self.high) / 2)), False

    def minus(self, *numbers: float) -> Enclosure:
        """Return the enclosure of the enclosed number minus the given numbers."""
        less = sum(map(Fraction, numbers))
        return Enclosure(self.low - less, self.high - less)

    def size(self) -> Fraction:
        """Return the largest absolute value in the enclosure."""
        return max(-self.low, self.high)

    def decimal(self, digits: int) -> str | None:
        """Return the number with this many digits; None if the enclosure does not decide them."""
        low, high = (_decimal(end, digits) for end in (self.low, self.high))
        return low if low == high else None


def nearest_pair(x: Enclosure) -> tuple[float, float, bool]:
    """Return hi, lo (the rest), and whether both are certain to be correctly rounded."""
    hi, is_decided = x.nearest()
    lo, is_rest_decided = x.minus(hi).nearest()
    return hi, lo, is_decided and is_rest_decided


def hi_lo(x: Enclosure, name: str) -> tuple[float, float]:
    """Return the correctly rounded binary64, and the correctly rounded rest.

    Raises
    ------
    UndecidedError
        The enclosure contains a number halfway between two binary64 ones. The message begins with
        `name`.
    """
    hi = x.binary64()
    if hi is None:
        raise UndecidedError(f"{name}: not known to enough digits to round it to binary64")
    lo = x.minus(hi).binary64()
    if lo is None:
        raise UndecidedError(f"{name}: not known to enough digits to round it to hi + lo")
    return hi, lo


def decimal_digits(x: Enclosure, digits: int, name: str) -> str:
    """Return the number with `digits` significant digits, correctly rounded; zero is ``0``.

    Raises
    ------
    UndecidedError
        The enclosure does not decide the last digit.
    """
    text = x.decimal(digits)
    if text is None:
        raise UndecidedError(f"{name}: not known to enough digits to round it to {digits} digits")
    return text


def decided_digits(x: Enclosure, digits: int) -> tuple[str, bool]:
    """Return the number with `digits` significant digits and True, or with fewer digits and False.

    With fewer digits the error is at most one unit of the last digit: ``0e-62`` is zero to within
    1e-62.
    """
    text = x.decimal(digits)
    if text is not None:
        return text, True
    middle, width = (x.low + x.high) / 2, x.high - x.low
    # The error of the written number is at most half a unit from rounding the midpoint, plus half
    # the width of the enclosure.
    last = _exponent_above(width)
    if middle:
        last = max(last, _exponent_above(abs(middle)) - digits + 1)
    scaled = round(middle / Fraction(10) ** last)
    written = f"{abs(scaled)}"
    sign, exponent = "-" if scaled < 0 else "", last + len(written) - 1
    fraction = f".{written[1:]}" if written[1:] else ""
    return f"{sign}{written[0]}{fraction}e{exponent:+d}", False


def _exponent_above(x: Fraction) -> int:
    """Return the smallest exponent of a power of ten that is not below a positive number."""
    exponent = len(str(x.numerator)) - len(str(x.denominator)) - 1
    while Fraction(10) ** exponent < x:
        exponent += 1
    return exponent


def _decimal(x: Fraction, digits: int) -> str:
    """Format a fraction with this many digits, rounded once, as ``1.50e+00``; ``0`` for zero."""
    context = Context(prec=digits, rounding=ROUND_HALF_EVEN, Emin=-9999, Emax=9999)
    rounded = context.divide(Decimal(x.numerator), Decimal(x.denominator))
    return f"{rounded:.{digits - 1}e}" if rounded else "0"


def upward(x: Fraction) -> float:
    """Return the smallest binary64 that is not below a number."""
    nearest = float(x)
    return nearest if Fraction(nearest) >= x else nextafter(nearest, inf)


def upward_ball(x: flint.arb) -> float:
    """Return the smallest binary64 that is not below any number of a ball."""
    return upward(upper_fraction(x))


def few_bits(bound: float) -> float:
    """Round a bound up to 8 bits: at most 1/128 larger, and such bounds compress well."""
    mantissa, exponent = frexp(bound)
    return ldexp(ceil(ldexp(mantissa, 8)), exponent - 8)


def decimal_above(x: Fraction) -> str:
    """Return a short decimal that is not below a nonnegative number."""
    context = Context(prec=3, rounding=ROUND_CEILING, Emin=-99999, Emax=99999)
    return f"{context.divide(Decimal(x.numerator), Decimal(x.denominator)):e}"
