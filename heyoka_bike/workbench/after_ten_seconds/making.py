"""Make after-ten-seconds.json: compute two candidates with heyoka, and prove all facts.

The candidate for the cycle that a weaving bicycle settles on is found by Newton's method. The
bicycle conserves its energy, so cycles form families of one parameter; the wanted cycle has the
energy of the maneuver. It is its own mirror image half a period later. With roll = 0 and rising, a
map takes a point (steer, roll rate, steer rate, speed) to the mirrored next upright crossing, and
Newton's method finds a fixed point. One of the four conditions follows from the others and is
replaced by the condition on the energy. Derivatives are central differences. The module
`limit_cycle` proves that the cycle exists.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from pathlib import Path
from typing import Any

import flint
import mpmath

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, benchmark, describe_inputs
from heyoka_bike.errors import InputError
from heyoka_bike.motion.events import REAR_LIFT, UPRIGHT, events, first_event
from heyoka_bike.motion.heyoka_adapter import require_heyoka
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory, evaluator
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.layout import AFTER, CANDIDATE
from heyoka_bike.reference.manifest import write_files
from heyoka_bike.reference.proof import candidate
from heyoka_bike.system.parallel import Progress
from heyoka_bike.workbench.after_ten_seconds.facts import prove_facts, render_facts

COLUMNS = ("steer_angle", "roll_rate", "steer_rate", "forward_speed")
MIRRORED = (-1, -1, -1, 1)

# Duration of a run that contains half a period of the cycle [s]. It is shorter than a whole period.
_A_HALF = Fraction(17, 16)
_SETTLING = Fraction(300)
_NEWTON_STEPS = 8
_ROUGH_DIGITS = 30
# Newton's method stops when its step is below 2^_LAST_BITS units in the last place.
_LAST_BITS = 12


@dataclass(frozen=True)
class Section:
    """The map from an upright state of the bicycle to the mirrored next one, at a precision.

    Attributes
    ----------
    bicycle : Bicycle
    digits : int
    """

    bicycle: Bicycle
    digits: int

    @property
    def bits(self) -> int:
        return Precision.of(self.digits).bits

    @property
    def mp(self) -> Any:
        """The mpmath context with the precision of the map."""
        context = mpmath.mp.clone()
        context.prec = self.bits + 32
        return context

    def run(self, x: Sequence[Any], duration: Fraction = _A_HALF) -> Trajectory:
        """Return the motion that starts upright with the values `x` of the four `COLUMNS`."""
        mp = self.mp
        values = [Fraction(int(mp.nint(mp.ldexp(v, self.bits))), 2**self.bits) for v in x]
        steer, roll_rate, steer_rate, speed = map(Exact, values)
        maneuver = Maneuver(
            "cycle", speed, roll_rate, duration, duration, steer=steer, steer_rate=steer_rate
        )
        return integrate(self.bicycle, maneuver, self.digits, is_regular=True)

    def half(self, x: Sequence[Any]) -> tuple[list[Any], Any, Any]:
        """Return the mirrored next upright point, its time [s], and the energy [J]."""
        run = self.run(x)
        crossing = next(events(run, (UPRIGHT,)))
        at = evaluator(run)
        with at.balls.precision():
            there = at.columns(crossing.time)
            point = [s * self.number(there[c]) for s, c in zip(MIRRORED, COLUMNS, strict=True)]
            energy = self.number(at.columns(Fraction(0))["mechanical_energy"])
        return point, self.number(crossing.time), energy

    def number(self, x: flint.arb) -> Any:
        """Return the midpoint of a ball as a number of mpmath."""
        man, exp = x.mid().man_exp()
        return self.mp.ldexp(self.mp.mpf(int(man)), int(exp))

    def derivatives(self, x: Sequence[Any]) -> Any:
        """Return the derivatives of the map and of the energy by the point, shape (5, 4)."""
        step = self.mp.ldexp(1, -self.bits // 3)
        found = self.mp.matrix(5, 4)
        for j in range(4):
            (up, _, e_up), (down, _, e_down) = (
                self.half([v + side * step * (i == j) for i, v in enumerate(x)]) for side in (1, -1)
            )
            for i, (a, b) in enumerate(zip([*up, e_up], [*down, e_down], strict=True)):
                found[i, j] = (a - b) / (2 * step)
        return found


def settled(bicycle: Bicycle, maneuver: Maneuver) -> list[float]:
    """Return the last upright point, with rising roll, of a maneuver that has settled."""
    run = integrate(bicycle, replace(maneuver, duration=_SETTLING))
    crossing = [e for e in events(run, (UPRIGHT,)) if e.rises][-1]
    at = evaluator(run)
    with at.balls.precision():
        there = at.columns(crossing.time)
        return [float(there[c].mid()) for c in COLUMNS]


def cycle_candidate(bicycle: Bicycle, maneuver: Maneuver, digits: int) -> Trajectory:
    """Return a candidate: over half a period of the cycle that has the energy of a maneuver."""
    section = Section(bicycle, digits)
    mp = section.mp
    start = integrate(bicycle, replace(maneuver, duration=maneuver.spacing), digits)
    at = evaluator(start, section.bits + 64)
    with at.balls.precision():
        wanted = section.number(at.columns(Fraction(0))["mechanical_energy"])
    x = [mp.mpf(v) for v in settled(bicycle, maneuver)]
    # The derivatives at the first guess are accurate enough for all steps of Newton's method.
    slopes = mp.matrix(Section(bicycle, _ROUGH_DIGITS).derivatives(x))
    matrix = slopes[:4, :].copy()
    for i in range(3):
        matrix[i, i] -= 1
    matrix[3, :] = slopes[4, :]
    for _ in range(_NEWTON_STEPS):
        there, _time, energy = section.half(x)
        rest = [*(b - a for a, b in zip(x[:3], there[:3], strict=True)), energy - wanted]
        change = mp.lu_solve(matrix, mp.matrix(rest))
        x = [a - b for a, b in zip(x, change, strict=True)]
        if mp.norm(change) < mp.ldexp(1, _LAST_BITS - section.bits):
            break
    return section.run(x)


_VERSION = "after-ten-seconds"
"""Replaces the version of the dataset in files: this folder has no version of its own."""

_DIGITS_OF_CYCLE = 50
"""Digits of the candidates. With these the 30 published digits are decided, although errors grow by
a factor of 10^12."""


def generate_after(folder: str | Path, *, progress: Progress | None = None) -> tuple[str, ...]:
    """Compute, prove and write facts on the benchmark's maneuvers after ten seconds.

    Parameters
    ----------
    folder
        Folder for candidate.h5 and after-ten-seconds.json; created if needed.
    progress
        As for `certify`.

    Returns
    -------
    tuple of str
        Names of the files that were written; files of equal content are not touched.

    Raises
    ------
    InputError
        The path is not a folder.
    NotCertifiedError
        A statement is not proved.
    DatasetError
        The folder cannot be written.
    MissingPackageError
        heyoka is not installed.
    """
    require_heyoka()
    if not str(folder).strip():
        raise InputError("--out: found nothing, expected a folder")
    bicycle, maneuvers = benchmark()
    cycle = cycle_candidate(bicycle, maneuvers[0], _DIGITS_OF_CYCLE)
    lift = first_event(bicycle, maneuvers[2], until=REAR_LIFT)
    # The event is always found, because the bicycle falls in maneuver 3 of the benchmark.
    assert lift is not None
    rows = ceil(Fraction(float(lift.time)) / maneuvers[2].spacing)
    until = replace(maneuvers[2], duration=rows * maneuvers[2].spacing)
    fall = integrate(bicycle, until, _DIGITS_OF_CYCLE)
    facts = prove_facts(cycle, fall, progress)
    runs = (cycle, fall)
    inputs = describe_inputs(bicycle, [run.maneuver for run in runs])
    files = {CANDIDATE: candidate.render(runs, inputs, _VERSION), AFTER: render_facts(facts)}
    return tuple(write_files(folder, files))
