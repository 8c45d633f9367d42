"""The four bodies of a bicycle: masses, positions and inertias in SI units.

The equations of motion combine each wheel with the body that carries it (see `constants`). Forces
in the axles and positions of centres of mass need separate bodies. The *axes of a frame* are those
of the parameters, x forward, y right along the axle, z down in the upright, straight position:
those of the rear frame are fixed in it, those of the front frame in the fork. They coincide at zero
steer.

`Axes` converts vectors between these axes:

========== ======================================================================================
heading    x along the heading of the rear wheel, y right, z down: the ground axes turned by yaw
rear       of the rear frame: x forward, y along the axle to the right, z down when upright
front      of the fork: equal to rear at zero steer
steer      z down the steer axis, y right along the front axle, x forward, across both
========== ======================================================================================
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from heyoka_bike.bicycle.equations.kinematics import Posture
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.vectors import Vector, from_turned, minus, plus, scaled


class Half(
    namedtuple("Half", "x z m ixx iyy izz ixz pivot_x pivot_z wheel_m wheel_r axial diametral")
):
    """A frame and its wheel: one of the two halves of the bicycle.

    Attributes
    ----------
    x, z
        Centre of mass of the frame from the hub, along the frame's axes [m].
    m, ixx, iyy, izz, ixz
        Mass of the frame [kg], and its inertia matrix about the centre of mass [kg m^2].
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
        """Return the frame's inertia times a vector."""
        x, y, z = v
        return self.ixx * x + self.ixz * z, self.iyy * y, self.ixz * x + self.izz * z

    def wheel_inertia_times(self, v: Vector) -> Vector:
        """Return the wheel's inertia times a vector."""
        return self.diametral * v[0], self.axial * v[1], self.diametral * v[2]


class Bodies(namedtuple("Bodies", "rear front sin_tilt cos_tilt g")):
    """The rear frame B with wheel R, the fork H with wheel F.

    Attributes
    ----------
    rear, front : Half
    sin_tilt, cos_tilt
        Sine and cosine of the steer axis tilt.
    g
        Gravity [m/s^2].
    """

    __slots__ = ()

    def convert(self, make: Callable[[Number], Number]) -> Bodies:
        """Return the bodies with `make` applied to each of their numbers."""
        return Bodies(*(Half(*map(make, x)) if isinstance(x, Half) else make(x) for x in self))


def bodies(bicycle: Bicycle, a: Arithmetic) -> Bodies:
    """Return the bodies of a bicycle in the number type of `a`."""
    p = {symbol: value.rational for symbol, value in bicycle.values.items()}
    return bodies_of(p, a.number(bicycle["lam"]), a)


def bodies_of(p: Mapping[str, Number], tilt: Number, a: Arithmetic) -> Bodies:
    """Return the bodies for this tilt and parameters, which are fractions or numbers of `a`."""
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


@dataclass(frozen=True, slots=True)
class Axes:
    """Sines and cosines of the angles between axes, to convert vectors from one to the other.

    Attributes
    ----------
    o
        Posture, with the sines and cosines of roll and steer.
    sin_pitch, cos_pitch, sin_tilt, cos_tilt
        Sines and cosines of the pitch and of the steer axis tilt.
    """

    o: Posture
    sin_pitch: Number
    cos_pitch: Number
    sin_tilt: Number
    cos_tilt: Number

    @classmethod
    def of(cls, b: Bodies, o: Posture) -> Axes:
        """Construct the axes in a posture."""
        s, c = b.sin_tilt, b.cos_tilt
        return cls(o, o.sb * c - o.cb * s, o.cb * c + o.sb * s, s, c)

    def from_rear(self, v: Vector) -> Vector:
        """Convert a vector from rear axes to heading axes."""
        o = self.o
        pitched = from_turned("y", self.sin_pitch, self.cos_pitch, v)
        return from_turned("x", o.sin_roll, o.cos_roll, pitched)

    def to_rear(self, v: Vector) -> Vector:
        """Convert a vector from heading axes to rear axes."""
        o = self.o
        rolled = from_turned("x", -o.sin_roll, o.cos_roll, v)
        return from_turned("y", -self.sin_pitch, self.cos_pitch, rolled)

    def from_steer(self, v: Vector) -> Vector:
        """Convert a vector from steer axes to heading axes."""
        o = self.o
        unsteered = from_turned("y", o.sb, o.cb, from_turned("z", o.s, o.c, v))
        return from_turned("x", o.sin_roll, o.cos_roll, unsteered)

    def to_steer(self, v: Vector) -> Vector:
        """Convert a vector from heading axes to steer axes."""
        o = self.o
        rolled = from_turned("x", -o.sin_roll, o.cos_roll, v)
        return from_turned("z", -o.s, o.c, from_turned("y", -o.sb, o.cb, rolled))

    def from_front(self, v: Vector) -> Vector:
        """Convert a vector from front axes to heading axes."""
        return self.from_steer(self.across_tilt(v, back=True))

    def to_front(self, v: Vector) -> Vector:
        """Convert a vector from heading axes to front axes."""
        return self.across_tilt(self.to_steer(v))

    def across_tilt(self, v: Vector, *, back: bool = False) -> Vector:
        """Convert a vector from steer to front axes, or back; at zero steer also to rear axes."""
        return from_turned("y", -self.sin_tilt if back else self.sin_tilt, self.cos_tilt, v)

    @property
    def front_heading(self) -> Vector:
        """Unit vector along the front wheel's heading, where the wheel's plane meets the floor."""
        return self.from_steer((self.o.cb_f, 0, self.o.sb_f))

    @property
    def front_down(self) -> Vector:
        """Unit vector from the front hub towards the lowest point of the front wheel."""
        return self.from_steer((-self.o.sb_f, 0, self.o.cb_f))

    @property
    def rear_down(self) -> Vector:
        """Unit vector from the rear hub towards the lowest point of the rear wheel."""
        return 0, -self.o.sin_roll, self.o.cos_roll


@dataclass(frozen=True, slots=True)
class Points:
    """Points of the bicycle relative to the rear contact point, in heading axes [m]."""

    rear_hub: Vector
    front_hub: Vector
    front_contact: Vector

    @classmethod
    def of(cls, b: Bodies, axes: Axes) -> Points:
        """Compute the points in a posture, from the rear hub to the pivot and onward."""
        rear_pivot, front_pivot = ((part.pivot_x, 0, part.pivot_z) for part in (b.rear, b.front))
        hub = scaled(-b.rear.wheel_r, axes.rear_down)
        hub_f = minus(plus(hub, axes.from_rear(rear_pivot)), axes.from_front(front_pivot))
        return cls(hub, hub_f, plus(hub_f, scaled(b.front.wheel_r, axes.front_down)))
