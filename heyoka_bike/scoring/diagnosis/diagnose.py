"""Score results and find out why they differ from the reference."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

from heyoka_bike.numbers.double import with_usual_errors
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.diagnosis.answers import mostly_zeros
from heyoka_bike.scoring.diagnosis.budget import (
    DEFAULT_BUDGET,
    USUAL,
    Budget,
    BudgetSpentError,
    Deadline,
    Watch,
)
from heyoka_bike.scoring.diagnosis.conclusions import NothingWrong
from heyoka_bike.scoring.diagnosis.explain import FEWEST_ROWS
from heyoka_bike.scoring.diagnosis.pursue import Answer, pursue
from heyoka_bike.scoring.evidence.as_compared import RowsOutside, TimesInLargerUnit
from heyoka_bike.scoring.evidence.as_read import TimesRepeated
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import SignContradiction
from heyoka_bike.scoring.evidence.contradictions import StoppedEarly
from heyoka_bike.scoring.explanation import Explanation
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.score import score, scored_rows
from heyoka_bike.system import jobs
from heyoka_bike.system.threads import one_thread_of_linear_algebra


@with_usual_errors
def diagnose(
    results: Any = None,
    reference: Reference | str | PathLike[str] | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    maneuver: int | None = None,
    columns: str | Sequence[str] | None = None,
    budget: float = DEFAULT_BUDGET,
    thorough: bool = False,
    **named: Any,
) -> Report:
    """Compare results with the reference, and find out why they differ.

    Parameters
    ----------
    results, reference
        As in `score`.
    progress
        Called with the fraction of the work that is done, 0 to 1.
    maneuver, columns
        As in `score`.
    budget
        Limit of the processor time for finding causes, in all threads of this process [s]. At the
        limit the report contains the causes found so far, and `is_stopped_early` is True.
    thorough
        True to try pairs of mistakes and other initial conditions even if the file shows a force
        that no single mistake explains.
    named
        As in `score`.

    Returns
    -------
    Report
        As from `score`, with a `diagnosis`: the mistakes or the parameters whose simulation
        explains the results, or a description of the error. Mistakes are simulated only for the
        columns of the benchmark. In other columns a factor, an offset, or the same number in every
        row is recognised. If the columns of the benchmark are missing, the diagnosis reports this.

    Raises
    ------
    InputError
        As in `score`; also if the reference does not start upright and straight, or the budget is
        not greater than zero.
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
    """Add the diagnosis to a report that was made with this reference."""
    deadline = budget.begun()
    watch = Watch(deadline)
    distinct = _at_distinct_times(report, reference)
    try:
        with one_thread_of_linear_algebra(), watch:
            found = _pursued(distinct, reference, progress or (lambda _: None), deadline)
    except BudgetSpentError:
        watch.end()
        found = Answer(distinct, (), is_whole=False)
    said = (*filter(_is_of_times, report.seen), *found.seen)
    has_cause = not all(x.only_describes for x in said)
    stopped = () if found.is_whole else (StoppedEarly(budget.seconds, has_cause),)
    if any(isinstance(x, TimesRepeated) and not x.are_identical for x in report.seen):
        # Do not report that nothing is wrong if rows with different values at the same time were
        # left out.
        said = tuple(x for x in said if not (isinstance(x, NothingWrong) and x.signs is None))
    told = [x.signs for x in said if isinstance(x, NothingWrong)]
    odd = [x for x in found.report.seen if isinstance(x, SignContradiction)]
    said = (*(x for x in odd if x not in told), *said)
    explanation = None
    if found.cause is not None and found.curves:
        explanation = Explanation(found.cause.message(), found.curves)
    return replace(
        report,
        seen=(*found.report.seen, *stopped),
        diagnosis=tuple(x.finding() for x in (*said, *stopped)),
        explanation=explanation,
    )


def _pursued(
    report: Report,
    reference: Reference,
    progress: Callable[[float], None],
    deadline: Deadline,
) -> Answer:
    """Find the causes of a report's errors; none if times are wrong and the rows are too few."""
    if any(map(_is_of_times, report.seen)) and max(m.rows for m in report.maneuvers) < FEWEST_ROWS:
        return Answer(report, ())
    if zeros := mostly_zeros(report):
        return Answer(report, zeros)
    return pursue(report, reference, progress, deadline)


def _at_distinct_times(report: Report, reference: Reference) -> Report:
    """Return the report without rows that repeat the time of the row before.

    It keeps the evidence of the whole file.
    """
    parts = tuple(m.part.at_distinct_times() for m in report.maneuvers)
    if all(p is m.part for p, m in zip(parts, report.maneuvers, strict=True)):
        return report
    return replace(scored_rows(report, parts, reference), seen=report.seen)


def _is_of_times(seen: Evidence) -> bool:
    """True for evidence of wrong times, which is reported before any cause."""
    match seen:
        case TimesRepeated():
            return not seen.are_identical
        case RowsOutside():
            return seen.may_be_in is not None
    return isinstance(seen, TimesInLargerUnit)


def diagnosed_elsewhere(
    report: Report, reference: Reference, budget: Budget, told: jobs.OnStage
) -> Report:
    """Run `diagnosed` as a job with one stage, ``diagnose``."""
    return diagnosed(report, reference, lambda share: told("diagnose", share), budget)
