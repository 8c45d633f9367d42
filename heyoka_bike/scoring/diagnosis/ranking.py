"""Why a result differs: the mistakes whose simulation explains the file.

A hypothesis is a program that makes one or two of the usual `mistakes`. Its motion is simulated,
and the file is compared with that motion as it is with the reference, with the definitions, signs
and units that then fit best. The *gain* of a hypothesis is the geometric mean, over maneuvers and
columns, of the factor by which the typical error (see `definitions`) falls from the correct
program to it: the likelihood ratio if the size of what remains, an unknown smooth error of
the integrator and the digits written, is unknown in each column. Motions are compared through their
difference from the simulated correct one, so that the simulation's own error cancels.

The *relief* is the same mean over the columns that the mistakes change at all: a wrong rate alone
changes two of eight. Hypotheses are ranked by their gain; those that the columns in which they
differ tell apart by less than a factor of 2 form a class.

Every mistake is tried alone; then the best one with all others, of the other pairs those that
`pairs` finds promising, and the best pair with one of the two replaced. If nothing explains a
motion that is clearly wrong, equations are tried that lack a term or have a force more: these take
seconds to compile.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

from heyoka_bike.errors import DatasetError, MissingPackageError
from heyoka_bike.reference.load import Reference
from heyoka_bike.reference.sensitivities import Sensitivities
from heyoka_bike.scoring.alignment import HALF, Part
from heyoka_bike.scoring.diagnosis.mistakes.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, Mistake
from heyoka_bike.scoring.diagnosis.mistakes.linearised import CODE as LINEARISED
from heyoka_bike.scoring.diagnosis.mistakes.linearised import has_constant_speed
from heyoka_bike.scoring.diagnosis.mistakes.search import ROUNDOFF, Search
from heyoka_bike.scoring.diagnosis.programs.applied import FORCES
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.programs.stepping import Stepping
from heyoka_bike.scoring.diagnosis.unknowns import estimation
from heyoka_bike.scoring.diagnosis.unknowns.estimation import Estimate, Fit, Place, Unknown
from heyoka_bike.scoring.diagnosis.unknowns.fitting import Fitting
from heyoka_bike.scoring.report import Curve

__all__ = ["Diagnosis", "Hypothesis", "rank"]

# The same factor that tells definitions apart.
_TOLD_APART = 2.0
# The product over the maneuvers of the relief that is worth a claim: 2 for each of three, 8 for one
# alone. Errors of correct programs resemble some mistake by up to 7 in one maneuver.
_CLAIMED = 2.0**3
# What leaves more than a fifth is a direction, no explanation.
_MOSTLY = 5.0
# The same for what a second mistake explains beyond the first: two always fit a little better.
_SECOND = 3.0**3
# What leaves more than this part of the columns off by half their scale explains no file.
_STRANGE = 0.25
# A number that is fitted fits something always; up to 7 in the errors of correct programs.
_FITTED = 10.0
# A mistake that is made leaves no column much farther off than if it were not.
_WORSE = 2.0
# What leaves so many times more than the best where the two differ is not less likely, but refuted.
_REFUTED = 100.0
# The best single mistakes, which are tried with others whatever superposition says.
_LEADERS = 3
# ... if they explain anything: two rates of eight columns that get better by a factor of 1.5.
_LEADING = 1.1
# Single mistakes that are tried in the place of either of the best pair.
_RIVALS = 12
# Hypotheses that are simulated together, at least.
_TOGETHER = 16
# A fit of parameters must explain so many times more than the best class to come first.
_FURTHER = 3.0
# No combination of parameters explains so much by chance; nor does a class: no fit is needed.
_EXPLAINED = 100.0
# Fits after which the definitions of the columns are looked at again.
_UNDERSTOOD = 2
# Typical error of roll or steer, in scales, for which other equations are tried.
_SHOWN = 0.01

Progress = Callable[[float], None]
"""Called with the part of the work that is done, 0 to 1."""


@dataclass(frozen=True, eq=False, slots=True)
class Diagnosis:
    """What explains a file.

    Attributes
    ----------
    classes : tuple of tuple of Hypothesis
        Ranked; hypotheses of a class cannot be told apart. Empty if nothing explains it.
    towards : tuple of Hypothesis
        Where nothing explains it: the class that goes farthest that way, but leaves more than an
        integrator does.
    tried, untried
        How many hypotheses were tried; how many that might explain it were not, without heyoka.
    estimate : Estimate or None
        What changed parameters or starts explain; its fits explain far more than any class. None
        where the set has no sensitivities, or a class leaves nothing worth a fit.
    unexplained : (int, str) or None
        Maneuver and column in which the best fit leaves more than an integrator does.
    energy_level : float or None
        Change of the file's own energy, see `remainder.energy_level`.
    values : mapping of Unknown to float
        Of the unknowns of the fits, in the correct program [SI].
    curves : tuple of Curve
        What the best of all leaves, in the column of each maneuver that it explains best.
    units : mapping of str to str
        Units that columns have if the best of all is true, where they seem to have others beside
        the correct motion.
    """

    classes: tuple[tuple[Hypothesis, ...], ...]
    towards: tuple[Hypothesis, ...]
    tried: int
    untried: int = 0
    estimate: Estimate | None = None
    unexplained: Place | None = None
    energy_level: float | None = None
    values: Mapping[Unknown, float] = field(default_factory=dict)
    curves: tuple[Curve, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)


def rank(
    parts: Sequence[Part], reference: Reference, *, simulator: Simulator | None = None,
    progress: Progress = lambda _: None,
) -> Diagnosis:  # fmt: skip
    """Search the mistakes, alone and in pairs, and the parameters that explain a file.

    Without heyoka neither equations that lack a term nor forces are tried, and changes of
    parameters to first order only.
    """
    if simulator is None:
        try:
            simulator = Simulator()
        except MissingPackageError:
            simulator = Stepping()
    sensitivities = None
    with suppress(DatasetError):
        sensitivities = reference.sensitivities
    search = Search(parts, reference, simulator)
    together = max(_TOGETHER, simulator.lanes // len(parts))
    singles: list[Hypothesis] = []
    mistakes = [*MISTAKES, *search.proposals()]
    for i, mistake in enumerate(mistakes):
        if i % together == 0:
            search.prepare((m,) for m in mistakes[i : i + together])
        if search.is_new((mistake,)):
            singles.append(search.judge((mistake,)))
        progress(0.5 * (i + 1) / len(mistakes))
    ranked = sorted(singles, key=lambda h: -h.gain)
    is_enough = search.is_enough(ranked[0])
    leaders = [h for h in ranked[:_LEADERS] if h.gain > _LEADING]
    for leader in leaders:
        order = search.order_beside(leader)
        if order is not None and (order.code,) not in {h.codes for h in singles}:
            singles.append(search.judge((order,)))
    # What linear programs have in common, whatever else is wrong with them.
    linear = [h for h in singles if h.codes == (LINEARISED,) and has_constant_speed(parts)]
    chosen = [] if is_enough else _beside(leaders, singles, [*leaders[:1], *linear])
    chosen += [] if is_enough else search.promising_pairs(singles)
    pairs: list[Hypothesis] = []
    for i, pair in enumerate(chosen):
        if i % together == 0:
            search.prepare(chosen[i : i + together])
        if search.is_new(pair):
            pairs.append(search.judge(pair))
        progress(0.5 + 0.35 * (i + 1) / len(chosen))
    best = max([*singles, *pairs], key=lambda h: h.gain)
    near = _with_one_replaced(best, ranked[:_RIVALS], mistakes)
    search.prepare(near)
    pairs += [search.judge(pair) for pair in near if search.is_new(pair)]
    classes, towards = _classes(search, singles, pairs)
    # A term that is left out of the equations shows; what is as right as this has them all.
    if simulator.is_quick and not classes and search.largest > _SHOWN:
        search.prepare((mistake,) for mistake in EQUATION_MISTAKES)
        singles += [search.judge((mistake,)) for mistake in EQUATION_MISTAKES]
        classes, towards = _classes(search, singles, pairs)
    found = Diagnosis(
        classes=classes,
        towards=towards,
        tried=len(singles) + len(pairs),
        untried=0 if classes or simulator.is_quick else len(EQUATION_MISTAKES),
        energy_level=search.energy_level,
        curves=search.curves(classes[0][0]) if classes else (),
        units=search.units_beside(classes[0][0]) if classes else {},
    )
    if sensitivities is None or (classes and classes[0][0].gain > _EXPLAINED):
        return found
    estimated = _with_estimate(found, search, sensitivities, simulator)
    if (
        simulator.is_quick
        and search.largest > _SHOWN
        and not estimated.classes
        and not _is_fitted(estimated)
    ):
        forced = _with_estimate(found, search, sensitivities, simulator, has_forces=True)
        return forced if _is_fitted(forced) else estimated
    return estimated


def _is_fitted(found: Diagnosis) -> bool:
    """Whether unknowns explain the file, with forces that do not drive what should be braked."""
    fits = found.estimate.fits if found.estimate else ()
    return (
        bool(fits)
        and found.unexplained is None
        and all(change > 0.0 for (name, _), change in fits[0].changes.items() if name in FORCES)
    )


def _with_estimate(
    found: Diagnosis, search: Search, sensitivities: Sensitivities, simulator: Simulator,
    *, has_forces: bool = False,
) -> Diagnosis:  # fmt: skip
    """The same with the parameters that explain far more, and forces that are applied."""
    rival = next((c[0].gain for c in (*found.classes, found.towards) if c), None)
    fitting, unexplained = search.fitting(), None
    units: Mapping[str, str] = {}
    for _ in range(_UNDERSTOOD):
        errors = fitting.errors if simulator.is_quick else None
        problem = fitting.problem(sensitivities, errors if has_forces else None)

        def is_enough(fit: Fit, fitting: Fitting = fitting) -> bool:
            return simulator.is_quick and search.is_kept(fitting.columns(fit.changes))

        worth = _FURTHER * rival if rival else 1.0
        estimate = estimation.estimate(problem, errors, worth, is_enough)
        if not estimate.fits:
            return replace(found, estimate=estimate)
        best = estimate.fits[0]
        if not simulator.is_quick:
            left = estimation.left_by(problem, errors, best)
            unexplained = search.too_large(estimation.in_scales(problem, left))
            break
        # Beside the correct motion the file may have seemed to have other definitions.
        understood, unexplained = search.understood_beside(fitting.columns(best.changes))
        units = search.other_units(understood)
        names = {key: u.column.name for key, u in understood.items()}
        if names == fitting.names:
            break
        fitting = search.fitting(understood)
    if unexplained is not None and found.classes:
        return replace(found, estimate=replace(estimate, fits=()))
    return replace(
        found,
        classes=tuple(c for c in found.classes if _REFUTED * c[0].gain > best.gain),
        towards=(),
        estimate=estimate,
        unexplained=unexplained,
        values={u: fitting.value(u) for fit in estimate.fits for u in fit.changes},
        curves=() if unexplained else fitting.curves(problem, errors, best),
        units=units,
    )


def _beside(
    leaders: Sequence[Hypothesis], singles: Sequence[Hypothesis], best: Sequence[Hypothesis]
) -> list[tuple[Mistake, ...]]:
    """The best mistakes with every other one, the next best with those that need no new motion."""
    place = {h.codes: i for i, h in enumerate(singles)}
    found = []
    widely = {h.codes for h in best}
    for leader in {h.codes: h for h in (*best, *leaders)}.values():
        for h in singles:
            if h is not leader and (leader.codes in widely or h.mistakes[0].kind == "output"):
                first, second = sorted((leader, h), key=lambda x: place[x.codes])
                found.append((*first.mistakes, *second.mistakes))
    return found


def _with_one_replaced(
    best: Hypothesis, rivals: Sequence[Hypothesis], order: Sequence[Mistake]
) -> list[tuple[Mistake, ...]]:
    """Pairs that differ from the best one in one mistake; none if that is not a pair."""
    if len(best.mistakes) == 1:
        return []
    place = {m.code: i for i, m in enumerate(order)}
    pairs = [
        (kept, *rival.mistakes)
        for kept in best.mistakes
        for rival in rivals
        if rival.codes[0] not in best.codes
    ]
    return [tuple(sorted(pair, key=lambda m: place.get(m.code, len(order)))) for pair in pairs]


def _classes(
    search: Search, singles: Sequence[Hypothesis], pairs: Sequence[Hypothesis]
) -> tuple[tuple[tuple[Hypothesis, ...], ...], tuple[Hypothesis, ...]]:
    """What is worth claiming, ranked, in classes that cannot be told apart; or the best other one.

    That is the class that improves the file the most where none explains it.
    """
    alone = {h.mistakes[0].code: h for h in singles}

    def improves(h: Hypothesis) -> bool:
        maneuvers = len({number for number, _ in h.after})
        return (
            h.contradicted is None
            and h.relief**maneuvers > _CLAIMED
            and h.gain > 1.0
            and (h.relief > _FITTED or not any(m.is_fitted for m in h.mistakes))
            and all(
                h.after[k] < _WORSE * max(h.before[k], ROUNDOFF) for k in h.after if k in h.before
            )
            and sum(x > HALF for x in h.after.values()) <= _STRANGE * len(h.after)
        )

    def needs_both(h: Hypothesis) -> bool:
        maneuvers = len({number for number, _ in h.after})
        return all(search.advantage(h, alone[c]) ** maneuvers > _SECOND for c in h.codes)

    worth = [h for h in singles if improves(h)]
    worth += [h for h in pairs if improves(h) and needs_both(h)]
    worth.sort(key=lambda h: -h.gain)
    classes = _ranked(search, worth)
    explain = tuple(
        tuple(h for h in c if h.unexplained is None and h.relief > _MOSTLY) for c in classes
    )
    if classes and not explain[0]:
        return (), classes[0]
    return tuple(c for c in explain if c), ()


def _ranked(search: Search, worth: Sequence[Hypothesis]) -> tuple[tuple[Hypothesis, ...], ...]:
    """Classes of what is sorted by gain, without what the best refutes."""
    classes: list[list[Hypothesis]] = []
    for h in worth:
        if classes and search.advantage(classes[0][0], h) > _REFUTED:
            continue
        if classes and search.advantage(classes[-1][0], h) < _TOLD_APART:
            classes[-1].append(h)
        else:
            classes.append([h])
    return tuple(tuple(c) for c in classes)
