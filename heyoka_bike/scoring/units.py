"""Units in which programs write the columns, and exact conversion to SI."""

from collections.abc import Mapping
from decimal import Decimal, localcontext
from functools import cache

import numpy as np

from heyoka_bike.numbers.double import Double, multiply

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
"""By SI unit, the units tried, UDUNITS spelling; mJ is N mm, the unit of programs that use mm.

Others are tried only in columns whose heading names them, see `reading.names.units`."""

# OEIS A000796; more than hi + lo can hold.
_PI = "3.14159265358979323846264338327950288419716939937510"

# In SI units.
_SIZES: Mapping[str, str] = {
    "rad": "1",
    "degree": "pi/180",
    "arcminute": "pi/10800",
    "arcsecond": "pi/648000",
    "grade": "pi/200",
    "revolution": "pi/0.5",
    "m": "1",
    "inch": "0.0254",
    "foot": "0.3048",
    "mile": "1609.344",
    "s": "1",
    "min": "60",
    "h": "3600",
    "knot": "1852/3600",
    "N": "1",
    "kgf": "9.80665",
    "lbf": "4.4482216152605",
    "J": "1",
    "W": "1",
}
_PREFIXES = {"u": "1e-6", "m": "1e-3", "c": "1e-2", "k": "1e3", "M": "1e6"}


def tried(si: str, named: str | None) -> tuple[str, ...]:
    """The units that values may be in, with that which their heading names."""
    return UNITS[si] if named is None or named in UNITS[si] else (*UNITS[si], named)


@cache
def factor(unit: str) -> tuple[float, float]:
    """What a value in a unit is multiplied by to be in SI units, as hi + lo.

    A number is a factor: ``0.3 m rad s-1`` is the speed of a wheel that turns by 1 rad/s.
    """
    with localcontext() as context:
        context.prec = 50
        exact = Decimal(1)
        for word in unit.split() if unit != "1" else ():
            name = word.removesuffix("-1")
            is_whole = name in _SIZES or name[0].isdigit()
            prefix, base = ("", name) if is_whole else (name[0], name[1:])
            numerator, _, denominator = _SIZES.get(base, base).replace("pi", _PI).partition("/")
            size = Decimal(_PREFIXES.get(prefix, "1")) * Decimal(numerator)
            size /= Decimal(denominator or "1")
            exact = exact * size if name == word else exact / size
        hi = float(exact)
        return hi, float(exact - Decimal(hi))


def to_si(values: Double, unit: str) -> Double:
    """Values in a unit as SI values, to 32 digits."""
    hi, lo = factor(unit)
    if (hi, lo) == (1.0, 0.0):
        return values
    return multiply(values, (np.full_like(values[0], hi), np.full_like(values[0], lo)))
