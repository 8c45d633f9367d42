"""Units in which programs write the columns, and exact conversion to SI."""

from collections.abc import Mapping
from decimal import Decimal, localcontext
from functools import cache

import numpy as np

from heyoka_bike.numbers.double import Double, multiply

# OEIS A000796; more than hi + lo can hold.
_PI = "3.14159265358979323846264338327950288419716939937510"
# 0.3048 times the pound's weight at 9.80665 m/s2, exactly.
_FOOT_POUND = "1.3558179483314004"

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

NAMED: Mapping[str, tuple[str, ...]] = {
    "rad": ("mrad", "urad", "arcminute", "arcsecond", "grade", "revolution"),
    "rad s-1": ("mrad s-1", "degree min-1", "revolution s-1", "revolution min-1"),
    "m s-1": ("cm s-1", "km s-1", "m min-1", "foot s-1", "inch s-1", "mile h-1", "knot"),
    "J": ("uJ", "MJ", "W h", "foot lbf"),
    "m": ("cm", "km", "um", "inch", "foot"),
    "N": ("MN", "kgf", "lbf"),
    "N m": ("N cm", "MN m", "foot lbf"),
    "1": (),
}
"""Units that are tried only in columns whose heading names them."""

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
    "mrad": ("1", "1000"),
    "urad": ("1", "1000000"),
    "arcminute": (_PI, "10800"),
    "arcsecond": (_PI, "648000"),
    "grade": (_PI, "200"),
    "revolution": (_PI, "0.5"),
    "mrad s-1": ("1", "1000"),
    "degree min-1": (_PI, "10800"),
    "revolution s-1": (_PI, "0.5"),
    "revolution min-1": (_PI, "30"),
    "cm s-1": ("1", "100"),
    "km s-1": ("1000", "1"),
    "m min-1": ("1", "60"),
    "foot s-1": ("0.3048", "1"),
    "inch s-1": ("0.0254", "1"),
    "mile h-1": ("0.44704", "1"),
    "knot": ("1852", "3600"),
    "uJ": ("1", "1000000"),
    "MJ": ("1000000", "1"),
    "W h": ("3600", "1"),
    "foot lbf": (_FOOT_POUND, "1"),
    "cm": ("1", "100"),
    "km": ("1000", "1"),
    "um": ("1", "1000000"),
    "inch": ("0.0254", "1"),
    "foot": ("0.3048", "1"),
    "MN": ("1000000", "1"),
    "kgf": ("9.80665", "1"),
    "lbf": ("4.4482216152605", "1"),
    "N cm": ("1", "100"),
    "MN m": ("1000000", "1"),
}


def tried(si: str, named: str | None) -> tuple[str, ...]:
    """The units that values may be in, with that which their heading names."""
    return UNITS[si] if named is None or named in UNITS[si] else (*UNITS[si], named)


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
