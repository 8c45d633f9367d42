"""The search for a cause, as a list of steps: each asks one question, and tries causes for it.

The likeliest causes come first. What leaves next to nothing of the file's error ends the search for
single causes; then pairs are tried, and at last other starts. What was judged when the time is
spent stays (`budget`).
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
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import KINDS, MISTAKES, Mistake, in_order
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS, LINEARISED_CODE
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.forces import FORWARD
from heyoka_bike.scoring.diagnosis.programs.program import (
    Cause,
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
from heyoka_bike.scoring.grades import has_right_digits
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
        Whether it is worth the time, from what was found before.
    tried : callable
        The causes that it tries, judged one after the other.
    is_of_start
        True if these are other starts, which are compared with the others last.
    """

    is_asked: Callable[[Search], bool]
    tried: Callable[[Search], Iterable[Hypothesis]]
    is_of_start: bool = False


@dataclass(eq=False)
class Search:
    """What is known of a file, and the causes that were judged.

    Attributes
    ----------
    file : FileUnderTest
    found : list of Hypothesis
        Single causes and pairs of them, in the order in which they were tried.
    starts : list of Hypothesis
        Other starts: these leave nothing in the equations, and are compared with the others last.
    is_thorough
        True to look on where the equations leave a force that no cause explains.
    """

    file: FileUnderTest
    found: list[Hypothesis] = field(default_factory=list)
    starts: list[Hypothesis] = field(default_factory=list)
    is_thorough: bool = False

    @property
    def residual(self) -> Residual | None:
        """What the equations of motion leave of the file's motion, if it shows that."""
        return self.file.residual

    @cached_property
    def by_equations(self) -> tuple[list[Causes], list[Causes]]:
        """Mistakes that the equations do not speak against, and others where they tell little."""
        return ([], []) if self.residual is None else _of_equations(self.residual)

    @property
    def is_over(self) -> bool:
        """True if no single cause that is tried later could take the place of one found."""
        return any(ends_search(h, self.residual) for h in (*self.found, *self.starts))

    @property
    def best(self) -> Hypothesis | None:
        """The likeliest cause until now; None if none is likelier than none."""
        likely = [h for h in (*self.found, *self.starts) if h.is_possible and h.log_odds > 0.0]
        return max(likely, key=lambda h: h.log_odds, default=None)

    @property
    def stops_at_unknown_force(self) -> bool:
        """True if the equations leave a force, nothing explains any of it, and that is said."""
        seen = self.residual
        is_left = seen is not None and shows_equations(seen) and seen.is_open
        return is_left and self.best is None and not self.is_thorough

    @property
    def ends_early(self) -> bool:
        """True if it ends at a force, or the file is right to six digits.

        A mistake of the model hardly leaves so little: the equations, integrators and what is
        written are looked at, which takes little time.
        """
        error = max(self.file.right.after.values(), default=1.0)
        is_near = has_right_digits(error) and not self.is_thorough
        return is_near or self.stops_at_unknown_force

    def carry_out(self, steps: Sequence[Trial], progress: Callable[[float], None]) -> None:
        """Try the causes of each step that is asked.

        Raises
        ------
        BudgetSpentError
            The time is spent; what was judged until then has been kept.
        """
        for i, step in enumerate(steps):
            if step.is_asked(self):
                kept = self.starts if step.is_of_start else self.found
                with step_log.logged(step) as told:
                    told.found = partial(self._in_words, self.file.tried)
                    kept.extend(step.tried(self))
            progress((i + 1) / len(steps))

    def _in_words(self, before: int) -> str:
        """How many were tried since so many had been, and what is the likeliest now."""
        return f"{self.file.tried - before} tried; {step_log.in_words(self.best)}"


def _is_open(search: Search) -> bool:
    """True if a single cause may still be found."""
    return not search.is_over


def _goes_on(search: Search) -> bool:
    """... and whole runs are worth their time."""
    return _is_open(search) and not search.ends_early


def _may_be_an_integrator(search: Search) -> bool:
    """True if nothing explains the error, which is small, and no force is left."""
    seen, file = search.residual, search.file
    is_small = max(file.right.after.values(), default=1.0) < MEANINGLESS_ERROR
    has_force = seen is not None and (seen.is_open or seen.visibility is Visibility.NOTHING)
    return is_small and not has_force and not any(explains_mostly(h, seen) for h in search.found)


def _are_linear(search: Search) -> Iterable[Hypothesis]:
    return search.file.judged((m,) for m in LINEAR_PROGRAMS)


def _by_equations(search: Search) -> Iterator[Hypothesis]:
    """Mistakes and values that the equations of motion speak for."""
    assert search.residual is not None
    found = []
    for h in search.file.judged(search.by_equations[0]):
        found.append(h)
        yield h
    yield from _values(search.file, search.residual)
    best = max(found, key=lambda h: h.log_odds, default=None)
    if best is not None and ends_search(best, search.residual) and not best.is_exhaustive:
        yield from _beside_known(search.file, search.residual, best)


def _beside_known(
    file: FileUnderTest, residual: Residual, best: Hypothesis
) -> Iterator[Hypothesis]:
    """Values that leave as little of the equations as a mistake of the library that leaves some.

    Whole runs tell which of them it is: an axial inertia as small as the diametral one is nearly a
    gyroscopic moment that is missing.
    """
    same = differences(apply(file.program, best.mistakes), file.program)
    for h in residual.as_good_as_known:
        if not h.parts <= same:
            yield from _fitted(file, [], [h.mistakes[0]], counts=(1,))


def _unresolved(search: Search) -> Iterable[Hypothesis]:
    """Mistakes that rows which are noisy or few neither show nor refute."""
    return search.file.judged(search.by_equations[1])


def _by_output(search: Search) -> Iterable[Hypothesis]:
    """Mistakes of the start, of what is written and of the clock."""
    file = search.file
    beside = (*LINEAR_PROGRAMS, *_written(file), *_clock(file.residual))
    return file.judged((m,) for m in (*_starts(file), *beside))


def _only_written(search: Search) -> Iterable[Hypothesis]:
    return search.file.judged((m,) for m in _written(search.file))


def _written(file: FileUnderTest) -> list[Mistake]:
    """Mistakes of what is written by a program that is right."""
    return [*file.of_kind("output"), *file.order_beside(file.right)]


def _by_library(search: Search) -> Iterable[Hypothesis]:
    return search.file.judged(search.file.possible([(m,) for m in OF_MODEL]))


def _shows_no_motion(search: Search) -> bool:
    return search.residual is None or search.residual.visibility is Visibility.NOTHING


def _equations_are_not_enough(search: Search) -> bool:
    """True if whole runs may show more than the equations of motion do."""
    seen = search.residual
    if seen is None:
        return True
    # A force that no cause explains in the equations is explained by no value of whole runs.
    is_seen = seen.visibility is not Visibility.NOTHING
    return is_seen and not (seen.is_open or _tells_all(seen))


def _asks_whole_runs(search: Search) -> bool:
    return _goes_on(search) and _equations_are_not_enough(search)


def _shows_another_start(search: Search) -> bool:
    """True if the file's motion meets the equations, and its rows lead back to another start."""
    seen = search.residual
    if seen is None or seen.visibility < Visibility.EQUATIONS_PARTLY or search.is_over:
        return False
    return seen.is_met and bool(seen.other_starts())


def _may_be_another_start(search: Search) -> bool:
    """True if nothing explains most, and no method of integration explains what remains."""
    seen = search.residual
    if seen is None or seen.methods or search.starts or search.ends_early:
        return False
    best = ranked(search.file, search.found)[:1]
    return not any(explains_mostly(c[0], seen) for c in best)


def _tells_all(residual: Residual) -> bool:
    """True if the equations tell of every value, also of those that change the speed first."""
    return residual.visibility >= Visibility.EQUATIONS_PARTLY and residual.equations == EQUATIONS


def _of_equations(residual: Residual) -> tuple[list[Causes], list[Causes]]:
    """Mistakes that the equations do not speak against, and others where they tell little.

    Whole runs show more than rows that are noisy or few, and terms that these do not resolve.
    """
    w, likeliest = THRESHOLDS, sorted(residual.known, key=lambda h: -h.log_odds)
    least = residual.log_odds - w.drop_log_odds
    singles = [h for h in likeliest if len(h.mistakes) == 1]
    pairs = [h for h in likeliest if len(h.mistakes) > 1 and h.log_odds > max(least, 0.0)]
    # What changes next to nothing of the equations is neither shown by them nor refuted.
    relief = 1.0 / w.min_pair_gain if residual.is_resolved else 0.0
    most = w.max_pairs if residual.visibility is Visibility.NOTHING else w.max_simulated
    likely = [h for h in singles if h.log_odds > least and h.relief > relief][:most]
    others = [h for h in singles[len(likely) :] if h.relief > 1.0 / CLEARLY][: w.max_simulated]
    is_partly = residual.visibility in (Visibility.STARTS, Visibility.EQUATIONS_PARTLY)
    others = others if is_partly else []
    return [h.mistakes for h in (*likely, *pairs[: w.max_pairs])], [h.mistakes for h in others]


def _values(file: FileUnderTest, residual: Residual) -> Iterator[Hypothesis]:
    """Values of parameters and forces that the equations speak for, as whole runs show them."""
    least = max(residual.log_odds - THRESHOLDS.drop_log_odds, 0.0)
    likely = [h for h in residual.fitted if h.log_odds > least][: THRESHOLDS.refined]
    if all(len(h.parts) > 1 for h in likely):
        likely += [h for h in residual.fitted if len(h.parts) == 1][:1]
    if residual.visibility >= Visibility.EQUATIONS_PARTLY:
        # A likely value with a small relief is kept too: rows far apart show less than whole runs.
        likely = [
            h
            for h in likely
            if h.relief > THRESHOLDS.explains or h.log_odds > THRESHOLDS.report_log_odds
        ]
    if residual.is_open or residual.visibility is Visibility.NOTHING:
        # Where a force is left, or no motion is seen, no values are those of the file.
        yield from file.judged(h.mistakes for h in likely)
        return
    # Whole runs show a small value beside a large one, and another start.
    names = [*PARAMETERS, *_names_of_starts(file)]
    if likely:
        yield from _fitted(file, names, [h.mistakes[0] for h in likely])


def _names_of_starts(file: FileUnderTest) -> list[str]:
    return [f"initial_{name}_{n}" for n in file.maneuvers for name in START]


def _of_whole_runs(file: FileUnderTest, counts: Collection[int]) -> Iterator[Hypothesis]:
    """So many values of parameters, forces and starts that whole runs speak for.

    And mistakes of these.
    """
    starts = _names_of_starts(file)
    # What the equations of roll and steer show they have shown.
    seen = file.residual
    names = [*UNKNOWNS, *starts]
    if seen is not None and seen.visibility >= Visibility.EQUATIONS_PARTLY and not seen.is_open:
        # Values that change the speed, and those that these equations favour without proving them.
        names = [*FORWARD, *(n for n in seen.promising if n not in FORWARD), *starts]
    found = [h for h in _fitted(file, names, counts=counts) if h.relief > BY_FAR]
    yield from found
    keys = {x.key for h in found for x in h.found}
    alike = [m for m in OF_MODEL if differences(apply(file.program, (m,)), file.program) <= keys]
    of_start = file.of_kind("start") if keys & {*starts} else ()
    yield from file.judged((m,) for m in (*alike, *of_start))


def _fitted(
    file: FileUnderTest,
    names: Sequence[str],
    begun: Sequence[Cause] = (),
    maneuver: int | None = None,
    counts: Collection[int] = COUNTS,
) -> tuple[Hypothesis, ...]:
    """The fewest of some values that explain whole runs, of one maneuver or all.

    Or values that are `begun` with, and others beside them.
    """
    return file.whole_runs(tuple(begun[:1]), maneuver).fewest(
        names,
        lambda m: file.judged([(m,)]),
        # Each of several values lets the error fall by far.
        lambda h: h.is_exhaustive or h.relief > BY_FAR**2,
        begun=[m.changes for m in begun],
        counts=counts,
    )


def _starts(file: FileUnderTest) -> list[Mistake]:
    """Mistakes of the start that may be; all of them where the file does not show its start."""
    every = len(file.right.expected)
    seen = file.residual
    if seen is None or sum(m.has_beginning for m in seen.motions) < every:
        return file.of_kind("start")
    return seen.starts_nearby(file.of_kind("start"))


def _pairs(file: FileUnderTest, found: Sequence[Hypothesis]) -> list[Causes]:
    """Pairs of mistakes that are worth a simulation.

    The best single ones are tried with those of the output, the very best with those of the start;
    and where the equations do not tell which mistakes of the model there are, with these.
    """
    alone = singles_by_code(found)
    likeliest = sorted(
        (h for h in alone.values() if h.gain > 1.0 and h.mistakes[0].kind in KINDS),
        key=lambda h: -h.log_odds,
    )
    leaders = [
        h for h in likeliest if h.log_odds > likeliest[0].log_odds - THRESHOLDS.drop_log_odds
    ]
    leaders = leaders[: THRESHOLDS.max_answers]
    if file.has_one_speed:
        # What linear programs have in common.
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
            others += [h.mistakes[0] for h in likeliest[: THRESHOLDS.rivals]]
        asked += _with_others(first, others)
    return asked


def _with_others(first: Cause, others: Iterable[Cause]) -> list[Causes]:
    """Pairs of a mistake with others, of which only one may be of the initial conditions."""
    kinds = {"start"}
    return [in_order((first, m)) for m in others if m != first and {m.kind, first.kind} != kinds]


def _of_start(file: FileUnderTest) -> Sequence[Hypothesis]:
    """Starts that whole runs speak for: that of each maneuver must be likely by itself.

    They begin where the file's own rows lead back to.
    """
    found: list[Hypothesis] = []
    seen = {
        m.found[0].maneuver: [m] for m in (file.residual.other_starts() if file.residual else ())
    }
    for n in file.maneuvers:
        values = _fitted(file, [f"initial_{name}_{n}" for name in START], seen.get(n, ()), n)
        # The other maneuvers may be as far off as before.
        found += [
            h
            for h in values
            if h.log_odds > THRESHOLDS.report_log_odds
            and max(h.after[k] for k in h.changed) < MEANINGLESS_ERROR
        ][:1]
    return [*file.judged([tuple(m for h in found for m in h.mistakes)])] or found


def _clock(residual: Residual | None) -> list[OtherScale]:
    """Times on another scale, if they explain what remains of the equations."""
    scales = [m.step for m in (residual.methods if residual else ()) if m.says == CLOCK]
    return [
        fitted_scale(
            "time_scaled",
            f"the times written are {1 / (1 + x):.6g} times those meant",
            "the step size and the times of the rows",
            1 + x,
        )
        for x in scales
    ]


SEARCH = (
    Trial(
        "linear",
        "are these the linear equations, at one speed?",
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
        "which mistake do they neither show nor refute?",
        lambda search: _is_open(search) and search.residual is not None,
        _unresolved,
    ),
    Trial(
        "integrator",
        "which integrator, run here, leaves the file's error?",
        _may_be_an_integrator,
        lambda search: search.file.by_integrators(),
    ),
    Trial(
        "start and output",
        "which start, clock or column is written?",
        _is_open,
        _by_output,
    ),
    Trial(
        "start",
        "is each maneuver the right motion of the start that its first rows show?",
        _shows_another_start,
        lambda search: _of_start(search.file),
        is_of_start=True,
    ),
    Trial(
        "whole runs",
        "which value do whole runs show?",
        _asks_whole_runs,
        lambda search: _of_whole_runs(search.file, COUNTS[:1]),
    ),
    Trial(
        "library",
        "which mistake of the model do whole runs show?",
        lambda search: _goes_on(search) and _shows_no_motion(search),
        _by_library,
    ),
    Trial(
        "several values",
        "which two or three values do whole runs show?",
        _asks_whole_runs,
        lambda search: _of_whole_runs(search.file, COUNTS[1:]),
    ),
    Trial(
        "together",
        "which two explain more than each of them?",
        lambda search: not search.ends_early,
        lambda search: search.file.judged(_pairs(search.file, [*search.found, *search.starts])),
    ),
    Trial(
        "starts",
        "is each maneuver the right motion of another start?",
        _may_be_another_start,
        lambda search: _of_start(search.file),
        is_of_start=True,
    ),
)
"""The steps of a search."""

OF_WHAT_IS_WRITTEN = (Trial("output", "which column is written?", lambda _: True, _only_written),)
"""The step of a search for mistakes of what is written only."""
