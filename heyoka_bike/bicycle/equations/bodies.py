"""The four bodies of a bicycle, each by itself: masses, places and inertias in SI units.

The equations of motion join each wheel with the body that holds it (see `constants`). Forces in
the axles and places of centres of mass need them apart. The *axes of a frame* are those of the
parameters, x forward, y right along the axle, z down in the upright, straight position: the rear
frame's are fixed in it, the front frame's in the fork; they coincide where steer is zero.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Mapping
from fractions import Fraction

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.vectors import Vector


class Half(
    namedtuple("Half", "x z m ixx iyy izz ixz pivot_x pivot_z wheel_m wheel_r axial diametral")
):
    """A frame with its wheel.

    Attributes
    ----------
    x, z
        Centre of mass of the frame from the hub, along the frame's axes [m].
    m, ixx, iyy, izz, ixz
        Mass of the frame [kg], its inertia matrix about that centre [kg m^2].
    pivot_x, pivot_z
        The pivot from the hub: the point of the steer axis that is on the floor when the bicycle is
        upright and straight [m].
    wheel_m, wheel_r
        Mass [kg] and radius [m] of the wheel.
    axial, diametral
        Inertias of the wheel [kg m^2].
    """

    __slots__ = ()

    def inertia_times(self, v: Vector) -> Vector:
        """The frame's inertia times a vector."""
        x, y, z = v
        return self.ixx * x + self.ixz * z, self.iyy * y, self.ixz * x + self.izz * z

    def wheel_inertia_times(self, v: Vector) -> Vector:
        """The wheel's inertia times a vector."""
        return self.diametral * v[0], self.axial * v[1], self.diametral * v[2]


class Bodies(namedtuple("Bodies", "rear front sin_tilt cos_tilt g")):
    """The rear frame B with wheel R, the fork H with wheel F.

    Attributes
    ----------
    rear, front : Half
    sin_tilt, cos_tilt
        Of the steer axis.
    g
        Gravity [m/s^2].
    """

    __slots__ = ()

    def convert(self, make: Callable[[Number], Number]) -> Bodies:
        """Return the bodies, each number passed through `make`."""
        return Bodies(*(Half(*map(make, x)) if isinstance(x, Half) else make(x) for x in self))


def bodies(bicycle: Bicycle, a: Arithmetic) -> Bodies:
    """The bodies of a bicycle in the number type of `a`."""
    p = {symbol: value.rational for symbol, value in bicycle.values.items()}
    return bodies_of(p, a.number(bicycle["lam"]), a)


def bodies_of(p: Mapping[str, Number], tilt: Number, a: Arithmetic) -> Bodies:
    """The bodies from the parameters as fractions or numbers of `a`, and the tilt."""
    pivot = p["w"] + p["c"]

    def part(frame: str, wheel: str, hub_x: Number) -> Half:
        radius = p[f"r{wheel}"]
        values = {
            "x": p[f"x{frame}"] - hub_x,
            "z": p[f"z{frame}"] + radius,
            **{name: p[f"I{frame}{name[1:]}"] for name in ("ixx", "iyy", "izz", "ixz")},
            "m": p[f"m{frame}"],
            "pivot_x": pivot - hub_x,
            "pivot_z": radius,
            "wheel_m": p[f"m{wheel}"],
            "wheel_r": radius,
            "axial": p[f"I{wheel}yy"],
            "diametral": p[f"I{wheel}xx"],
        }
        return Half(**{name: a.number(x) for name, x in values.items()})

    return Bodies(
        rear=part("B", "R", Fraction(0)), front=part("H", "F", p["w"]),
        sin_tilt=a.sin(tilt), cos_tilt=a.cos(tilt), g=a.number(p["g"]),
    )  # fmt: skip
