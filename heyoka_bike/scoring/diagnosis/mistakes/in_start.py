"""Mistakes in the initial conditions, and exchanged maneuvers."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from itertools import combinations
from math import pi

from heyoka_bike.scoring.diagnosis.mistakes.in_model import MODEL_MISTAKES
from heyoka_bike.scoring.diagnosis.programs.program import (
    INITIAL_STATE,
    Mistake,
    Program,
    Start,
    start_mistake,
)

_ONE_DEGREE = pi / 180

MISPLACED = "maneuver_"
"""Beginning of the codes of maneuvers that are written in the place of others."""


def _place(sources: Mapping[int, int]) -> Mistake:
    """Make a mistake that writes maneuvers in the place of others.

    `sources` gives, for the number written, the number of the maneuver that is computed.
    """

    def make(program: Program) -> Program:
        held = program.motion.starts
        starts = {n: held.get(sources.get(n, n), s) for n, s in held.items()}
        return program.moving(starts=starts)

    told = [f"maneuver {held} is in the place of maneuver {n}" for n, held in sources.items()]
    return Mistake(
        MISPLACED + "_".join(f"{held}_as_{n}" for n, held in sources.items()),
        ", and ".join((", ".join(told[:-1]), told[-1]) if told[:-1] else told),
        "the initial speed and roll rate of each maneuver, and which rows are written where",
        "start",
        make,
    )


_Scaled = Callable[[Start, float], Start]
"""Function from initial conditions and a ratio to the changed initial conditions."""


def _faster(start: Start, ratio: float) -> Start:
    """Multiply the initial speed by a ratio."""
    return replace(start, speed=start.speed * ratio)


def _scaled(program: Program, change: _Scaled, ratio: float) -> Program:
    """Return the program with the initial conditions of all maneuvers changed by a ratio."""
    starts = {n: change(s, ratio) for n, s in program.motion.starts.items()}
    return program.moving(starts=starts)


def _by_radius(code: str, says: str, change: _Scaled, own: str, other: str) -> Mistake:
    """Make a mistake that divides the speed by the radius of the other wheel, for its initial spin.

    The rolling conditions make the other initial velocities agree with this spin (`_faster`), or
    these are right, and the wheel slips until the constraints act.
    """

    def make(program: Program) -> Program:
        lengths = program.motion.bicycle
        return _scaled(program, change, float(lengths[own]) / float(lengths[other]))

    return Mistake(
        code, says, "the initial spin: the speed over the wheel's own radius", "start", make
    )


def _spin_kept(code: str, rear: str) -> Mistake:
    """Make a mistake that exchanges wheels or radii, but keeps the rear wheel's initial spin."""
    (exchange,) = (m for m in MODEL_MISTAKES if m.code == code)

    def make(program: Program) -> Program:
        made = exchange.change(program)
        right, wrong = (float(p.motion.bicycle["rR"]) for p in (program, made))
        return _scaled(made, _faster, wrong / right)

    says = f"{exchange.says}, and the rear {rear} starts with the speed over its right radius"
    return Mistake(f"{code}_spin_kept", says, "which wheel is the rear one", "model", make)


@cache
def misplaced(numbers: tuple[int, ...]) -> tuple[Mistake, ...]:
    """Return mistakes that exchange maneuvers: one replaced, two exchanged, or all rotated."""
    # List the single replacements first: a file of one maneuver cannot distinguish them from
    # exchanges, and the first of several indistinguishable mistakes is reported.
    alone = [{n: held} for n in numbers for held in numbers if n != held]
    exchanged = [{a: b, b: a} for a, b in combinations(numbers, 2)]
    turned = [(*numbers[i:], *numbers[:i]) for i in range(1, len(numbers))]
    in_turn = [dict(zip(numbers, order, strict=True)) for order in turned]
    orders = [x for x in in_turn if x not in exchanged]
    return tuple(map(_place, [*alone, *exchanged, *orders]))


_ROLL = INITIAL_STATE.index("roll")

START_MISTAKES: tuple[Mistake, ...] = (
    start_mistake("roll_of_frame_only", "only the rear frame starts with the roll rate",
                  "the initial velocities of fork and wheels",
                  lambda s: replace(s, rolling=s.rolling & frozenset("B"))),
    start_mistake("roll_without_wheels", "the wheels start without the roll rate",
                  "the initial velocities of the wheels",
                  lambda s: replace(s, rolling=s.rolling - frozenset("RF"))),
    start_mistake("roll_without_wheels_turning", "the wheels start without the roll rate, but "
                  "their hubs move sideways with it",
                  "the initial angular velocities of the wheels",
                  lambda s: replace(s, turning=s.turning - frozenset("RF"))),
    start_mistake("roll_about_centre", "the roll rate is about the centre of mass, not the ground",
                  "the lateral velocities at the start: zero on the ground",
                  lambda s: replace(s, about_centre=True)),
    start_mistake("roll_without_translation", "the bodies start with the roll rate, but their "
                  "centres of mass do not move sideways",
                  "the lateral velocities at the start: height times roll rate",
                  lambda s: replace(s, falling=False)),
    start_mistake("roll_rate_in_degrees", "the initial roll rate is read as degrees per second",
                  "the unit of the initial roll rate",
                  lambda s: replace(s, roll_rate=s.roll_rate * _ONE_DEGREE)),
    start_mistake("no_roll_rate", "the initial roll rate is zero", "the initial roll rate",
                  lambda s: replace(s, roll_rate=0.0)),
    start_mistake("roll_rate_sign", "the initial roll rate is to the left",
                  "the sign of the initial roll rate",
                  lambda s: replace(s, roll_rate=-s.roll_rate)),
    start_mistake("steer_rate_as_roll_rate", "the steer rate starts as large as the roll rate",
                  "the initial steer rate: zero",
                  lambda s: replace(s, steer_rate=s.roll_rate)),
    start_mistake("roll_rate_on_steer", "the steer rate starts with the value of the roll rate, "
                  "which starts from zero", "the order of the initial rates",
                  lambda s: replace(s, steer_rate=s.roll_rate, roll_rate=0.0)),
    start_mistake("roll_rate_as_roll", "the roll angle starts with the value of the roll rate, "
                  "which starts from zero", "the order of the initial values",
                  lambda s: replace(s, added=((_ROLL, s.roll_rate),), roll_rate=0.0)),
    start_mistake("front_wheel_at_rest", "the front wheel starts without spin",
                  "the initial angular velocity of the front wheel",
                  lambda s: replace(s, front_spin=0.0)),
    start_mistake("rear_wheel_at_rest", "the rear wheel starts without spin",
                  "the initial angular velocity of the rear wheel",
                  lambda s: replace(s, rear_spin=0.0)),
    start_mistake("wheels_at_rest", "both wheels start without spin",
                  "the initial angular velocities of the wheels",
                  lambda s: replace(s, rear_spin=0.0, front_spin=0.0)),
    start_mistake("speed_of_centre", "the initial speed is that of the centre of mass",
                  "the point whose speed is set: the rear hub",
                  lambda s: replace(s, speed_of_centre=True)),
    start_mistake("speed_in_km_h", "the initial speed is read as km/h",
                  "the unit of the initial speed", lambda s: replace(s, speed=s.speed / 3.6)),
    _by_radius("speed_by_front_radius", "the initial spin of the rear wheel is the speed over the "
               "radius of the front wheel", _faster, "rR", "rF"),
    _by_radius("speed_by_rear_radius", "the initial spin of the front wheel is the speed over the "
               "radius of the rear wheel", _faster, "rF", "rR"),
    _by_radius("rear_spin_by_front_radius", "only the rear wheel starts with the spin that belongs "
               "to the other wheel's radius", lambda s, x: replace(s, rear_spin=x), "rR", "rF"),
    _by_radius("front_spin_by_rear_radius", "only the front wheel starts with the spin that "
               "belongs to the other wheel's radius", lambda s, x: replace(s, front_spin=x),
               "rF", "rR"),
    _spin_kept("wheels_exchanged", "one"),
    _spin_kept("radii_exchanged", "wheel"),
)  # fmt: skip
"""Mistakes in the initial conditions, in no particular order, without those of `misplaced`."""

VIOLATING = frozenset(
    ("roll_of_frame_only", "roll_without_wheels", "roll_without_wheels_turning",
     "roll_about_centre", "roll_without_translation", "front_wheel_at_rest",
     "rear_wheel_at_rest", "wheels_at_rest",
     "rear_spin_by_front_radius", "front_spin_by_rear_radius")
)  # fmt: skip
"""Codes of the mistakes whose initial velocities violate the rolling constraints."""
