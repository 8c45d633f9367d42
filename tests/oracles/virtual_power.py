"""The virtual power of the bicycle's four rigid bodies along a motion that is given.

Positions follow from the yaw, roll, pitch and steer angles. Velocities are linear in the rates of
these angles and of the wheels. Accelerations are the derivatives of the velocities with respect to
time. No equation of motion is solved. By the principle of virtual power (Jourdain's principle), a
motion obeys Newton's and Euler's equations if

    sum over the bodies of (d(m v)/dt - m g k) . v* + dH/dt . w* = 0

for all virtual velocities v*, w* that the bearings and the rolling wheels allow. Here v is the
velocity of a body's centre of mass, and H its angular momentum about this centre. The reactions of
the bearings and of the floor have no power at these velocities.

Bodies, axes and parameters are those of `newton_euler`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from heyoka_bike.bicycle.parameters import Bicycle
from oracles.multibody import to_rim
from oracles.vectors import Arithmetic, Matrix, Number, Vector, axes, product, rotation

FREE = ("roll", "steer", "spin")
"""The independent rates. The spin is the rear wheel's, positive when it rolls forward."""
BOUND = ("yaw", "pitch", "front wheel")
"""The rates that follow, because the front wheel rolls."""


@dataclass(frozen=True, slots=True)
class Jet:
    """A number and its derivative with respect to time."""

    value: Number
    rate: Number

    def __add__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.value + other.value, self.rate + other.rate)
        return Jet(self.value + other, self.rate)

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.rate)

    def __sub__(self, other: Any) -> Jet:
        return self + -other

    def __rsub__(self, other: Any) -> Jet:
        return -self + other

    def __mul__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            rate = self.value * other.rate + self.rate * other.value
            return Jet(self.value * other.value, rate)
        if isinstance(other, Vector):
            return NotImplemented
        return Jet(self.value * other, self.rate * other)

    def __truediv__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            quotient = self.value / other.value
            return Jet(quotient, (self.rate - quotient * other.rate) / other.value)
        return Jet(self.value / other, self.rate / other)

    def __rtruediv__(self, other: Any) -> Jet:
        quotient = other / self.value
        return Jet(quotient, -(quotient * self.rate) / self.value)

    __radd__ = __add__
    __rmul__ = __mul__

    def sin(self) -> Jet:
        return Jet(self.value.sin(), self.rate * self.value.cos())

    def cos(self) -> Jet:
        return Jet(self.value.cos(), -(self.rate * self.value.sin()))

    def sqrt(self) -> Jet:
        root = self.value.sqrt()
        return Jet(root, self.rate / (2 * root))


@dataclass(frozen=True)
class Balance:
    """What a motion violates at one time; everything but `terms` is zero for the bicycle's motion.

    Attributes
    ----------
    height
        Height of the front wheel's lowest point above the floor [m].
    slip
        Velocity of the front wheel's material point there [m/s]. Its component along the heading
        is zero, because it determines the front wheel's rate.
    terms
        For each rate in `FREE`, set to 1 as a virtual velocity: the power of each body's inertia
        force, weight and inertia moment [N m].
    """

    height: Number
    slip: Vector
    terms: Mapping[str, list[Number]]

    @property
    def powers(self) -> dict[str, Number]:
        """The virtual power for each rate in `FREE` [N m]."""
        return {rate: sum(terms) for rate, terms in self.terms.items()}


def balance(
    number: Arithmetic, bicycle: Bicycle, angles: Mapping[str, Jet], rates: Mapping[str, Jet]
) -> Balance:
    """Evaluate the rolling of the front wheel and the virtual power.

    Parameters
    ----------
    number
        Arithmetic of the parameters; its functions must accept jets.
    bicycle
    angles
        Yaw, roll, pitch and steer [rad].
    rates
        The rates of these angles and the spin [rad/s].
    """
    p = {symbol: number.exact(x) for symbol, x in bicycle.values.items()}
    x, y, z = axes(number)
    turned = rotation(number, z, angles["yaw"])
    heading, leaned = turned(x), product(turned, rotation(number, x, angles["roll"]))
    rear = product(leaned, rotation(number, y, angles["pitch"]))
    tilted = Vector((number.sin(p["lam"]), 0, number.cos(p["lam"])))
    front = product(rear, rotation(number, tilted, angles["steer"]))
    axle, steer_axis, front_axle = rear(y), rear(tilted), front(y)
    arm, front_arm = to_rim(number, axle, p["rR"]), to_rim(number, front_axle, p["rF"])
    attitudes = {"R": rear, "B": rear, "H": front, "F": front}

    # Vectors from the rear hub to the centres of mass, and to the point of the steer bearing that
    # is on the floor in the reference position
    pivot = rear(Vector((p["w"] + p["c"], 0, p["rR"])))
    to_fork = front(Vector((p["xH"] - p["w"] - p["c"], 0, p["zH"])))
    to_front_hub = front(Vector((-p["c"], 0, -p["rF"])))
    to_frame = rear(Vector((p["xB"], 0, p["zB"] + p["rR"])))

    # Velocities of the bodies if one rate is 1 and the others are 0
    omega, velocity, slip = {}, {}, {}
    for rate in (*FREE, *BOUND):
        frame = {"yaw": z, "roll": heading, "pitch": axle}.get(rate, 0 * z)
        fork = steer_axis if rate == "steer" else frame
        wheel = front_axle if rate == "front wheel" else fork
        # The spin is the whole angular velocity of the rear wheel about its axle.
        rear_wheel = -axle if rate == "spin" else frame - frame.dot(axle) * axle
        hub = arm.cross(rear_wheel)
        bearing = hub + frame.cross(pivot)
        front_hub = bearing + fork.cross(to_front_hub)
        omega[rate] = {"R": rear_wheel, "B": frame, "H": fork, "F": wheel}
        velocity[rate] = {
            "R": hub,
            "B": hub + frame.cross(to_frame),
            "H": bearing + fork.cross(to_fork),
            "F": front_hub,
        }
        slip[rate] = front_hub + wheel.cross(front_arm)

    without = _combined(rates, slip)
    along = slip["front wheel"]
    wheel_rate = -without.dot(along) / along.dot(along)
    actual = {**rates, "front wheel": wheel_rate}
    allowed = {rate: _allowed(rate, slip) for rate in FREE}
    terms: dict[str, list[Number]] = {rate: [] for rate in FREE}
    for body, attitude in attitudes.items():
        mass, inertia = p[f"m{body}"], _inertia(p, body)
        linear, angular = ({rate: v[rate][body] for rate in v} for v in (velocity, omega))
        turning = attitude.transposed(_combined(actual, angular))
        force = _rates(mass * _combined(actual, linear))
        weight = -(mass * p["g"]) * z
        moment = _rates(attitude(inertia(turning)))
        for rate, shares in allowed.items():
            v = _combined(shares, {r: _values(linear[r]) for r in shares})
            w = _combined(shares, {r: _values(angular[r]) for r in shares})
            terms[rate] += [force.dot(v), weight.dot(v), moment.dot(w)]
    lowest = pivot + to_front_hub + front_arm - arm
    return Balance(-lowest[2].value, _values(without + wheel_rate * along), terms)


def _allowed(rate: str, slip: Mapping[str, Vector]) -> dict[str, Number]:
    """Return the rates that keep the front wheel rolling if this rate is 1, by Cramer's rule."""
    a, b, c = (_values(slip[name]) for name in BOUND)
    s = -_values(slip[rate])
    volumes = s.dot(b.cross(c)), a.dot(s.cross(c)), a.dot(b.cross(s))
    whole = a.dot(b.cross(c))
    return {rate: 1, **{name: x / whole for name, x in zip(BOUND, volumes, strict=True)}}


def _inertia(p: Mapping[str, Number], body: str) -> Matrix:
    xx, yy = p[f"I{body}xx"], p[f"I{body}yy"]
    zz, xz = (xx, 0) if body in "RF" else (p[f"I{body}zz"], p[f"I{body}xz"])
    return Matrix((Vector((xx, 0, xz)), Vector((0, yy, 0)), Vector((xz, 0, zz))))


def _combined(factors: Mapping[str, Number], vectors: Mapping[str, Vector]) -> Vector:
    """Return the sum of the vectors, each times its factor."""
    first, *others = (factor * vectors[name] for name, factor in factors.items())
    return sum(others, first)


def _values(v: Vector) -> Vector:
    return Vector(x.value if isinstance(x, Jet) else x for x in v)


def _rates(v: Vector) -> Vector:
    return Vector(x.rate for x in v)
