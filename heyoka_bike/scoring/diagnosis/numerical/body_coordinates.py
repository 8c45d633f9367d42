"""Leading errors of programs that integrate the coordinates of all bodies, with constraints.

Multibody programs discretise positions and Euler parameters of each body, not the state of the
reduced equations, and so have other error terms. A method of order p makes errors in proportion to
the derivatives of order p + 1 of these coordinates:

- of the velocities: the constraint forces project them, in the metric of kinetic energy, onto the
  motions that rolling allows;
- of the positions: roll and steer are read from the bodies that define them;
- of the hinges: where constraints are kept at velocity level only, the axle of a wheel drifts from
  that of its bearing. The misalignment stays, turns with the wheel, and shakes the bicycle at the
  wheel's speed. How it acts on the accelerations is left open, by terms in the square of the speed
  and without it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np

from heyoka_bike.bicycle.equations.kinematics import posture, rear_rates, speeds
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.numerical.variation import SPIN, VELOCITIES, Variations
from heyoka_bike.scoring.diagnosis.programs.start import BODIES, inertial_properties

# Derivatives come from polynomials through this many states on either side, so far apart [s]: the
# wheels turn by a sixth of a radian in between, and the fifth derivative keeps five digits.
_SIDE = 4
_APART = 0.006
_OFFSETS = _APART * np.arange(-_SIDE, _SIDE + 1)
_MONOMIALS = np.linalg.inv(np.vander(_OFFSETS, increasing=True))

_ASSEMBLY: Mapping[str, str] = {"R": "B", "B": "B", "H": "H", "F": "H"}
_WHEELS = "RF"


@dataclass(frozen=True, slots=True)
class _Twists:
    """Velocities of the bodies: of the centres in the fixed frame, angular in the assembly's.

    `wheel` is the rate of each wheel relative to its assembly about the axle.
    """

    velocity: Mapping[str, Array]
    turn: Mapping[str, Array]
    wheel: Mapping[str, Array]
    attitude: Mapping[str, Array]


class BodyCoordinates:
    """Forces on the state that stand for errors in the coordinates of the bodies."""

    def __init__(self, motion: Variations) -> None:
        self._motion = motion
        p = motion.values
        self._tilt = p["lam"]
        self._masses, places, inertias = inertial_properties(p)
        axes = _about_axle(self._tilt)
        self._inertias = {b: axes @ i @ axes.T for b, i in inertias.items()}
        hubs = {"B": places["R"], "H": places["F"]}
        self._arms = {b: axes @ (places[b] - hubs[b]) for b in "BH"}
        self._joint = np.array([float(motion.equations.k.d1 * motion.equations.k.length), 0.0, 0.0])
        self._front_hub = axes @ (places["F"] - places["R"]) - self._joint
        around = self._around()
        found = self._twists(around)
        self._velocity = found.velocity
        self._attitude = dict(found.attitude)
        for b in _WHEELS:
            turned = _turn(1, _integral(found.wheel[b]))
            self._attitude[b] = _times(found.attitude[_ASSEMBLY[b]], turned)
        self._wheel = {b: rate[_SIDE] for b, rate in found.wheel.items()}
        self._units = [self._twists(self._unit(i)) for i in VELOCITIES]
        self._mass = sum(self._work(b, self._units, self._units) for b in BODIES)

    def forces(self, order: int) -> list[Array]:
        """Forces of a method of some order, each of shape (7, maneuvers, points)."""
        return [
            self._of_positions(order + 1),
            self._of_velocities(order + 1),
            *self._of_front_hinge(order + 1),
        ]

    def _of_positions(self, n: int) -> Array:
        """Derivatives of roll, yaw and steer as Euler parameters have them."""
        y = self._motion.states
        rear, front = self._tangent("B", n), self._tangent("H", n)
        beta = y[1] + self._tilt
        force = np.zeros_like(y)
        force[0] = np.cos(beta) * rear[0] + np.sin(beta) * rear[2]
        force[2] = front[2] - rear[2]
        force[6] = (np.cos(beta) * rear[2] - np.sin(beta) * rear[0]) / np.cos(y[0])
        return force

    def _of_velocities(self, n: int) -> Array:
        """Derivatives of the velocities, projected onto the allowed ones."""
        work: Array | float = 0.0
        for b in BODIES:
            linear, angular = _derivative(self._velocity[b], n), self._tangent(b, n + 1)
            for_each = [
                self._masses[b] * np.sum(unit.velocity[b] * linear, axis=0)
                + np.einsum("imn,ij,jmn->mn", unit.turn[b], self._inertias[b], angular)
                for unit in self._units
            ]
            work = work + np.stack(for_each, axis=-1)
        found = np.linalg.solve(self._mass, np.asarray(work)[..., None])[..., 0]
        force = np.zeros_like(self._motion.states)
        force[list(VELOCITIES)] = np.moveaxis(found, -1, 0)
        return force

    def _of_front_hinge(self, n: int) -> list[Array]:
        """The drift of the front axle in its bearing, as it may act on roll and steer."""
        y = self._motion.states
        drift = self._tangent("F", n) - self._tangent("H", n)
        # About e1 and e3 in one complex number, which turns with the wheel.
        rate = drift[0] + 1j * drift[2]
        half = self._motion.step[:, None] / 2
        turned = np.exp(-1j * half * (self._wheel["F"][:, 1:] + self._wheel["F"][:, :-1]))
        angle = np.zeros_like(rate)
        for i in range(rate.shape[1] - 1):
            pushed = angle[:, i] + half[:, 0] * rate[:, i]
            angle[:, i + 1] = turned[:, i] * pushed + half[:, 0] * rate[:, i + 1]
        forces = []
        for part in (angle.real, angle.imag):
            for row in VELOCITIES[:2]:
                for power in (0, 2):
                    force = np.zeros_like(y)
                    force[row] = y[SPIN] ** power * part
                    forces.append(force)
        return forces

    def _tangent(self, b: str, n: int) -> Array:
        """n-th derivative of a body's Euler parameters, as a rotation vector in its assembly."""
        q = self._attitude[b]
        return 2 * _times(_conjugate(q[:, _SIDE]), _derivative(q, n))[1:]

    def _work(self, b: str, one: Sequence[_Twists], other: Sequence[_Twists]) -> Array:
        """A body's part of the mass matrix, shape (maneuvers, points, 3, 3)."""
        v, v2 = (np.stack([u.velocity[b] for u in units]) for units in (one, other))
        w, w2 = (np.stack([u.turn[b] for u in units]) for units in (one, other))
        linear = self._masses[b] * np.einsum("aimn,bimn->mnab", v, v2)
        found: Array = linear + np.einsum("aimn,ij,bjmn->mnab", w, self._inertias[b], w2)
        return found

    def _around(self) -> Array:
        """States before and after each point, shape (7, samples, maneuvers, points)."""
        y = self._motion.states
        samples = {0: y}
        for sign in (1, -1):
            z, h = y, sign * _APART / 2
            for i in range(1, _SIDE + 1):
                z = self._motion.flow(self._motion.flow(z, h), h)
                samples[sign * i] = z
        return np.stack([samples[i] for i in sorted(samples)], axis=1)

    def _unit(self, row: int) -> Array:
        """The positions, with one independent velocity 1 and the others zero."""
        y = self._motion.states.copy()
        y[list(VELOCITIES)] = 0.0
        y[row] = 1.0
        return y

    def _twists(self, y: Array) -> _Twists:
        """Velocities of all bodies in states of shape (7, ...)."""
        k, a = self._motion.equations.k, Arrays()
        o = posture(k, a, y[0], y[1], y[2])
        v = k.rear.r * y[SPIN]
        w1, w3 = rear_rates(o, v, y[3], y[4])
        u = speeds(k, o, v, w1, w3, y[4])
        heading = _times(_turn(2, y[6]), _turn(0, y[0]))
        rear = _times(heading, _turn(1, y[1] + self._tilt))
        front = _times(rear, _turn(2, y[2]))
        turn = {"B": np.stack([u.w1, u.q, u.w3]), "H": np.stack([u.w1_f, u.q_f, u.w3_f])}
        wheel = {"R": -y[SPIN] - u.q, "F": -u.v_f / k.front.r - u.q_f}
        for b in _WHEELS:
            turn[b] = turn[_ASSEMBLY[b]].copy()
            turn[b][1] += wheel[b]
        hub = float(k.length) * np.stack([v, k.rear.r * u.p, np.zeros_like(v)])
        velocity = {"R": _rotated(heading, hub)}
        velocity["B"] = velocity["R"] + _rotated(rear, _cross(turn["B"], self._arms["B"]))
        joint = velocity["R"] + _rotated(rear, _cross(turn["B"], self._joint))
        velocity["F"] = joint + _rotated(front, _cross(turn["H"], self._front_hub))
        velocity["H"] = velocity["F"] + _rotated(front, _cross(turn["H"], self._arms["H"]))
        return _Twists(velocity, turn, wheel, {"B": rear, "H": front})


def _about_axle(tilt: float) -> Array:
    """From the axes of the upright frame to those along the steer axis."""
    s, c = np.sin(tilt), np.cos(tilt)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def _derivative(samples: Array, n: int) -> Array:
    """n-th derivative at the middle of samples of shape (components, samples, ...)."""
    found: Array = np.tensordot(factorial(n) * _MONOMIALS[n], samples, (0, 1))
    return found


def _integral(samples: Array) -> Array:
    """Integral from the middle to each of samples of shape (samples, ...)."""
    powers = np.arange(1, len(_OFFSETS) + 1)
    weights = _OFFSETS[:, None] ** powers / powers @ _MONOMIALS
    found: Array = np.tensordot(weights, samples, (1, 0))
    return found


def _turn(axis: int, angle: Array) -> Array:
    """Quaternion of a turn about an axis, shape (4, ...)."""
    found = np.zeros((4, *angle.shape))
    found[0], found[1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return found


def _conjugate(q: Array) -> Array:
    return np.concatenate([q[:1], -q[1:]])


def _times(a: Array, b: Array) -> Array:
    """Product of quaternions."""
    scalar = a[0] * b[0] - np.sum(a[1:] * b[1:], axis=0)
    vector = a[0] * b[1:] + b[0] * a[1:] + _cross(a[1:], b[1:])
    return np.concatenate([scalar[None], vector])


def _rotated(q: Array, v: Array) -> Array:
    return _times(_times(q, np.concatenate([np.zeros((1, *v.shape[1:])), v])), _conjugate(q))[1:]


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
