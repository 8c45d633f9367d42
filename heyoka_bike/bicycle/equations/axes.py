"""The axes in which vectors of the bicycle are given, and turning vectors from one to another.

========== ======================================================================================
heading    x along the heading of the rear wheel, y right, z down: the ground axes turned by yaw
rear       of the rear frame: x forward, y along the axle to the right, z down when upright
front      of the fork: the same as rear where steer is zero
steer      z down the steer axis, y right along the front axle, x forward, across both
========== ======================================================================================
"""

from __future__ import annotations

from dataclasses import dataclass

from heyoka_bike.bicycle.equations.bodies import Bodies
from heyoka_bike.bicycle.equations.kinematics import Posture
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.vectors import (
    Vector,
    from_turned_x,
    from_turned_y,
    from_turned_z,
    minus,
    plus,
    scaled,
)


@dataclass(frozen=True, slots=True)
class Axes:
    """Sines and cosines of the angles between the axes.

    Attributes
    ----------
    o
        With those of roll and steer.
    sin_pitch, cos_pitch, sin_tilt, cos_tilt
        Of the pitch, and of the tilt of the steer axis.
    """

    o: Posture
    sin_pitch: Number
    cos_pitch: Number
    sin_tilt: Number
    cos_tilt: Number

    @classmethod
    def of(cls, b: Bodies, o: Posture) -> Axes:
        """The axes in a posture."""
        s, c = b.sin_tilt, b.cos_tilt
        return cls(o, o.sb * c - o.cb * s, o.cb * c + o.sb * s, s, c)

    def from_rear(self, v: Vector) -> Vector:
        """Heading components of a vector given in rear axes."""
        o = self.o
        pitched = from_turned_y(self.sin_pitch, self.cos_pitch, v)
        return from_turned_x(o.sin_roll, o.cos_roll, pitched)

    def to_rear(self, v: Vector) -> Vector:
        """Rear components of a vector given in heading axes."""
        o = self.o
        rolled = from_turned_x(-o.sin_roll, o.cos_roll, v)
        return from_turned_y(-self.sin_pitch, self.cos_pitch, rolled)

    def from_steer(self, v: Vector) -> Vector:
        """Heading components of a vector given in steer axes."""
        o = self.o
        unsteered = from_turned_y(o.sb, o.cb, from_turned_z(o.s, o.c, v))
        return from_turned_x(o.sin_roll, o.cos_roll, unsteered)

    def to_steer(self, v: Vector) -> Vector:
        """Steer components of a vector given in heading axes."""
        o = self.o
        rolled = from_turned_x(-o.sin_roll, o.cos_roll, v)
        return from_turned_z(-o.s, o.c, from_turned_y(-o.sb, o.cb, rolled))

    def from_front(self, v: Vector) -> Vector:
        """Heading components of a vector given in front axes."""
        return self.from_steer(self.across_tilt(v, back=True))

    def to_front(self, v: Vector) -> Vector:
        """Front components of a vector given in heading axes."""
        return self.across_tilt(self.to_steer(v))

    def across_tilt(self, v: Vector, *, back: bool = False) -> Vector:
        """From steer to front axes, or back; the same for the rear before it is steered."""
        return from_turned_y(-self.sin_tilt if back else self.sin_tilt, self.cos_tilt, v)

    @property
    def front_heading(self) -> Vector:
        """Heading of the front wheel, where its plane meets the floor."""
        return self.from_steer((self.o.cb_f, 0, self.o.sb_f))

    @property
    def front_down(self) -> Vector:
        """From the front hub towards the lowest point of its wheel, a unit vector."""
        return self.from_steer((-self.o.sb_f, 0, self.o.cb_f))

    @property
    def rear_down(self) -> Vector:
        """From the rear hub towards the lowest point of its wheel."""
        return 0, -self.o.sin_roll, self.o.cos_roll


@dataclass(frozen=True, slots=True)
class Points:
    """Points of the bicycle from the rear contact point, in heading axes [m]."""

    rear_hub: Vector
    front_hub: Vector
    front_contact: Vector

    @classmethod
    def of(cls, b: Bodies, axes: Axes) -> Points:
        """The points in a posture: from the rear hub to the pivot, and from there on."""
        rear_pivot, front_pivot = ((part.pivot_x, 0, part.pivot_z) for part in (b.rear, b.front))
        hub = scaled(-b.rear.wheel_r, axes.rear_down)
        hub_f = minus(plus(hub, axes.from_rear(rear_pivot)), axes.from_front(front_pivot))
        return cls(hub, hub_f, plus(hub_f, scaled(b.front.wheel_r, axes.front_down)))
