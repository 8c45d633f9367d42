"""The search for a cause, as a list of steps: each step answers one question by trying causes.

The likeliest causes come first. A cause that explains nearly all of the file's error ends the
search for single causes. Then pairs are tried, and at last other initial conditions. At the time
limit (`budget`) the causes that were judged so far are the result.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis import step_log
from heyoka_bike.scoring.diagnosis.claims import LINEAR, ends_search, explains_mostly
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.integrated import with_steps_of_rows
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import KINDS, MISTAKES, Mistake, in_order
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS, LINEARISED_CODE
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.forces import FORWARD
from heyoka_bike.scoring.diagnosis.programs.program import (
    Cause,
    FittedValues,
    OtherScale,
    apply,
    differences,
    fitted_scale,
)
from heyoka_bike.scoring.diagnosis.ranking import ranked, singles_by_code
from heyoka_bike.scoring.diagnosis.residual.fits import COUNTS
from heyoka_bike.scoring.diagnosis.residual.methods import CLOCK
from heyoka_bike.scoring.diagnosis.residual.residual import (
    EQUATIONS,
    UNKNOWNS,
    Residual,
    Visibility,
    shows_equations,
)
from heyoka_bike.scoring.diagnosis.seen_file import FileUnderTest
from heyoka_bike.scoring.grades import TOLERANCE, has_right_digits
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY

OF_MODEL = (
    *(m for m in MISTAKES if m.kind == "model" and m.code not in LINEAR),
    *EQUATION_MISTAKES,
)
"""Mistakes of the library that change the equations of motion."""

Causes = tuple[Cause, ...]


@dataclass(frozen=True, slots=True)
class Trial(step_log.Step):
    """A step that tries causes.

    Attributes
    ----------
    is_asked : callable
        Returns True if the step is worth its time, given the causes found so far.
    tried : callable
        Tries the causes; yields each as soon as it is judged.
    is_of_start
        True if the causes are initial conditions, which are ranked after the others.
    """

    is_asked: Callable[[Search], bool]
    tried: Callable[[Search], Iterable[Hypothesis]]
    is_of_start: bool = False


@dataclass(eq=False)
class Search:
    """The state of a search: the file, and the causes that were judged.

    Attributes
    ----------
    file : FileUnderTest
    found : list of Hypothesis
        Single causes and pairs of them, in the order in which they were tried.
    starts : list of Hypothesis
        Other initial conditions. They leave no residual in the equations, and are ranked after the
        others.
    is_thorough
        True to continue even if the file shows a force that no single cause explains.
    """

    file: FileUnderTest
    found: list[Hypothesis] = field(default_factory=list)
    starts: list[Hypothesis] = field(default_factory=list)
    is_thorough: bool = False

    @property
    def residual(self) -> Residual | None:
        """Residual of the equations along the file's motion; None if the file does not show it."""
        return self.file.residual

    @cached_property
    def by_equations(self) -> tuple[list[Causes], list[Causes]]:
        """Mistakes that the residual suggests, and mistakes that it does not exclude."""
        return ([], []) if self.residual is None else _of_equations(self.residual)

    @property
    def is_over(self) -> bool:
        """True if one of the causes found is good enough to end the search for single causes."""
        return any(ends_search(h, self.residual) for h in (*self.found, *self.starts))

    @property
    def best(self) -> Hypothesis | None:
        """The likeliest cause so far; None if no cause is likely."""
        likely = [h for h in (*self.found, *self.starts) if h.is_possible and h.log_odds > 0.0]
        return max(likely, key=lambda h: h.log_odds, default=None)

    @property
    def stops_at_unknown_force(self) -> bool:
        """True if the file shows a force that no cause explains, and the search is not thorough."""
        seen = self.residual
        is_left = seen is not None and shows_equations(seen) and seen.is_open
        return is_left and self.best is None and not self.is_thorough

    @property
    def ends_early(self) -> bool:
        """True if the search skips the long steps.

        It does so at an unknown force, or if the file is right to six digits, compared with the
        exact motion or with that of a cause: another mistake of the model hardly makes so small an
        error. The short steps remain: the equations, integrators and the output.
        """

        def is_near(h: Hypothesis) -> bool:
            return has_right_digits(max(h.after.values(), default=1.0))

        is_right = is_near(self.file.right) or any(
            is_near(h) and ends_search(h, self.residual) for h in self.found
        )
        return (is_right and not self.is_thorough) or self.stops_at_unknown_force

    def carry_out(self, steps: Sequence[Trial], progress: Callable[[float], None]) -> None:
        """Carry out the steps that are worth their time.

        Raises
        ------
        BudgetSpentError
            The time limit is reached; `found` and `starts` contain the causes judged so far.
        """
        for i, step in enumerate(steps):
            if step.is_asked(self):
                kept = self.starts if step.is_of_start else self.found
                with step_log.logged(step) as log:
                    log.found = partial(self._in_words, self.file.tried)
                    kept.extend(step.tried(self))
            progress((i + 1) / len(steps))

    def _in_words(self, before: int) -> str:
        """Describe how many causes a step tried, and the likeliest cause so far."""
        return f"{self.file.tried - before} tried; {step_log.in_words(self.best)}"


def _is_open(search: Search) -> bool:
    """True if no cause found so far ends the search for single causes."""
    return not search.is_over


def _goes_on(search: Search) -> bool:
    """True if the search for single causes goes on, and whole runs are worth their time."""
    return _is_open(search) and not search.ends_early


def _may_be_an_integrator(search: Search) -> bool:
    """True if the error is small, no cause explains most of it, and the rows show no force."""
    seen, file = search.residual, search.file
    is_small = max(file.right.after.values(), default=1.0) < MEANINGLESS_ERROR
    has_force = seen is not None and (seen.is_open or seen.visibility is Visibility.NOTHING)
    return is_small and not has_force and not any(explains_mostly(h, seen) for h in search.found)


def _are_linear(search: Search) -> Iterable[Hypothesis]:
    return search.file.judged((m,) for m in LINEAR_PROGRAMS)


def _by_equations(search: Search) -> Iterator[Hypothesis]:
    """Judge the mistakes and fitted values that reduce the residual of the equations."""
    assert search.residual is not None
    found = []
    for h in search.file.judged(search.by_equations[0]):
        found.append(h)
        yield h
    yield from _values(search.file, search.residual)
    best = max(found, key=lambda h: h.log_odds, default=None)
    if best is not None and ends_search(best, search.residual) and not best.is_exhaustive:
        yield from _beside_known(search.file, search.residual, best)
    if not any(h.is_exhaustive for h in search.found):
        yield from _from_other_starts(search)


def _from_other_starts(search: Search) -> Iterable[Hypothesis]:
    """Judge the cause that satisfies the equations, from the initial conditions of the file.

    If only the initial conditions are wrong beside it, whole runs seem to exclude it. Opposite
    initial rates are left to the row check for mirrored maneuvers.
    """
    seen = search.residual
    best = seen.best if seen is not None else None
    if seen is None or best is None or best.mistakes[0].kind != "model":
        return ()
    starts = [m for m in seen.other_starts(best.mistakes) if not _is_mirrored(m)]
    return search.file.judged([(*best.mistakes, *starts)]) if starts else ()


def _is_mirrored(start: FittedValues) -> bool:
    """True if initial values are the given ones with the opposite sign."""
    return all(abs(x.value + x.right) <= TOLERANCE * abs(x.right) for x in start.found)


def _beside_known(
    file: FileUnderTest, residual: Residual, best: Hypothesis
) -> Iterator[Hypothesis]:
    """Judge parameters that reduce the residual as much as a known mistake that leaves an error.

    Whole runs show which of them is the cause. For example, an axial inertia as small as the
    diametral one has nearly the effect of a missing gyroscopic moment.
    """
    same = differences(apply(file.program, best.mistakes), file.program)
    for h in residual.as_good_as_known:
        if not h.parts <= same:
            yield from _fitted(file, [], [h.mistakes[0]], counts=(1,))


def _unresolved(search: Search) -> Iterable[Hypothesis]:
    """Judge mistakes that noisy or few rows neither show nor exclude."""
    return search.file.judged(search.by_equations[1])


def _by_output(search: Search) -> Iterable[Hypothesis]:
    """Judge mistakes of the initial conditions, of the output and of the clock."""
    file = search.file
    starts: list[Causes] = [(m,) for m in _starts(file)]
    if len(starts) > THRESHOLDS.max_starts:
        starts = file.promising(starts, THRESHOLDS.max_leaders)
    beside = (*LINEAR_PROGRAMS, *_written(file), *_clock(file.residual))
    return file.judged((*starts, *((m,) for m in beside)))


def _only_written(search: Search) -> Iterable[Hypothesis]:
    return search.file.judged((m,) for m in _written(search.file))


def _proposed(file: FileUnderTest, proposed: Sequence[Causes]) -> Iterator[Hypothesis]:
    """Judge given causes with their values, and with the values fitted to the rows again."""
    yield from file.judged(proposed)
    for causes in proposed:
        values = [m for m in causes if m.found]
        if len(values) == len(causes) == 1:
            yield from _fitted(file, [], values, counts=(len(values[0].found),))


def _written(file: FileUnderTest) -> list[Mistake]:
    """Return the possible mistakes in the output of a correct program."""
    return [*file.of_kind("output"), *file.order_beside(file.right)]


def _by_library(search: Search) -> Iterable[Hypothesis]:
    return search.file.judged(
        search.file.promising([(m,) for m in OF_MODEL], THRESHOLDS.max_simulated)
    )


def _shows_no_motion(search: Search) -> bool:
    return search.residual is None or search.residual.visibility is Visibility.NOTHING


def _equations_are_not_enough(search: Search) -> bool:
    """True if whole runs may show more than the equations of motion do."""
    seen = search.residual
    if seen is None:
        return True
    # If no cause explains a force that the equations show, no value fitted to whole runs explains
    # it.
    is_seen = seen.visibility is not Visibility.NOTHING
    return is_seen and not (seen.is_open or _determines_all(seen))


def _asks_whole_runs(search: Search) -> bool:
    return _goes_on(search) and _equations_are_not_enough(search)


def _shows_another_start(search: Search) -> bool:
    """True if the motion satisfies the equations, but starts from other initial conditions."""
    seen = search.residual
    if seen is None or seen.visibility < Visibility.EQUATIONS_PARTLY or search.is_over:
        return False
    return seen.is_met and bool(seen.other_starts())


def _may_be_another_start(search: Search) -> bool:
    """True if no cause explains most of the error, and no integrator the residual."""
    seen = search.residual
    if seen is None or seen.methods or search.starts or search.ends_early:
        return False
    best = ranked(search.file, search.found)[:1]
    return not any(explains_mostly(c[0], seen) for c in best)


def _determines_all(residual: Residual) -> bool:
    """True if the equations determine all parameters, also those that mainly affect the speed."""
    return residual.visibility >= Visibility.EQUATIONS_PARTLY and residual.equations == EQUATIONS


def _of_equations(residual: Residual) -> tuple[list[Causes], list[Causes]]:
    """Return mistakes that the residual suggests, and mistakes that it does not exclude.

    The second list is for whole runs, which show more than noisy or few rows do.
    """
    limits, likeliest = THRESHOLDS, sorted(residual.known, key=lambda h: -h.log_odds)
    least = residual.log_odds - limits.drop_log_odds
    singles = [h for h in likeliest if len(h.mistakes) == 1]
    pairs = [h for h in likeliest if len(h.mistakes) > 1 and h.log_odds > max(least, 0.0)]
    # The equations neither show nor exclude a mistake that hardly changes them.
    relief = 1.0 / limits.min_pair_gain if residual.is_resolved else 0.0
    most = limits.max_unseen if residual.visibility is Visibility.NOTHING else limits.max_simulated
    likely = [h for h in singles if h.log_odds > least and h.relief > relief][:most]
    others = [h for h in singles[len(likely) :] if h.relief > 1.0 / CLEARLY][: limits.max_simulated]
    is_partly = residual.visibility in (Visibility.STARTS, Visibility.EQUATIONS_PARTLY)
    others = others if is_partly else []
    return [h.mistakes for h in (*likely, *pairs[: limits.max_pairs])], [h.mistakes for h in others]


def _values(file: FileUnderTest, residual: Residual) -> Iterator[Hypothesis]:
    """Judge likely values of parameters and forces, fitted to the equations and to whole runs."""
    least = max(residual.log_odds - THRESHOLDS.drop_log_odds, 0.0)
    likely = [h for h in residual.fitted if h.log_odds > least][: THRESHOLDS.max_refined]
    if all(len(h.parts) > 1 for h in likely):
        likely += [h for h in residual.fitted if len(h.parts) == 1][:1]
    if residual.visibility >= Visibility.EQUATIONS_PARTLY:
        # Keep likely values that reduce the residual only little: if the rows are far apart,
        # simulations of whole runs show more than the residual.
        likely = [
            h
            for h in likely
            if h.relief > THRESHOLDS.explained_factor or h.log_odds > THRESHOLDS.report_log_odds
        ]
    if residual.is_open or residual.visibility is Visibility.NOTHING:
        # Either a force remains unexplained or no motion is visible, so refining the values would
        # be useless.
        yield from file.judged(h.mistakes for h in likely)
        return
    # Simulations of whole runs also show a small error of a second parameter, and wrong initial
    # conditions, so fit all of these.
    names = [*PARAMETERS, *_names_of_starts(file)]
    if likely:
        yield from _fitted(file, names, [h.mistakes[0] for h in likely])


def _names_of_starts(file: FileUnderTest) -> list[str]:
    return [f"initial_{name}_{n}" for n in file.maneuvers for name in START]


def _of_whole_runs(file: FileUnderTest, counts: Collection[int]) -> Iterator[Hypothesis]:
    """Judge values of parameters, forces and initial conditions, fitted to whole runs.

    `counts` lists how many values are fitted together. Mistakes of the library that change the same
    values are judged, too.
    """
    starts = _names_of_starts(file)
    # If the equations of roll and steer show any value, they have been searched for the values that
    # they contain, so those values need not be tried again.
    seen = file.residual
    names = [*UNKNOWNS, *starts]
    if seen is not None and _shows_values(seen) and not seen.is_open:
        # Try values that mainly change the speed, and values that the equations of roll and steer
        # suggest but do not determine.
        names = [*FORWARD, *(n for n in seen.promising if n not in FORWARD), *starts]
    found = [h for h in _fitted(file, names, counts=counts) if h.relief > BY_FAR]
    yield from found
    keys = {x.key for h in found for x in h.found}
    alike = [m for m in OF_MODEL if differences(apply(file.program, (m,)), file.program) <= keys]
    of_start = file.of_kind("start") if keys & {*starts} else ()
    yield from file.judged((m,) for m in (*alike, *of_start))


def _shows_values(residual: Residual) -> bool:
    """True if the equations determine some value, however unlikely it is to be the cause."""
    return residual.visibility >= Visibility.EQUATIONS_PARTLY and bool(residual.fitted)


def _fitted(
    file: FileUnderTest,
    names: Sequence[str],
    begun: Sequence[Cause] = (),
    maneuver: int | None = None,
    counts: Collection[int] = COUNTS,
) -> tuple[Hypothesis, ...]:
    """Fit as few of the named values as explain whole runs of one maneuver, or of all.

    Values in `begun` are included first, and other values are added to them.
    """
    return file.whole_runs(tuple(begun[:1]), maneuver).fewest(
        names,
        lambda m: file.judged([(m,)]),
        # Fit no further values once the error is negligible or smaller by the factor `BY_FAR**2`.
        lambda h: h.is_exhaustive or h.relief > BY_FAR**2,
        begun=[m.changes for m in begun],
        counts=counts,
    )


def _starts(file: FileUnderTest) -> list[Mistake]:
    """Return possible mistakes of the initial conditions; all if the file does not show these."""
    every = len(file.right.expected)
    seen = file.residual
    if seen is None or sum(m.has_beginning for m in seen.motions) < every:
        return file.of_kind("start")
    return seen.starts_nearby(file.of_kind("start"))


def _pairs(file: FileUnderTest, found: Sequence[Hypothesis]) -> list[Causes]:
    """Return the pairs of mistakes that are worth a simulation.

    The best single mistakes are paired with mistakes of the output, and the very best also with
    mistakes of the initial conditions. If the equations do not show the mistakes of the model,
    these are paired, too.
    """
    alone = singles_by_code(found)
    likeliest = sorted(
        (h for h in alone.values() if h.gain > 1.0 and h.mistakes[0].kind in KINDS),
        key=lambda h: -h.log_odds,
    )
    leaders = [
        h for h in likeliest if h.log_odds > likeliest[0].log_odds - THRESHOLDS.drop_log_odds
    ]
    leaders = leaders[: THRESHOLDS.max_leaders]
    if file.has_one_speed:
        # A linear program may contain a mistake in addition to being linear.
        leaders += [h for h in likeliest if h.codes == (LINEARISED_CODE,) and h not in leaders]
    asked: list[Causes] = []
    for leader in [] if any(h.is_exhaustive for h in found) else leaders:
        (first,) = leader.mistakes
        others: list[Cause] = [*file.of_kind("output"), *file.order_beside(leader)]
        if leader is likeliest[0]:
            others += _starts(file)
        if leader is likeliest[0] and first.kind == "output":
            others += [h.mistakes[0] for h in alone.values() if h.mistakes[0].kind == "model"]
        elif not shows_equations(file.residual):
            others += [h.mistakes[0] for h in likeliest[: THRESHOLDS.max_partners]]
        asked += _with_others(first, others)
    return asked


def _with_others(first: Cause, others: Iterable[Cause]) -> list[Causes]:
    """Return pairs of a mistake with others; at most one of a pair is of the initial conditions."""
    kinds = {"start"}
    return [in_order((first, m)) for m in others if m != first and {m.kind, first.kind} != kinds]


def _of_start(file: FileUnderTest) -> Sequence[Hypothesis]:
    """Fit the initial conditions of each maneuver to whole runs; each must be likely by itself.

    The fit begins with the initial conditions to which the file's own rows lead back.
    """
    found: list[Hypothesis] = []
    seen = {
        m.found[0].maneuver: [m] for m in (file.residual.other_starts() if file.residual else ())
    }
    for n in file.maneuvers:
        values = _fitted(file, [f"initial_{name}_{n}" for name in START], seen.get(n, ()), n)
        # Only the error of the fitted maneuver counts, because the errors of the other maneuvers do
        # not change.
        found += [
            h
            for h in values
            if h.log_odds > THRESHOLDS.report_log_odds
            and max(h.after[k] for k in h.changed) < MEANINGLESS_ERROR
        ][:1]
    return [*file.judged([tuple(m for h in found for m in h.mistakes)])] or found


def _clock(residual: Residual | None) -> list[OtherScale]:
    """Return the scales of the times that explain the residual of the equations."""
    scales = [m.step for m in (residual.methods if residual else ()) if m.says == CLOCK]
    return [
        fitted_scale(
            "time_scaled",
            f"the times written are {1 / (1 + x):.6g} times the correct times",
            "the step size and the times of the rows",
            1 + x,
        )
        for x in scales
    ]


SEARCH = (
    Trial(
        "linear",
        "are these motions of the linear equations, at one speed?",
        lambda search: search.file.has_one_speed,
        _are_linear,
    ),
    Trial(
        "equations",
        "which mistake, value or force do the equations of motion show?",
        lambda search: _is_open(search) and search.residual is not None,
        _by_equations,
    ),
    Trial(
        "unresolved",
        "which mistake do the equations neither show nor exclude?",
        lambda search: _is_open(search) and search.residual is not None,
        _unresolved,
    ),
    Trial(
        "integrator",
        "which integrator makes the file's error if it is run here?",
        _may_be_an_integrator,
        lambda search: search.file.by_integrators(),
    ),
    Trial(
        "start and output",
        "which initial conditions, clock or column are wrong?",
        _is_open,
        _by_output,
    ),
    Trial(
        "start",
        "is each maneuver the exact motion from the initial conditions in its first rows?",
        _shows_another_start,
        lambda search: _of_start(search.file),
        is_of_start=True,
    ),
    Trial(
        "whole runs",
        "which wrong value explains the errors of whole runs?",
        _asks_whole_runs,
        lambda search: _of_whole_runs(search.file, COUNTS[:1]),
    ),
    Trial(
        "library",
        "which mistake of the model explains the errors of whole runs?",
        lambda search: _goes_on(search) and _shows_no_motion(search),
        _by_library,
    ),
    Trial(
        "several values",
        "which two or three wrong values explain the errors of whole runs?",
        _asks_whole_runs,
        lambda search: _of_whole_runs(search.file, COUNTS[1:]),
    ),
    Trial(
        "large steps",
        "which integrator of low order, with a step from row to row, makes the file?",
        lambda search: _goes_on(search) and _may_be_an_integrator(search),
        lambda search: search.file.by_integrators(with_steps_of_rows),
    ),
    Trial(
        "together",
        "which two mistakes explain more than each of them alone?",
        lambda search: not search.ends_early,
        lambda search: search.file.judged(
            search.file.promising(
                _pairs(search.file, [*search.found, *search.starts]), THRESHOLDS.max_leaders
            )
        ),
    ),
    Trial(
        "starts",
        "is each maneuver the exact motion from other initial conditions?",
        _may_be_another_start,
        lambda search: _of_start(search.file),
        is_of_start=True,
    ),
)
"""The steps of a search."""

OF_WHAT_IS_WRITTEN = (Trial("output", "which column is wrong?", lambda _: True, _only_written),)
"""The only step of a search for mistakes of the output."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The steps of a search.

    Attributes
    ----------
    steps : tuple of Trial
    asks_equations
        False if the equations along the file's own motion are not needed.
    """

    steps: tuple[Trial, ...]
    asks_equations: bool = True


EVERYTHING = Plan(SEARCH)
"""The whole search."""

ONLY_EQUATIONS = Plan(tuple(x for x in SEARCH if x.name == "equations"))
"""A short search among the causes that the equations of motion show."""

ONLY_OUTPUT = Plan(OF_WHAT_IS_WRITTEN, asks_equations=False)
"""A search for mistakes of the output of a correct program."""


def again(causes: Sequence[Causes]) -> Plan:
    """Return the plan to judge causes that were found before faults of the rows were corrected."""
    return _only(
        "again",
        "does this cause explain the rows without their faults?",
        lambda search: _proposed(search.file, causes),
    )


def with_output(causes: Causes) -> Plan:
    """Return the plan to judge causes together with each mistake of the output.

    Some rows or columns show these causes, and the others contradict them.
    """
    return _only(
        "with output",
        "which mistake of the output contradicts this cause?",
        lambda search: search.file.judged(
            in_order((*causes, m)) for m in _written(search.file) if m not in causes
        ),
    )


def _only(name: str, question: str, tried: Callable[[Search], Iterable[Hypothesis]]) -> Plan:
    """Return a plan of one step, which does not need the equations along the file's motion."""
    return Plan((Trial(name, question, lambda _: True, tried),), asks_equations=False)
