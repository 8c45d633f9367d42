"""From the 26 parameters of a bicycle to the constants of its equations.

The bicycle is two *gyrostats* joined at the steer axis: the rear assembly (frame and rider B with
rear wheel R) and the front assembly (fork and handlebar H with front wheel F). Each is a rigid body
carrying a wheel that spins about its axle.

Lengths are in units of the rear wheel radius and masses in units of the rear assembly's mass, so
two constants are 1 and their products disappear from the equations. Time stays in seconds, so
angles and their rates do not depend on the units.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING

from heyoka_bike.numbers.arithmetic import Arithmetic, Number, value_of

if TYPE_CHECKING:
    from heyoka_bike.bicycle.parameters import Bicycle


class Assembly(
    namedtuple("Assembly", "r m l1 l3 i11 i13 i33 i22 spin mass_v mass_q skew rest"),
):
    """Constants of a frame with its wheel, in axes e at its hub: e3 down the steer axis, e2 axle.

    Attributes
    ----------
    r, m
        Wheel radius and total mass.
    l1, l3
        Centre of mass from the hub, along e1 and e3.
    i11, i13, i33
        Inertia matrix elements about the centre of mass, wheel included.
    i22
        Inertia about e2, without the wheel's own axial inertia.
    spin
        Axial inertia of the wheel over its radius.
    mass_v, mass_q
        Effective masses of hub speed (the rolling wheel included) and of rotation about the axle.
    skew, rest
        i13 / i33 and i11 - i13^2 / i33: the square completed in the inertia.
    """

    __slots__ = ()


class Constants(
    namedtuple("Constants", "rear front tilt d1 d2 d3 h0 h1 h2 h3 lever1 lever3 g length mass")
):
    """The constants of a bicycle with which its equations are computed.

    Attributes
    ----------
    rear, front : Assembly
    tilt
        Steer axis tilt [rad].
    d1, d2, d3
        From the rear hub to the steer axis (along e1), along the axis (e3), and from the axis to
        the front hub (e1 of the front).
    h0, h1, h2, h3
        Rear wheel radius and d1, d2, d3 over the front wheel radius.
    lever1, lever3
        Front centre of mass from the joint: up the axis, and ahead of it.
    g
        Gravity [rear wheel radii per s^2].
    length, mass
        The units of length [m] and mass [kg].
    """

    __slots__ = ()

    def convert(self, make: Callable[[Number], Number]) -> Constants:
        """Return the constants with `make` applied to each of them."""
        return Constants(
            *(Assembly(*map(make, x)) if isinstance(x, Assembly) else make(x) for x in self)
        )


def constants(bicycle: Bicycle, a: Arithmetic) -> Constants:
    """Return the constants of the equations in the number type of `a`.

    Positions and inertias are combined in rational arithmetic, in the upright axes; only the
    rotation by the tilt uses the number type.
    """
    p = {symbol: value.rational for symbol, value in bicycle.values.items()}
    return constants_of(p, a.number(bicycle["lam"]), a, is_vertical=bicycle["lam"].is_zero)


def constants_of(
    p: Mapping[str, Number], tilt: Number, a: Arithmetic, *, is_vertical: bool
) -> Constants:
    """Return constants from the tilt and the parameters, as fractions or duals of fractions."""
    s, c = a.sin(tilt), a.cos(tilt)
    length, mass = p["rR"], p["mB"] + p["mR"]

    def assembly(body: str, wheel: str, hub_x: Number) -> Assembly:
        radius = p[f"r{wheel}"]
        parts = (
            (p[f"m{body}"], p[f"x{body}"], p[f"z{body}"]),
            (p[f"m{wheel}"], hub_x, -radius),
        )
        total = parts[0][0] + parts[1][0]
        x, z = (sum(part[0] * part[k] for part in parts) / total for k in (1, 2))
        xx = p[f"I{body}xx"] + p[f"I{wheel}xx"]
        zz = p[f"I{body}zz"] + p[f"I{wheel}xx"]
        yy, xz = p[f"I{body}yy"], p[f"I{body}xz"]
        for part_mass, part_x, part_z in parts:
            dx, dz = part_x - x, part_z - z
            xx += part_mass * (dz * dz)
            zz += part_mass * (dx * dx)
            yy += part_mass * (dx * dx + dz * dz)
            xz -= part_mass * dx * dz
        unit = mass * (length * length)
        ixx, iyy, izz, ixz = (a.number(i / unit) for i in (xx, yy, zz, xz))
        lx, lz = a.number((x - hub_x) / length), a.number((z + radius) / length)
        r, m = a.number(radius / length), a.number(total / mass)
        ja = a.number(p[f"I{wheel}yy"] / unit)
        l1, l3 = lx * c - lz * s, lx * s + lz * c
        i11 = ixx * c * c - 2 * ixz * s * c + izz * s * s
        i13 = (ixx - izz) * s * c + ixz * (c * c - s * s)
        i33 = ixx * s * s + 2 * ixz * s * c + izz * c * c
        # If all mass lies on a line parallel to the third axis, i33 and i13 are zero. Their ratio
        # is undefined then, so use zero.
        on_axis = value_of(zz) == value_of(xz) == 0 and (value_of(xx) == 0 or is_vertical)
        skew = 0 * i13 if on_axis else i13 / i33
        return Assembly(
            r=r, m=m, l1=l1, l3=l3, i11=i11, i13=i13, i33=i33, i22=iyy, spin=ja / r,
            mass_v=m + ja / (r * r), mass_q=iyy + m * (l1 * l1 + l3 * l3),
            skew=skew, rest=i11 - i13 * skew,
        )  # fmt: skip

    rear, front = assembly("B", "R", Fraction(0)), assembly("H", "F", p["w"])
    w, trail = a.number(p["w"] / length), a.number(p["c"] / length)
    d1 = (w + trail) * c - rear.r * s
    d2 = w * s + (rear.r - front.r) * c
    d3 = front.r * s - trail * c
    return Constants(
        rear=rear, front=front, tilt=tilt, d1=d1, d2=d2, d3=d3,
        h0=rear.r / front.r, h1=d1 / front.r, h2=d2 / front.r, h3=d3 / front.r,
        lever1=front.l3 + d2, lever3=front.l1 + d3,
        g=a.number(p["g"] / length), length=a.number(length), mass=a.number(mass),
    )  # fmt: skip
