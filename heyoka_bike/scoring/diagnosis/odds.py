"""Odds of causes: one likelihood for causes of every kind, and the thresholds of the diagnosis.

A cause leaves a part of a file's error: the error of an integrator, and rounding to the digits
written. The size of this remaining error is unknown. If its prior is 1 / size, and the error has n
independent values in each maneuver, the likelihood of a cause is size^-n there. The odds of one
cause against another are

    product over the maneuvers of (error left by the other / error left by the one)^n,

times their prior odds. Each factor is a geometric mean over the columns in which the two causes
differ. Before the file is examined, "none of these" is the likeliest. A mistake of the library is
less likely, because there are many, and each fitted value costs more, because it always explains
something. The same holds for the residual of the equations along the file's own motion, with
equations instead of columns.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import log

Place = tuple[int, str]
"""Number of a maneuver, and key of a column or name of an equation."""

TINY = 1e-16
"""Smaller errors, relative to the scale, count as zero: a thousandth of the roundoff."""


@dataclass(frozen=True, slots=True)
class Thresholds:
    """Limits and prior odds of the diagnosis, with the experiments behind their values.

    Logarithms are natural.

    Attributes
    ----------
    independent_values
        Number of independent values in the error of a maneuver. In one maneuver the error of a
        correct program resembles some mistake of the library by up to a factor of 7. These are odds
        of 400 to 1, as expected for the best of some hundred mistakes.
    value_cost
        Log odds against a fitted value, which is found to about 1e-5 of its range. One initial
        value explains errors of correct programs by factors up to 9, three by factors up to 30.
    further_cause_cost
        Log odds against a further cause.
    report_log_odds
        Log odds above which a cause is reported, and above which two causes count as
        distinguishable.
    drop_log_odds
        Log odds against a cause, relative to the best, above which it is not listed at all.
    explained_factor
        Factor by which the error must fall for a cause to count as an explanation. Below it, the
        cause is a direction only.
    direction_factor
        Factor by which the residual must fall for a direction to be reported. For a fork 1 cm off
        the plane of symmetry, the first-order term leaves a hundredth. For tyres 2 cm wide, which
        no force explains, the best force leaves an eighth.
    max_far_off
        Largest fraction of the columns that a cause may leave off by over half their scale.
    negligible_error
        Remaining error, relative to the scale, that needs no further cause.
    max_answers
        Number of classes of causes, and of causes in a class, that are reported.
    max_leaders
        Number of single causes that are tried in pairs by whole runs.
    max_values
        Number of values that are fitted together.
    max_pairs
        Number of pairs of mistakes of the library that are judged.
    max_unseen
        Number of single mistakes that are simulated because of the equations if the file does not
        show its motion.
    max_starts
        Number of mistakes of the initial conditions that are simulated. A mistake that was made is
        far nearer to the file's own start than the given one.
    max_subsets
        Number of single values that are refined; half as many pairs, and a third of triples.
    max_simulated
        Number of mistakes of the library that are simulated.
    max_refined
        Number of fits to the equations that are refined by whole runs.
    max_partners
        Number of causes that the best ones are paired with by whole runs if the file does not show
        its motion; and number of subsets of unknowns that are tried with one more.
    min_pair_gain
        Improvement factor over each of its mistakes alone that a pair must reach in the equations.
        It is small, because whole runs show more of a small mistake besides a large one.
    residual_exponent, run_exponent
        Exponent of the gain to first order that gives the gain expected of a large change: in the
        equations, and in whole runs, whose first quarter counts separately.
    force_ratio
        Ratio of the residual that the best cause leaves to the difference between the rates and the
        slopes of the angles, above which a force is missing. Files of correct programs reach 152
        (IDA, which solves for the rates), those of engines that slip and yield 662.
    visible_ratio, visible_fraction
        The equations are judged if the residual is this many times its uncertainty, or if the
        uncertainty is below this fraction of the accelerations.
    start_scatter_factor
        An initial value differs from the given one if it is off by this many times the scatter of
        the rows.
    """

    independent_values: float = 6.0
    value_cost: float = 10.8
    further_cause_cost: float = log(100.0)
    report_log_odds: float = log(1000.0)
    drop_log_odds: float = log(1e9)
    explained_factor: float = 5.0
    direction_factor: float = 30.0
    max_far_off: float = 0.25
    negligible_error: float = 1e-8
    max_answers: int = 3
    max_leaders: int = 3
    max_values: int = 3
    max_pairs: int = 6
    max_unseen: int = 6
    max_starts: int = 6
    max_subsets: int = 6
    max_simulated: int = 20
    max_refined: int = 2
    max_partners: int = 12
    min_pair_gain: float = 1.05
    residual_exponent: float = 4.0
    run_exponent: float = 2.0
    force_ratio: float = 1000.0
    visible_ratio: float = 30.0
    visible_fraction: float = 1e-5
    start_scatter_factor: float = 3.0


THRESHOLDS = Thresholds()


def log_ratio(
    one: Mapping[Place, float], other: Mapping[Place, float], places: Collection[Place]
) -> float:
    """Return the log odds of two explanations, from the errors that they leave at some places."""
    found = 0.0
    for number in {n for n, _ in places}:
        found += fall(one, other, [k for k in places if k[0] == number])
    return THRESHOLDS.independent_values * found


def fall(
    one: Mapping[Place, float], other: Mapping[Place, float], places: Collection[Place]
) -> float:
    """Return the mean logarithm of the ratio of the errors that two explanations leave."""
    tiny = TINY
    logs = [log(max(one[k], tiny) / max(other[k], tiny)) for k in places]
    return sum(logs) / len(logs) if logs else 0.0
