"""What a cause may claim: whether what it leaves can be an integrator's error."""

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import OF_TENSORS
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS, LINEARISED_CODE
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, Place
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, WITHOUT_POTENTIAL
from heyoka_bike.scoring.diagnosis.residual.residual import Residual, Visibility, shows_equations
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, TOLERANCE
from heyoka_bike.scoring.judge.own_definitions import FAR_WORSE
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY

LINEAR = frozenset(m.code for m in LINEAR_PROGRAMS)
"""Codes of programs of the linear equations."""


def explains(h: Hypothesis, residual: Residual | None) -> bool:
    """True if what is left can be an integrator's error."""
    # A method that is run has no value that is fitted: rows tell its step.
    is_mistake = any(
        m.kind not in ("output", "method") and m.code != LINEARISED_CODE for m in h.mistakes
    )
    is_hidden = is_mistake and not shows_equations(residual)
    # Each of several explains something where the equations do not show it.
    least = BY_FAR**h.count if is_hidden else THRESHOLDS.explains
    if h.unexplained is not None or h.relief < least:
        return False
    if h.count > 1 and any(x.name in FORCES for x in h.found) and left_over(h, residual):
        # Several values with a force among them can share an error that none of them causes.
        return False
    is_of_motion = all(m.kind != "output" and m.code not in LINEAR for m in h.mistakes)
    if residual is None or residual.visibility is Visibility.NOTHING or not is_of_motion:
        return True
    if any(h.understood[key].assumed().name != x for key, x in residual.definitions.items()):
        # The equations were asked in other definitions.
        return True
    return not residual.leaves_force(residual.relief(h.mistakes))


def explains_mostly(h: Hypothesis, residual: Residual | None) -> bool:
    """True if a further cause can only be beside this one, and small beside one of the output."""
    is_small = max(h.after.values(), default=1.0) < TOLERANCE
    is_large = h.is_possible and h.relief > BY_FAR and explains(h, residual)
    return is_large and (is_small or any(m.kind == "model" for m in h.mistakes))


def ends_search(h: Hypothesis, residual: Residual | None) -> bool:
    """True if no single cause that is tried later could take its place."""
    return h.is_exhaustive or explains_mostly(h, residual)


def above_digits(h: Hypothesis) -> dict[Place, float]:
    """What a cause leaves beyond digits: typical errors in scales, where they are more."""
    # Programs do not agree on the energy of forces that store some, nor on that of a rotor in the
    # place of their own.
    stores = any(x.name in FORCES and x.name not in WITHOUT_POTENTIAL for x in h.found)
    has_energy = not stores and OF_TENSORS.isdisjoint(h.codes)
    return {
        k: x
        for k, x in h.after.items()
        if x > max(THRESHOLDS.negligible_error, MAX_ROUNDING_FLOORS * h.floors.get(k, 0.0))
        and (has_energy or not k[1].endswith("_energy"))
    }


def left_over(h: Hypothesis, residual: Residual | None) -> Place | None:
    """Return a column in which a cause leaves what neither digits nor an integrator do.

    Much is left in a column that the cause does not touch; or little is explained, of all or of one
    column of a maneuver; or far more is left than in the other columns of the motion, whose errors
    an integrator makes; or the equations leave what no integrator does. None if there is no such
    column: the cause is all that is wrong.
    """
    above = above_digits(h)
    if not above:
        return None
    worst = max(above, key=above.__getitem__)
    untouched = {k: x for k, x in above.items() if k not in h.changed and x > TOLERANCE}
    if untouched:
        return max(untouched, key=untouched.__getitem__)
    if h.relief < BY_FAR:
        return worst
    # In another maneuver, say, it explains next to nothing.
    unexplained = {k: x for k, x in above.items() if x > TOLERANCE and h.before[k] < CLEARLY * x}
    if unexplained:
        return max(unexplained, key=unexplained.__getitem__)
    if residual is not None and residual.leaves_more(h.mistakes):
        return worst
    others = [x for (_, key), x in h.after.items() if key in LATERAL and key != worst[1]]
    # Columns of roll and steer of one motion may be off by parts of their scales that differ, too.
    times = FAR_WORSE if worst[1] in LATERAL else CLEARLY
    is_alone = bool(others) and above[worst] > times * max(*others, THRESHOLDS.negligible_error)
    return worst if is_alone else None
