"""The loop of a diagnosis: run each row check once, and correct the rows before the next check.

A fault that a row check finds is reported as a cause and undone. The corrected rows are diagnosed
like any file: by the next row checks, and at last by the search among simulated motions. So a
mistake of the model is also found in a file with, for example, a rate computed by differences.
Faults that are visible only in comparison with the wrong motion are looked for at the end, see
`beside`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.definitions import Understandings
from heyoka_bike.scoring.diagnosis import visible_faults
from heyoka_bike.scoring.diagnosis.answers import answers, is_right, is_whole_cause
from heyoka_bike.scoring.diagnosis.beside import causes_of, consistent_parts, faults_beside
from heyoka_bike.scoring.diagnosis.budget import BudgetSpentError, Deadline
from heyoka_bike.scoring.diagnosis.conclusions import (
    Explained,
    IntegratedBy,
    LinearMotion,
    NoCauseFound,
    NothingToDiagnose,
    NothingWrong,
)
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.numerical import SinglePrecisionBeside
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.residual.residual import Residual
from heyoka_bike.scoring.diagnosis.row_checks import ROW_CHECKS, run_check
from heyoka_bike.scoring.diagnosis.search import (
    EVERYTHING,
    ONLY_EQUATIONS,
    ONLY_OUTPUT,
    Causes,
    Plan,
    again,
    with_output,
)
from heyoka_bike.scoring.diagnosis.wrong_columns import (
    ColumnsApart,
    columns_apart,
    faults_in_other_columns,
)
from heyoka_bike.scoring.evidence.as_compared import (
    ConstantColumns,
    ConstantInMotion,
    NeverFilled,
    Unfilled,
)
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import (
    Conventions,
    DefinitionUnknown,
    OtherZero,
    SignContradiction,
)
from heyoka_bike.scoring.evidence.contradictions import SinglePrecision, TimeShift
from heyoka_bike.scoring.explanation import Curve
from heyoka_bike.scoring.findings import maneuvers
from heyoka_bike.scoring.grades import TOLERANCE, has_right_digits
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.ratios import BY_FAR
from heyoka_bike.scoring.recognition import ZEROED
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.averages import StepAverage
from heyoka_bike.scoring.rows.edits import Columns
from heyoka_bike.scoring.rows.other_columns import OtherColumn
from heyoka_bike.scoring.rows.other_moments import OtherMoment, PartMultiplied
from heyoka_bike.scoring.rows.scaled_columns import ColumnRatio, without_ratio
from heyoka_bike.scoring.rows.table import Undone, worst
from heyoka_bike.scoring.rows.wrong_times import OtherClock
from heyoka_bike.scoring.score import scored_rows

# Causes whose simulated run the report draws.
_SHOWN = Explained | IntegratedBy | LinearMotion


@dataclass(frozen=True, slots=True)
class RightElsewhere(Evidence):
    """Some maneuvers are right; the diagnosis is about the other maneuvers only.

    Attributes
    ----------
    wrong, right : tuple of int
        Numbers of the maneuvers.
    max_rel_error
        Largest error of the right maneuvers, relative to the scale.
    is_rest
        True if other faults of the file are named beside this.
    """

    wrong: tuple[int, ...]
    right: tuple[int, ...]
    max_rel_error: float
    is_rest: bool = False

    only_describes = True
    code = "right_elsewhere"

    def message(self) -> str:
        is_are = "is" if len(self.wrong) == 1 else "are"
        start = "Otherwise only" if self.is_rest else "Only"
        return (
            f"{start} {maneuvers(self.wrong)} {is_are} wrong. In {maneuvers(self.right)} the "
            f"largest error is only {self.max_rel_error:.1g} of a column's largest value. So look "
            f"for input or settings of your program that differ in {maneuvers(self.wrong)}"
        )

    def numbers(self) -> Mapping[str, Any]:
        numbers = {"wrong": list(self.wrong), "right": list(self.right)}
        return {**numbers, "max_rel_error": self.max_rel_error}


@dataclass(frozen=True, eq=False, slots=True)
class Answer:
    """The result of a diagnosis, or of one step of it.

    Attributes
    ----------
    report : Report
        The score that was diagnosed.
    seen : tuple of Evidence
        The evidence to report, in this order.
    cause : Evidence or None
        The cause that explains the file, if its run is drawn.
    curves : tuple of Curve
        The errors that this cause leaves.
    is_whole
        False if the time limit was reached before every cause was tried.
    edit : ColumnRatio or None
        An offset or a ratio of a column that must be undone before the diagnosis continues.
    residual : Residual or None
        Residual of the equations of motion; None if the file does not show its motion.
    """

    report: Report
    seen: tuple[Evidence, ...]
    cause: Evidence | None = None
    curves: tuple[Curve, ...] = ()
    is_whole: bool = True
    edit: ColumnRatio | None = None
    residual: Residual | None = None


@dataclass(eq=False)
class Pursuit:
    """The state of a diagnosis.

    Attributes
    ----------
    root : Report
        The score of the file as it was read.
    reference : Reference
    progress : callable
        Called with the fraction of the work that is done, 0 to 1.
    deadline : Deadline
    view : Report
        The score of the corrected rows: all faults found so far are undone.
    seen : list of Evidence
        Evidence of the faults that were undone, in this order.
    explained : set of str
        Keys of columns with an unknown definition whose error a cause explains.
    simulator : Simulator
        It keeps the motions that were simulated.
    asks_for_edit
        False after an edit was found, see `explain`.
    answer : Answer or None
        The answer at the end of the diagnosis, or the answer so far while further faults of the
        rows are looked for; None before.
    """

    root: Report
    reference: Reference
    progress: Callable[[float], None]
    deadline: Deadline
    view: Report = field(init=False)
    seen: list[Evidence] = field(default_factory=list)
    explained: set[str] = field(default_factory=set)
    simulator: Simulator = field(default_factory=Simulator)
    asks_for_edit: bool = True
    answer: Answer | None = None

    def __post_init__(self) -> None:
        self.view = self.root

    def undo(self, undone: Undone) -> None:
        """Continue with the rows in which a fault was undone.

        The diagnosis ends if these rows are right, or their error is far smaller than before. It
        also ends if a known mistake of the output explains all of it. That mistake is then reported
        instead of a ratio, of an average, of a clock, or of columns that are exchanged in all
        maneuvers.
        """
        # A maneuver whose columns were all left out cannot be compared.
        parts = tuple(part for part in undone.parts if part.has_values())
        if not parts:
            self.seen += undone.seen
            self.answer = Answer(self.view, ())
            return
        rest = self.scored(parts)
        before, left = worst(self.view), worst(rest)
        is_end = left.max_rel_error < min(TOLERANCE, before.max_rel_error / BY_FAR)
        if any(self._may_be_known(x, is_end=is_end) for x in undone.seen):
            known = self.of_columns(BENCHMARK_COLUMNS, ONLY_OUTPUT)
            if any(_is_mistake(x) and _explains_all(x) for x in known.seen[:1]):
                self.answer = known
                return
        self.seen += undone.seen
        self.view = rest
        if is_end:
            is_all = is_right(rest) or left.max_rel_error < ROUNDING
            self.answer = Answer(rest, () if is_all else (left,))

    def _may_be_known(self, x: Evidence, *, is_end: bool) -> bool:
        """True if a known mistake of the output may explain a fault of the rows.

        A clock of one maneuver that leaves no error elsewhere is no mistake of the whole program.
        """
        is_everywhere = isinstance(x, OtherColumn) and len(x.maneuvers) == len(self.view.maneuvers)
        is_of_all = isinstance(x, OtherClock) and (x.maneuver is None or not is_end)
        # No known mistake of the output takes a part of a sum from another row.
        is_moved = isinstance(x, OtherMoment) and x.part is None
        is_changed = isinstance(x, ColumnRatio | PartMultiplied | StepAverage)
        return is_changed or is_moved or is_everywhere or is_of_all

    def scored(self, parts: Sequence[Part]) -> Report:
        """Compare rows of the file with the exact motion."""
        return scored_rows(self.root, parts, self.reference)

    def of_motion(self, plan: Plan = EVERYTHING) -> Answer:
        """Find the cause of the remaining errors by simulating the motions of programs."""
        report = self.view
        unknown = {c.key for m in report.maneuvers for c in m.columns if not c.is_known}
        # If the definition of a column is unknown, its error is no evidence about the program.
        keys = [key for key in BENCHMARK_COLUMNS if key not in unknown]
        found = self.of_columns(keys, plan)
        if found.edit is not None:
            return found
        if unknown and found.cause is None:
            # A mistake in the output may explain the columns with unknown definitions, so try these
            # mistakes, too.
            other = self.of_columns(BENCHMARK_COLUMNS, ONLY_OUTPUT)
            if any(_is_mistake(x) for x in other.seen[:1]):
                self.explained |= unknown
                return other
            if any(isinstance(x, ColumnsApart) or is_whole_cause(x, report) for x in other.seen):
                return other
            found = replace(found, is_whole=found.is_whole and other.is_whole)
        if any(isinstance(x, NothingToDiagnose) for x in found.seen):
            return found
        more = faults_in_other_columns(report, unknown)
        if any(isinstance(x, NothingWrong) for x in found.seen):
            # Report the columns that are wrong before those that are right.
            return replace(found, seen=(*more, _right(report, keys)))
        return replace(found, seen=(*found.seen, *more))

    def of_rows(self, parts: Sequence[Part], plan: Plan) -> Answer:
        """Find the cause of the errors of other rows, see `of_motion`; `view` does not change."""
        before, self.view = self.view, self.scored(parts)
        try:
            return self.of_motion(plan)
        finally:
            self.view = before

    def of_columns(self, keys: Sequence[str], plan: Plan = EVERYTHING) -> Answer:
        """Find the cause of errors in some columns by the steps of a plan."""
        report = self.view
        maneuvers = tuple(
            replace(m, columns=tuple(c for c in m.columns if c.key in keys), part=m.part.only(keys))
            for m in report.maneuvers
        )
        parts = [m.part for m in maneuvers]
        if not any(part.has_values() for part in parts):
            return Answer(report, (NothingToDiagnose(),))
        asked = replace(report, maneuvers=maneuvers)
        if is_right(asked):
            return Answer(report, (NothingWrong(are_all=not report.not_compared),))
        visible = visible_faults.shown(asked)
        if visible_faults.are_departures(visible, asked):
            # A mistake of the model or of the initial conditions would be visible from the start of
            # the run, so do not search for one.
            return Answer(report, visible)
        asked, elsewhere = _without_right_maneuvers(asked)
        parts = [m.part for m in asked.maneuvers]
        # If some columns show that the motion is right, the other columns are written wrongly.
        if columns_apart(asked) is not None:
            plan = ONLY_OUTPUT
        found = explain(
            parts, self.reference, simulator=self.simulator, plan=plan,
            asks_for_edit=self.asks_for_edit, progress=self.progress, deadline=self.deadline,
        )  # fmt: skip
        if found.edit is not None:
            return Answer(report, (), edit=found.edit)
        seen = answers(found, asked, visible)
        # If the search was stopped early, it may have found no cause.
        first = next(iter(seen), None)
        cause = first if found.curves and isinstance(first, _SHOWN) else None
        if elsewhere is not None and not _is_of_starts(first):
            seen = (*seen, elsewhere)
        return Answer(report, seen, cause, found.curves, found.is_whole, residual=found.causes)

    def whole_answer(self, end: Answer) -> Answer:
        """Combine the last answer with the evidence of the faults that were undone before it."""
        is_late = any(isinstance(x, TimeShift) for x in self.seen)
        is_rest = bool(self.seen) or any(isinstance(x, ConstantColumns) for x in self.root.seen)
        more = tuple(
            replace(x, is_rest=is_rest) if isinstance(x, ColumnsApart | RightElsewhere) else x
            for x in end.seen
            if not (self.seen and isinstance(x, NothingWrong) and x.signs is None)
            and not (is_late and isinstance(x, NoCauseFound))
        )  # fmt: skip
        # If the last answer compares the error with the rounding of single precision, do not report
        # single precision a second time.
        is_compared = any(isinstance(x, SinglePrecision | SinglePrecisionBeside) for x in more)
        undone = (x for x in self.seen if not (is_compared and isinstance(x, SinglePrecision)))
        explained = self.explained | {getattr(x, "key", "") for x in self.seen}
        # Do not ask for the definition of a column whose error is explained.
        kept = (
            x
            for x in self.root.seen
            if not (isinstance(x, DefinitionUnknown) and x.key in explained)
            and not self._is_undone(x)
        )
        seen = tuple(x for one in kept for x in _with_cause(one, end.cause))
        return replace(end, report=replace(self.root, seen=seen), seen=(*undone, *more))

    def _is_undone(self, seen: Evidence) -> bool:
        """True for signs that do not contradict each other in the corrected rows."""
        return (
            isinstance(seen, SignContradiction)
            and seen not in self.view.seen
            and self.view.by_column().keys() >= {*seen.keys}
        )


def pursue(
    report: Report, reference: Reference, progress: Callable[[float], None], deadline: Deadline
) -> Answer:
    """Find the causes of a report's errors: run each row check once, and undo the faults found.

    If the diagnosis is interrupted, the answer contains the evidence found so far.
    """
    pursuit = Pursuit(report, reference, progress, deadline)
    try:
        end = _end_of(pursuit)
    except BudgetSpentError:
        end = replace(pursuit.answer or Answer(pursuit.view, ()), is_whole=False)
    return pursuit.whole_answer(end)


def _end_of(pursuit: Pursuit) -> Answer:
    """Run all row checks, and then search for a cause by simulating programs."""
    for check in ROW_CHECKS:
        if (undone := run_check(check, pursuit.view)) is not None:
            pursuit.undo(undone)
        if pursuit.answer is not None:
            return pursuit.answer
    end = pursuit.of_motion()
    if end.edit is not None:
        pursuit.undo(without_ratio(pursuit.view, end.edit))
        pursuit.asks_for_edit = False
        end = pursuit.answer or pursuit.of_motion()
    # If the time limit is reached from here on, this answer remains.
    pursuit.answer = end
    has_cause = bool(causes_of(end.seen))
    if has_cause:
        causes = causes_of(end.seen, is_incomplete=True)
    else:
        causes = _by_consistent_rows(pursuit, end)
    faults: tuple[Evidence, ...] = ()
    beside = faults_beside(causes, pursuit.view, pursuit.reference, pursuit.simulator)
    if beside is not None:
        faults, judged = beside.seen, pursuit.of_rows(beside.parts, again(causes))
    elif causes and not has_cause:
        judged = pursuit.of_motion(with_output(causes[0]))
    else:
        return end
    if not any(isinstance(x, Explained) for x in judged.seen):
        # The causes do not explain the corrected rows either, so discard the corrections.
        return end
    pursuit.seen += faults
    return judged


def _by_consistent_rows(pursuit: Pursuit, end: Answer) -> list[Causes]:
    """Find causes from the rows that do not contradict each other, see `consistent_parts`.

    The error of an integrator, if one was run, also explains such contradictions.
    """
    if any(isinstance(x, IntegratedBy) for x in end.seen):
        return []
    seen = end.residual
    motions = () if seen is None else seen.motions
    # A mismatch of rates and angles that is far smaller than the residual does not cause it.
    if seen is not None and seen.mismatch * BY_FAR < max(seen.shares.values()):
        motions = ()
    for parts in consistent_parts(pursuit.view, motions):
        if causes := causes_of(pursuit.of_rows(parts, ONLY_EQUATIONS).seen):
            return causes
    return []


def _is_mistake(seen: Evidence) -> bool:
    """True for a mistake of the library; False for fitted values and other evidence."""
    return isinstance(seen, Explained) and not seen.hypotheses[0].found


def _explains_all(seen: Evidence) -> bool:
    """True for a cause that leaves only what digits or an integrator explain."""
    return isinstance(seen, Explained) and seen.rest is None


def _right(report: Report, keys: Sequence[str]) -> NothingWrong:
    """Return the evidence that columns are right; it names them if the file has others."""
    every = report.by_column()
    told = tuple(key for key in every if key in keys)
    signs = next((x for x in report.seen if isinstance(x, SignContradiction)), None)
    named = () if len(told) == len(every) else told
    return NothingWrong(named, signs, not report.not_compared)


def _without_right_maneuvers(report: Report) -> tuple[Report, RightElsewhere | None]:
    """Return the report without its right maneuvers if others are far worse, and the evidence.

    A wrong model would be wrong in all maneuvers.
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


def _with_cause(seen: Evidence, cause: Evidence | None) -> Iterator[Evidence]:
    """Yield what remains of evidence about the whole file if a cause explains the file."""
    first = cause.hypotheses[0] if isinstance(cause, Explained) else None
    if first is None or not isinstance(seen, Conventions | OtherZero | NeverFilled):
        yield seen
    elif isinstance(seen, NeverFilled):
        yield from _unfilled_with(seen, first)
    else:
        yield from _conventions_with(seen, first.understood)


def _conventions_with(
    seen: Conventions | OtherZero, understood: Understandings
) -> Iterator[Evidence]:
    """Drop the conventions that a file does not have if a cause explains it.

    The missing energy of a body, for example, is no other zero, and a speed that fits another
    definition because the motion is wrong has the default one.
    """
    zeroed = {key for key, u in understood.items() if not u.offset}
    default = {key for key, u in understood.items() if u.column.default}
    if isinstance(seen, OtherZero):
        if seen.key not in zeroed:
            yield seen
        return
    offsets = {k: x for k, x in seen.offsets.items() if k not in zeroed}
    definitions = tuple(d for d in seen.definitions if d.key not in default)
    rest = replace(seen, offsets=offsets, definitions=definitions)
    if any((rest.turned, rest.units, rest.offsets, rest.definitions)):
        yield rest


def _unfilled_with(seen: NeverFilled, cause: Hypothesis) -> Iterator[ConstantColumns]:
    """Separate the columns that are constant in the motion of a cause from those never filled in.

    Without gravity, for example, the potential energy is zero.
    """
    expected = dict(zip(dict.fromkeys(n for n, _ in cause.after), cause.expected, strict=True))
    constant = tuple(x for x in seen.columns if _is_constant(x, expected.get(x.maneuver, {})))
    rest = tuple(x for x in seen.columns if x not in constant)
    if rest:
        yield replace(seen, columns=rest)
    if constant:
        yield ConstantInMotion(constant, seen.maneuvers)


def _is_constant(x: Unfilled, expected: Columns) -> bool:
    """True if a motion has the number of an unfilled column in every row, in some definition."""
    each = (expected[c.name] for c in DEFINITIONS[x.key] if c.name in expected)
    constant = [v for v in each if np.ptp(v) <= ROUNDING * np.max(np.abs(v))]
    if x.key in ZEROED:
        return bool(constant)
    return any(abs(x.number - v[0]) <= TOLERANCE * abs(v[0]) for v in constant)


def _is_of_starts(seen: Evidence | None) -> bool:
    """True if only initial conditions were found: each belongs to one maneuver."""
    found = seen.hypotheses[0].found if isinstance(seen, Explained) else ()
    return bool(found) and all(x.maneuver is not None for x in found)
