"""Units in which programs write the columns, and exact conversion to SI."""

from collections.abc import Mapping
from fractions import Fraction
from functools import cache

import numpy as np

from heyoka_bike.numbers.double import PI, Double, multiply
from heyoka_bike.numbers.unit import size

UNITS: Mapping[str, tuple[str, ...]] = {
    "rad": ("rad", "degree"),
    "rad s-1": ("rad s-1", "degree s-1", "revolution min-1"),
    "m s-1": ("m s-1", "km h-1", "mm s-1", "mile h-1"),
    "J": ("J", "kJ", "mJ"),
    "m": ("m", "mm"),
    "N": ("N", "kN", "mN"),
    "N m": ("N m", "kN m", "N mm"),
    "1": ("1",),
}
"""Units that are tried for each SI unit, in UDUNITS spelling. mJ is N mm, for programs in mm.

Other units are tried only in columns whose heading names them, see
`reading.names.heading_units`."""


def tried(si: str, named: str | None) -> tuple[str, ...]:
    """Return the units that values may be in, including the one that their heading names."""
    return UNITS[si] if named is None or named in UNITS[si] else (*UNITS[si], named)


@cache
def factor(unit: str) -> tuple[float, float]:
    """Return the factor from a unit to SI units, as hi + lo.

    A unit may begin with a factor: ``0.3 m rad s-1`` is the speed of a wheel with a radius of
    0.3 m that turns at 1 rad/s.
    """
    first, _, rest = unit.partition(" ")
    number, name = (first, rest) if rest and first[0].isdigit() else ("1", unit)
    found = size(name)
    assert found is not None
    one, half_turns, _ = found
    exact = Fraction(number) * one * PI**half_turns
    hi = float(exact)
    return hi, float(exact - Fraction(hi))


def unit_told_by(ratio: float, si: str, taken: str, within: float) -> str | None:
    """Return the true unit of numbers that are wrong by a factor; None if no unit explains it.

    Parameters
    ----------
    ratio, within
        The factor, and its relative tolerance.
    si, taken
        The SI unit of the quantity, and the unit in which the numbers were read.
    """
    found = (u for u in UNITS[si] if u != taken)
    times = factor(taken)[0]
    # If all values are zero, they do not show a unit.
    if not ratio:
        return None
    return next((u for u in found if abs(times / factor(u)[0] / ratio - 1.0) < within), None)


def to_si(values: Double, unit: str) -> Double:
    """Convert values from a unit to SI units, to 32 digits."""
    hi, lo = factor(unit)
    if (hi, lo) == (1.0, 0.0):
        return values
    return multiply(values, (np.full_like(values[0], hi), np.full_like(values[0], lo)))
