"""The benchmark's maneuvers after their ten seconds, proved from candidates alone.

The candidates are the motion of a cycle, and maneuver 3 until it falls. What follows from them
and from the inputs of the benchmark is published in after-ten-seconds.json, see `after_file`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import flint

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.events import (
    FRONT_LIFT,
    GREATEST_LEAN,
    KINDS,
    REAR_LIFT,
    Event,
    Quantity,
    zeros,
)
from heyoka_bike.motion.trajectory import Evaluator, Trajectory, evaluator
from heyoka_bike.numbers.arithmetic import Balls, Number, exact_ball
from heyoka_bike.numbers.exact import ZERO, Exact
from heyoka_bike.numbers.rounding import Enclosure
from heyoka_bike.reference.proof.enclose import Progress, enclose
from heyoka_bike.workbench.after_ten_seconds.limit_cycle import Cycle, prove_cycle

CYCLE = (
    "There is a cycle with the energy that maneuver 1 starts with. Half a period later it is its "
    "own mirror image, and it does not come upright in between. It attracts the motions of this "
    "energy that come near it: the multipliers are all below 1 in magnitude. That maneuver 1 comes "
    "near it is computed, not proved."
)
SETTLING = (
    "The bicycle that runs upright and straight with the energy that maneuver 2 starts with has "
    "this speed. That maneuver 2 comes to it is computed, not proved."
)
FALL = (
    "From the start of maneuver 3 both wheels press on the floor until the rear wheel's normal "
    "force vanishes, at the lift-off. Until then no roll angle is larger than the largest named."
)
USED = (
    "what is trusted in certificate.json",
    "that the mirror image of a motion is a motion, and that motions keep their energy and both "
    "wheels on the floor; the tests show that these are identities",
)
"""The facts that are taken as known."""

_GUARD_BITS = 64
_BITS = 400


@dataclass(frozen=True)
class Fact:
    """Something that is proved.

    Attributes
    ----------
    about : str
        The maneuver.
    statement : str
    numbers : mapping of str to Enclosure
        By what they are, with their unit.
    """

    about: str
    statement: str
    numbers: Mapping[str, Enclosure]


def _steer_rate(equations: Equations, state: Sequence[Number]) -> Number:
    return equations.unfold(state)[1].steer_rate


def cycle_fact(run: Trajectory, like: Maneuver, progress: Progress | None = None) -> Fact:
    """The cycle near a candidate that has the energy of a maneuver.

    Raises
    ------
    NotCertifiedError
        It does not exist, or is not shown to.
    """
    cycle = prove_cycle(run, like, progress)
    if not cycle.is_attracting:
        raise NotCertifiedError(f"{run.maneuver.name}: it is not shown to be attracting")
    at = evaluator(run, run.bits + _GUARD_BITS, cycle.certificate)
    with at.balls.precision():
        half = cycle.half_period
        start = at.columns(Fraction(0))
        upright = {"steer angle [rad]": "steer_angle", "roll rate [rad/s]": "roll_rate",
                   "steer rate [rad/s]": "steer_rate", "speed [m/s]": "forward_speed"}  # fmt: skip
        numbers = {
            "period [s]": 2 * half,
            "largest roll angle [rad]": _largest(at, KINDS[GREATEST_LEAN], "roll_angle", half)[1],
            "largest steer angle [rad]": _largest(at, _steer_rate, "steer_angle", half)[1],
            "mean of the forward speed [m/s]": _mean_speed(at, cycle),
            **{f"{name}, upright and rising": start[key] for name, key in upright.items()},
            **{f"half-period multiplier {i}": x for i, x in enumerate(cycle.multipliers, 1)},
            **{f"Floquet multiplier {i}": x * x for i, x in enumerate(cycle.multipliers, 1)},
        }
    return _fact(like, CYCLE, numbers)


def settling_fact(bicycle: Bicycle, maneuver: Maneuver) -> Fact:
    """The speed, upright and straight, with the energy of a start that is upright and straight."""
    balls = Balls(_BITS)
    with balls.precision():
        equations = Equations.of(bicycle, balls)

        def kinetic(m: Maneuver) -> flint.arb:
            return flint.arb(equations.energies(initial_state(equations, m)).kinetic)

        one = replace(maneuver, speed=Exact(Fraction(1)), roll_rate=ZERO)
        speed = (kinetic(maneuver) / kinetic(one)).sqrt()
    return _fact(maneuver, SETTLING, {"final speed [m/s]": speed})


def fall_fact(run: Trajectory, progress: Progress | None = None) -> Fact:
    """When the rear wheel leaves the floor.

    Raises
    ------
    NotCertifiedError
        It is not shown to, or a wheel may be pulled down before.
    """
    certificate = enclose(run, progress)
    at = evaluator(run, run.bits + _GUARD_BITS, certificate)
    lift = _first(run, zeros(run, KINDS[REAR_LIFT], REAR_LIFT, certificate), "the rear wheel lifts")
    with at.balls.precision():
        start = KINDS[FRONT_LIFT](at.equations, at.state(Fraction(0)))
        before = [
            e for e in zeros(run, KINDS[FRONT_LIFT], FRONT_LIFT, certificate)
            if not e.time > lift.time
        ]  # fmt: skip
        if before or not start > 0 or lift.rises:
            raise NotCertifiedError(f"{run.maneuver.name}: a wheel may be pulled down sooner")
        time, roll = _largest(at, KINDS[GREATEST_LEAN], "roll_angle", lift.time)
        there, on_floor = at.columns(lift.time), forces(at.equations, at.state(lift.time))
        leaning = forces(at.equations, at.state(time))
        numbers = {
            "largest roll angle, time [s]": time,
            "largest roll angle [rad]": roll,
            "friction coefficient that the rear wheel needs then": leaning.rear.friction(at.balls),
            "lift-off, time [s]": lift.time,
            "roll angle at the lift-off [rad]": there["roll_angle"],
            "steer angle at the lift-off [rad]": there["steer_angle"],
            "speed at the lift-off [m/s]": there["forward_speed"],
            "normal force on the front wheel at the lift-off [N]": on_floor.front.normal,
        }
    return _fact(run.maneuver, FALL, numbers)


def _fact(maneuver: Maneuver, statement: str, numbers: Mapping[str, flint.arb]) -> Fact:
    enclosed = {name: Enclosure.of(x) for name, x in numbers.items()}
    return Fact(maneuver.name, statement, enclosed)


def _first(run: Trajectory, found: Sequence[Event], what: str) -> Event:
    if not found or not found[0].is_single:
        raise NotCertifiedError(f"{run.maneuver.name}: it is not shown when {what}")
    return found[0]


def _largest(
    at: Evaluator, rate: Quantity, column: str, end: flint.arb
) -> tuple[flint.arb, flint.arb]:
    """Where a column is largest in magnitude from the start to a time, and how large.

    It is so where its rate vanishes, or at one of the ends.
    """
    run = at.trajectory
    found = zeros(run, rate, column, at.certificate)
    if any(e.time.overlaps(end) for e in found):
        raise NotCertifiedError(f"{run.maneuver.name}: {column} may be largest at the end")
    times = [flint.arb(0), *(e.time for e in found if e.time < end), end]
    sizes = [abs(at.columns(t)[column]) for t in times]
    best = max(range(len(times)), key=lambda i: float(sizes[i].mid()))
    if not all(x < sizes[best] for i, x in enumerate(sizes) if i != best):
        raise NotCertifiedError(f"{run.maneuver.name}: it is not shown where {column} is largest")
    return times[best], sizes[best]


def _mean_speed(at: Evaluator, cycle: Cycle) -> flint.arb:
    """Of the rear hub along its heading, over half a period [m/s]."""
    run, k, turned = at.trajectory, at.equations.k, flint.arb(0)
    for i, bounds in enumerate(cycle.certificate.pieces):
        piece = run.piece(i)
        h = exact_ball(piece.h)
        s = ((cycle.half_period - exact_ball(piece.t0)) / h).min(flint.arb(1))
        if not s > 0:
            break
        spin = flint.arb_poly(list(piece.rows[5])).integral()(s) / flint.arb(2) ** piece.grid
        turned += h * (spin + flint.arb(0, exact_ball(bounds[5]).upper()))
    return flint.arb(k.length * k.rear.r * turned / cycle.half_period)
