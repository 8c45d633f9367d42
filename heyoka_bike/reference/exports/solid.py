"""The nearest bicycle whose bodies are solid, for engines that load no others.

Measured moments of inertia can violate the triangle inequality, and idealised bodies have no mass
or no extent. Engines refuse such a body, or replace its moments.
"""

from __future__ import annotations

from fractions import Fraction
from math import hypot

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.exact import Exact

_MASS = 1e-6
"""Minimum mass of a body [kg]."""
_GYRATION = 1e-3
"""Minimum radius of gyration about a principal axis [m]."""
_MARGIN = 1e-9
"""Relative excess of the sum of the two smaller moments over the largest. Engines add the moments
in binary64, where a sum without excess could be rounded down."""
_ROUNDOFF = 1e-12  # maximum relative error that counts as roundoff
_DIGITS = 12


def nearest_solid(bicycle: Bicycle) -> tuple[Bicycle, list[str]]:
    """Return the bicycle with the nearest masses and moments that a solid body can have.

    The distance is the sum of squared differences over the elements of each inertia matrix. The
    principal axes do not change.

    Returns
    -------
    tuple of (Bicycle, list of str)
        The bicycle, and a line for each changed parameter.
    """
    changed: dict[str, Exact] = {}
    for letter in "BHRF":
        symbols, m = [f"I{letter}{ij}" for ij in ("xx", "yy", "zz", "xz")], f"m{letter}"
        xx, yy, zz, xz = symbols
        old = {s: float(bicycle[s]) for s in (*symbols, m) if s in bicycle.values}
        mass = max(old[m], _MASS)
        # The parameters of a wheel contain neither Izz, which equals Ixx, nor Ixz, which is zero.
        given = (old[xx], old[yy], old.get(zz, old[xx]), old.get(xz, 0.0))
        found = _nearest(given, mass * _GYRATION**2)
        new = dict(zip(symbols, found, strict=True)) | {m: mass}
        changed |= {s: _exact(new[s]) for s, x in old.items() if new[s] != x}
    said = [f"{s} is {_said(x)} in place of {_said(bicycle[s])}" for s, x in changed.items()]
    return (bicycle.replace(**changed) if changed else bicycle), said


def _nearest(elements: tuple[float, float, float, float], least: float) -> tuple[float, ...]:
    """Return xx, yy, zz, xz of the nearest inertia that a solid body can have."""
    xx, yy, zz, xz = elements
    mean, half = (xx + zz) / 2, hypot((xx - zz) / 2, xz)
    given = [mean - half, mean + half, yy]
    moments = [max(x, least) for x in given]
    largest = max(range(3), key=moments.__getitem__)
    lacking = (2 + _MARGIN) * moments[largest] - sum(moments)
    if lacking > 0 and 2 * max(given) > sum(given):
        moments = [x + lacking / 3 * (-1 if i == largest else 1) for i, x in enumerate(moments)]
    if moments == given:
        return elements
    # Keep the principal directions in the plane of symmetry: shift the mean of the two moments, and
    # scale half their difference.
    shift = (moments[0] + moments[1]) / 2 - mean
    new_half = (moments[1] - moments[0]) / 2
    excess = (new_half - half) / half if abs(new_half - half) > _ROUNDOFF * half else 0.0
    across = (xx - zz) / 2 * excess
    return xx + shift + across, moments[2], zz + shift - across, xz + xz * excess


def _exact(x: float) -> Exact:
    return Exact(Fraction(f"{x:.{_DIGITS}g}"))


def _said(x: Exact) -> str:
    return f"{float(x):.6g}"
