"""Why results differ from the reference: a score, with what explains it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.display import shown_by
from heyoka_bike.numbers.double import two_sum, with_usual_errors
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.alignment import Alignment
from heyoka_bike.scoring.diagnosis.answers import (
    NOTHING_WRONG,
    explanation,
    findings,
    is_right,
    nothing_wrong,
)
from heyoka_bike.scoring.diagnosis.budget import SECONDS, USUAL, Budget, Deadline
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.plain import beside
from heyoka_bike.scoring.diagnosis.written import STEPS, AsMeant, Step, as_meant, worst
from heyoka_bike.scoring.evidence import (
    DefinitionUnknown,
    SignContradiction,
    StoppedEarly,
    TimeShift,
)
from heyoka_bike.scoring.findings import Finding, named, warning
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.score import score, scored
from heyoka_bike.system import jobs

NOTHING = warning(
    "nothing_to_diagnose",
    "the diagnosis looks at the benchmark's columns, and none of them has a value: "
    + ", ".join(BENCHMARK_COLUMNS),
)


@with_usual_errors
def diagnose(
    results: Any = None,
    reference: Reference | str | PathLike[str] | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    maneuver: int | None = None,
    columns: str | Sequence[str] | None = None,
    budget: float = SECONDS,
    **named: Any,
) -> Report:
    """Compare results with the reference, and say why they differ.

    Parameters
    ----------
    results, reference
        As in `score`.
    progress
        Called with the part of the work that is done, 0 to 1.
    maneuver, columns
        As in `score`.
    budget
        Processor time that looking for causes may take, in all threads of this process [s]. When it
        is spent the report has what was found until then, and `is_stopped_early`.
    named
        As in `score`.

    Returns
    -------
    Report
        As from `score`, with a `diagnosis`: the mistakes or the parameters whose simulation
        explains the results, or what their error looks like. Mistakes are simulated for the columns
        of the benchmark only; of others a factor, an offset or the same number in every row is
        seen. Without the former little or nothing can be said; this is said.

    Raises
    ------
    InputError
        See `score`; or a reference that does not start upright and straight, or a budget that is
        not more than zero.
    NothingScoredError
        Nothing can be compared.
    """
    given = Budget(budget)
    known = load_reference(reference)
    found = score(results, known, maneuver=maneuver, columns=columns, **named)
    return diagnosed(found, known, progress, given)


def diagnosed(
    report: Report,
    reference: Reference,
    progress: Callable[[float], None] | None = None,
    budget: Budget = USUAL,
) -> Report:
    """The report with its diagnosis; the reference is the one it was made with."""
    found, is_whole = _explained(report, reference, progress or (lambda _: None), budget.begun())
    if is_whole:
        return found
    stopped = StoppedEarly(budget.seconds)
    said = shown_by("sayings").finding(stopped)
    return replace(found, seen=(*found.seen, stopped), diagnosis=(*found.diagnosis, said))


def _explained(
    report: Report,
    reference: Reference,
    progress: Callable[[float], None],
    deadline: Deadline,
    steps: Sequence[Step] = STEPS,
) -> tuple[Report, bool]:
    """The report with its diagnosis, and whether every cause was tried.

    What is written is looked at by these steps first.
    """
    late = next((x for x in report.seen if isinstance(x, TimeShift)), None)
    if late is not None:
        shifted = _shifted(report, reference, late.shift)
        inner, is_whole = _explained(shifted, reference, progress, deadline)
        rest = tuple(f for f in inner.diagnosis if f.code != "no_mistake_found")
        said = (shown_by("sayings").finding(late), *rest)
        return replace(report, diagnosis=said, explanation=inner.explanation), is_whole
    meant = as_meant(report, steps)
    if meant is not None:
        return _beside(report, meant, reference, progress, deadline)
    unknown = {c.key for m in report.maneuvers for c in m.columns if not c.is_known}
    # A column of unknown meaning shows its meaning, not what the program does.
    keys = [key for key in BENCHMARK_COLUMNS if key not in unknown]
    found, is_whole = _of_columns(report, reference, keys, progress, deadline)
    if unknown and found.explanation is None:
        # It may be another column, or be computed wrongly.
        other, is_other_whole = _of_columns(
            report, reference, BENCHMARK_COLUMNS, progress, deadline, only_output=True
        )
        if any(f.code == "mistake" for f in other.diagnosis[:1]):
            others = tuple(x for x in report.seen if not isinstance(x, DefinitionUnknown))
            return replace(other, seen=others), is_other_whole
        is_whole = is_whole and is_other_whole
    seen = () if NOTHING in found.diagnosis else beside(report, unknown)
    more = tuple(map(shown_by("sayings").finding, seen))
    if any(f.code == NOTHING_WRONG for f in found.diagnosis):
        # What is wrong comes first.
        return replace(found, diagnosis=(*more, _right(report, keys))), is_whole
    return replace(found, diagnosis=(*found.diagnosis, *more)), is_whole


def _beside(
    report: Report,
    meant: AsMeant,
    reference: Reference,
    progress: Callable[[float], None],
    deadline: Deadline,
) -> tuple[Report, bool]:
    """What is seen in the rows of a report, and the diagnosis of the rows as they were meant.

    What is left of these is no cause of its own where it is right, and far less than before.
    """
    found = (*map(shown_by("sayings").finding, meant.seen),)
    rest = scored(meant.alignment(report), reference)
    before, left = worst(report), worst(rest)
    if left.max_rel_error < min(WEIGHTS.little, before.max_rel_error / WEIGHTS.mostly):
        if not is_right(rest):
            found = (*found, shown_by("sayings").finding(left))
        return replace(report, diagnosis=found), True
    inner, is_whole = _explained(rest, reference, progress, deadline, meant.steps)
    more = tuple(f for f in inner.diagnosis if f.code != NOTHING_WRONG)
    return replace(report, diagnosis=(*found, *more), explanation=inner.explanation), is_whole


def _right(report: Report, keys: Sequence[str]) -> Finding:
    """All columns that are diagnosed are right, each by itself; named where there are others."""
    every = dict.fromkeys(c.key for m in report.maneuvers for c in m.columns if c.values)
    told = [key for key in every if key in keys]
    which = "every column" if len(told) == len(every) else f"{named(told)}: each"
    signs = next((x for x in report.seen if isinstance(x, SignContradiction)), None)
    if signs is not None:
        odd: Finding = shown_by("sayings").finding(signs)
        return replace(odd, message=f"{which} is right by itself, but {odd.message}")
    return nothing_wrong(which)


def diagnosed_elsewhere(
    report: Report, reference: Reference, budget: Budget, told: jobs.TellStage
) -> Report:
    """`diagnosed` as a job: its stage is ``diagnose``, and takes one second."""
    return diagnosed(report, reference, lambda share: told("diagnose", share), budget)


def _of_columns(
    report: Report,
    reference: Reference,
    keys: Sequence[str],
    progress: Callable[[float], None],
    deadline: Deadline,
    *,
    only_output: bool = False,
) -> tuple[Report, bool]:
    """The report with the diagnosis of these columns, and whether every cause was tried.

    With `only_output` by mistakes of what is written only.
    """
    maneuvers = tuple(
        replace(m, columns=tuple(c for c in m.columns if c.key in keys), part=m.part.only(keys))
        for m in report.maneuvers
    )
    parts = [m.part for m in maneuvers]
    if not any(part.has_values() for part in parts):
        return replace(report, diagnosis=(NOTHING,)), True
    if is_right(replace(report, maneuvers=maneuvers)):
        return replace(report, diagnosis=(nothing_wrong("every column"),)), True
    found = explain(parts, reference, only_output=only_output, progress=progress, deadline=deadline)
    said = findings(found, replace(report, maneuvers=maneuvers))
    return replace(report, diagnosis=said, explanation=explanation(found, said)), found.is_whole


def _shifted(report: Report, reference: Reference, shift: float) -> Report:
    """The report with so much taken off all times, of the rows that are then within the run."""
    parts = []
    for part in (m.part for m in report.maneuvers):
        time, rest = two_sum(part.time, np.full_like(part.time, -shift))
        rows = (time >= 0.0) & (time <= float(part.reference.duration))
        parts.append(replace(part, time=time, time_lo=rest + part.time_lo).at(rows))
    return scored(Alignment(report.file, tuple(parts), ()), reference)
