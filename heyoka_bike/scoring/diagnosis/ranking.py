"""Why a result differs: which force is missing, which mistake explains the file.

First the file's own motion is put into the exact equations (`residual`): what remains says which
mistakes of the model, which parameters and which forces can be the cause, without any simulation.
These are then simulated, with mistakes of the start and of what is written, which leave nothing in
the equations, and the file is compared with each motion as it is with the reference, with the
definitions, signs and units that then fit best. Where a file does not show its motion (columns are
missing, rows are few) all mistakes of the library are simulated.

The *gain* of a hypothesis is the geometric mean, over maneuvers and columns, of the factor by which
the typical error (see `definitions`) falls from the correct program to it: the likelihood ratio if
the size of what remains, an unknown smooth error of the integrator and the digits written, is
unknown in each column. Motions are compared through their difference from the simulated correct
one, so that the simulation's own error cancels. The *relief* is the same mean over the columns
that the mistakes change at all: a wrong rate alone changes two of eight. Hypotheses are ranked by
their gain; those that the columns in which they differ tell apart by less than a factor of 2 form a
class.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from heyoka_bike.errors import MissingPackageError
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import HALF, Part
from heyoka_bike.scoring.diagnosis.mistakes.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, Mistake, apply, in_order
from heyoka_bike.scoring.diagnosis.mistakes.linearised import CODE as LINEARISED
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS, has_constant_speed
from heyoka_bike.scoring.diagnosis.mistakes.search import ROUNDOFF, Search
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.programs.stepping import Stepping
from heyoka_bike.scoring.diagnosis.residual.causes import Causes
from heyoka_bike.scoring.diagnosis.residual.fitted import other_values
from heyoka_bike.scoring.diagnosis.residual.shooting import FURTHER
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
# The best single mistakes, which are tried with others.
_LEADERS = 3
# ... if they explain anything: two rates of eight columns that get better by a factor of 1.5.
_LEADING = 1.1
# Single mistakes that are tried in the place of either of the best pair.
_RIVALS = 12
# Hypotheses that are simulated together, at least.
_TOGETHER = 16
# Causes that are simulated, of each kind.
_SIMULATED = 6

# Typical error of roll or steer, in scales, for which equations without a term are tried where the
# file does not show its motion: to compile them takes seconds.
_SHOWN = 0.01

_LINEAR = {m.code for m in LINEAR_PROGRAMS}
_OF_MODEL = [m for m in MISTAKES if m.kind == "model" and m.code not in _LINEAR]

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
    tried
        How many hypotheses were tried.
    causes : Causes or None
        What the equations of motion say of the file's own motion; None where it does not show it.
    unsimulated : tuple of Mistake
        What the equations of motion speak for most, if no simulator here has such forces.
    is_quick
        Whether heyoka simulates, so that starts were fitted and terms left out.
    energy_level : float or None
        Change of the file's own energy, see `remainder.energy_level`.
    curves : tuple of Curve
        What the best of all leaves, in the column of each maneuver that it explains best.
    units : mapping of str to str
        Units that columns have if the best of all is true, where they seem to have others beside
        the correct motion.
    """

    classes: tuple[tuple[Hypothesis, ...], ...]
    towards: tuple[Hypothesis, ...]
    tried: int
    causes: Causes | None = None
    unsimulated: tuple[Mistake, ...] = ()
    is_quick: bool = True
    energy_level: float | None = None
    curves: tuple[Curve, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)


def rank(
    parts: Sequence[Part], reference: Reference, *, simulator: Simulator | None = None,
    progress: Progress = lambda _: None,
) -> Diagnosis:  # fmt: skip
    """Find the mistakes, alone and in pairs, and the parameters and forces that explain a file."""
    if simulator is None:
        try:
            simulator = Simulator()
        except MissingPackageError:
            simulator = Stepping()
    tried = _Tried(Search(parts, reference, simulator), progress)
    library = [*_OF_MODEL, *EQUATION_MISTAKES]
    causes = tried.search.causes(library)
    progress(0.2)
    proposed = _of_causes(causes, tried.search) if causes else []
    if causes is None or causes.is_blown_up or not causes.is_shown:
        proposed = [*dict.fromkeys([*proposed, *((m,) for m in _OF_MODEL)])]
    singles = tried.judged(
        [
            *(p for p in proposed if len(p) == 1),
            *((m,) for m in LINEAR_PROGRAMS),
            *((m,) for m in MISTAKES if m.kind != "model"),
            *((m,) for m in tried.search.proposals()),
        ],
        0.6,
    )
    ranked = sorted(singles, key=lambda h: -h.gain)
    leaders = [h for h in ranked[:_LEADERS] if h.gain > _LEADING]
    for leader in leaders:
        order = tried.search.order_beside(leader)
        if order is not None:
            singles += tried.judged([(order,)])
    pairs = tried.judged([p for p in proposed if len(p) > 1])
    if not (ranked and tried.search.is_enough(ranked[0])):
        # What linear programs have in common, whatever else is wrong with them.
        linearised = [h for h in singles if h.codes == (LINEARISED,) and has_constant_speed(parts)]
        of_model = [h for h in singles if h.codes in [tuple(m.code for m in p) for p in proposed]]
        best = max(of_model, key=lambda h: h.gain, default=None)
        widely = [*leaders[:1], *linearised, *([best] if best and causes else [])]
        pairs += tried.judged(_beside(leaders, singles, widely), 0.9)
        if pairs:
            best = max([*singles, *pairs], key=lambda h: h.gain)
            pairs += tried.judged(_with_one_replaced(best, ranked[:_RIVALS]))
    singles = _with_fewest_values(singles)
    classes, towards = _classes(tried.search, singles, pairs)
    if not classes and not causes and tried.search.is_quick and tried.search.largest > _SHOWN:
        singles += tried.judged([(m,) for m in EQUATION_MISTAKES])
        classes, towards = _classes(tried.search, singles, pairs)
    if not classes and causes and tried.search.is_quick:
        start = tried.search.shooting(causes.motions).start()
        if start is not None:
            singles += tried.judged([(start,)])
            classes, towards = _classes(tried.search, singles, pairs)
    progress(1.0)
    return Diagnosis(
        classes=classes,
        towards=towards,
        tried=len(singles) + len(pairs) + (len(library) if causes else 0),
        causes=causes,
        unsimulated=_unsimulated(causes, simulator) if causes and not classes else (),
        is_quick=tried.search.is_quick,
        energy_level=tried.search.energy_level,
        curves=tried.search.curves(classes[0][0]) if classes else (),
        units=tried.search.units_beside(classes[0][0]) if classes else {},
    )


def _with_fewest_values(singles: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Without fits that explain less than three times what fits of fewer values do."""
    gain: dict[int, float] = {}
    for h in singles:
        gain[len(h.found)] = max(gain.get(len(h.found), 0.0), h.gain)
    return [
        h for h in singles if all(h.gain > FURTHER * gain[n] for n in gain if 0 < n < len(h.found))
    ]


def _of_causes(causes: Causes, search: Search) -> list[tuple[Mistake, ...]]:
    """Programs that the equations of motion speak for."""
    known = [c for c in causes.known if c.relief > causes.least]
    fitted = [c for c in causes.fitted if c.relief > causes.least]
    shooting = search.shooting(causes.motions)
    named = [c.mistakes for c in known[:_SIMULATED]]
    found = [shooting.refined(c) if search.is_quick else c for c in fitted[:_SIMULATED]]
    # Each of two mistakes is tried alone, too.
    return [
        *dict.fromkeys((m,) for mistakes in named for m in mistakes),
        *(mistakes for mistakes in named if len(mistakes) > 1),
        *((other_values(c.changes, c.uncertain, causes.program),) for c in found),
    ]


def _unsimulated(causes: Causes, simulator: Simulator) -> tuple[Mistake, ...]:
    """The cause that explains most, if it is a force or a term and these are not simulated."""
    best = max((*causes.known, *causes.fitted), key=lambda c: c.relief, default=None)
    if best is None or simulator.has_forces or best.relief < causes.least:
        return ()
    made = best.mistakes or (other_values(best.changes, best.uncertain, causes.program),)
    return made if apply(causes.program, made).amounts else ()


class _Tried:
    """Hypotheses that are simulated, each once."""

    def __init__(self, search: Search, progress: Progress) -> None:
        self.search = search
        self._progress, self._done = progress, 0.2
        self._together = max(_TOGETHER, search.lanes)

    def judged(
        self, several: Sequence[tuple[Mistake, ...]], done: float | None = None
    ) -> list[Hypothesis]:
        """Those that are new; so much of all work is done then."""
        found = []
        for i, mistakes in enumerate(several):
            if i % self._together == 0:
                self.search.prepare(several[i : i + self._together])
            if self.search.is_new(mistakes):
                found.append(self.search.judge(mistakes))
            if done is not None:
                self._progress(self._done + (done - self._done) * (i + 1) / len(several))
        self._done = done or self._done
        return found


def _beside(
    leaders: Sequence[Hypothesis], singles: Sequence[Hypothesis], best: Sequence[Hypothesis]
) -> list[tuple[Mistake, ...]]:
    """The best mistakes with every other one, the next best with those that need no new motion."""
    widely = {h.codes for h in best}
    return [
        in_order((*leader.mistakes, *h.mistakes))
        for leader in {h.codes: h for h in (*best, *leaders)}.values()
        for h in singles
        if h is not leader and (leader.codes in widely or h.mistakes[0].kind == "output")
    ]


def _with_one_replaced(best: Hypothesis, rivals: Sequence[Hypothesis]) -> list[tuple[Mistake, ...]]:
    """Pairs that differ from the best one in one mistake; none if that is not a pair."""
    if len(best.mistakes) == 1:
        return []
    return [
        in_order((kept, *rival.mistakes))
        for kept in best.mistakes
        for rival in rivals
        if rival.codes[0] not in best.codes
    ]


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
