"""Why a result differs: which force is missing, which mistake explains the file.

First the file's own motion is put into the exact equations (`residual`): what remains says which
mistakes of the model, which parameters and which forces can be the cause, without any simulation.
The likeliest are then simulated, with mistakes of the start and of what is written, which leave
nothing in the equations, and the file is compared with each motion as it is with the reference.
Where a file does not show its motion (columns are missing, rows are few) all mistakes of the
library are simulated. All are compared in one way, by their odds (`evidence`). A search that has no
time left (`budget`) ends with what was found until then.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from math import log

import numpy as np

from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.budget import NEVER, BudgetSpentError, Deadline
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS, Hypothesis, log_odds_before
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, Mistake, in_order
from heyoka_bike.scoring.diagnosis.mistakes.linearised import CODE as LINEARISED
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS
from heyoka_bike.scoring.diagnosis.programs.forces import FORWARD
from heyoka_bike.scoring.diagnosis.programs.program import apply, clock_mistake, differences
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.residual.methods import CLOCK
from heyoka_bike.scoring.diagnosis.residual.observed import upright
from heyoka_bike.scoring.diagnosis.residual.residual import EQUATIONS, UNKNOWNS, Residual
from heyoka_bike.scoring.diagnosis.seen_file import SeenFile
from heyoka_bike.scoring.explanation import Curve

__all__ = ["Diagnosis", "Hypothesis", "explain"]

# The first row is given, and of one more the error may have any size: that tells nothing.
_FEWEST_ROWS_DIAGNOSED = 3
_LINEAR = {m.code for m in LINEAR_PROGRAMS}
_OF_MODEL = [
    *(m for m in MISTAKES if m.kind == "model" and m.code not in _LINEAR),
    *EQUATION_MISTAKES,
]

Mistakes = tuple[Mistake, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Diagnosis:
    """The causes that explain a file.

    Attributes
    ----------
    classes : tuple of tuple of Hypothesis
        Ranked; hypotheses of a class cannot be told apart. Empty if nothing explains it, and of a
        search that was stopped also if what it did not try might explain more.
    tried
        Number of hypotheses tried.
    causes : Residual or None
        What the equations of motion say of the file's own motion; None where it does not show it.
    curves : tuple of Curve
        What the best of all leaves, in the column of each maneuver that it explains best.
    units : mapping of str to str
        Units that columns have if the best of all is true, where they seem to have others beside
        the correct motion.
    is_whole
        False if the time was spent before all was tried.
    likeliest : Hypothesis or None
        Where `classes` are empty only for that, the best until then.
    """

    classes: tuple[tuple[Hypothesis, ...], ...]
    tried: int
    causes: Residual | None = None
    curves: tuple[Curve, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    is_whole: bool = True
    likeliest: Hypothesis | None = None


def explain(
    parts: Sequence[Part], reference: Reference, *, simulator: Simulator | None = None,
    only_output: bool = False, progress: Callable[[float], None] = lambda _: None,
    deadline: Deadline = NEVER,
) -> Diagnosis:  # fmt: skip
    """Find the mistakes, alone and in pairs, and the parameters and forces that explain a file.

    With `only_output` of what is written only. `progress` is called with the part of the work that
    is done, 0 to 1. At the `deadline` what was found until then is compared.
    """
    # Of rows at one time the first: an event is often written twice.
    parts = [part.at(np.diff(part.time, prepend=-np.inf) > 0.0) for part in parts]
    parts = [upright(part, understand(parts)) for part in parts]
    if max(len(part.time) for part in parts) < _FEWEST_ROWS_DIAGNOSED:
        return Diagnosis((), 0)
    library = () if only_output else _OF_MODEL
    found: list[Hypothesis] = []
    starts: list[Hypothesis] = []
    try:
        file = SeenFile(parts, reference, simulator or Simulator(), library, deadline)
    except BudgetSpentError:
        return Diagnosis((), 0, is_whole=False)
    residual, is_whole = file.residual, True
    progress(0.3)
    # What was judged before the time is spent stays in the lists.
    try:
        if only_output:
            written = (*file.of_kind("output"), *file.order_beside(file.right))
            found.extend(file.judged((m,) for m in written))
        else:
            _search(file, found, progress)
        progress(0.9)
        is_explained = any(_explains_mostly(c[0], residual) for c in _compared(file, found)[:1])
        if not (only_output or is_explained) and residual is not None and not residual.methods:
            # The start leaves nothing in the equations.
            starts.extend(_of_start(file))
    except BudgetSpentError:
        is_whole = False
    progress(1.0)
    classes = _compared(file, found, starts)
    tried = file.tried + (len(_OF_MODEL) if residual else 0)
    if not classes:
        return Diagnosis((), tried, residual, is_whole=is_whole)
    best, usual = classes[0][0], file.right.understood
    if not (is_whole or _ends_search(best, residual)):
        return Diagnosis((), tried, residual, is_whole=False, likeliest=best)
    units = {key: u.unit for key, u in best.understood.items() if u.unit != usual[key].unit}
    return Diagnosis(classes, tried, residual, file.curves(best), units, is_whole)


def _search(file: SeenFile, found: list[Hypothesis], progress: Callable[[float], None]) -> None:
    """Add single mistakes and values, and pairs, to what was found.

    The likeliest first; what leaves next to nothing ends the search for single ones.
    """
    for judged in _in_order(file):
        found.extend(judged)
        if any(_ends_search(h, file.residual) for h in found):
            break
    progress(0.6)
    found.extend(file.judged(_pairs(file, found)))


def _ends_search(h: Hypothesis, residual: Residual | None) -> bool:
    """True if no single cause that is tried later could take its place."""
    return h.leaves_nothing or _explains_mostly(h, residual)


def _in_order(file: SeenFile) -> Iterator[Iterable[Hypothesis]]:
    """Programs that are worth a simulation, the likeliest by the equations of motion first."""
    seen = file.residual
    others: list[Mistakes] = []
    if file.has_one_speed:
        yield file.judged((m,) for m in LINEAR_PROGRAMS)
    if seen is not None:
        likely, others = _of_equations(seen)
        yield chain(file.judged(likely), _values(file, seen))
    yield file.judged(others)
    written = (*file.of_kind("output"), *file.order_beside(file.right))
    beside = (*LINEAR_PROGRAMS, *written, *_clock(seen))
    yield file.judged((m,) for m in (*_starts(file), *beside))
    if seen is None or seen.is_blown_up:
        yield file.judged(file.possible([(m,) for m in _OF_MODEL]))
    if seen is None or not (seen.is_blown_up or (_tells_all(seen) and not seen.is_open)):
        yield _of_whole_runs(file)


def _tells_all(residual: Residual) -> bool:
    """True if the equations tell of every value, also of those that change the speed first."""
    return residual.is_judged and residual.equations == EQUATIONS


def _of_equations(residual: Residual) -> tuple[list[Mistakes], list[Mistakes]]:
    """Mistakes that the equations do not speak against, and others where they tell little.

    Whole runs show more than rows that are noisy or few, and terms that these do not resolve.
    """
    w, ranked = WEIGHTS, sorted(residual.known, key=lambda h: -h.log_odds)
    least = residual.log_odds - w.refuted
    singles = [h for h in ranked if len(h.mistakes) == 1]
    pairs = [h for h in ranked if len(h.mistakes) > 1 and h.log_odds > max(least, 0.0)]
    # What changes next to nothing of the equations is neither shown by them nor refuted.
    relief = 1.0 / w.also if residual.is_resolved else 0.0
    most = w.pairs if residual.is_blown_up else w.simulated
    likely = [h for h in singles if h.log_odds > least and h.relief > relief][:most]
    others = [h for h in singles[len(likely) :] if h.relief > w.kept][: w.simulated]
    others = [] if residual.is_shown or residual.is_blown_up else others
    return [h.mistakes for h in (*likely, *pairs[: w.pairs])], [h.mistakes for h in others]


def _values(file: SeenFile, residual: Residual) -> Iterator[Hypothesis]:
    """Values of parameters and forces that the equations speak for, as whole runs show them."""
    least = max(residual.log_odds - WEIGHTS.refuted, 0.0)
    likely = [h for h in residual.fitted if h.log_odds > least][: WEIGHTS.refined]
    if all(len(h.parts) > 1 for h in likely):
        likely += [h for h in residual.fitted if len(h.parts) == 1][:1]
    if residual.is_judged:
        # Whole runs are explained no better.
        likely = [h for h in likely if h.relief > WEIGHTS.explains]
    if residual.is_open or residual.is_blown_up:
        # Where a force is left, or no motion is seen, no values are those of the file.
        yield from file.judged(h.mistakes for h in likely)
        return
    # Whole runs show a small value beside a large one, and another start.
    names = [*PARAMETERS, *_names_of_starts(file)]
    if likely:
        yield from _fitted(file, names, [h.mistakes[0] for h in likely])


def _names_of_starts(file: SeenFile) -> list[str]:
    return [f"initial_{name}_{n}" for n in file.maneuvers for name in START]


def _of_whole_runs(file: SeenFile) -> Iterator[Hypothesis]:
    """Values of parameters, forces and starts that whole runs speak for, and mistakes of these."""
    starts = _names_of_starts(file)
    # What the equations of roll and steer show they have shown.
    is_half = file.residual is not None and file.residual.is_judged and not file.residual.is_open
    names = [*(FORWARD if is_half else UNKNOWNS), *starts]
    found = [h for h in _fitted(file, names) if h.relief > WEIGHTS.mostly]
    yield from found
    keys = {x.key for h in found for x in h.found}
    alike = [m for m in _OF_MODEL if differences(apply(file.program, (m,)), file.program) <= keys]
    of_start = file.of_kind("start") if keys & {*starts} else ()
    yield from file.judged((m,) for m in (*alike, *of_start))


def _fitted(
    file: SeenFile, names: Sequence[str], begun: Sequence[Mistake] = (), maneuver: int | None = None
) -> tuple[Hypothesis, ...]:
    """The fewest of some values that explain whole runs, of one maneuver or all.

    Or values that are `begun` with, and others beside them.
    """
    return file.whole_runs(tuple(begun[:1]), maneuver).fewest(
        names,
        lambda m: file.judged([(m,)]),
        lambda h: h.leaves_nothing,
        begun=[m.changes for m in begun],
    )


def _starts(file: SeenFile) -> list[Mistake]:
    """Mistakes of the start that may be; all of them where the file does not show its start."""
    every = len(file.right.expected)
    seen = file.residual
    if seen is None or sum(m.beginning is not None for m in seen.motions) < every:
        return file.of_kind("start")
    return seen.starts_nearby(file.of_kind("start"))


def _pairs(file: SeenFile, found: Sequence[Hypothesis]) -> list[Mistakes]:
    """Pairs of mistakes that are worth a simulation.

    The best single ones are tried with those of the output, the very best with those of the start;
    and where the equations do not tell which mistakes of the model there are, with these.
    """
    alone = _alone(found)
    ranked = sorted((h for h in alone.values() if h.gain > 1.0), key=lambda h: -h.log_odds)
    leaders = [h for h in ranked if h.log_odds > ranked[0].log_odds - WEIGHTS.refuted]
    leaders = leaders[: WEIGHTS.leaders]
    if file.has_one_speed:
        # What linear programs have in common.
        leaders += [h for h in ranked if h.codes == (LINEARISED,) and h not in leaders]
    asked: list[Mistakes] = []
    for leader in [] if any(h.leaves_nothing for h in found) else leaders:
        (first,) = leader.mistakes
        others = [*file.of_kind("output"), *file.order_beside(leader)]
        if leader is ranked[0]:
            others += _starts(file)
        if leader is ranked[0] and first.kind == "output":
            others += [h.mistakes[0] for h in alone.values() if h.mistakes[0].kind == "model"]
        elif file.residual is None or not file.residual.is_shown:
            others += [h.mistakes[0] for h in ranked[: WEIGHTS.rivals]]
        asked += _with_others(first, others)
    return asked


def _alone(found: Sequence[Hypothesis]) -> dict[str, Hypothesis]:
    """Single mistakes, by their codes."""
    return {h.codes[0]: h for h in found if len(h.mistakes) == 1}


def _likelier(file: SeenFile, found: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Single mistakes, and pairs that are likelier than each of their mistakes alone."""
    alone = _alone(found)

    def is_likelier(h: Hypothesis) -> bool:
        each = [alone[code] for code in h.codes if code in alone]
        return all(file.log_odds(h, one) > WEIGHTS.said for one in each)

    pairs = [h for h in found if len(h.mistakes) > 1]
    return [*alone.values(), *filter(is_likelier, pairs)]


def _with_others(first: Mistake, others: Iterable[Mistake]) -> list[Mistakes]:
    """Pairs of a mistake with others, of which only one may be of the initial conditions."""
    kinds = {"start"}
    return [in_order((first, m)) for m in others if m != first and {m.kind, first.kind} != kinds]


def _of_start(file: SeenFile) -> Sequence[Hypothesis]:
    """Starts that whole runs speak for: that of each maneuver must be likely by itself.

    They begin where the file's own rows lead back to.
    """
    found: list[Hypothesis] = []
    seen = {
        m.found[0].maneuver: [m] for m in (file.residual.other_starts() if file.residual else ())
    }
    for n in file.maneuvers:
        values = _fitted(file, [f"initial_{name}_{n}" for name in START], seen.get(n, ()), n)
        found += [h for h in values if h.is_possible and h.log_odds > WEIGHTS.said][:1]
    return [*file.judged([tuple(m for h in found for m in h.mistakes)])] or found


def _clock(residual: Residual | None) -> list[Mistake]:
    """Times on another scale, if they explain what remains of the equations."""
    scales = [m.step for m in (residual.methods if residual else ()) if m.says == CLOCK]
    return [
        clock_mistake(
            "time_scaled",
            f"the times written are {1 / (1 + x):.6g} times those meant",
            "the step size and the times of the rows",
            scale=1 + x,
            is_fitted=True,
        )
        for x in scales
    ]


def _compared(
    file: SeenFile, found: Sequence[Hypothesis], starts: Sequence[Hypothesis] = ()
) -> tuple[tuple[Hypothesis, ...], ...]:
    """Rank likely hypotheses in classes that cannot be told apart, if the best of all explains."""
    all_of_them = (*_likelier(file, found), *starts)
    worth = [h for h in all_of_them if h.is_possible and h.log_odds > WEIGHTS.said]
    count = len({n for h in worth for n, _ in h.after})
    worth.sort(
        key=lambda h: WEIGHTS.values * count * log(h.gain) + log_odds_before(h.mistakes),
        reverse=True,
    )
    classes: list[list[Hypothesis]] = []
    for h in worth:
        if classes and (
            file.log_odds(classes[0][0], h) > WEIGHTS.refuted
            # The best with something more says nothing more.
            or classes[0][0].parts < h.parts
        ):
            continue
        if classes and file.log_odds(classes[-1][0], h) < WEIGHTS.said:
            classes[-1].append(h)
        else:
            classes.append([h])
    explain = [[h for h in c if _explains(h, file.residual)] for c in classes]
    return tuple(tuple(c) for c in explain if c) if classes and explain[0] else ()


def _explains(h: Hypothesis, residual: Residual | None) -> bool:
    """True if what is left can be an integrator's error."""
    is_seen = residual is not None and residual.is_shown
    is_mistake = any(m.kind != "output" and m.code != LINEARISED for m in h.mistakes)
    # Each of several explains something where the equations do not show it.
    least = WEIGHTS.mostly**h.count if is_mistake and not is_seen else WEIGHTS.explains
    if h.unexplained is not None or h.relief < least:
        return False
    is_of_motion = all(m.kind != "output" and m.code not in _LINEAR for m in h.mistakes)
    if residual is None or residual.is_blown_up or not is_of_motion:
        return True
    if any(h.understood[key].assumed().name != x for key, x in residual.definitions.items()):
        # The equations were asked in other definitions.
        return True
    return not residual.leaves_force(residual.relief(h.mistakes))


def _explains_mostly(h: Hypothesis, residual: Residual | None) -> bool:
    """True if a further cause can only be beside this one, and small beside one of the output."""
    is_small = max(h.after.values(), default=1.0) < WEIGHTS.little
    is_large = h.is_possible and h.relief > WEIGHTS.mostly and _explains(h, residual)
    return is_large and (is_small or any(m.kind == "model" for m in h.mistakes))
