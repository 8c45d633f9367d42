"""Newton's and Euler's equations of rigid bodies under constraints, in redundant coordinates.

Each body has its own acceleration (3) and angular acceleration (3). With a constraint's condition
J v = 0, they solve one linear system together with the reactions r,

    M a - J^T r = weight - gyroscopic torque,        J a = -(dJ/dt) v.

There is no generalised coordinate, no Lagrangian and no projection. The equations are those of any
textbook, for example P. E. Nikravesh, "Computer-Aided Analysis of Mechanical Systems", Prentice
Hall (1988), chapter 11.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from oracles.vectors import Arithmetic, Matrix, Number, Vector, axes, zero

Parts = Mapping[str, tuple[Vector, Vector]]
"""Coefficients of each body's velocity and angular velocity in a sum."""


@dataclass(frozen=True)
class Body:
    """A rigid body in its current position.

    Attributes
    ----------
    mass
    inertia
        Inertia about the centre of mass, in the body's axes.
    attitude
        Rotation from the body's axes to the inertial ones.
    centre
        Position of the centre of mass.
    weight
        Force of gravity.
    """

    mass: Number
    inertia: Matrix
    attitude: Matrix
    centre: Vector
    weight: Vector

    def momentum(self, omega: Vector) -> Vector:
        """Return the angular momentum about the centre of mass."""
        return self.attitude(self.inertia(self.attitude.transposed(omega)))


@dataclass(frozen=True)
class Twist:
    """Velocity of the centre of mass and angular velocity, or their time derivatives."""

    linear: Vector
    angular: Vector


Twists = Mapping[str, Twist]


class Constraint(Protocol):
    """Conditions J v = 0, and the term (dJ/dt) v of their derivative."""

    @property
    def name(self) -> str: ...
    def rows(self) -> list[Parts]: ...
    def rest(self, velocities: Twists) -> Sequence[Number]: ...


@dataclass(frozen=True)
class SamePoint:
    """The constraint that a point of `inner` and a point of `outer` have the same velocity.

    Each arm is the vector from the centre of mass of its body to the point. The
    reaction is the force on `outer`.
    """

    number: Arithmetic
    name: str
    inner: str
    outer: str
    inner_arm: Vector
    outer_arm: Vector

    def rows(self) -> list[Parts]:
        return [
            {self.outer: (e, self.outer_arm.cross(e)), self.inner: (-e, -self.inner_arm.cross(e))}
            for e in axes(self.number)
        ]

    def rest(self, velocities: Twists) -> Sequence[Number]:
        i, o = velocities[self.inner].angular, velocities[self.outer].angular
        return o.cross(o.cross(self.outer_arm)) - i.cross(i.cross(self.inner_arm))


@dataclass(frozen=True)
class SameAxis:
    """`outer` turns relative to `inner` about neither of two directions fixed in `inner`.

    The reactions are the components of the torque on `outer` along these directions.
    """

    number: Arithmetic
    name: str
    inner: str
    outer: str
    directions: tuple[Vector, Vector]

    def rows(self) -> list[Parts]:
        none = zero(self.number)
        return [{self.outer: (none, t), self.inner: (none, -t)} for t in self.directions]

    def rest(self, velocities: Twists) -> Sequence[Number]:
        i, o = velocities[self.inner].angular, velocities[self.outer].angular
        return [i.cross(t).dot(o - i) for t in self.directions]


@dataclass(frozen=True)
class Rolling:
    """The material point at the lowest point of a wheel's rim is at rest.

    The reaction is the force of the floor on the wheel.
    """

    number: Arithmetic
    name: str
    wheel: str
    axle: Vector
    radius: Number

    def rows(self) -> list[Parts]:
        arm = to_rim(self.number, self.axle, self.radius)
        return [{self.wheel: (e, arm.cross(e))} for e in axes(self.number)]

    def rest(self, velocities: Twists) -> Sequence[Number]:
        omega = velocities[self.wheel].angular
        # The arm is radius * u / |u| with u = k - (k.n) n. The spin does not move the axle n.
        down, n = axes(self.number)[2], self.axle
        n_dot = omega.cross(n)
        u = down - down.dot(n) * n
        u_dot = -(down.dot(n_dot) * n) - down.dot(n) * n_dot
        square = u.dot(u)
        arm_dot = (self.radius / self.number.sqrt(square)) * (u_dot - (u.dot(u_dot) / square) * u)
        return omega.cross(arm_dot)


def to_rim(number: Arithmetic, axle: Vector, radius: Number) -> Vector:
    """Return the vector from a wheel's hub to the lowest point of its rim."""
    down = axes(number)[2]
    in_plane = down - down.dot(axle) * axle
    arm: Vector = (radius / number.sqrt(in_plane.dot(in_plane))) * in_plane
    return arm


def solve_velocities(
    number: Arithmetic,
    bodies: Sequence[str],
    constraints: Sequence[Constraint],
    given: Sequence[tuple[Parts, Number]],
) -> dict[str, Twist]:
    """Return the velocities that satisfy the constraints and have the given sums."""
    conditions = [(parts, number.exact(0)) for c in constraints for parts in c.rows()]
    conditions += given
    matrix = [_dense(number, bodies, parts) for parts, _ in conditions]
    return _by_body(bodies, number.solve(matrix, [value for _, value in conditions]))


def solve_accelerations(
    number: Arithmetic,
    bodies: Mapping[str, Body],
    constraints: Sequence[Constraint],
    velocities: Twists,
) -> tuple[dict[str, Twist], dict[str, list[Number]]]:
    """Return accelerations by body, and reactions by constraint."""
    nought = number.exact(0)
    jacobian = [_dense(number, tuple(bodies), parts) for c in constraints for parts in c.rows()]
    own, total = 6 * len(bodies), 6 * len(bodies) + len(jacobian)
    matrix = [[nought] * total for _ in range(total)]
    rhs: list[Number] = []
    for i, (name, body) in enumerate(bodies.items()):
        for k, e in enumerate(axes(number)):
            matrix[6 * i + k][6 * i + k] = body.mass
            for j, x in enumerate(body.momentum(e)):
                matrix[6 * i + 3 + j][6 * i + 3 + k] = x
        omega = velocities[name].angular
        rhs += [*body.weight, *(-gyroscopic_torque(omega, body.momentum(omega)))]
    for r, row in enumerate(jacobian):
        for k, x in enumerate(row):
            matrix[k][own + r] = -x
            matrix[own + r][k] = x
    rhs += [-x for c in constraints for x in c.rest(velocities)]

    solution = number.solve(matrix, rhs)
    reactions = iter(solution[own:])
    return _by_body(tuple(bodies), solution[:own]), {
        c.name: list(itertools.islice(reactions, len(c.rows()))) for c in constraints
    }


def gyroscopic_torque(omega: Vector, momentum: Vector) -> Vector:
    """Return the rate of change of the angular momentum at constant angular velocity."""
    return omega.cross(momentum)


def _dense(number: Arithmetic, bodies: Sequence[str], parts: Parts) -> list[Number]:
    none = (zero(number), zero(number))
    return [x for body in bodies for vector in parts.get(body, none) for x in vector]


def _by_body(bodies: Sequence[str], numbers: Sequence[Number]) -> dict[str, Twist]:
    return {
        body: Twist(Vector(numbers[6 * i : 6 * i + 3]), Vector(numbers[6 * i + 3 : 6 * i + 6]))
        for i, body in enumerate(bodies)
    }
