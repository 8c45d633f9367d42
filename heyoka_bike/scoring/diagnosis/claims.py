"""Tests whether a cause explains a file: whether the remaining error can be an integrator's."""

from collections.abc import Sequence

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import OF_TENSORS
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS, LINEARISED_CODE
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, Place
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, WITHOUT_POTENTIAL
from heyoka_bike.scoring.diagnosis.programs.program import Cause
from heyoka_bike.scoring.diagnosis.residual.residual import Residual, Visibility, shows_equations
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.judge.own_definitions import FAR_WORSE
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY

LINEAR = frozenset(m.code for m in LINEAR_PROGRAMS)
"""Codes of the programs with linear equations."""


def explains(h: Hypothesis, residual: Residual | None) -> bool:
    """True if an integrator may cause the error that remains with a cause."""
    # A simulated integration method needs no stronger evidence, because it has no fitted value: the
    # distance of the rows determines its step.
    is_mistake = any(
        m.kind not in ("output", "method") and m.code != LINEARISED_CODE for m in h.mistakes
    )
    is_hidden = is_mistake and not shows_equations(residual)
    # A cause that the residual of the equations does not show must reduce the error by the factor
    # `BY_FAR`; n such causes must reduce it by this factor to the power of n.
    least = BY_FAR**h.count if is_hidden else THRESHOLDS.explained_factor
    if h.unexplained is not None or h.relief < least:
        return False
    if h.count > 1 and any(x.name in FORCES for x in h.found) and left_over(h, residual):
        # Several fitted values that include a force may fit an error that has a different cause.
        # Reject them if an error remains.
        return False
    is_of_motion = all(m.kind != "output" and m.code not in LINEAR for m in h.mistakes)
    if residual is None or residual.visibility is Visibility.NOTHING or not is_of_motion:
        return True
    if any(h.understood[key].assumed().name != x for key, x in residual.definitions.items()):
        # The residual was computed with other definitions of the columns, so it cannot refute this
        # hypothesis.
        return True
    return not residual.leaves_force([residual.judged(*h.mistakes)])


def explains_mostly(h: Hypothesis, residual: Residual | None) -> bool:
    """True if a cause explains so much that no other single cause can replace it.

    It explains much of the error. A cause that is not in the model must also leave only a small
    error. So must linear equations: their motion resembles that of the nonlinear ones with the same
    mistake.
    """
    is_small = max(h.after.values(), default=1.0) < TOLERANCE
    is_large = h.is_possible and h.relief > BY_FAR and explains(h, residual)
    is_nonlinear = any(m.kind == "model" and m.code not in LINEAR for m in h.mistakes)
    return is_large and (is_small or is_nonlinear)


def ends_search(h: Hypothesis, residual: Residual | None) -> bool:
    """True if a cause is good enough to end the search for single causes."""
    return h.is_exhaustive or explains_mostly(h, residual)


def above_digits(h: Hypothesis) -> dict[Place, float]:
    """Return the typical errors (in scales) above the digits that remain with a cause."""
    has_energy = has_usual_energy(h.mistakes)
    return {
        k: x
        for k, x in h.after.items()
        if x > max(THRESHOLDS.negligible_error, MAX_ROUNDING_FLOORS * h.floors.get(k, 0.0))
        and (has_energy or not k[1].endswith("_energy"))
    }


def has_usual_energy(mistakes: Sequence[Cause]) -> bool:
    """True unless programs with these mistakes compute the energies in different ways.

    They do if forces store energy, and if a rotor replaces the wheel's own inertia.
    """
    forces = {x.name for m in mistakes for x in m.found if x.name in FORCES}
    return forces <= WITHOUT_POTENTIAL and OF_TENSORS.isdisjoint(m.code for m in mistakes)


def left_over(h: Hypothesis, residual: Residual | None) -> Place | None:
    """Return a column with an error that neither digits nor an integrator can cause.

    None if there is no such column: then the cause is all that is wrong. A column is returned if

    - it has a large error, and the cause does not change it;
    - the cause explains little of all errors, or of the error of one column of a maneuver;
    - it is visible in a plot, and values were fitted to a file that does not show its equations: a
      value fitted to few columns explains a part of any error;
    - its error is far larger than those of the other columns of the motion, which an integrator
      causes, or than all errors of another maneuver;
    - the equations have a residual that no integrator makes.
    """
    above = above_digits(h)
    if not above:
        return None
    worst = max(above, key=above.__getitem__)
    untouched = {k: x for k, x in above.items() if k not in h.changed and x > TOLERANCE}
    if untouched:
        return max(untouched, key=untouched.__getitem__)
    is_fitted_blindly = bool(h.found) and not shows_equations(residual)
    if h.relief < BY_FAR or (is_fitted_blindly and above[worst] > TOLERANCE):
        return worst
    # A cause that reduces the total error may still explain hardly any of the error of some column,
    # for example in another maneuver.
    unexplained = {k: x for k, x in above.items() if x > TOLERANCE and h.before[k] < CLEARLY * x}
    if unexplained:
        return max(unexplained, key=unexplained.__getitem__)
    if residual is not None and residual.leaves_more(h.mistakes):
        return worst
    by_maneuver = grouped((n, x) for (n, key), x in h.after.items() if key in LATERAL)
    least = min(map(max, by_maneuver.values()), default=1.0)
    if above[worst] > max(FAR_WORSE * max(least, THRESHOLDS.negligible_error), TOLERANCE):
        return worst
    others = [x for (_, key), x in h.after.items() if key in LATERAL and key != worst[1]]
    # Roll and steer columns of the same motion may have very different relative errors. So the
    # error of such a column must exceed the others by a larger factor.
    times = FAR_WORSE if worst[1] in LATERAL else CLEARLY
    is_alone = bool(others) and above[worst] > times * max(*others, THRESHOLDS.negligible_error)
    return worst if is_alone else None
