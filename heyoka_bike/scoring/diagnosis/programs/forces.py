"""Forces that a program adds to gravity, and terms that it lacks, each with a coefficient.

The benchmark has none of these forces. Simulators add some by default, and equations written by
hand lack some terms. Each force is linear in its coefficient and acts along velocities: a force f
at a point with the velocity v has the power f . v, and a torque likewise. The power at unit
independent speeds (roll rate, steer rate, rolling rate) is the generalised force. A missing term is
represented by a force that cancels it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement, product
from types import MappingProxyType

import numpy as np

from heyoka_bike.bicycle.equations.bodies import Axes, Half
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.vectors import Vector, cross, from_turned, minus, plus, scaled

INDEPENDENT = range(3)
_FRAME_OF_BODY = {"R": "B", "B": "B", "H": "H", "F": "H"}
_SIDE: Vector = (0.0, 1.0, 0.0)

Linear = Mapping[str, Vector]
"""Quantities linear in the speeds, by name: velocities [m/s] and angular velocities [rad/s]."""

Turn = Callable[[Vector], Vector]
"""Function from the components of a vector in some axes to those in other axes."""


@dataclass(frozen=True, slots=True)
class Tensors:
    """Inertia that does not turn with its body; initially its axes are those of the body.

    Attributes
    ----------
    bodies
        Letters of the bodies: rear frame B, fork H.
    axes
        The axes that it keeps: ``ground``, or ``rear`` for those of the rear frame.
    """

    bodies: str
    axes: str


TENSORS = {
    "tensors_turning": Tensors("BH", "ground"),
    "tensor_turning_B": Tensors("B", "ground"),
    "tensor_turning_H": Tensors("H", "ground"),
    "tensor_steering_H": Tensors("H", "rear"),
}
"""Rotations of inertia that may be missing, by name; these are not forces."""


class Moving:
    """A motion, and all velocities along which forces act.

    Velocities ``v_R`` ... ``v_F`` of the bodies' centres are in heading axes, angular velocities
    ``w_R`` ... ``w_F`` in the axes of the body's frame. ``rates`` are roll rate, steer rate and the
    speed of the rear hub along the heading. ``spin_R`` and ``spin_F`` are the rates of the wheels
    about their axles relative to their frames, ``turn_B`` and ``turn_H`` the angular velocities of
    both frames in heading axes.

    Parameters
    ----------
    equations : Equations
        Equations of the regular form, over arrays.
    state
        State of the regular form, with the yaw.
    unturned : mapping of str to number
        By name in `TENSORS`: the fraction of this inertia that does not turn.
    """

    def __init__(
        self,
        equations: Equations,
        state: Sequence[Number],
        unturned: Mapping[str, Number] = MappingProxyType({}),
    ) -> None:
        self.equations, self.state, self.b = equations, state, equations.b
        self._unturned = {name: part for name, part in unturned.items() if np.any(part)}
        self.axes = Axes.of(equations.b, equations.unfold(state)[0])
        self.now = _velocities(equations, state)
        self.masses = dict(
            zip("RBHF", (self.b.rear.wheel_m, self.b.rear.m, self.b.front.m, self.b.front.wheel_m),
                strict=True)
        )  # fmt: skip

    @cached_property
    def units(self) -> list[dict[str, Vector]]:
        """The velocities if one independent speed is 1 and the others are 0, for each speed."""
        zero, state = 0.0 * self.state[0], self.state
        speeds = ([zero + float(i == j) for j in INDEPENDENT] for i in INDEPENDENT)
        return [_velocities(self.equations, [*state[:3], *x, state[6]]) for x in speeds]

    @cached_property
    def mass(self) -> list[list[Number]]:
        """The mass matrix of the independent speeds."""
        half = [[self.product(u, w) for w in self.units[: i + 1]] for i, u in enumerate(self.units)]
        return [[half[max(i, j)][min(i, j)] for j in INDEPENDENT] for i in INDEPENDENT]

    @cached_property
    def rates(self) -> list[Number]:
        """Time derivatives of the state, without additional forces."""
        if not self._unturned:
            return self._right
        return [*self._right[:3], *self.added(self.free()), self._right[6]]

    @cached_property
    def _right(self) -> list[Number]:
        return self.equations.rates_with_yaw(self.state)

    def product(self, one: Linear, other: Linear) -> Number:
        """Return twice the bilinear form of the kinetic energy, for two sets of velocities."""
        found = 0.0
        for body, mass in self.masses.items():
            found = found + mass * dot(one[f"v_{body}"], other[f"v_{body}"])
            found = found + dot(one[f"w_{body}"], self.inertia(body, other[f"w_{body}"]))
        return found

    def inertia(self, body: str, v: Vector) -> Vector:
        """Return the inertia tensor of a body times a vector."""
        half: Half = self.b.rear if body in "RB" else self.b.front
        if body in "RF":
            return half.wheel_inertia_times(v)
        turning = found = half.inertia_times(v)
        for name, part in self._unturned.items():
            if body in TENSORS[name].bodies:
                to, back = self._other_axes(body, TENSORS[name].axes)
                found = plus(found, scaled(part, minus(back(half.inertia_times(to(v))), turning)))
        return found

    def _other_axes(self, body: str, axes: str) -> tuple[Turn, Turn]:
        """Return functions that convert from the axes of rear frame or fork to others, and back."""
        out, back = (
            (self.axes.from_rear, self.axes.to_rear)
            if body == "B"
            else (self.axes.from_front, self.axes.to_front)
        )
        if axes == "rear":
            to_rear, from_rear = self.axes.to_rear, self.axes.from_rear
            return lambda v: to_rear(out(v)), lambda v: back(from_rear(v))
        a, yaw = self.equations.a, self.state[6]
        to_ground = a.sin(yaw), a.cos(yaw)
        return lambda v: from_turned("z", *to_ground, out(v)), lambda v: back(self.ground(v))

    @cached_property
    def bias(self) -> Linear:
        """Derivatives of the velocities at constant independent speeds, each in its own axes."""
        dual = self.equations.over(Duals(self.equations.a))
        angles = [Dual(q, (rate,)) for q, rate in zip(self.state[:3], self._right[:3], strict=True)]
        moved = _velocities(dual, [*angles, *self.state[3:]])
        found = {name: (_slope(x), _slope(y), _slope(z)) for name, (x, y, z) in moved.items()}
        # Add the rotation of the heading axes, so that the accelerations of the centres of mass are
        # relative to the ground.
        turn: Vector = (0.0, 0.0, self._right[6])
        for body in "RBHF":
            found[f"v_{body}"] = plus(found[f"v_{body}"], cross(turn, self.now[f"v_{body}"]))
        return found

    def acceleration(self, name: str) -> Vector:
        """Return the time derivative of a velocity, without additional forces."""
        found = self.bias[name]
        for unit, rate in zip(self.units, self.rates[3:6], strict=True):
            found = plus(found, scaled(rate, unit[name]))
        return found

    def ground(self, v: Vector) -> Vector:
        """Convert a vector from ground axes to heading axes."""
        a, yaw = self.equations.a, self.state[6]
        return from_turned("z", -a.sin(yaw), a.cos(yaw), v)

    def free(self) -> list[Number]:
        """Return the generalised forces of weight and inertia at constant independent speeds."""
        found: list[Number] = [0.0] * 3
        for body, mass in self.masses.items():
            v, w = f"v_{body}", f"w_{body}"
            pull = scaled(mass, minus((0.0, 0.0, self.b.g), self.bias[v]))
            momentum = cross(self.now[f"w_{_FRAME_OF_BODY[body]}"], self.inertia(body, self.now[w]))
            turn = plus(self.inertia(body, self.bias[w]), momentum)
            for i, unit in enumerate(self.units):
                found[i] = found[i] + dot(pull, unit[v]) - dot(turn, unit[w])
        return found

    def powers(self, force: Linear) -> list[Number]:
        """Return the generalised forces of forces and torques, given by velocity name [N m]."""
        found: list[Number] = []
        for unit in self.units:
            power: Number = 0.0
            for name, f in force.items():
                power = power + dot(f, unit[name])
            found.append(power)
        return found

    def added(self, forces: Sequence[Number]) -> list[Number]:
        """Return the accelerations that generalised forces add to the independent speeds."""
        return solved(self.mass, forces)

    def altered(self, amounts: Mapping[str, Number]) -> list[Number]:
        """Return the derivatives of the state if forces with these coefficients act [SI]."""
        if not amounts:
            return self.rates
        force, rotors = self._forces(amounts, self)
        mass = [[x + (rotors[i] if i == j else 0.0) for j, x in enumerate(row)]
                for i, row in enumerate(self.mass)]  # fmt: skip
        # The equations are solved for the change of the accelerations. So subtract the torque that
        # the rotors need for the unchanged accelerations of the wheels.
        force = [f - j * x for f, j, x in zip(force, rotors, self.rates[3:6], strict=True)]
        if any(FORCES[name].is_inertial for name in amounts):
            mass = self._less_inertial(mass, {n: x for n, x in amounts.items()
                                              if FORCES[n].is_inertial})  # fmt: skip
        changed = [x + y for x, y in zip(self.rates[3:6], solved(mass, force), strict=True)]
        return [*self.rates[:3], *changed, self.rates[6]]

    def _forces(
        self, amounts: Mapping[str, Number], seen: Moving
    ) -> tuple[list[Number], list[Number]]:
        """Return generalised forces at the accelerations of `seen`, and inertias of rotors."""
        force: list[Number] = [0.0] * 3
        rotors: list[Number] = [0.0] * 3
        for name, amount in amounts.items():
            each = self.powers(FORCES[name].law(seen))
            strength = amount
            if (turned := FORCES[name].turned) is not None:
                a = self.equations.a
                strength, lost = a.sin(amount), 1.0 - a.cos(amount)
                of_lost = self.powers(turned(self))
                force = [f + lost * x for f, x in zip(force, of_lost, strict=True)]
            if (squared := FORCES[name].squared) is not None:
                of_square = self.powers(squared(seen))
                force = [f + amount * amount * x for f, x in zip(force, of_square, strict=True)]
            force = [f + strength * x for f, x in zip(force, each, strict=True)]
            if (hinge := FORCES[name].turns_with) is not None:
                rotors[hinge] = rotors[hinge] + amount
        return force, rotors

    def _less_inertial(
        self, mass: Sequence[Sequence[Number]], amounts: Mapping[str, Number]
    ) -> list[list[Number]]:
        """Return the mass matrix minus the derivatives of forces linear in the accelerations."""
        at_right, _ = self._forces(amounts, self)
        columns = []
        for i in INDEPENDENT:
            other = copy(self)
            other.rates = [x + float(j == 3 + i) for j, x in enumerate(self.rates)]
            ahead, _ = self._forces(amounts, other)
            columns.append([x - y for x, y in zip(ahead, at_right, strict=True)])
        return [[x - columns[j][i] for j, x in enumerate(row)] for i, row in enumerate(mass)]


def _velocities(equations: Equations, state: Sequence[Number]) -> dict[str, Vector]:
    o, u = equations.unfold(state)
    k, b = equations.k, equations.b
    axes = Axes.of(b, o)
    length = b.rear.wheel_r / k.rear.r
    found: dict[str, Vector] = {}
    p_f = o.cb_f * u.w1_f + o.sb_f * u.w3_f
    for frame, wheel, half, out, hub, (w1, q, w3), spin in (
        ("B", "R", b.rear, axes.from_rear, (u.v * o.cb, k.rear.r * u.p, u.v * o.sb),
         (u.w1, u.q, u.w3), u.v / k.rear.r),
        ("H", "F", b.front, axes.from_front, (u.v_f * o.cb_f, k.front.r * p_f, u.v_f * o.sb_f),
         (u.w1_f, u.q_f, u.w3_f), u.v_f / k.front.r),
    ):  # fmt: skip
        x, _, z = from_turned("y", b.sin_tilt, b.cos_tilt, (w1, 0.0, w3))
        turning: Vector = (x, q, z)
        of_hub = scaled(length, from_turned("y", b.sin_tilt, b.cos_tilt, hub))
        found[f"v_{wheel}"] = out(of_hub)
        found[f"v_{frame}"] = out(plus(of_hub, cross(turning, (half.x, 0.0, half.z))))
        found[f"w_{frame}"], found[f"w_{wheel}"] = turning, (x, -spin, z)
        found[f"turn_{frame}"] = out(turning)
        found[f"spin_{wheel}"] = (0.0, -spin - q, 0.0)
    found["rates"] = (state[3], state[4], length * u.v)
    return found


def dot(u: Vector, v: Vector) -> Number:
    """Return the scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _slope(x: Number) -> Number:
    return x.slopes[0] if isinstance(x, Dual) else 0.0


def solved(m: Sequence[Sequence[Number]], right: Sequence[Number]) -> list[Number]:
    """Solve three linear equations by Cramer's rule."""
    rows: list[Vector] = [(row[0], row[1], row[2]) for row in m]
    across = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])]
    determinant = dot(rows[0], across[0])
    return [
        sum(x * a[i] for x, a in zip(right, across, strict=True)) / determinant for i in INDEPENDENT
    ]


Law = Callable[[Moving], Linear]
"""Function from a motion to the forces with a unit coefficient, by velocity name."""


@dataclass(frozen=True, slots=True)
class Force:
    """A force whose coefficient is zero in the correct program.

    Attributes
    ----------
    says
        Name of the coefficient in messages.
    unit
    size
        Small value of the coefficient [SI].
    law
        Forces with a unit coefficient.
    is_part
        True if the coefficient is the missing fraction of a term.
    is_fitted
        True if the coefficient is an unknown of fits; False for a sum or a multiple of others.
    turns_with
        Index of the independent speed of a rotor whose inertia is the coefficient; None for forces.
    turned
        For a coefficient that is an angle by which a force of the benchmark is rotated: the loss of
        that force at 90 degrees. It is multiplied by 1 - cos, and `law` by sin.
    squared
        Additional forces that are multiplied by the square of the coefficient.
    is_inertial
        True if the law is linear in the accelerations.
    stores_energy
        False if the potential energy remains that of gravity. If True, the potential energy is not
        compared, because programs define the stored energy in different ways.
    is_property
        True if messages call the coefficient a parameter: a length, an angle or an inertia.
    check
        What to check in a program that has this force; empty for the general advice.
    """

    says: str
    unit: str
    size: float
    law: Law
    is_part: bool = False
    is_fitted: bool = True
    turns_with: int | None = None
    turned: Law | None = None
    squared: Law | None = None
    is_inertial: bool = False
    stores_energy: bool = True
    is_property: bool = False
    check: str = ""


PLACE_IN_STATE = {"roll angle": 0, "steer angle": 2, "roll rate": 3, "steer rate": 4}
"""Indices in the state of the variables of terms."""


def _along(speed: int, names: Sequence[str] = (), power: int = 0, sign: float = 1.0) -> Law:
    """Make a force along an independent speed, in proportion to a term of the state.

    The term is a product of variables of the state and a power of the speed. Along roll and steer a
    square is x |x|, because left and right are alike.
    """

    def law(m: Moving) -> Linear:
        x = sign * m.now["rates"][2] ** power + 0.0 * m.state[0]
        variables = [m.state[PLACE_IN_STATE[name]] for name in names]
        if speed < 2 and len(names) == 2:
            variables[1] = np.abs(variables[1])
        for variable in variables:
            x = x * variable
        roll, steer, forward = (x if i == speed else 0.0 for i in INDEPENDENT)
        return {"rates": (roll, steer, forward)}

    return law


def _on_axles(wheels: str, strength: Callable[[Number], Number]) -> Law:
    """Make a torque between wheel and frame that depends on the rate between them."""
    return lambda m: {f"spin_{w}": (0.0, strength(m.now[f"spin_{w}"][1]), 0.0) for w in wheels}


def _from_ground(wheels: str) -> Law:
    """Make a constant rolling-resistance torque of the ground about the axles."""
    return lambda m: {f"w_{w}": (0.0, 1.0 + 0.0 * m.state[0], 0.0) for w in wheels}


def _drag(point: str) -> Law:
    """Make a force against a velocity, in proportion to its square."""

    def law(m: Moving) -> Linear:
        v = m.now[point]
        return {point: scaled(-m.equations.a.sqrt(dot(v, v)), v)}

    return law


def _forward_drag(law: Law) -> Law:
    """Make a drag in proportion to the square of the hub's speed, at the point of a unit force."""
    return lambda m: {
        name: scaled(-m.now["rates"][2] * m.now["rates"][2], f) for name, f in law(m).items()
    }


_AHEAD_AXIS: Vector = (1.0, 0.0, 0.0)


def _on_all(m: Moving) -> Linear:
    """Return a unit forward force at the centre of mass of the whole bicycle."""
    whole = sum(m.masses.values())
    return {f"v_{b}": scaled(mass / whole, _AHEAD_AXIS) for b, mass in m.masses.items()}


def _on_ground(m: Moving) -> Linear:
    """Return a unit forward force at the point of the rear frame on the ground below the hub."""
    below: Vector = (0.0, 0.0, m.b.rear.wheel_r)
    return {"v_R": _AHEAD_AXIS, "w_B": cross(below, m.axes.to_rear(_AHEAD_AXIS))}


def _decay(m: Moving) -> Linear:
    """Return forces by which the velocities of all centres of mass decay."""
    return {f"v_{b}": scaled(-mass, m.now[f"v_{b}"]) for b, mass in m.masses.items()}


def _spin_down(m: Moving) -> Linear:
    """Return torques by which the angular velocities of all bodies decay."""
    return {f"w_{b}": scaled(-1.0, m.inertia(b, m.now[f"w_{b}"])) for b in m.masses}


def _scrub(frame: str) -> Law:
    """Return the law of the torque with which a tyre resists the yaw rate."""
    return lambda m: {f"turn_{frame}": (0.0, 0.0, -m.now[f"turn_{frame}"][2])}


def _crown(frames: str) -> Law:
    """Make the torque of tyres with a round section: a leaning wheel is loaded off its plane."""

    def law(m: Moving) -> Linear:
        k, b = m.equations.k, m.b
        base = b.rear.wheel_r / k.rear.r * (b.cos_tilt * (k.d1 + k.d3) + b.sin_tilt * k.d2)
        on_front = m.masses["F"] + m.masses["H"] + (
            m.masses["B"] * b.rear.x + m.masses["H"] * b.front.x) / base  # fmt: skip
        whole = sum(m.masses.values())
        found = {}
        for frame in frames:
            out, mass = (
                (m.axes.from_rear, whole - on_front)
                if frame == "B"
                else (m.axes.from_front, on_front)
            )
            x, y, z = out(_SIDE)
            lean = -mass * b.g * z / m.equations.a.sqrt(x * x + y * y)
            found[f"turn_{frame}"] = (lean * y, -lean * x, 0.0)
        return found

    return law


def _slope_of_ground(along: Vector) -> Law:
    """Make the force that gravity would have if this horizontal axis of the ground pointed up."""

    def law(m: Moving) -> Linear:
        pull = scaled(-m.b.g, m.ground(along))
        return {f"v_{b}": scaled(mass, pull) for b, mass in m.masses.items()}

    return law


def _weightless(bodies: str) -> Law:
    return lambda m: {f"v_{b}": (0.0, 0.0, -m.masses[b] * m.b.g) for b in bodies}


def _without_spin_moment(wheels: str) -> Law:
    """Make the torque that cancels the gyroscopic moment of spin: angular velocity x I_yy spin."""

    def law(m: Moving) -> Linear:
        found = {}
        for w in wheels:
            momentum = (0.0, m.inertia(w, m.now[f"w_{w}"])[1], 0.0)
            found[f"w_{w}"] = cross(m.now[f"w_{_FRAME_OF_BODY[w]}"], momentum)
        return found

    return law


def _without_euler(bodies: str) -> Law:
    """Make the torques that cancel the gyroscopic torques w x (I w) of bodies."""
    return lambda m: {
        f"w_{b}": cross(m.now[f"w_{b}"], m.inertia(b, m.now[f"w_{b}"])) for b in bodies
    }


def _without_centrifugal(bodies: str) -> Law:
    """Make the forces that cancel the centrifugal and Coriolis forces of bodies."""
    return lambda m: {f"v_{b}": scaled(m.masses[b], m.bias[f"v_{b}"]) for b in bodies}


def _to_the_side(body: str) -> Law:
    """Make the forces, linear in the distance, of a centre of mass moved to the right."""

    def law(m: Moving) -> Linear:
        into = m.axes.to_rear if body == "B" else m.axes.to_front
        out = m.axes.from_rear if body == "B" else m.axes.from_front
        mass = m.masses[body]
        free = into(minus((0.0, 0.0, m.b.g), m.acceleration(f"v_{body}")))
        return {
            f"w_{body}": scaled(mass, cross(_SIDE, free)),
            f"v_{body}": scaled(-mass, out(_of_the_side(m, body))),
        }

    return law


def _to_the_side_squared(body: str) -> Law:
    """Make the torque, quadratic in the distance, of a centre of mass moved to the right."""
    return lambda m: {f"w_{body}": scaled(-m.masses[body], cross(_SIDE, _of_the_side(m, body)))}


def _of_the_side(m: Moving, body: str) -> Vector:
    """Return the acceleration, relative to a body's centre, of a point 1 m to the right of it."""
    w = m.now[f"w_{body}"]
    return plus(cross(m.acceleration(f"w_{body}"), _SIDE), cross(w, cross(w, _SIDE)))


def _held_speed(m: Moving) -> Linear:
    """Return the force of a drive that keeps the rolling rate of the rear wheel constant."""
    unit = m.added([0.0, 0.0, 1.0])[2]
    length = m.units[2]["rates"][2]
    return {"rates": (0.0, 0.0, -m.rates[5] / unit / length)}


def _held_spin(m: Moving) -> Linear:
    """Return the torque of a motor that keeps the rate between rear wheel and frame constant."""
    change = m.added(m.powers({"spin_R": _SIDE}))
    by_unit_torque = sum(unit["spin_R"][1] * x for unit, x in zip(m.units, change, strict=True))
    return {"spin_R": (0.0, -m.acceleration("spin_R")[1] / by_unit_torque, 0.0)}


_BRAKED_WHEELS = (
    ("", "RF", "each wheel", "the wheels'"),
    ("_R", "R", "the rear wheel", "the rear wheel's"),
    ("_F", "F", "the front wheel", "the front wheel's"),
)
"""End of a coefficient's name, letters of the wheels, and their names in messages."""
_BODIES = {"R": "rear wheel", "B": "rear frame", "H": "fork", "F": "front wheel"}
_POINTS_OF_FORCES: tuple[tuple[str, str, Law], ...] = (
    ("frame", "rear frame's centre of mass", lambda _: {"v_B": _AHEAD_AXIS}),
    ("hub", "rear hub", lambda _: {"v_R": _AHEAD_AXIS}),
    ("whole", "centre of mass of the whole bicycle", _on_all),
    ("ground", "rear contact", _on_ground),
)
"""Points of forces along the heading: name, words, and unit force."""


def _part(says: str, law: Law, *, is_fitted: bool = True, stores_energy: bool = False) -> Force:
    """Make a term that may be missing, wholly or in part."""
    return Force(
        says, "1", 0.1, law, is_part=True, is_fitted=is_fitted, stores_energy=stores_energy
    )


_ALONG = (
    ("roll", "roll torque"),
    ("steer", "torque on the steer axis"),
    ("speed", "force forward at the rear hub"),
)
"""Equations of motion, with words for the force or torque in each."""
_POWERS_OF_SPEED = ("", " the forward speed", " the square of the forward speed")


_NAMED_OTHERWISE = (
    "roll_by", "roll_by_roll_angle", "roll_by_roll_rate", "steer_by", "steer_by_steer_angle",
    "steer_by_steer_rate", "speed_by", "speed_by_speed_speed",
)  # fmt: skip


def _of_the_state() -> dict[str, Force]:
    """Make forces in proportion to simple terms of the state.

    Terms along roll and steer are odd, because left and right are alike; terms along the speed are
    even.
    """
    odd: list[tuple[tuple[str, ...], str]] = [((), "")]
    even = [*odd]
    for x in PLACE_IN_STATE:
        odd += [((x,), f" the {x}"), ((x, x), f" the {x} times its absolute value")]
        odd += [((x, x, x), f" the cube of the {x}")]
    for x, y in combinations_with_replacement(PLACE_IN_STATE, 2):
        even.append(((x, y), f" the square of the {x}" if x == y else f" the {x} times the {y}"))
    found = {}
    for i, (where, what) in enumerate(_ALONG):
        for (names, term), power in product(even if i == 2 else odd, range(3)):
            times = " times" if term and power else ""
            says = f"coefficient of a {what} proportional to{term}{times}{_POWERS_OF_SPEED[power]}"
            powers = {"m": int(i < 2) - power, "s": power + sum("rate" in x for x in names)}
            unit = " ".join(["N", *(u if n == 1 else f"{u}{n}" for u, n in powers.items() if n)])
            name = "_".join([where, "by", *names, *["speed"] * power]).replace(" ", "_")
            # A constant force, or a force that depends on an angle, may have a potential.
            stores_energy = not (names or power) or any("angle" in x for x in names)
            found[name] = Force(
                says, unit, 1.0, _along(i, names, power), is_fitted=False,
                stores_energy=stores_energy,
            )  # fmt: skip
    return {name: force for name, force in found.items() if name not in _NAMED_OTHERWISE}


OF_THE_STATE = _of_the_state()
"""Forces that are fitted only if no other force explains a file."""

_CHECK_FLOOR = "that the floor is horizontal, and the direction of gravity"

FORWARD: Mapping[str, Force] = {
    "air_drag": Force("drag coefficient (force / squared speed) at the rear frame's centre of mass",
                      "kg m-1", 0.1, _drag("v_B"), stores_energy=False),
    **{name: force for where, point, law in _POINTS_OF_FORCES for name, force in (
        (f"{where}_drag", Force(f"drag coefficient (force / squared forward speed) at the {point}",
                                "kg m-1", 0.1, _forward_drag(law), stores_energy=False)),
        (f"{where}_push", Force(f"constant force forward at the {point}", "N", 1.0, law,
                                stores_energy=False)))},
    "slope_along": Force("angle by which the ground rises along its x axis", "rad", 1e-3,
                         _slope_of_ground(_AHEAD_AXIS), turned=_weightless("RBHF"),
                         is_property=True, check=_CHECK_FLOOR),
    **{f"wheel_friction{end}": Force(f"viscous friction of {each}'s axle", "N m s", 0.01,
                                     _on_axles(wheels, lambda rate: -rate), stores_energy=False)
       for end, wheels, each, _ in _BRAKED_WHEELS},
    **{f"brake{end}": Force(f"constant torque that brakes {each} against its frame", "N m", 0.1,
                            _on_axles(wheels, lambda rate: 1.0 + 0.0 * rate),
                            stores_energy=False)
       for end, wheels, each, _ in _BRAKED_WHEELS},
    **{f"rolling_resistance{end}": Force(f"constant torque of the ground that brakes {each}",
                                         "N m", 0.1, _from_ground(wheels), stores_energy=False)
       for end, wheels, each, _ in _BRAKED_WHEELS},
    "velocity_damping": Force("rate at which all velocities and angular velocities are damped",
                              "s-1", 0.01, lambda m: {**_decay(m), **_spin_down(m)},
                              stores_energy=False),
    "linear_damping": Force("rate at which the velocities of all bodies' centres are damped",
                            "s-1", 0.01, _decay, stores_energy=False),
    "angular_damping": Force("rate at which all angular velocities are damped", "s-1", 0.01,
                             _spin_down, stores_energy=False),
    "speed_held": _part("change of the rear wheel's speed (a drive holds the speed)", _held_speed),
    "spin_held": _part("change of the rear wheel's rate against the frame (a motor holds it)",
                       _held_spin),
}  # fmt: skip
"""Forces that mainly change the speed; all others mainly change roll and steer."""

FORCES: Mapping[str, Force] = {
    **FORWARD,
    "steer_rotor": Force("inertia of a rotor that turns with the steer axis (armature)", "kg m2",
                         1e-3, lambda _: {}, turns_with=1, is_property=True),
    "steer_damping": Force("damping of the steer axis", "N m s", 0.1,
                           _along(1, ["steer rate"], sign=-1.0), stores_energy=False),
    "steer_stiffness": Force("stiffness of a spring on the steer axis", "N m", 1.0,
                             _along(1, ["steer angle"], sign=-1.0)),
    "steer_torque": Force("constant torque on the steer axis (positive to the right)", "N m", 0.1,
                          _along(1)),
    "steer_friction": Force("dry friction of the steer axis", "N m", 0.1, lambda m: {
        "rates": (0.0, -np.tanh(m.state[4] / 1e-4), 0.0)}, stores_energy=False),
    "roll_damping": Force("damping of the roll", "N m s", 1.0,
                          _along(0, ["roll rate"], sign=-1.0), stores_energy=False),
    "roll_stiffness": Force("stiffness of a spring against the roll", "N m", 1.0,
                            _along(0, ["roll angle"], sign=-1.0)),
    "roll_torque": Force("constant torque on the rear frame (positive to the right)", "N m", 0.1,
                         _along(0)),
    "air_lift": Force("lift coefficient (force / squared speed) at the rear frame's centre of mass",
                      "kg m-1", 0.1, lambda m: {"v_B": (0.0, 0.0, -(m.now["rates"][2] ** 2))},
                      stores_energy=False),
    "side_wind": Force("constant force along the ground's y axis on the rear frame", "N", 1.0,
                       lambda m: {"v_B": m.ground(_SIDE)}),
    "slope_across": Force("angle by which the ground rises along its y axis", "rad", 1e-3,
                          _slope_of_ground(_SIDE), turned=_weightless("RBHF"), is_property=True,
                          check=_CHECK_FLOOR),
    **{f"crown{end}": Force(f"radius of the {whose} cross-section", "m", 1e-3, _crown(frames),
                            is_property=True)
       for end, whose, frames in (("", "tyres'", "BH"), ("_R", "rear tyre's", "B"),
                                  ("_F", "front tyre's", "H"))},
    "scrub_R": Force("damping of the rear tyre about the vertical (torque / yaw rate)", "N m s",
                     0.1, _scrub("B"), stores_energy=False),
    "scrub_F": Force("damping of the front tyre about the vertical (torque / yaw rate)", "N m s",
                     0.1, _scrub("H"), stores_energy=False),
    **{f"side_{b}": Force(f"distance of the {_BODIES[b]}'s centre of mass to the right of the "
                          "plane of symmetry", "m", 1e-3, _to_the_side(b),
                          squared=_to_the_side_squared(b), is_inertial=True, is_property=True,
                          check="the sideways coordinates of the centres of mass")
       for b in "BH"},
    **{f"no_spin_moment{end}": _part(f"gyroscopic moment of {whose} spin",
                                     _without_spin_moment(wheels))
       for end, wheels, _, whose in _BRAKED_WHEELS},
    **{name: _part(f"gyroscopic torque w x (I w) of {whose}", _without_euler(bodies),
                   is_fitted=False)
       for name, whose, bodies in (("gyroscopic", "all bodies", "RBHF"),
                                   ("frames_gyroscopic", "rear frame and fork", "BH"),
                                   ("wheels_gyroscopic", "the wheels", "RF"))},
    "centrifugal_RBHF": _part("centrifugal and Coriolis force of all bodies",
                              _without_centrifugal("RBHF")),
    "wheels_weight": _part("weight of the wheels", _weightless("RF"), is_fitted=False,
                           stores_energy=True),
    **{f"{kind}_{b}": _part(f"{says} of the {name}", law(b),
                            # The term of a wheel is not fitted, because it nearly equals the moment
                            # of the wheel's spin.
                            is_fitted=kind != "gyroscopic" or b in "BH",
                            stores_energy=kind == "weight")
       for kind, says, law in (("gyroscopic", "gyroscopic torque w x (I w)", _without_euler),
                               ("centrifugal", "centrifugal and Coriolis force",
                                _without_centrifugal),
                               ("weight", "weight", _weightless))
       for b, name in _BODIES.items()},
    **OF_THE_STATE,
}  # fmt: skip
"""All forces by name."""

WITHOUT_POTENTIAL = frozenset(name for name, x in FORCES.items() if not x.stores_energy)
"""Forces that store no energy, so that the potential energy remains that of gravity."""

# Plausible missing fractions of a term, and the largest deviation of a fitted fraction from them.
# In this order, the term is missing, has the opposite sign, is doubled, or is halved.
_PLAUSIBLE, _OFF = (1.0, 2.0, -1.0, 0.5), 0.05

# A fitted mass, length or other size may be at most this much below zero [SI].
_ZERO = 1e-6
# Names of sizes, which cannot be negative: masses, moments of inertia, lengths and gravity.
_SIZE = re.compile(r"m[RBHF]|I[RBHF](xx|yy|zz)|r[RF]|w|g|crown(_[RF])?")


def is_plausible(name: str, amount: float) -> bool:
    """True unless a mass or length is negative, or a term's missing fraction is implausible."""
    if _SIZE.fullmatch(name):
        return amount > -_ZERO
    is_part = name in FORCES and FORCES[name].is_part
    return not is_part or any(abs(amount - x) < _OFF for x in _PLAUSIBLE)


def rates_altered(
    equations: Equations, state: Sequence[Number], amounts: Mapping[str, Number]
) -> list[Number]:
    """Compute the time derivatives of the state of the regular form, including the yaw.

    Parameters
    ----------
    equations : Equations
        Equations of the regular form, over arrays.
    state
        State of the regular form, with the yaw.
    amounts : mapping of str to number
        Coefficients of `FORCES` [SI], and missing fractions of `TENSORS`.
    """
    forces, unturned = forces_and_tensors(amounts)
    return Moving(equations, state, unturned).altered(forces)


def forces_and_tensors(
    amounts: Mapping[str, Number],
) -> tuple[dict[str, Number], dict[str, Number]]:
    """Split coefficients into those of `FORCES` and those of `TENSORS`."""
    unturned = {name: x for name, x in amounts.items() if name in TENSORS}
    return {name: x for name, x in amounts.items() if name not in TENSORS}, unturned
