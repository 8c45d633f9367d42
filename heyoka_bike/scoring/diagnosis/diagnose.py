"""Why results differ from the reference: a score, with what explains it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.double import multiply, two_sum, with_usual_errors
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.alignment import Alignment
from heyoka_bike.scoring.diagnosis import plain
from heyoka_bike.scoring.diagnosis.answers import answers, is_right, is_whole_cause
from heyoka_bike.scoring.diagnosis.as_meant import AsMeant, Look, as_meant, worst
from heyoka_bike.scoring.diagnosis.budget import (
    SECONDS,
    USUAL,
    Budget,
    BudgetSpentError,
    Deadline,
    Watch,
)
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.found import (
    Explained,
    IntegratedBy,
    LinearMotion,
    NoCauseFound,
    NothingToDiagnose,
    NothingWrong,
)
from heyoka_bike.scoring.diagnosis.written import STEPS
from heyoka_bike.scoring.evidence.as_compared import RowsOutside, TimesInLargerUnit
from heyoka_bike.scoring.evidence.as_read import TimesRepeated
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import DefinitionUnknown, SignContradiction
from heyoka_bike.scoring.evidence.contradictions import StoppedEarly, TimeShift
from heyoka_bike.scoring.evidence.error_shape import RightElsewhere
from heyoka_bike.scoring.evidence.output_faults import ColumnRatio, ColumnsApart, OtherColumn
from heyoka_bike.scoring.explanation import Curve, Explanation
from heyoka_bike.scoring.grades import TOLERANCE, has_right_digits
from heyoka_bike.scoring.ratios import BY_FAR
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.score import score, scored
from heyoka_bike.system import jobs
from heyoka_bike.system.threads import one_thread_of_linear_algebra

# The first row is given, and one more shows no motion.
_FEWEST_ROWS = 3
# Whose runs have a figure.
_SHOWN = Explained | IntegratedBy | LinearMotion


@dataclass(frozen=True, eq=False, slots=True)
class Answer:
    """What a diagnosis found.

    Attributes
    ----------
    report : Report
        The score that it is about.
    seen : tuple of Evidence
        What is said, in this order.
    cause : Evidence or None
        What explains the file, for its figure.
    curves : tuple of Curve
        What that leaves.
    is_whole
        False if the time was spent before every cause was tried.
    """

    report: Report
    seen: tuple[Evidence, ...]
    cause: Evidence | None = None
    curves: tuple[Curve, ...] = ()
    is_whole: bool = True


@with_usual_errors
def diagnose(
    results: Any = None,
    reference: Reference | str | PathLike[str] | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    maneuver: int | None = None,
    columns: str | Sequence[str] | None = None,
    budget: float = SECONDS,
    thorough: bool = False,
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
    thorough
        True to try two mistakes at once, and other starts, also where the equations of motion leave
        a force of which no cause explains anything.
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
    given = Budget(budget, is_thorough=thorough)
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
    from heyoka_bike.showing import causes

    deadline = budget.begun()
    watch = Watch(deadline)
    distinct = _at_distinct_times(report, reference)
    try:
        with one_thread_of_linear_algebra(), watch:
            found = _answer(distinct, reference, progress or (lambda _: None), deadline)
    except BudgetSpentError:
        watch.end()
        found = Answer(distinct, (), is_whole=False)
    stopped = () if found.is_whole else (StoppedEarly(budget.seconds),)
    said = (*filter(_is_of_times, report.seen), *found.seen)
    if distinct is not report:
        # The other rows are right: no more is wrong than their times.
        said = tuple(x for x in said if not (isinstance(x, NothingWrong) and x.signs is None))
    odd = next((x for x in report.seen if isinstance(x, SignContradiction)), None)
    if odd is not None and not any(isinstance(x, NothingWrong) and x.signs for x in said):
        said = (odd, *said)
    explanation = None
    if found.cause is not None and found.curves:
        explanation = Explanation(causes.finding(found.cause).message, found.curves)
    return replace(
        report,
        seen=(*found.report.seen, *stopped),
        diagnosis=tuple(map(causes.finding, (*said, *stopped))),
        explanation=explanation,
    )


def _at_distinct_times(report: Report, reference: Reference) -> Report:
    """The report without rows at the time of the row before them, between which nothing moves.

    Its evidence stays that of the whole file.
    """
    parts = tuple(m.part.at_distinct_times() for m in report.maneuvers)
    if all(p is m.part for p, m in zip(parts, report.maneuvers, strict=True)):
        return report
    return replace(scored(Alignment(report.file, parts, ()), reference), seen=report.seen)


def _is_of_times(seen: Evidence) -> bool:
    """True for evidence that the times are written wrongly, which comes before any cause."""
    match seen:
        case TimesRepeated():
            return not seen.are_identical
        case RowsOutside():
            return seen.may_be_in is not None
    return isinstance(seen, TimesInLargerUnit)


def _answer(
    report: Report,
    reference: Reference,
    progress: Callable[[float], None],
    deadline: Deadline,
    steps: Sequence[Look] = STEPS,
) -> Answer:
    """What explains a report. What is written is looked at by these steps first.

    Where it is interrupted its answer is empty, and what its caller saw stays.
    """
    try:
        return _whole_answer(report, reference, progress, deadline, steps)
    except BudgetSpentError:
        return Answer(report, (), is_whole=False)


def _whole_answer(
    report: Report,
    reference: Reference,
    progress: Callable[[float], None],
    deadline: Deadline,
    steps: Sequence[Look],
) -> Answer:
    if any(map(_is_of_times, report.seen)) and max(m.rows for m in report.maneuvers) < _FEWEST_ROWS:
        # Too few to say more than that of a run whose times are wrong.
        return Answer(report, ())
    late = next((x for x in report.seen if isinstance(x, TimeShift)), None)
    larger = next((x for x in report.seen if isinstance(x, TimesInLargerUnit)), None)
    if larger is not None:
        scaled = _at_other_times(report, reference, larger.seconds, 0.0)
        return replace(_answer(scaled, reference, progress, deadline), report=report)
    if late is not None:
        shifted = _at_other_times(report, reference, 1.0, late.shift)
        inner = _answer(shifted, reference, progress, deadline)
        rest = (x for x in inner.seen if not isinstance(x, NoCauseFound))
        return replace(inner, report=report, seen=(late, *rest))
    meant = as_meant(report, steps)
    if meant is not None:
        return _beside(report, meant, reference, progress, deadline)
    unknown = {c.key for m in report.maneuvers for c in m.columns if not c.is_known}
    # A column of unknown meaning shows its meaning, not what the program does.
    keys = [key for key in BENCHMARK_COLUMNS if key not in unknown]
    found = _of_columns(report, reference, keys, progress, deadline)
    if unknown and found.cause is None:
        # It may be another column, or be computed wrongly.
        other = _of_columns(
            report, reference, BENCHMARK_COLUMNS, progress, deadline, only_output=True
        )
        if any(_is_mistake(x) for x in other.seen[:1]):
            others = tuple(x for x in report.seen if not isinstance(x, DefinitionUnknown))
            return replace(other, report=replace(report, seen=others))
        if any(isinstance(x, ColumnsApart) or is_whole_cause(x) for x in other.seen):
            return other
        found = replace(found, is_whole=found.is_whole and other.is_whole)
    if any(isinstance(x, NothingToDiagnose) for x in found.seen):
        return found
    more = plain.beside(report, unknown)
    if any(isinstance(x, NothingWrong) for x in found.seen):
        # What is wrong comes first.
        return replace(found, seen=(*more, _right(report, keys)))
    return replace(found, seen=(*found.seen, *more))


def _is_mistake(seen: Evidence) -> bool:
    """True of a mistake of the library, and not of values that were found."""
    return isinstance(seen, Explained) and not seen.hypotheses[0].found


def _leaves_nothing(seen: Evidence) -> bool:
    return isinstance(seen, Explained) and seen.hypotheses[0].leaves_nothing


def _beside(
    report: Report,
    meant: AsMeant,
    reference: Reference,
    progress: Callable[[float], None],
    deadline: Deadline,
) -> Answer:
    """What is seen in the rows of a report, and the diagnosis of the rows as they were meant.

    What is left of these is no cause of its own where it is right, or far less than before. A
    known mistake of what is written that leaves nothing takes the place of a ratio, or of a column
    that is in the place of another in all maneuvers.
    """
    there = meant.alignment(report)
    if not there.parts:
        return Answer(report, meant.seen)
    rest = scored(there, reference)
    before, left = worst(report), worst(rest)
    if any(
        isinstance(x, ColumnRatio)
        or (isinstance(x, OtherColumn) and len(x.maneuvers) == len(report.maneuvers))
        for x in meant.seen
    ):
        known = _of_columns(
            report, reference, BENCHMARK_COLUMNS, progress, deadline, only_output=True
        )
        if any(_is_mistake(x) and _leaves_nothing(x) for x in known.seen[:1]):
            return known
    if left.max_rel_error < min(TOLERANCE, before.max_rel_error / BY_FAR):
        return Answer(report, (*meant.seen, *(() if is_right(rest) else (left,))))
    inner = _answer(rest, reference, progress, deadline, meant.steps)
    more = (x for x in inner.seen if not (isinstance(x, NothingWrong) and x.signs is None))
    return replace(inner, report=report, seen=(*meant.seen, *more))


def _right(report: Report, keys: Sequence[str]) -> NothingWrong:
    """All columns that are diagnosed are right, each by itself; named where there are others."""
    every = dict.fromkeys(c.key for m in report.maneuvers for c in m.columns if c.values)
    told = tuple(key for key in every if key in keys)
    signs = next((x for x in report.seen if isinstance(x, SignContradiction)), None)
    return NothingWrong(() if len(told) == len(every) else told, signs)


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
) -> Answer:
    """What explains these columns; with `only_output` of mistakes of what is written."""
    maneuvers = tuple(
        replace(m, columns=tuple(c for c in m.columns if c.key in keys), part=m.part.only(keys))
        for m in report.maneuvers
    )
    parts = [m.part for m in maneuvers]
    if not any(part.has_values() for part in parts):
        return Answer(report, (NothingToDiagnose(),))
    asked = replace(report, maneuvers=maneuvers)
    if is_right(asked):
        return Answer(report, (NothingWrong(),))
    at_once = plain.shown(asked)
    if plain.are_departures(at_once, asked):
        # What is wrong in the model or at the start is wrong from the start.
        return Answer(report, at_once)
    asked, elsewhere = _wrong_alone(asked)
    parts = [m.part for m in asked.maneuvers]
    # Beside columns that show the right motion, what is wrong is how others are written.
    only_output = only_output or plain.columns_apart(asked) is not None
    found = explain(parts, reference, only_output=only_output, progress=progress, deadline=deadline)
    seen = answers(found, asked, at_once)
    # Nothing is said of a search that was stopped before it found anything.
    first = next(iter(seen), None)
    cause = first if found.curves and isinstance(first, _SHOWN) else None
    if elsewhere is not None and not _is_of_starts(first):
        seen = (*seen, elsewhere)
    return Answer(report, seen, cause, found.curves, found.is_whole)


def _wrong_alone(report: Report) -> tuple[Report, RightElsewhere | None]:
    """The report without the maneuvers that are right, beside others that are far from it.

    A model that is wrong is so in all of them.
    """
    errors = {m.maneuver: worst(replace(report, maneuvers=(m,))) for m in report.maneuvers}
    largest = max(x.max_rel_error for x in errors.values())
    right = {
        n: x.max_rel_error for n, x in errors.items()
        if has_right_digits(x.max_rel_error)
        and x.max_rel_error * BY_FAR**2 < largest
    }  # fmt: skip
    if not right:
        return report, None
    kept = tuple(m for m in report.maneuvers if m.maneuver not in right)
    numbers = tuple(m.maneuver for m in kept)
    seen = RightElsewhere(numbers, tuple(right), max(right.values()))
    return replace(report, maneuvers=kept), seen


def _is_of_starts(seen: Evidence | None) -> bool:
    """True if all that was found are starts, which are of one maneuver each."""
    found = seen.hypotheses[0].found if isinstance(seen, Explained) else ()
    return bool(found) and all(x.maneuver is not None for x in found)


def _at_other_times(report: Report, reference: Reference, scale: float, shift: float) -> Report:
    """The report with times multiplied by a scale, less a shift, of the rows then within the run.

    It is the report itself if that leaves no row of a maneuver.
    """
    parts = []
    for part in (m.part for m in report.maneuvers):
        factor = np.full_like(part.time, scale), np.zeros_like(part.time)
        hi, lo = multiply((part.time, part.time_lo), factor)
        time, rest = two_sum(hi, np.full_like(hi, -shift))
        parts.append(replace(part, time=time, time_lo=rest + lo).within_run())
    if not all(part.has_values() for part in parts):
        return replace(report, seen=())
    return scored(Alignment(report.file, tuple(parts), ()), reference)
