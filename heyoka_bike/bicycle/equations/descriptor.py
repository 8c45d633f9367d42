"""The bicycle in descriptor form: redundant coordinates, and contact forces as multipliers.

The frames and wheels move in `COORDINATES`; six velocities of the wheels' lowest points vanish, and
the contact forces along them are the `MULTIPLIERS`. With the energy T - V = L(q, v),

    q' = v,    d/dt dL/dv - dL/dq = G(q)^T lambda,    G(q) v = 0,

a system of index 2. In the system of index 3, the conditions h(q) = 0 on the wheels' heights
replace those on the vertical velocities. Only `from_reduced` uses the reduced equations.

This is not the form in which the reference is integrated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.equations.bodies import Bodies, Half
from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import Configuration, whole_rates
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.dual import Dual, Duals, Traced, Traces
from heyoka_bike.numbers.vectors import Vector, cross, from_turned, minus, plus

COORDINATES = (
    "rear_hub_x", "rear_hub_y", "rear_hub_z", "yaw", "roll", "pitch", "steer", "rear_wheel_angle",
    "front_wheel_angle",
)  # fmt: skip
"""Coordinates in the ground frame [m, rad], see `whole_motion`."""

MULTIPLIERS = (
    "rear_longitudinal_force", "rear_lateral_force", "rear_normal_force",
    "front_longitudinal_force", "front_lateral_force", "front_normal_force",
)  # fmt: skip
"""Forces of the floor on the wheels [N], see `forces.Contact`."""

_NORMAL = (2, 5)
_N = len(COORDINATES)


@dataclass(frozen=True, slots=True)
class _Moving:
    """A frame with its wheel in motion; vectors are along the frame's axes.

    Attributes
    ----------
    part : Half
    hub, turning, wheel_turning
        Velocity of the hub, angular velocities of frame and wheel.
    down
        Vertical unit vector.
    depth
        Position of the hub along `down`.
    """

    part: Half
    hub: Vector
    turning: Vector
    wheel_turning: Vector
    down: Vector
    depth: Number

    def lagrangian2(self, g: Number) -> Number:
        """Return twice the Lagrangian: twice kinetic minus potential energy [J]."""
        p, arm = self.part, (self.part.x, 0, self.part.z)
        centre = plus(self.hub, cross(self.turning, arm))
        depth = self.depth + _dot(self.down, arm)
        return (
            p.m * (_dot(centre, centre) + 2 * g * depth)
            + p.wheel_m * (_dot(self.hub, self.hub) + 2 * g * self.depth)
            + _dot(self.turning, p.inertia_times(self.turning))
            + _dot(self.wheel_turning, p.wheel_inertia_times(self.wheel_turning))
        )

    def contact(self, a: Arithmetic) -> tuple[Number, Number, Number, Number]:
        """Return the velocity of the wheel's lowest point (ahead, aside, up), and its height."""
        x, _, z = self.down
        cos_lean = a.sqrt(x * x + z * z)
        ahead, below = (z / cos_lean, 0, -x / cos_lean), (x / cos_lean, 0, z / cos_lean)
        r = self.part.wheel_r
        arm = (r * below[0], 0, r * below[2])
        u = plus(self.hub, cross(self.wheel_turning, arm))
        aside = cross(self.down, ahead)
        return _dot(ahead, u), _dot(aside, u), -_dot(self.down, u), -(self.depth + r * cos_lean)


def _dot(u: Vector, v: Vector) -> Number:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _moving(
    b: Bodies, a: Arithmetic, q: Sequence[Number], v: Sequence[Number]
) -> tuple[_Moving, _Moving]:
    """Return both frames with their wheels, in motion with these coordinates and rates."""
    (s_yaw, s_roll, s_pitch, s_steer), (c_yaw, c_roll, c_pitch, c_steer) = (
        [f(angle) for angle in q[3:7]] for f in (a.sin, a.cos)
    )

    def pitched(u: Vector) -> Vector:
        return from_turned("y", -s_pitch, c_pitch, u)

    def rolled(u: Vector) -> Vector:
        return from_turned("x", -s_roll, c_roll, u)

    def steered(u: Vector) -> Vector:
        upright = from_turned("y", -b.sin_tilt, b.cos_tilt, u)
        return from_turned(
            "y", b.sin_tilt, b.cos_tilt, from_turned("z", -s_steer, c_steer, upright)
        )

    x, y, z = rolled((0, 0, v[3]))
    turning = plus(pitched((x + v[4], y, z)), (0, v[5], 0))
    hub = pitched(rolled(from_turned("z", -s_yaw, c_yaw, (v[0], v[1], v[2]))))
    down = pitched(rolled((0, 0, 1)))
    rear = _Moving(b.rear, hub, turning, plus(turning, (0, v[7], 0)), down, q[2])
    pivot, pivot_f = ((part.pivot_x, 0, part.pivot_z) for part in (b.rear, b.front))
    turning_f = plus(steered(turning), (v[6] * b.sin_tilt, 0, v[6] * b.cos_tilt))
    hub_f = minus(steered(plus(hub, cross(turning, pivot))), cross(turning_f, pivot_f))
    down_f = steered(down)
    depth_f = q[2] + _dot(down, pivot) - _dot(down_f, pivot_f)
    wheel_f = plus(turning_f, (0, v[8], 0))
    return rear, _Moving(b.front, hub_f, turning_f, wheel_f, down_f, depth_f)


@dataclass(frozen=True, slots=True)
class Descriptor:
    """The equations in descriptor form.

    Attributes
    ----------
    b : Bodies
        Bodies in the number type of `a`, or one that `a` accepts.
    a : Arithmetic
    """

    b: Bodies
    a: Arithmetic

    def inertia_forces(
        self, q: Sequence[Number], v: Sequence[Number], acceleration: Sequence[Number]
    ) -> list[Number]:
        """Return d/dt dL/dv - dL/dq, which the contact forces have to balance."""
        found = self._lagrange(
            [Dual(x, (rate,)) for x, rate in zip(q, v, strict=True)],
            [Dual(x, (rate,)) for x, rate in zip(v, acceleration, strict=True)],
        )
        return [p.slopes[0] - f.value for p, f in zip(*found, strict=True)]

    def mass(self, q: Sequence[Number]) -> list[list[Number]]:
        """Return the mass matrix: derivatives of the momenta with respect to the rates."""
        rates = Duals(self.a).variables([self.a.number(0)] * _N)
        momenta, _ = self._lagrange([Dual(x, (0,) * _N) for x in q], rates)
        return [list(p.slopes) for p in momenta]

    def _lagrange(self, q: Sequence[Dual], v: Sequence[Dual]) -> tuple[list[Dual], list[Dual]]:
        """Return the derivatives of the Lagrangian L with respect to v and to q."""
        traces = Traces(Duals(self.a))
        variables = [Traced(x) for x in (*q, *v)]
        rear, front = _moving(self.b, traces, variables[:_N], variables[_N:])
        both = (rear.lagrangian2(self.b.g) + front.lagrangian2(self.b.g)) / 2
        still = (0,) * len(q[0].slopes)
        found = [
            x if isinstance(x, Dual) else Dual(x, still) for x in traces.gradient(both, variables)
        ]
        return found[_N:], found[:_N]

    def rolling(self, q: Sequence[Number]) -> list[list[Number]]:
        """Return the constraint Jacobian G: contact velocities differentiated by the rates."""
        rates = Duals(self.a).variables([self.a.number(0)] * _N)
        found = self.over(Duals(self.a)).velocities(q, rates)
        return [list(u.slopes) for u in found]

    def over(self, a: Arithmetic) -> Descriptor:
        """Return the same equations for another number type, which accepts the constants."""
        return Descriptor(self.b, a)

    def velocities(self, q: Sequence[Number], v: Sequence[Number]) -> list[Number]:
        """Return G v: velocities of the wheels' lowest points along the `MULTIPLIERS` [m/s]."""
        return [u for half in _moving(self.b, self.a, q, v) for u in half.contact(self.a)[:3]]

    def heights(self, q: Sequence[Number]) -> list[Number]:
        """Return the heights of the wheels' lowest points above the floor [m]."""
        zero = [self.a.number(0)] * _N
        return [half.contact(self.a)[3] for half in _moving(self.b, self.a, q, zero)]

    def residual(self, z: Sequence[Number], rates: Sequence[Number], *, index: int) -> list[Number]:
        """Return the residual of the equations for a state `z` and its time derivative `rates`.

        Parameters
        ----------
        z, rates
            24 numbers each; the derivatives of the multipliers do not enter.
        index
            2 or 3.
        """
        q, v, multipliers = z[:_N], z[_N : 2 * _N], z[2 * _N :]
        needed = self.inertia_forces(q, v, rates[_N : 2 * _N])
        given = [
            self.a.sum([x * u for x, u in zip(column, multipliers, strict=True)])
            for column in zip(*self.rolling(q), strict=True)
        ]
        constraints = self.velocities(q, v)
        if index == 3:
            for i, height in zip(_NORMAL, self.heights(q), strict=True):
                constraints[i] = height
        return [
            *(rate - x for rate, x in zip(rates, v, strict=False)),
            *(x - y for x, y in zip(needed, given, strict=True)),
            *constraints,
        ]


def from_reduced(equations: Equations, y: Sequence[Number]) -> tuple[list[Number], list[Number]]:
    """Return the state of the descriptor form and its derivative from a reduced state.

    Parameters
    ----------
    equations : Equations
    y
        State in the form of the equations, with the yaw and `whole_motion.INTEGRALS`.
    """
    once = Duals(equations.a)
    moving = [Dual(x, (f,)) for x, f in zip(y, whole_rates(equations, y), strict=True)]
    rates = whole_rates(equations.over(once), moving)
    twice = equations.over(Duals(once))
    q = _coordinates(twice, [Dual(x, (f,)) for x, f in zip(moving, rates, strict=True)])
    contacts = forces(equations, y[:6])
    multipliers = [
        x for c in (contacts.rear, contacts.front) for x in (c.longitudinal, c.lateral, c.normal)
    ]
    values = [x.value.value for x in q]
    speeds = [x.value.slopes[0] for x in q]
    accelerations = [x.slopes[0].slopes[0] for x in q]
    still = [equations.a.number(0)] * len(multipliers)
    return [*values, *speeds, *multipliers], [*speeds, *accelerations, *still]


def _coordinates(equations: Equations, y: Sequence[Number]) -> list[Number]:
    roll, pitch, steer = y[:3]
    hub = Configuration.of(equations, y).places()["rear_hub"]
    return [*hub, y[6], roll, pitch, steer, *y[9:]]


def to_reduced(b: Bodies, a: Arithmetic, z: Sequence[Number]) -> list[Number]:
    """Convert a state of the descriptor form to the regular form, with yaw and integrals."""
    q, v = z[:_N], z[_N : 2 * _N]
    x, y, _, yaw, roll, pitch, steer, *wheels = q
    rear, _ = _moving(b, a, q, v)
    aside = b.rear.wheel_r * a.sin(roll)
    contact = x + aside * a.sin(yaw), y - aside * a.cos(yaw)
    spin = -rear.wheel_turning[1]
    return [roll, pitch, steer, v[4], v[6], spin, yaw, *contact, *wheels]
