"""Units in which programs write the columns, and exact conversion to SI."""

from collections.abc import Mapping
from decimal import Decimal, localcontext
from functools import cache

import numpy as np

from heyoka_bike.numbers.double import Double, multiply

# OEIS A000796; more than hi + lo can hold.
_PI = "3.14159265358979323846264338327950288419716939937510"

UNITS: Mapping[str, tuple[str, ...]] = {
    "rad": ("rad", "degree"),
    "rad s-1": ("rad s-1", "degree s-1"),
    "m s-1": ("m s-1", "km h-1", "mm s-1"),
    "J": ("J", "kJ", "mJ"),
    "m": ("m", "mm"),
    "N": ("N", "kN", "mN"),
    "N m": ("N m", "kN m", "N mm"),
    "1": ("1",),
}
"""By SI unit, the units tried, UDUNITS spelling; mJ is N mm, the unit of programs that use mm."""

# Numerator and denominator.
_FACTORS: Mapping[str, tuple[str, str]] = {
    "rad": ("1", "1"),
    "degree": (_PI, "180"),
    "rad s-1": ("1", "1"),
    "degree s-1": (_PI, "180"),
    "m s-1": ("1", "1"),
    "km h-1": ("5", "18"),
    "mm s-1": ("1", "1000"),
    "J": ("1", "1"),
    "kJ": ("1000", "1"),
    "mJ": ("1", "1000"),
    "m": ("1", "1"),
    "mm": ("1", "1000"),
    "N": ("1", "1"),
    "kN": ("1000", "1"),
    "mN": ("1", "1000"),
    "N m": ("1", "1"),
    "kN m": ("1000", "1"),
    "N mm": ("1", "1000"),
    "1": ("1", "1"),
}


@cache
def factor(unit: str) -> tuple[float, float]:
    """What a value in a unit is multiplied by to be in SI units, as hi + lo."""
    numerator, denominator = _FACTORS[unit]
    with localcontext() as context:
        context.prec = 50
        exact = Decimal(numerator) / Decimal(denominator)
        hi = float(exact)
        return hi, float(exact - Decimal(hi))


def to_si(values: Double, unit: str) -> Double:
    """Values in a unit as SI values, to 32 digits."""
    hi, lo = factor(unit)
    if (hi, lo) == (1.0, 0.0):
        return values
    return multiply(values, (np.full_like(values[0], hi), np.full_like(values[0], lo)))
