"""Exact numbers of Python libraries, which may have more digits than binary64.

Fractions, mpmath's mpf, gmpy2's mpfr, and flint's arb, arf and fmpq are recognised by their
attributes, so that none of these packages has to be imported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal
from fractions import Fraction
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Double

# Decimal arithmetic with more digits than a pair of binary64 numbers can contain.
_DECIMAL = Context(prec=50, Emax=MAX_EMAX, Emin=MIN_EMIN, traps=[])
_BITS_OF_BINARY64 = 53
# Minimum number of bits that a ball is assumed to have, however large its radius is.
_LEAST_BITS = 1


@dataclass(frozen=True, slots=True)
class LongNumbers:
    """Exact values of a column.

    Attributes
    ----------
    values : sequence of Fraction or None
        None for a value that is missing or not finite.
    bits : int or None
        Bits of the longest value; None if a value is no binary number, such as 1/3.
    """

    values: Sequence[Fraction | None]
    bits: int | None

    def as_pairs(self) -> Double:
        """Return the values as hi + lo; NaN for a missing value."""
        hi = np.array([np.nan if x is None else float(x) for x in self.values])
        rests = zip(self.values, hi.tolist(), strict=True)
        lo = [0.0 if x is None else float(x - Fraction(near)) for x, near in rests]
        return hi, np.array(lo)

    def as_decimals(self) -> list[str]:
        """Return the values as decimals that `float` reads."""
        return [
            "nan"
            if x is None
            else str(_DECIMAL.divide(Decimal(x.numerator), Decimal(x.denominator))).lower()
            for x in self.values
        ]


def long_numbers(array: NDArray[Any]) -> LongNumbers | None:
    """Return the exact values of an array of objects; None if they are not such numbers."""
    items = array.tolist()
    long = [x for x in items if not isinstance(x, str | int | float | Decimal | None)]
    if not long or not all(map(_is_long, long)):
        return None
    values = [_exactly(x) for x in items]
    exact = [x for x in values if x is not None]
    if any(x.denominator & (x.denominator - 1) for x in exact):
        return LongNumbers(values, None)
    bits = max([_BITS_OF_BINARY64, *map(_bits, exact)])
    # A ball has no more correct bits than its radius allows.
    known = [max(int(x.rel_accuracy_bits()), _LEAST_BITS) for x in long if _is_ball(x) and x != 0]
    return LongNumbers(values, min([bits, max(known, default=bits)]))


def _is_ball(x: Any) -> bool:
    return hasattr(x, "mid") and hasattr(x, "rel_accuracy_bits")


def _is_long(x: Any) -> bool:
    is_number = hasattr(x, "as_integer_ratio") or hasattr(x, "man_exp")
    return is_number or (hasattr(x, "p") and hasattr(x, "q"))


def _exactly(x: Any) -> Fraction | None:
    """Return the exact value of a number; None if it is not finite."""
    try:
        if isinstance(x, str | int | float | Decimal):
            found = Fraction(x)
        elif hasattr(x, "as_integer_ratio"):
            found = Fraction(*map(int, x.as_integer_ratio()))
        elif hasattr(x, "p"):
            found = Fraction(int(x.p), int(x.q))
        else:
            middle = x.mid() if _is_ball(x) else x
            mantissa, exponent = map(int, middle.man_exp())
            found = Fraction(mantissa) * Fraction(2) ** exponent
        return found if isfinite(float(found)) else None
    except (AttributeError, ValueError, OverflowError, TypeError, ZeroDivisionError):
        return None


def _bits(x: Fraction) -> int:
    numerator = abs(x.numerator)
    return (numerator // (numerator & -numerator)).bit_length() if numerator else 0
