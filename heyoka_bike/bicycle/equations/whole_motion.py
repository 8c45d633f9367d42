"""The whole motion: positions, attitudes and rotation of all parts; columns of motion.h5.

The module `columns` lists the meaning of each column.

The *ground frame* has x along the initial heading, y to the right, z down, and its origin at the
initial rear contact point. Yaw, position and wheel angles do not enter the equations of motion;
they are integrals of functions of the state. All other columns follow from the state and these
integrals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import flint

from heyoka_bike.bicycle.equations.bodies import Axes, Points
from heyoka_bike.bicycle.equations.constants import Constants
from heyoka_bike.bicycle.equations.forces import Forces, forces
from heyoka_bike.bicycle.equations.kinematics import Posture, Speeds
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.numbers.arithmetic import Balls, Number
from heyoka_bike.numbers.vectors import Quaternion, Vector, from_turned, plus, product, scaled

INTEGRALS = ("rear_contact_x", "rear_contact_y", "rear_wheel_angle", "front_wheel_angle")
"""Names of the integrals of `rates_of_integrals`, zero at the start."""


def wheel_rates(k: Constants, u: Speeds) -> tuple[Number, Number]:
    """Return the rotation rates of the wheels in their frames [rad/s]; forward is negative."""
    return -(u.v / k.rear.r + u.q), -(u.v_f / k.front.r + u.q_f)


def track_speeds(k: Constants, u: Speeds) -> tuple[Number, Number]:
    """Return the speeds of the contact points along their tracks [m/s].

    The contact point of a rolling wheel moves along its heading by the length of rim that passes
    it. With the roll frame's rate nu about the axle (see `kinematics`), the speed is v + r nu.
    """
    return k.length * (u.v + k.rear.r * u.nu), k.length * (u.v_f + k.front.r * u.nu_f)


def rates_of_integrals(equations: Equations, state: Sequence[Number]) -> list[Number]:
    """Return the time derivatives of `INTEGRALS`; the yaw is the seventh entry of the state."""
    k, a, yaw = equations.k, equations.a, state[6]
    _, u = equations.unfold(state)
    speed, _ = track_speeds(k, u)
    return [speed * a.cos(yaw), speed * a.sin(yaw), *wheel_rates(k, u)]


def whole_rates(equations: Equations, state: Sequence[Number]) -> list[Number]:
    """Return the time derivatives of the state with the yaw and `INTEGRALS`."""
    return [*equations.rates_with_yaw(state), *rates_of_integrals(equations, state)]


@dataclass(frozen=True, slots=True)
class Configuration:
    """Positions [m] in the ground frame, attitudes, and angular velocities [rad/s].

    Each is computed on first use.

    Attributes
    ----------
    equations : Equations
    o, u
        See `kinematics.unfold`.
    angles
        Roll, pitch, steer and yaw [rad].
    x, y
        Coordinates of the rear contact point [m].
    """

    equations: Equations
    o: Posture
    u: Speeds
    angles: Sequence[Number]
    x: Number
    y: Number

    @classmethod
    def of(cls, equations: Equations, state: Sequence[Number]) -> Configuration:
        """Return the configuration of a state that includes the yaw and `INTEGRALS`."""
        roll, pitch, steer, *_, yaw = state[:7]
        o, u = equations.unfold(state)
        return cls(equations, o, u, (roll, pitch, steer, yaw), state[7], state[8])

    @property
    def _axes(self) -> Axes:
        return Axes.of(self.equations.b, self.o)

    def _turned(self, v: Vector) -> Vector:
        """Convert a vector from heading axes to the ground frame."""
        yaw = self.angles[3]
        a = self.equations.a
        return from_turned("z", a.sin(yaw), a.cos(yaw), v)

    def places(self) -> dict[str, Vector]:
        """Positions of contact points, hubs, and centres of mass of the frames and the bicycle.

        The centre of mass of a wheel is its hub.
        """
        a, b, axes = self.equations.a, self.equations.b, self._axes
        points = Points.of(b, axes)
        rear = plus(points.rear_hub, axes.from_rear((b.rear.x, 0, b.rear.z)))
        front = plus(points.front_hub, axes.from_front((b.front.x, 0, b.front.z)))
        parts = (
            (b.rear.wheel_m, points.rear_hub), (b.rear.m, rear),
            (b.front.wheel_m, points.front_hub), (b.front.m, front),
        )  # fmt: skip
        total = a.sum([m for m, _ in parts])
        x, y, z = (a.sum([m * v[i] for m, v in parts]) / total for i in range(3))
        from_contact = {
            "front_contact": points.front_contact,
            "rear_hub": points.rear_hub,
            "front_hub": points.front_hub,
            "rear_frame_com": rear,
            "front_frame_com": front,
            "com": (x, y, z),
        }
        turned = {name: self._turned(v) for name, v in from_contact.items()}
        return {name: (self.x + v[0], self.y + v[1], v[2]) for name, v in turned.items()}

    def attitudes(self) -> dict[str, tuple[Vector, Vector, Vector]]:
        """Axes of rear frame and fork in the ground frame: the columns of rotation matrices."""
        axes = self._axes
        x, y, z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
        return {
            name: (self._turned(turn(x)), self._turned(turn(y)), self._turned(turn(z)))
            for name, turn in (("rear_frame", axes.from_rear), ("front_frame", axes.from_front))
        }

    def quaternions(self) -> dict[str, Quaternion]:
        """Attitudes of rear frame and fork as unit quaternions: rotate by yaw, roll, pitch, steer.

        The signs follow from half the angles, so the quaternions are continuous.
        """
        a, b = self.equations.a, self.equations.b
        sines, cosines = ([f(x / 2) for x in self.angles] for f in (a.sin, a.cos))
        yawed, rolled = (cosines[3], 0, 0, sines[3]), (cosines[0], sines[0], 0, 0)
        rear = product(product(yawed, rolled), (cosines[1], 0, sines[1], 0))
        along = scaled(sines[2], (b.sin_tilt, 0, b.cos_tilt))
        return {"rear_frame": rear, "front_frame": product(rear, (cosines[2], *along))}

    def turning(self) -> dict[str, Vector]:
        """Angular velocities of rear frame and fork, each along its own axes."""
        axes, u = self._axes, self.u
        return {
            "rear_frame": axes.across_tilt((u.w1, u.q, u.w3)),
            "front_frame": axes.across_tilt((u.w1_f, u.q_f, u.w3_f)),
        }

    def spins(self) -> dict[str, Number]:
        """Absolute angular velocities of the wheels about their axles [rad/s]."""
        k = self.equations.k
        return {
            "rear_wheel": -(self.u.v / k.rear.r),
            "front_wheel": -(self.u.v_f / k.front.r),
        }


class NonnegativeRoots(Balls):
    """Ball arithmetic for square roots of nonnegative numbers whose balls may reach below zero.

    The radicands in the columns are sums of squares: of velocities, or of a tangential force.
    """

    def sqrt(self, x: flint.arb) -> flint.arb:
        root: flint.arb = super().sqrt(x)
        if root.is_finite():
            return root
        half = x.upper().sqrt() / 2
        return flint.arb(half, half.upper())


def motion_columns(equations: Equations, state: Sequence[Number]) -> dict[str, Number]:
    """Return every column of `MOTION_COLUMNS` by name, SI units.

    Parameters
    ----------
    equations : Equations
    state
        State in the form of the equations, with the yaw and then `INTEGRALS`.
    """
    f, a = forces(equations, state), equations.a
    found = _dense(Configuration.of(equations, state), f, state)
    found |= {"rear_friction": f.rear.friction(a), "front_friction": f.front.friction(a)}
    return {c.name: found[c.name] for c in MOTION_COLUMNS}


def dense_columns(equations: Equations, state: Sequence[Number]) -> list[Number]:
    """Return the values of `DENSE_COLUMNS`, which are analytic: without square roots of forces."""
    found = _dense(Configuration.of(equations, state), forces(equations, state), state)
    return [found[name] for name in DENSE_COLUMNS]


def _dense(c: Configuration, f: Forces, state: Sequence[Number]) -> dict[str, Number]:
    found = dict(zip(INTEGRALS, state[7:], strict=True))
    for name, v in c.places().items():
        found |= named(name, v)
    for name, v in c.turning().items():
        found |= named(f"{name}_omega", v)
    for name, q in c.quaternions().items():
        found |= {f"{name}_q{i}": x for i, x in enumerate(q)}
    for name, columns in c.attitudes().items():
        for j, axis in enumerate(columns, start=1):
            found |= {f"{name}_r{i}{j}": x for i, x in enumerate(axis, start=1)}
    found |= {f"{name}_omega_y": x for name, x in c.spins().items()}
    for end, contact in (("rear", f.rear), ("front", f.front)):
        found |= {
            f"{end}_normal_force": contact.normal,
            f"{end}_longitudinal_force": contact.longitudinal,
            f"{end}_lateral_force": contact.lateral,
        }
    for name, joint in (
        ("rear_axle", f.rear_axle), ("front_axle", f.front_axle), ("steer_joint", f.steer)
    ):  # fmt: skip
        found |= named(f"{name}_force", joint.force) | named(f"{name}_moment", joint.moment)
    return found


def named(name: str, v: Vector) -> dict[str, Number]:
    """Return the components of a vector by the names of their columns."""
    return {f"{name}_{axis}": x for axis, x in zip("xyz", v, strict=True)}
