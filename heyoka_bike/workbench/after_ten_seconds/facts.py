"""Prove facts about the benchmark's maneuvers after their ten seconds, from candidates alone.

The candidates are the motion of a cycle, and maneuver 3 until it falls. The facts that follow from
them and from the inputs of the benchmark are published in after-ten-seconds.json, in a folder with
the candidates (candidate.h5). This module proves them and checks the published file. All numbers
are correctly rounded to their digits.

`prove_lift` proves when a wheel first leaves the floor, for any initial state.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path
from typing import Any

import flint

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, benchmark, describe_inputs
from heyoka_bike.errors import DatasetError, NotCertifiedError
from heyoka_bike.motion.events import (
    FRONT_LIFT,
    GREATEST_LEAN,
    KINDS,
    REAR_LIFT,
    Event,
    Quantity,
    events,
    zeros,
)
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Evaluator, OnTime, Trajectory, evaluator
from heyoka_bike.numbers.arithmetic import Balls, Number, exact_ball
from heyoka_bike.numbers.exact import ZERO, Exact
from heyoka_bike.numbers.rounding import Enclosure
from heyoka_bike.reference.hdf5 import DAMAGE
from heyoka_bike.reference.layout import AFTER, CANDIDATE
from heyoka_bike.reference.manifest import MOST_BYTES_OF_SET, read_inside
from heyoka_bike.reference.proof.candidate import parse_candidate
from heyoka_bike.reference.proof.enclose import enclose
from heyoka_bike.system.jobs import OnStage
from heyoka_bike.system.parallel import Progress, side_by_side
from heyoka_bike.system.resources import after_folder
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
"""Facts used without proof."""

_BITS_OF_FACTS = 400


@dataclass(frozen=True)
class Fact:
    """A proved statement about a maneuver, with enclosures of its numbers.

    Attributes
    ----------
    about : str
        The maneuver.
    statement : str
    numbers : mapping of str to Enclosure
        Numbers by description, with their unit.
    """

    about: str
    statement: str
    numbers: Mapping[str, Enclosure]


def _steer_rate(equations: Equations, state: Sequence[Number]) -> Number:
    return equations.unfold(state)[1].steer_rate


def cycle_fact(run: Trajectory, like: Maneuver, progress: OnTime | None = None) -> Fact:
    """Prove that a limit cycle with the energy of a maneuver exists near a candidate.

    Raises
    ------
    NotCertifiedError
        The cycle does not exist, or its existence is not proved.
    """
    cycle = prove_cycle(run, like, progress)
    if not cycle.is_attracting:
        raise NotCertifiedError(f"{run.maneuver.name}: the cycle is not proved to be attracting")
    at = evaluator(run, certificate=cycle.certificate)
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
    """Return the speed of upright straight running that has the initial energy of a maneuver."""
    balls = Balls(_BITS_OF_FACTS)
    with balls.precision():
        equations = Equations.of(bicycle, balls)

        def kinetic(m: Maneuver) -> flint.arb:
            return flint.arb(equations.energies(initial_state(equations, m)).kinetic)

        one = replace(maneuver, speed=Exact(Fraction(1)), roll_rate=ZERO)
        speed = (kinetic(maneuver) / kinetic(one)).sqrt()
    return _fact(maneuver, SETTLING, {"final speed [m/s]": speed})


def fall_fact(run: Trajectory, progress: OnTime | None = None) -> Fact:
    """Prove at what time the rear wheel leaves the floor, and that no wheel lifts earlier.

    Raises
    ------
    NotCertifiedError
        The lift is not proved, or a wheel may lift earlier.
    """
    certificate = enclose(run, progress)
    at = evaluator(run, certificate=certificate)
    lift = _first(run, zeros(run, KINDS[REAR_LIFT], REAR_LIFT, certificate), "the rear wheel lifts")
    with at.balls.precision():
        start = KINDS[FRONT_LIFT](at.equations, at.state(Fraction(0)))
        before = [
            e for e in zeros(run, KINDS[FRONT_LIFT], FRONT_LIFT, certificate)
            if not e.time > lift.time
        ]  # fmt: skip
        if before or not start > 0 or lift.rises:
            raise NotCertifiedError(f"{run.maneuver.name}: a wheel may lift earlier")
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
        raise NotCertifiedError(f"{run.maneuver.name}: the time at which {what} is not proved")
    return found[0]


def _largest(
    at: Evaluator, rate: Quantity, column: str, end: flint.arb
) -> tuple[flint.arb, flint.arb]:
    """Return when the magnitude of a column is largest, up to a time, and this magnitude.

    It occurs where the rate of the column vanishes, or at one of the ends.
    """
    run = at.trajectory
    found = zeros(run, rate, column, at.certificate)
    if any(e.time.overlaps(end) for e in found):
        raise NotCertifiedError(f"{run.maneuver.name}: {column} may be largest at the end")
    times = [flint.arb(0), *(e.time for e in found if e.time < end), end]
    sizes = [abs(at.columns(t)[column]) for t in times]
    best = max(range(len(times)), key=lambda i: float(sizes[i].mid()))
    if not all(x < sizes[best] for i, x in enumerate(sizes) if i != best):
        raise NotCertifiedError(f"{run.maneuver.name}: it is not proved where {column} is largest")
    return times[best], sizes[best]


def _mean_speed(at: Evaluator, cycle: Cycle) -> flint.arb:
    """Return the mean speed of the rear hub along its heading over half a period [m/s]."""
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


_DIGITS_OF_FACTS = 30
_LETTERS_SHOWN = 60  # maximum number of characters shown of a value in a file

Digits = Callable[[Enclosure, str, str], int]
"""Function that returns the number of digits to write for an enclosure, a maneuver and a name."""


def prove_facts(
    cycle: Trajectory, fall: Trajectory, progress: Progress | None = None
) -> tuple[Fact, ...]:
    """Prove all statements about the maneuvers of the benchmark, from the two candidates.

    Raises
    ------
    NotCertifiedError
        A statement is not proved, or a candidate has other inputs.
    """
    bicycle, maneuvers = benchmark()
    for run in (cycle, fall):
        if describe_inputs(run.bicycle, []) != describe_inputs(bicycle, []):
            raise NotCertifiedError(
                f"{run.maneuver.name}: the bicycle is not that of the benchmark"
            )
    if _start(fall.maneuver) != _start(maneuvers[2]):
        raise NotCertifiedError(f"{fall.maneuver.name}: it does not start as {maneuvers[2].name}")
    weaving, falling = side_by_side(
        _prove,
        [(cycle, maneuvers[0]), (fall, None)],
        [(run.maneuver.name, float(run.breaks[-1])) for run in (cycle, fall)],
        progress,
    )
    return weaving, settling_fact(bicycle, maneuvers[1]), falling


def _prove(run: Trajectory, like: Maneuver | None, report: OnStage) -> Fact:
    def progress(t: float) -> None:
        report("certify", t)

    return fall_fact(run, progress) if like is None else cycle_fact(run, like, progress)


def _start(m: Maneuver) -> tuple[Any, ...]:
    return m.speed, m.roll_rate, m.roll, m.steer, m.steer_rate


def render_facts(facts: Sequence[Fact], digits: Digits | None = None) -> bytes:
    """Return the bytes of after-ten-seconds.json.

    Raises
    ------
    NotCertifiedError
        The enclosure of a number does not decide its digits.
    """
    count = digits or (lambda x, about, name: _decided(x))
    document = {
        "schema_version": 1,
        "inputs": describe_inputs(*benchmark()),
        "proved": [
            {
                "about": fact.about,
                "statement": fact.statement,
                "numbers": {
                    name: _text(x, count(x, fact.about, name), name)
                    for name, x in fact.numbers.items()
                },
            }
            for fact in facts
        ],
        "used": USED,
    }
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def _decided(x: Enclosure) -> int:
    """Return the number of decimal digits that an enclosure determines."""
    return next((n for n in range(_DIGITS_OF_FACTS, 0, -1) if x.decimal(n) is not None), 1)


def _text(x: Enclosure, digits: int, name: str) -> str:
    text = x.decimal(digits)
    if text is None:
        raise NotCertifiedError(f"{name}: {digits} digits are not decided")
    return str(Decimal(text))


def certify_after(
    folder: str | Path | None = None, *, progress: Progress | None = None
) -> tuple[Fact, ...]:
    """Prove the statements of after-ten-seconds.json again, from the candidates in its folder.

    Parameters
    ----------
    folder
        Folder of the file; by default the one that comes with the package.
    progress
        As for `certify`; the stage is ``certify``.

    Raises
    ------
    NotCertifiedError
        A statement is not proved, or the file differs from it.
    DatasetError
        A file is missing, or has another format.
    """
    where = after_folder() if folder is None else Path(folder)
    raw = _read(where, AFTER)
    runs = parse_candidate(_read(where, CANDIDATE), where / CANDIDATE)
    try:
        said = {x["about"]: x["numbers"] for x in json.loads(raw)["proved"]}
        found = {(about, name): text for about, x in said.items() for name, text in x.items()}
    except DAMAGE as e:
        raise DatasetError(
            f"{where / AFTER} is not a file that 'heyoka-bike generate --after-ten-seconds' writes "
            f"({e})"
        ) from None
    if len(runs) != 2:
        raise DatasetError(f"{where / CANDIDATE}: found {len(runs)} motions, expected 2")
    facts = prove_facts(*runs, progress)
    proved = {(fact.about, name): x for fact in facts for name, x in fact.numbers.items()}
    for key in found.keys() ^ proved.keys():
        what = "the proof does not cover this number" if key in found else "the number is missing"
        raise NotCertifiedError(f"{where / AFTER}: {', '.join(key)}: {what}")
    for key, x in proved.items():
        text = _text(x, _digits(found[key]), ", ".join(key))
        if text != found[key]:
            raise NotCertifiedError(
                f"{where / AFTER}: {', '.join(key)}: published {found[key]!r:.{_LETTERS_SHOWN}}, "
                f"proved {text}"
            )
    if raw != render_facts(facts, lambda x, about, name: _digits(found[about, name])):
        raise NotCertifiedError(
            f"{where / AFTER}: the inputs or the sentences differ from the proved ones"
        )
    return facts


def _digits(text: object) -> int:
    """Return the number of significant digits of a published number; 1 if it is not a number."""
    try:
        return max(len(Decimal(str(text)[:_LETTERS_SHOWN]).as_tuple().digits), 1)
    except InvalidOperation:
        return 1


def _read(folder: Path, name: str) -> bytes:
    try:
        return read_inside(folder, name, MOST_BYTES_OF_SET)
    except (OSError, ValueError) as e:
        reason = getattr(e, "strerror", None) or e
        raise DatasetError(f"{folder / name}: cannot be read: {reason}") from None


_AFTER = Fraction(1, 2**10)
"""The candidate ends this long after a lift found in binary64 [s]."""

_PRECISION = "binary128"


@dataclass(frozen=True, slots=True)
class ProvedLift:
    """Proved statements about when the wheels of a motion leave the floor.

    Attributes
    ----------
    lift : Event or None
        Enclosure of the first time at which a normal force passes zero; None if that is not proved.
    is_decided : bool
        True if both wheels are proved to press on the floor until the lift, or until `end`.
    end : Fraction
        End of the search [s].
    """

    lift: Event | None
    is_decided: bool
    end: Fraction


def prove_lift(
    bicycle: Bicycle, maneuver: Maneuver, time: float | None, progress: OnTime | None = None
) -> ProvedLift:
    """Prove when a wheel first leaves the floor, or that none does within the maneuver.

    Parameters
    ----------
    bicycle, maneuver
        Bicycle and initial state; the duration matters if no lift is expected.
    time
        Time of the lift found in binary64 [s]; None if none was found.

    Raises
    ------
    NotCertifiedError
        No certificate was found.
    MissingPackageError
        heyoka is not installed.
    """
    end = maneuver.duration if time is None else Fraction(time) + _AFTER
    run = integrate(bicycle, replace(maneuver, duration=end, spacing=end), _PRECISION)
    certificate = enclose(run, progress)
    found = list(events(run, (REAR_LIFT, FRONT_LIFT), certificate))
    lift = next((x for x in found if x.rises is False), None)
    before = found if lift is None else found[: found.index(lift)]
    return ProvedLift(lift, not before, end)
