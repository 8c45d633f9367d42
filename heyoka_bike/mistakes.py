"""The usual mistakes: what a program that makes one of them computes instead.

Each mistake changes a `Program`: the bicycle's parameters, the start, or what is written. Mistakes
can be made together, in any order that makes sense; `apply` makes several.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import cos, pi, sin, tan

import numpy as np

from heyoka_bike.chebyshev import Array
from heyoka_bike.exact import Exact
from heyoka_bike.parameters import Bicycle
from heyoka_bike.start import Start

Columns = Mapping[str, Array]

_DEGREE = pi / 180
# Point P2 of the steer axis as the benchmark text prints it, truncated: x, z [m].
_PRINTED_P2 = (Fraction("0.82188470506"), Fraction("-0.85595086466"))


@dataclass(frozen=True, slots=True)
class Program:
    """What a program computes and writes.

    Attributes
    ----------
    bicycle : Bicycle
    starts
        Of each maneuver, by number.
    clock
        From the written times and their usual distance [s] to the times meant.
    rows
        Changes of the columns, in order: columns and written times to columns.
    """

    bicycle: Bicycle
    starts: Mapping[int, Start]
    clock: Callable[[Array, float], Array] = lambda t, _: t
    rows: tuple[Callable[[Columns, Array], Columns], ...] = ()


@dataclass(frozen=True, slots=True)
class Mistake:
    """One usual mistake.

    Attributes
    ----------
    code
        Stable name.
    says
        What the program does, one sentence.
    check
        What to look at in one's own program.
    kind
        ``model``, ``start`` or ``output``; the former two change the motion.
    change
        Makes it.
    """

    code: str
    says: str
    check: str
    kind: str
    change: Callable[[Program], Program]


def apply(program: Program, mistakes: Iterable[Mistake]) -> Program:
    """A program that makes all of the mistakes."""
    for mistake in mistakes:
        program = mistake.change(program)
    return program


def _model(
    code: str, says: str, check: str, change: Callable[[dict[str, Fraction], float], None]
) -> Mistake:
    """A mistake in the parameters: `change` alters them in place, told the tilt [rad]."""

    def make(program: Program) -> Program:
        values = dict(program.bicycle.values)
        tilt = float(values["lam"])
        p = {s: x.rational for s, x in values.items() if x.is_rational}
        change(p, tilt)
        values.update({s: Exact(x) for s, x in p.items()})
        # Not checked: what mistaken programs compute with need not make sense.
        return replace(program, bicycle=Bicycle(program.bicycle.name, values))

    return Mistake(code, says, check, "model", make)


def _set(**values: str) -> Callable[[dict[str, Fraction], float], None]:
    return lambda p, _: p.update({s: Fraction(x) for s, x in values.items()})


def _negate(*symbols: str) -> Callable[[dict[str, Fraction], float], None]:
    return lambda p, _: p.update({s: -p[s] for s in symbols})


def _exchange(*pairs: tuple[str, str]) -> Callable[[dict[str, Fraction], float], None]:
    return lambda p, _: p.update({s: p[t] for a, b in pairs for s, t in ((a, b), (b, a))})


def _about(body: str, place: str) -> Callable[[dict[str, Fraction], float], None]:
    """The inertia given is about another point than the body's centre of mass, or taken so."""

    def change(p: dict[str, Fraction], _: float) -> None:
        x, z = p[f"x{body}"], p[f"z{body}"]
        if place == "hub":
            x, z = (x, z + p["rR"]) if body == "B" else (x - p["w"], z + p["rF"])
        m = p[f"m{body}"]
        p[f"I{body}xx"] += m * z * z
        p[f"I{body}zz"] += m * x * x
        p[f"I{body}yy"] += m * (x * x + z * z)
        p[f"I{body}xz"] -= m * x * z

    return change


def _rotated(body: str, sign: int) -> Callable[[dict[str, Fraction], float], None]:
    """The inertia taken in axes turned by the tilt of the steer axis."""

    def change(p: dict[str, Fraction], tilt: float) -> None:
        s, c = sin(sign * tilt), cos(sign * tilt)
        xx, zz, xz = (float(p[f"I{body}{ij}"]) for ij in ("xx", "zz", "xz"))
        p[f"I{body}xx"] = Fraction(xx * c * c - 2 * xz * s * c + zz * s * s)
        p[f"I{body}zz"] = Fraction(xx * s * s + 2 * xz * s * c + zz * c * c)
        p[f"I{body}xz"] = Fraction((xx - zz) * s * c + xz * (c * c - s * s))

    return change


def _through_p2(p: dict[str, Fraction], tilt: float) -> None:
    """The axis with the given tilt through the printed point."""
    x, z = _PRINTED_P2
    p["c"] = x - z * Fraction(tan(tilt)) - p["w"]


def _tilt_reversed(program: Program) -> Program:
    lam = program.bicycle["lam"]
    values = {**program.bicycle.values, "lam": Exact(-lam.rational, -lam.pi_multiple)}
    return replace(program, bicycle=Bicycle(program.bicycle.name, values))


def _start(code: str, says: str, check: str, change: Callable[[Start], Start]) -> Mistake:
    def make(program: Program) -> Program:
        return replace(program, starts={n: change(s) for n, s in program.starts.items()})

    return Mistake(code, says, check, "start", make)


def _output(
    code: str, says: str, check: str, change: Callable[[Columns, Array], Columns]
) -> Mistake:
    def make(program: Program) -> Program:
        return replace(program, rows=(*program.rows, change))

    return Mistake(code, says, check, "output", make)


def _clock(code: str, says: str, check: str, change: Callable[[Array, float], Array]) -> Mistake:
    def make(program: Program) -> Program:
        before = program.clock
        return replace(program, clock=lambda t, step: change(before(t, step), step))

    return Mistake(code, says, check, "output", make)


def _differences(which: str) -> Callable[[Columns, Array], Columns]:
    """Rates from the angles of neighbouring rows."""

    def rate(angle: Array, time: Array) -> Array:
        if len(angle) < 3:
            return np.full_like(angle, np.nan)
        forward = np.diff(angle) / np.diff(time)
        if which == "forward":
            return np.append(forward, forward[-1])
        if which == "backward":
            return np.insert(forward, 0, forward[0])
        found: Array = np.gradient(angle, time)
        return found

    def change(columns: Columns, time: Array) -> Columns:
        made = dict(columns)
        for key in ("roll", "steer"):
            made[f"{key}_rate"] = rate(columns[f"{key}_angle"], time)
        # The derivative of another roll angle is of another definition of the rate.
        for angle, definition in (("tait_bryan_xyz", "tait_bryan_xyz_rate"), ("zyx", "zyx_rate")):
            made[f"roll_rate_{definition}"] = rate(columns[f"roll_angle_{angle}"], time)
        return made

    return change


_SAME = "the same for all bodies: the benchmark gives matrix elements"
_WHEEL = "the inertia tensor of the wheel: Iyy is about its axle, Ixx = Izz about a diameter"

MISTAKES: tuple[Mistake, ...] = (
    _model("sign_IBxz", "I_Bxz of the rear frame has the opposite sign",
           f"the sign convention of products of inertia, {_SAME}", _negate("IBxz")),
    _model("sign_IHxz", "I_Hxz of the fork has the opposite sign",
           f"the sign convention of products of inertia, {_SAME}", _negate("IHxz")),
    _model("products_of_inertia", "both products of inertia have the opposite sign",
           "whether your program wants -integral(x z dm) or the matrix element",
           _negate("IBxz", "IHxz")),
    _model("inertia_B_about_origin", "the inertia of the rear frame is taken about the origin of "
           "the frame", "the point that your program takes inertias about", _about("B", "origin")),
    _model("inertia_B_about_hub", "the inertia of the rear frame is taken about the rear hub",
           "the point that your program takes inertias about", _about("B", "hub")),
    _model("inertia_H_about_origin", "the inertia of the fork is taken about the origin of the "
           "frame", "the point that your program takes inertias about", _about("H", "origin")),
    _model("inertia_H_about_hub", "the inertia of the fork is taken about the front hub",
           "the point that your program takes inertias about", _about("H", "hub")),
    _model("inertia_H_rotated", "the inertia of the fork is taken in axes along the steer axis",
           "the axes in which your program takes the fork's inertia", _rotated("H", 1)),
    _model("inertia_H_rotated_back", "the inertia of the fork is turned by the tilt the wrong way",
           "the axes in which your program takes the fork's inertia", _rotated("H", -1)),
    _model("spin_R_missing", "the rear wheel has no inertia about its axle", _WHEEL,
           _set(IRyy="0")),
    _model("spin_F_missing", "the front wheel has no inertia about its axle", _WHEEL,
           _set(IFyy="0")),
    _model("spin_missing", "the wheels have no inertia about their axles", _WHEEL,
           _set(IRyy="0", IFyy="0")),
    _model("diametral_missing", "the wheels have no inertia about their diameters", _WHEEL,
           _set(IRxx="0", IFxx="0")),
    _model("exchanged_R", "Ixx and Iyy of the rear wheel are exchanged", _WHEEL,
           _exchange(("IRxx", "IRyy"))),
    _model("exchanged_F", "Ixx and Iyy of the front wheel are exchanged", _WHEEL,
           _exchange(("IFxx", "IFyy"))),
    _model("exchanged_RF", "Ixx and Iyy of both wheels are exchanged", _WHEEL,
           _exchange(("IRxx", "IRyy"), ("IFxx", "IFyy"))),
    Mistake("tilt_sign", "the steer axis is tilted forward instead of backward",
            "the direction of the steer axis: its upper end is behind its lower one", "model",
            _tilt_reversed),
    _model("trail_sign", "the trail is negative", "where the steer axis meets the ground: ahead "
           "of the front contact point", _negate("c")),
    _model("trail_zero", "the trail is zero", "where the steer axis meets the ground: ahead of "
           "the front contact point", _set(c="0")),
    _model("printed_p2", "the steer axis goes through the printed point P2",
           "how the steer axis is built: from wheel base, trail and tilt", _through_p2),
    _model("radii_exchanged", "the wheel radii are exchanged", "the radii of the wheels",
           _exchange(("rR", "rF"))),
    _model("mass_H_missing", "the fork has no mass and no inertia", "the body H of the fork",
           _set(mH="0", IHxx="0", IHyy="0", IHzz="0", IHxz="0")),
    _model("mass_B_missing", "the rear frame with rider has no mass and no inertia",
           "the body B of the frame with rider", _set(mB="0", IBxx="0", IByy="0", IBzz="0",
                                                      IBxz="0")),
    _model("gravity_9.8", "gravity is 9.8 m/s^2", "gravity: the benchmark has 9.81",
           _set(g="9.8")),
    _model("gravity_9.80665", "gravity is 9.80665 m/s^2", "gravity: the benchmark has 9.81",
           _set(g="9.80665")),
    _model("gravity_9.82", "gravity is 9.82 m/s^2", "gravity: the benchmark has 9.81",
           _set(g="9.82")),
    _start("roll_of_frame_only", "only the rear frame starts with the roll rate",
           "the initial velocities of fork and wheels",
           lambda s: replace(s, rolling=s.rolling & frozenset("B"))),
    _start("roll_without_wheels", "the wheels start without the roll rate",
           "the initial velocities of the wheels",
           lambda s: replace(s, rolling=s.rolling - frozenset("RF"))),
    _start("roll_about_centre", "the roll rate is about the centre of mass, not the ground",
           "the lateral velocities at the start: zero on the ground",
           lambda s: replace(s, about_centre=True)),
    _start("roll_rate_in_degrees", "the initial roll rate is taken as degrees per second",
           "the unit of the initial roll rate",
           lambda s: replace(s, roll_rate=s.roll_rate * _DEGREE)),
    _start("no_roll_rate", "the initial roll rate is zero", "the initial roll rate",
           lambda s: replace(s, roll_rate=0.0)),
    _start("roll_rate_sign", "the initial roll rate is to the left",
           "the sign of the initial roll rate", lambda s: replace(s, roll_rate=-s.roll_rate)),
    _start("front_wheel_at_rest", "the front wheel starts without spin",
           "the initial angular velocity of the front wheel",
           lambda s: replace(s, spinning=s.spinning - frozenset("F"))),
    _start("rear_wheel_at_rest", "the rear wheel starts without spin",
           "the initial angular velocity of the rear wheel",
           lambda s: replace(s, spinning=s.spinning - frozenset("R"))),
    _start("speed_of_centre", "the initial speed is that of the centre of mass",
           "the point whose speed is set: the rear hub",
           lambda s: replace(s, speed_of_centre=True)),
    _clock("one_step_late", "each row is written one step late",
           "when a row is written: before or after the step", lambda t, h: np.maximum(t - h, 0.0)),
    _clock("one_step_early", "each row is written one step early, or the first one at t = h",
           "when a row is written: before or after the step", lambda t, h: t + h),
    _output("forward_differences", "the rates are forward differences of the angles",
            "where the rates come from", _differences("forward")),
    _output("backward_differences", "the rates are backward differences of the angles",
            "where the rates come from", _differences("backward")),
    _output("central_differences", "the rates are central differences of the angles",
            "where the rates come from", _differences("central")),
)  # fmt: skip
"""The library, in no particular order."""
