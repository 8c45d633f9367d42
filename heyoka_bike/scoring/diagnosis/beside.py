"""Faults of the rows in a file whose motion has a cause of its own.

The looks at the rows compare a file with the exact motion. Once a cause of the file's motion is
found, its motion takes the place of the exact one, and the same looks are asked again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Alignment, Part
from heyoka_bike.scoring.diagnosis.claims import has_usual_energy
from heyoka_bike.scoring.diagnosis.conclusions import BesideCause, Direction, Explained
from heyoka_bike.scoring.diagnosis.programs.program import Cause, Program, apply, beginning
from heyoka_bike.scoring.diagnosis.programs.simulated_maneuver import with_columns
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.scoring.diagnosis.seen_file import correct_program
from heyoka_bike.scoring.diagnosis.sources import SOURCES, looked
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.score import scored


@dataclass(frozen=True, eq=False, slots=True)
class Beside:
    """Faults of the rows beside causes of the motion.

    Attributes
    ----------
    causes : sequence of tuple of Cause
        The likeliest causes of the motion.
    seen : tuple of Evidence
        The faults.
    parts : tuple of Part
        The rows without the faults. Columns whose corrected values would come from the simulated
        motion are left out.
    """

    causes: Sequence[tuple[Cause, ...]]
    seen: tuple[Evidence, ...]
    parts: tuple[Part, ...]


def faults_beside(
    seen: Sequence[Evidence], report: Report, reference: Reference, simulator: Simulator
) -> Beside | None:
    """Find the faults of the rows that show in comparison with the motion of a cause.

    Parameters
    ----------
    seen
        The conclusions on the report. The first cause of the motion counts, if it leaves an error
        in some column that it does not explain.
    report
        The file, compared with the exact motion.
    reference, simulator

    Returns
    -------
    Beside or None
        None if no fault is found.
    """
    causes = next((found for x in seen if (found := _incomplete(x))), [])
    if not causes or any(m.kind == "method" for m in causes[0]):
        return None
    program = apply(correct_program(reference), causes[0])
    if program.edits or program.motion.linear:
        return None
    parts = _compared_with(program, report, reference, simulator)
    if not has_usual_energy(causes[0]):
        parts = [part.only([k for k in part.values if not k.endswith("_energy")]) for part in parts]
    found: list[Evidence] = []
    for source in SOURCES:
        if not (source.is_of_motion and parts):
            continue
        here = scored(Alignment(report.file, tuple(parts), ()), reference)
        if (undone := looked(source, here)) is not None:
            found += undone.seen
            kept = (
                part.only([k for k in part.values if (part.number, k) not in undone.filled])
                for part in undone.parts
            )
            parts = [part for part in kept if part.has_values()]
    if not (found and parts):
        return None
    own = tuple(replace(part, reference=reference[part.number]) for part in parts)
    return Beside(causes, tuple(map(BesideCause, found)), own)


def _incomplete(x: Evidence) -> list[tuple[Cause, ...]]:
    """The causes of a conclusion, if they leave an error in some column; otherwise none."""
    if isinstance(x, Explained) and x.rank == 1 and x.rest is not None:
        return [h.mistakes for h in (*x.hypotheses, *x.rivals)]
    return [x.hypothesis.mistakes] if isinstance(x, Direction) else []


def _compared_with(
    program: Program, report: Report, reference: Reference, simulator: Simulator
) -> list[Part]:
    """The rows to compare with the motion of a program, up to the end of that motion."""
    found = []
    for m in report.maneuvers:
        whole = reference[m.maneuver]
        motion = MotionRequest(
            program.motion.bicycle,
            beginning(program, m.maneuver),
            np.array([float(whole.duration)]),
            dict(program.motion.amounts),
        )
        simulated = with_columns(whole, partial(simulator.at, motion))
        rows = m.part.at(m.part.time <= simulated.time[-1])
        if len(rows.time) >= MIN_ROWS_FOR_SHAPE:
            found.append(replace(rows, reference=simulated))
    return found
