"""Find faults of the rows in a file whose motion is wrong for another reason.

The row checks compare a file with the exact motion. Once the cause of a wrong motion is found, the
simulated motion with this cause replaces the exact one, and the same checks are repeated. If a
fault of the rows hides the cause, the search leaves out the rows or the rate that contradict the
rest of the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.diagnosis.claims import has_usual_energy
from heyoka_bike.scoring.diagnosis.conclusions import BesideCause, Direction, Explained
from heyoka_bike.scoring.diagnosis.mistakes.linearised import has_constant_speed
from heyoka_bike.scoring.diagnosis.programs.program import Program, apply
from heyoka_bike.scoring.diagnosis.programs.simulated_maneuver import with_columns
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator, requested
from heyoka_bike.scoring.diagnosis.residual.observed import Observed, integral
from heyoka_bike.scoring.diagnosis.row_checks import ROW_CHECKS, run_check
from heyoka_bike.scoring.diagnosis.search import Causes
from heyoka_bike.scoring.diagnosis.seen_file import correct_program
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE
from heyoka_bike.scoring.ratios import BY_FAR
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.rates import LATERAL_ANGLES
from heyoka_bike.scoring.rows.table import Undone
from heyoka_bike.scoring.score import scored_rows

SPEED = "forward_speed"


def faults_beside(
    causes: Sequence[Causes], report: Report, reference: Reference, simulator: Simulator
) -> Undone | None:
    """Find faults of the rows by comparing them with the simulated motion of a cause.

    Parameters
    ----------
    causes
        The likeliest causes of the motion, the best first. The simulated motion with the best cause
        replaces the exact one.
    report
        The file, compared with the exact motion.
    reference, simulator

    Returns
    -------
    Undone or None
        The faults, and the rows without them; columns whose corrected values would come from the
        simulated motion are left out. None if no fault is found.
    """
    if not causes or any(m.kind == "method" for m in causes[0]):
        return None
    program = apply(correct_program(reference), causes[0])
    if program.edits or program.motion.linear:
        return None
    parts = _compared_with(program, report, reference, simulator)
    if not has_usual_energy(causes[0]):
        parts = [part.only([k for k in part.values if not k.endswith("_energy")]) for part in parts]
    found: list[Evidence] = []
    compared = scored_rows(report, parts, reference)
    for check in ROW_CHECKS:
        if not (check.is_of_motion and parts):
            continue
        undone = run_check(check, compared)
        if undone is not None:
            found += undone.seen
            kept = (
                part.only([k for k in part.values if (part.number, k) not in undone.filled])
                for part in undone.parts
            )
            parts = [part for part in kept if part.has_values()]
            compared = scored_rows(report, parts, reference)
    if not (found and parts):
        return None
    own = tuple(replace(part, reference=reference[part.number]) for part in parts)
    return Undone(tuple(map(BesideCause, found)), own)


def causes_of(seen: Sequence[Evidence], *, is_incomplete: bool = False) -> list[Causes]:
    """Return the likeliest causes of the motion in a list of conclusions; empty if it has none.

    With `is_incomplete`, only causes that leave an error in some column.
    """
    for x in seen:
        if isinstance(x, Explained) and x.rank == 1 and not (is_incomplete and x.rest is None):
            return [h.mistakes for h in (*x.hypotheses, *x.rivals)]
        if isinstance(x, Direction):
            return [x.hypothesis.mistakes]
    return []


def consistent_parts(report: Report, motions: Sequence[Observed]) -> Iterator[tuple[Part, ...]]:
    """Yield the rows without the maneuvers or columns that may contradict the rest of a file.

    A rate is the slope of its angle, whatever the motion is. If this fails in some maneuvers only,
    they are left out. If it fails in all, but for one angle only, then first its rate is left out,
    and next the angle is replaced by the integral of the rate. At last a speed is left out that is
    the same in every row: the speed of a bicycle that leans and steers varies.
    """
    off = {(m.number, key): x for m in motions for key, x in m.inconsistencies().items()}
    ranked = sorted(off, key=lambda place: -off[place])
    count = next(
        (i for i in range(1, len(ranked)) if off[ranked[i - 1]] > BY_FAR * off[ranked[i]]), 0
    )
    numbers, keys = {n for n, _ in ranked[:count]}, {key for _, key in ranked[:count]}
    parts = tuple(m.part for m in report.maneuvers)
    if 0 < len(numbers) < len(parts):
        yield tuple(part for part in parts if part.number not in numbers)
    elif len(keys) == 1:
        (rate,) = keys
        yield tuple(part.without(keys) for part in parts)
        yield tuple(_with_integral(part, rate) for part in parts)
    if has_constant_speed(parts) and any(SPEED in part.values for part in parts):
        yield tuple(part.without({SPEED}) for part in parts)


def _with_integral(part: Part, rate: str) -> Part:
    """Replace an angle with the integral of its rate, from the upright start on."""
    angle = LATERAL_ANGLES[rate]
    whole = part.at(np.isfinite(part.values[rate]))
    values = {**whole.values, angle: integral(whole.time, whole.values[rate])}
    lo = {key: x for key, x in whole.lo.items() if key != angle}
    units = {key: x for key, x in whole.units.items() if key not in (angle, rate)}
    return replace(whole, values=values, lo=lo, units=units)


def _compared_with(
    program: Program, report: Report, reference: Reference, simulator: Simulator
) -> list[Part]:
    """Return the rows with a program's motion as reference, without motions that end early."""
    found = []
    for m in report.maneuvers:
        whole = reference[m.maneuver]
        motion = requested(program, m.maneuver, np.array([float(whole.duration)]))
        simulated = with_columns(whole, partial(simulator.at, motion))
        # If the simulated motion ends early, its columns are not finite after its end. Leave out
        # such a maneuver.
        is_whole = all(np.isfinite(x).all() for x in simulated.rows.hi.values())
        if is_whole and m.rows >= MIN_ROWS_FOR_SHAPE:
            # Programs are simulated without the columns of the whole motion, such as the path.
            part = m.part.only([key for key in m.part.values if key in simulated.definitions])
            found.append(replace(part, reference=simulated))
    return found
