"""Rates: whether a rate is the derivative of the file's angle, even if both are wrong.

The reference's rate is the derivative of its angle, so it suffices to compare the errors, which are
small and smooth: over a step, the increase of the angle's error should be the integral of the
rate's error.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from heyoka_bike.bicycle.columns import DERIVATIVES
from heyoka_bike.numbers.double import median
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.scoring.evidence.contradictions import RateContradiction
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import AS_GOOD
from heyoka_bike.scoring.recognition import FASTEST_MODE
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore

RATES = ("roll_rate", "steer_rate")


def rates_contradicted(report: Report) -> Iterator[RateContradiction]:
    """Yield rates that visibly differ from the derivatives of the file's angles."""
    for key in RATES:
        off = {
            m.maneuver: x
            for m in report.maneuvers
            if key in m.consistency.contradicted
            and (x := getattr(m.consistency, key))
            > TOLERANCE * float(abs(m[key].trace.reference).max())
        }
        if off:
            worst = max(off, key=off.__getitem__)
            yield RateContradiction(tuple(off), key, off[worst], worst)


def from_derivative(
    reference: ReferenceManeuver, columns: Mapping[str, ColumnScore], key: str
) -> tuple[float | None, bool]:
    """Return the rms difference of a rate from the angle's derivative, and whether it is wrong.

    The difference [rad/s] is None if the file does not show it. The rate is wrong if the difference
    is larger than rounding, and at least twice as large as the derivative of the angle's error. The
    integral over a step is taken by the trapezoidal rule.
    """
    if key not in columns:
        return None, False
    rate = columns[key]
    pair = DERIVATIVES.get((key, rate.as_understood.definition))
    angle = columns.get(pair[0]) if pair else None
    if pair is None or angle is None or angle.as_understood.definition != pair[1]:
        return None, False
    t = rate.trace.time
    step = np.diff(t)
    usual = float(median(step)) if len(step) else 0.0
    # Rows that are far apart do not show the derivative.
    if not 0.0 < usual <= FASTEST_MODE:
        return None, False
    # Leave out repeated times and the tiny steps at events.
    near = (step > usual / 10) & (step <= FASTEST_MODE)
    if not near.any():
        return None, False
    with np.errstate(over="ignore"):
        slope = np.diff(angle.trace.error)[near] / step[near]
    if not np.isfinite(slope).all():
        return None, False
    mean = (rate.trace.error[1:] + rate.trace.error[:-1])[near] / 2
    found = rms(slope - mean)
    if _distance_left_open(reference, rate, angle) > found / 2:
        return None, False
    rounding = 2**0.5 * (angle.floor or 0.0) / usual + (rate.floor or 0.0)
    # An integrator's error changes the rate and the angle in the same way, so the rate's error
    # differs little from the slope of the angle's error. If the rate is a finite difference of the
    # angle, its error does not appear in the angle.
    return found, found > max(MAX_ROUNDING_FLOORS * rounding, AS_GOOD * rms(slope))


def _distance_left_open(
    reference: ReferenceManeuver, rate: ColumnScore, angle: ColumnScore
) -> float:
    """Return the largest rms difference between definitions that the rate may have [rad/s]."""
    names = {c.definition: c.name for c in reference.definitions[rate.key]}
    angles = {(angle.key, other) for other in angle.indistinguishable}
    meant = list(rate.indistinguishable)
    # A dataset may contain the column of an angle without the column of its rate.
    meant += [d for (_, d), of in DERIVATIVES.items() if of in angles and d in names]
    own = names[rate.as_understood.definition]
    rows = reference.approximate(reference.time, [own, *(names[d] for d in meant)])
    return max((rms(rows[names[other]] - rows[own]) for other in meant), default=0.0)
