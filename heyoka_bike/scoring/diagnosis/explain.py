"""Why a result differs: which force is missing, which mistake explains the file.

First the file's own motion is put into the exact equations (`residual`): what remains says which
mistakes of the model, which parameters and which forces can be the cause, without any simulation.
The likeliest are then simulated, with mistakes of the start and of what is written, which leave
nothing in the equations, and the file is compared with each motion as it is with the reference.
Where a file does not show its motion (columns are missing, rows are few) all mistakes of the
library are simulated. All are compared in one way, by their odds (`evidence`).
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import log

from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS, Hypothesis, log_odds_before, log_ratio
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, Mistake, in_order
from heyoka_bike.scoring.diagnosis.mistakes.linearised import CODE as LINEARISED
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS, has_constant_speed
from heyoka_bike.scoring.diagnosis.programs.program import clock_mistake
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.residual.causes import Cause, Causes, log_odds
from heyoka_bike.scoring.diagnosis.residual.methods import CLOCK
from heyoka_bike.scoring.diagnosis.residual.observed import upright
from heyoka_bike.scoring.diagnosis.seen_file import SeenFile
from heyoka_bike.scoring.report import Curve

__all__ = ["Diagnosis", "Hypothesis", "explain"]

# The best single mistakes, which are tried with those of start and output.
_LEADERS = 3
# Single mistakes that are tried with these where the file does not show its motion.
_RIVALS = 12
# Causes that are simulated, of each kind.
_SIMULATED = 6
# ... where the equations speak for none clearly.
_MOST = 20
# ... and of those whose values whole runs find.
_REFINED = 2
# The equations do not exclude mistakes that leave at most twice as much of them.
_HIDDEN = 0.5

_LINEAR = {m.code for m in LINEAR_PROGRAMS}
_OF_MODEL = [
    *(m for m in MISTAKES if m.kind == "model" and m.code not in _LINEAR),
    *EQUATION_MISTAKES,
]
_OF_START = [m for m in MISTAKES if m.kind == "start"]
_OF_OUTPUT = [m for m in MISTAKES if m.kind == "output"]

Progress = Callable[[float], None]
"""Called with the part of the work that is done, 0 to 1."""


@dataclass(frozen=True, eq=False, slots=True)
class Diagnosis:
    """The causes that explain a file.

    Attributes
    ----------
    classes : tuple of tuple of Hypothesis
        Ranked; hypotheses of a class cannot be told apart. Empty if nothing explains it.
    tried
        Number of hypotheses tried.
    causes : Causes or None
        What the equations of motion say of the file's own motion; None where it does not show it.
    curves : tuple of Curve
        What the best of all leaves, in the column of each maneuver that it explains best.
    units : mapping of str to str
        Units that columns have if the best of all is true, where they seem to have others beside
        the correct motion.
    """

    classes: tuple[tuple[Hypothesis, ...], ...]
    tried: int
    causes: Causes | None = None
    curves: tuple[Curve, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)


def explain(
    parts: Sequence[Part], reference: Reference, *, simulator: Simulator | None = None,
    progress: Progress = lambda _: None,
) -> Diagnosis:  # fmt: skip
    """Find the mistakes, alone and in pairs, and the parameters and forces that explain a file."""
    parts = [upright(part, understand(parts)) for part in parts]
    file = SeenFile(parts, reference, simulator or Simulator())
    progress(0.1)
    causes = file.causes(_OF_MODEL)
    progress(0.3)
    proposed = _of_causes(causes, file) if causes else []
    found = _alone(file, causes, proposed)
    progress(0.6)
    found += _together(file, causes, proposed, found, has_constant_speed(parts))
    progress(0.9)
    classes = _compared(file, found, causes)
    if not classes and causes is not None and not causes.methods:
        # The start leaves nothing in the equations.
        classes = _compared(file, [*found, *_of_start(file, causes)], causes)
    progress(1.0)
    return Diagnosis(
        classes=classes,
        tried=file.tried + (len(_OF_MODEL) if causes else 0),
        causes=causes,
        curves=file.curves(classes[0][0]) if classes else (),
        units=file.units_beside(classes[0][0]) if classes else {},
    )


def _alone(
    file: SeenFile, causes: Causes | None, proposed: Sequence[tuple[Mistake, ...]]
) -> list[Hypothesis]:
    """Single mistakes, as many as there is reason to simulate."""
    of_model = [m for mistakes in proposed for m in mistakes]
    if causes is None or causes.is_blown_up:
        of_model += _OF_MODEL
    else:
        # Whole runs show more than rows that are noisy or few, and small terms far better.
        best = causes.best_of(_OF_MODEL)[:_MOST]
        of_model += [m for m in best if not causes.is_shown or causes.relief((m,)) > _HIDDEN]
    found = file.judged([(m,) for m in of_model])
    if not any(h.leaves_nothing for h in found):
        starts = file.starts_like_its_own(_OF_START, causes.motions if causes else ())
        others = (*starts, *LINEAR_PROGRAMS, *_OF_OUTPUT, *file.order_beside(), *_clock(causes))
        found += file.judged([(m,) for m in others])
    return found


def _together(
    file: SeenFile,
    causes: Causes | None,
    proposed: Sequence[tuple[Mistake, ...]],
    found: Sequence[Hypothesis],
    has_one_speed: bool,
) -> list[Hypothesis]:
    """Pairs that are likelier than each of their mistakes alone.

    The best mistakes are tried with those of the output, the very best with those of the start; and
    where the equations do not tell which mistakes of the model there are, with these.
    """
    asked = [mistakes for mistakes in proposed if len(mistakes) > 1]
    ranked = sorted((h for h in found if h.gain > 1.0), key=lambda h: -h.log_odds)
    for leader in _leaders(ranked, has_one_speed):
        (first,) = leader.mistakes
        others = [*_OF_OUTPUT, *file.order_beside(leader)]
        if leader is ranked[0]:
            others += file.starts_like_its_own(_OF_START, causes.motions if causes else ())
        if leader is ranked[0] and first.kind == "output":
            others += [h.mistakes[0] for h in found if h.mistakes[0].kind == "model"]
        elif causes is None or causes.is_blown_up or not causes.is_shown:
            others += [h.mistakes[0] for h in ranked[:_RIVALS]]
        asked += _with_others(first, others)
    alone = {h.mistakes[0].code: h for h in found}

    def is_likelier(pair: Hypothesis) -> bool:
        each = [alone[c] for c in pair.codes if c in alone]
        return all(_log_odds(file, pair, one) > WEIGHTS.said for one in each)

    return [*filter(is_likelier, file.judged(asked))]


def _leaders(ranked: Sequence[Hypothesis], has_one_speed: bool) -> list[Hypothesis]:
    """The best mistakes; where the speed is constant, what linear programs have in common, too."""
    leaders = [] if ranked and ranked[0].leaves_nothing else [*ranked[:_LEADERS]]
    if leaders and has_one_speed:
        leaders += [h for h in ranked[_LEADERS:] if h.codes == (LINEARISED,)]
    return leaders


def _with_others(first: Mistake, others: Iterable[Mistake]) -> list[tuple[Mistake, ...]]:
    """Pairs of a mistake with others, of which only one may be of the initial conditions."""
    kinds = {"start"}
    return [in_order((first, m)) for m in others if m != first and {m.kind, first.kind} != kinds]


def _of_start(file: SeenFile, causes: Causes) -> list[Hypothesis]:
    """Starts to which the file's rows lead back: that of each maneuver must be likely by itself."""
    starts = file.shooting(causes.motions).refined(file.other_starts(causes.motions))
    found = file.judged([c.made(causes.program) for c in starts])
    found = [h for h in found if h.is_possible and h.log_odds > WEIGHTS.said]
    return file.judged([tuple(m for h in found for m in h.mistakes)]) or found


def _of_causes(causes: Causes, file: SeenFile) -> list[tuple[Mistake, ...]]:
    """Programs that the equations of motion speak for."""
    count = len(causes.motions)
    odds = [log_odds(c, count) for c in (*causes.known, *causes.fitted)]
    least = max([0.0, *(x - WEIGHTS.refuted for x in odds)])

    def likely(several: Iterable[Cause]) -> list[Cause]:
        return sorted(
            (c for c in several if log_odds(c, count) > least), key=lambda c: -log_odds(c, count)
        )[:_SIMULATED]

    fitted = likely(causes.fitted)[:_REFINED]
    if all(len(c.changes) > 1 for c in fitted):
        fitted += [c for c in causes.fitted if len(c.changes) == 1][:1]
    if not causes.is_open:
        # Where a force is left no values are those of the file.
        fitted = file.shooting(causes.motions).refined(fitted, with_others=True)
    return [c.made(causes.program) for c in (*likely(causes.known), *fitted)]


def _clock(causes: Causes | None) -> list[Mistake]:
    """Times on another scale, if they explain what remains of the equations."""
    scales = [m.step for m in (causes.methods if causes else ()) if m.says == CLOCK]
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


def _log_odds(file: SeenFile, one: Hypothesis, other: Hypothesis) -> float:
    """Logarithm of the odds of one hypothesis against another."""
    seen = log_ratio(other.after, one.after, file.where_they_differ(one, other))
    return seen + log_odds_before(one.mistakes) - log_odds_before(other.mistakes)


def _compared(
    file: SeenFile, found: Sequence[Hypothesis], causes: Causes | None
) -> tuple[tuple[Hypothesis, ...], ...]:
    """Rank likely hypotheses in classes that cannot be told apart, if the best of all explains."""
    worth = [h for h in found if h.is_possible and h.log_odds > WEIGHTS.said]
    count = len({n for h in worth for n, _ in h.after})
    worth.sort(
        key=lambda h: WEIGHTS.values * count * log(h.gain) + log_odds_before(h.mistakes),
        reverse=True,
    )
    classes: list[list[Hypothesis]] = []
    for h in worth:
        if classes and (
            _log_odds(file, classes[0][0], h) > WEIGHTS.refuted
            # The best with something more says nothing more.
            or classes[0][0].parts < h.parts
        ):
            continue
        if classes and _log_odds(file, classes[-1][0], h) < WEIGHTS.said:
            classes[-1].append(h)
        else:
            classes.append([h])
    explain = [[h for h in c if _explains(h, causes)] for c in classes]
    return tuple(tuple(c) for c in explain if c) if classes and explain[0] else ()


def _explains(h: Hypothesis, causes: Causes | None) -> bool:
    """True if what is left can be an integrator's error."""
    if h.unexplained is not None or h.relief < WEIGHTS.explains:
        return False
    is_of_motion = all(m.kind != "output" and m.code not in _LINEAR for m in h.mistakes)
    if causes is None or causes.is_blown_up or not is_of_motion:
        return True
    return not causes.leaves_force(causes.relief(h.mistakes))
