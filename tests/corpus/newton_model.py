"""The bicycle by the Newton-Euler equations in the coordinates of the four bodies.

A program as a student writes it from a textbook. Each body has a position, a quaternion, a velocity
and an angular velocity in global axes. The accelerations and the reactions of three hinges and two
rolling wheels are the solution of one linear system. Switches make the usual mistakes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from corpus.benchmark import MANEUVERS, TABLE_1, Array, Columns
from corpus.methods import Method

B, H, R, F = range(4)
"""Rear frame, fork, rear wheel, front wheel."""
_DOWN = np.array([0.0, 0.0, 1.0])
_AXLE = np.array([0.0, 1.0, 0.0])


def _skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _cross(a: Array, b: Array) -> Array:
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _attitude(q: Array) -> Array:
    w, x, y, z = q / np.sqrt(q @ q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])  # fmt: skip


def _across(axis: Array) -> tuple[Array, Array]:
    """Two directions perpendicular to an axis in the plane of the bicycle, or to an axle."""
    if axis is _AXLE:
        return np.array([1.0, 0.0, 0.0]), _DOWN
    return _AXLE, _cross(axis, _AXLE)


@dataclass(frozen=True)
class Program:
    """A program; its defaults are correct.

    Attributes
    ----------
    gyroscopic
        Bodies whose torque w x (I w) is in Euler's equations.
    turned_by
        Bodies whose inertia tensor wrongly turns with another body; with None it does not turn.
    contact
        Contact point of a wheel: ``rim``, its lowest point; ``below``, straight below the hub.
    weightless
        Bodies without weight.
    applied
        Function of attitudes, velocities and angular velocities that returns the forces and
        torques on the bodies in addition to weight, as an array of shape (4, 6).
    method
    """

    method: Method
    gyroscopic: tuple[int, ...] = (B, H, R, F)
    turned_by: Mapping[int, int | None] = field(default_factory=dict)
    contact: str = "rim"
    weightless: tuple[int, ...] = ()
    applied: Callable[[list[Array], Array, Array], Array] | None = None
    p: Mapping[str, float] = field(default_factory=lambda: TABLE_1)

    def compute(self, maneuver: int) -> Columns:
        states = self.method(self.slope, self.start(*MANEUVERS[maneuver]), self._lean)
        return self.output(states)

    def _lean(self, state: Array) -> float:
        return float(np.arcsin((_attitude(state[12:16]) @ _AXLE)[2]))

    def _centres(self) -> Array:
        p = self.p
        return np.array([
            [p["xB"], 0, p["zB"]], [p["xH"], 0, p["zH"]], [0, 0, -p["rR"]], [p["w"], 0, -p["rF"]]
        ])  # fmt: skip

    def _tensors(self) -> list[Array]:
        found = []
        for letter in "BHRF":
            xx, yy = self.p[f"I{letter}xx"], self.p[f"I{letter}yy"]
            zz, xz = self.p.get(f"I{letter}zz", xx), self.p.get(f"I{letter}xz", 0.0)
            found.append(np.array([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]]))
        return found

    def _masses(self) -> list[float]:
        return [self.p[f"m{letter}"] for letter in "BHRF"]

    def start(self, v: float, roll_rate: float) -> Array:
        """Initial state: positions (12), quaternions (16), velocities (12), angular velocities
        (12)."""
        places, roll = self._centres(), np.array([roll_rate, 0.0, 0.0])
        quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (4, 1))
        velocities = np.array([v, 0.0, 0.0]) + np.cross(roll, places)
        spins = np.tile(roll, (4, 1))
        spins[R] -= v / self.p["rR"] * _AXLE
        spins[F] -= v / self.p["rF"] * _AXLE
        return np.concatenate([x.ravel() for x in (places, quaternions, velocities, spins)])

    def slope(self, _: float, state: Array) -> Array:
        places, velocities = state[:12].reshape(4, 3), state[28:40].reshape(4, 3)
        quaternions, spins = state[12:28].reshape(4, 4), state[40:].reshape(4, 3)
        attitudes = [_attitude(q) for q in quaternions]
        n, rows, right = np.zeros((45, 45)), [], []
        force = np.zeros(45)
        for i, (mass, tensor) in enumerate(zip(self._masses(), self._tensors(), strict=True)):
            by = self.turned_by.get(i, i)
            a = np.eye(3) if by is None else attitudes[by]
            tensor = a @ tensor @ a.T
            n[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = mass * np.eye(3)
            n[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = tensor
            if i not in self.weightless:
                force[6 * i : 6 * i + 3] = mass * self.p["g"] * _DOWN
            if i in self.gyroscopic:
                force[6 * i + 3 : 6 * i + 6] = -_cross(spins[i], tensor @ spins[i])
        if self.applied is not None:
            force[:24] += self.applied(attitudes, velocities, spins).ravel()
        for one, other, point, axis in self._hinges():
            self._hinge(rows, right, places, attitudes, spins, one, other, point, axis)
        for wheel, radius in ((R, self.p["rR"]), (F, self.p["rF"])):
            self._rolling(rows, right, attitudes[wheel] @ _AXLE, spins[wheel], wheel, radius)
        conditions = np.vstack(rows)
        n[24:, :24], n[:24, 24:] = conditions, -conditions.T
        force[24:] = np.concatenate(right)
        found = np.linalg.solve(n, force)[:24].reshape(4, 6)
        turning = np.empty((4, 4))
        turning[:, 0] = -np.sum(spins * quaternions[:, 1:], axis=1) / 2
        turning[:, 1:] = (quaternions[:, :1] * spins + np.cross(spins, quaternions[:, 1:])) / 2
        return np.concatenate(
            [velocities.ravel(), turning.ravel(), found[:, :3].ravel(), found[:, 3:].ravel()]
        )

    def _hinges(self) -> tuple[tuple[int, int, Array, Array], ...]:
        """Each hinge: two bodies, a point, and the axis on the upright bicycle."""
        p, centres = self.p, self._centres()
        steer = np.array([np.sin(p["lam"]), 0.0, np.cos(p["lam"])])
        foot = np.array([p["w"] + p["c"], 0.0, 0.0])
        return (
            (B, R, centres[R], _AXLE), (H, F, centres[F], _AXLE), (B, H, foot, steer),
        )  # fmt: skip

    def _hinge(
        self, rows: list[Array], right: list[Array], places: Array, attitudes: list[Array],
        spins: Array, one: int, other: int, point: Array, axis: Array,
    ) -> None:  # fmt: skip
        centres = self._centres()
        s, t = (attitudes[i] @ (point - centres[i]) for i in (one, other))
        j = np.zeros((3, 24))
        j[:, 6 * one : 6 * one + 3], j[:, 6 * other : 6 * other + 3] = np.eye(3), -np.eye(3)
        j[:, 6 * one + 3 : 6 * one + 6], j[:, 6 * other + 3 : 6 * other + 6] = -_skew(s), _skew(t)
        rows.append(j)
        w, x = spins[one], spins[other]
        right.append(_cross(x, _cross(x, t)) - _cross(w, _cross(w, s)))
        n = attitudes[other] @ axis
        for across in _across(axis):
            d = attitudes[one] @ across
            j, normal = np.zeros((1, 24)), _cross(d, n)
            j[0, 6 * one + 3 : 6 * one + 6], j[0, 6 * other + 3 : 6 * other + 6] = normal, -normal
            rows.append(j)
            change = _cross(_cross(w, d), n) + _cross(d, _cross(x, n))
            right.append(np.array([-(w - x) @ change]))

    def _rolling(
        self, rows: list[Array], right: list[Array], axle: Array, spin: Array, wheel: int,
        radius: float,
    ) -> None:  # fmt: skip
        if self.contact == "rim":
            to = _DOWN - (_DOWN @ axle) * axle
            turn = _cross(spin, axle)
            change = -(_DOWN @ turn) * axle - (_DOWN @ axle) * turn
            length = np.sqrt(to @ to)
            arm = radius * to / length
            moving = radius * (change / length - to * (to @ change) / length**3)
        else:
            arm, moving = radius * _DOWN, np.zeros(3)
        j = np.zeros((3, 24))
        j[:, 6 * wheel : 6 * wheel + 3] = np.eye(3)
        j[:, 6 * wheel + 3 : 6 * wheel + 6] = -_skew(arm)
        rows.append(j)
        right.append(-_cross(spin, moving))

    def output(self, states: Array) -> Columns:
        """Angles and rates from the attitudes of the bodies; energies as sums over the bodies."""
        found: list[list[float]] = []
        masses, tensors = self._masses(), self._tensors()
        steer_axis = self._hinges()[2][3]
        for state in states.T:
            if np.isnan(state).any():
                found.append([np.nan] * 7)
                continue
            places, velocities = state[:12].reshape(4, 3), state[28:40].reshape(4, 3)
            spins = state[40:].reshape(4, 3)
            attitudes = [_attitude(q) for q in state[12:28].reshape(4, 4)]
            axle = attitudes[B] @ _AXLE
            heading = _cross(axle, _DOWN) / np.hypot(axle[0], axle[1])
            potential = -sum(m * self.p["g"] * r[2] for m, r in zip(masses, places, strict=True))
            kinetic = sum(
                (m * v @ v + (a.T @ w) @ i @ (a.T @ w)) / 2
                for m, v, w, a, i in zip(masses, velocities, spins, attitudes, tensors, strict=True)
            )
            axis = attitudes[B] @ steer_axis
            turned = attitudes[H] @ _AXLE
            found.append([
                np.arcsin(axle[2]), spins[B] @ heading, velocities[R] @ heading, potential,
                kinetic, np.arctan2(_cross(axle, turned) @ axis, axle @ turned),
                (spins[H] - spins[B]) @ axis])  # fmt: skip
        names = ("roll", "roll_rate", "speed", "potential", "kinetic", "steer", "steer_rate")
        return dict(zip(names, np.array(found).T, strict=True))
