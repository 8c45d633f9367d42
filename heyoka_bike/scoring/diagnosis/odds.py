"""Odds of causes: one likelihood for causes of every kind.

What a cause leaves of a file's error is an error of unknown size: that of an integrator, and the
digits written. If it may have any size (a prior of 1 / size), and is worth n independent values in
each maneuver, the likelihood of a cause is size^-n there, and the odds of two causes are

    product over the maneuvers of (what one leaves / what the other leaves)^n,

each a geometric mean over the columns in which the two differ, times the odds before the file is
looked at: "none of these" is the likeliest before, one of the many mistakes of the library less so,
and each value that is fitted costs more, as it always explains something. The same holds for what
is left of the equations of motion along the file's own motion: there the equations take the place
of the columns.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import log

Place = tuple[int, str]
"""A maneuver's number, and a column's key or the name of an equation."""

TINY = 1e-16
"""Errors below this part of a scale are as good as zero: a thousandth of roundoff."""


@dataclass(frozen=True, slots=True)
class Thresholds:
    """Thresholds, limits and prior odds of the diagnosis, each with its experiment.

    Attributes
    ----------
    values
        Independent values in the error of a maneuver. Errors of correct programs resemble some
        mistake of the library by up to a factor of 7 in one maneuver: odds of 400 to 1, as often as
        one of some hundred mistakes should.
    fitted
        Logarithm of the odds against a value that is fitted being where it is found, to some 1e-5
        of its range: one value of a start explains errors of correct programs by up to 9, three by
        30.
    further
        The same against there being a further cause.
    report_log_odds
        Logarithm of the odds from which a cause is said, and from which two are told apart.
    drop_log_odds
        ... and from which one is not even said to be less likely.
    explains
        By so much the error must fall: what leaves more is a direction, no explanation.
    nearly
        By so much it must fall for a direction to be named: of a fork 1 cm to the side the term to
        first order leaves a hundredth; of tyres 2 cm wide, which no force explains, the best one
        leaves an eighth.
    max_far_off
        What leaves more than this part of the columns off by half their scale explains no file.
    negligible_error
        What is left below this part needs no other cause.
    max_answers
        Causes, or classes of them that cannot be told apart, that are worth a sentence; single
        causes that are tried with others by whole runs; and values that are found together.
    max_pairs
        Pairs of mistakes of the library that are simulated, and mistakes of the start: one that is
        made comes far nearer to the file's own start, but for what follows within the first rows.
        Of values that are found, so many are refined, half as many pairs, and a third of triples.
    max_simulated
        Mistakes of the library that are simulated where the equations do not speak against them.
    refined
        Fitted values that the equations speak for, and that are found by whole runs.
    rivals
        Causes that are tried together: of each one with each of the library in the equations, and
        of the very best by whole runs where the file does not show its motion; and sets of unknowns
        that are tried with one more.
    min_pair_gain
        Two mistakes that explain so many times more than each of them are compared: whole runs
        tell more of a small one beside a large one.
    promise
        To first order a large change explains little: this power of its relief is hoped for, of
        accelerations, and of whole runs, whose first quarter counts by itself.
    force_ratio
        The best cause leaves of the equations so many times what the rates are off from the slopes
        of the angles where a force is missing: in files of correct programs up to 152 (IDA, which
        solves for the rates), in those of engines that slip and yield up to 662.
    shows
        The equations are judged where what remains is so many times what is uncertain, or that is
        less than such a part of the accelerations.
    sure
        A value of the start is another one if it is off by so many times what the rows disagree.
    """

    values: float = 6.0
    fitted: float = 10.8
    further: float = log(100.0)
    report_log_odds: float = log(1000.0)
    drop_log_odds: float = log(1e9)
    explains: float = 5.0
    nearly: float = 30.0
    max_far_off: float = 0.25
    negligible_error: float = 1e-8
    max_answers: int = 3
    max_pairs: int = 6
    max_simulated: int = 20
    refined: int = 2
    rivals: int = 12
    min_pair_gain: float = 1.05
    promise: tuple[float, float] = (4.0, 2.0)
    force_ratio: float = 1000.0
    shows: tuple[float, float] = (30.0, 1e-5)
    sure: float = 3.0


THRESHOLDS = Thresholds()


def log_ratio(
    one: Mapping[Place, float], other: Mapping[Place, float], places: Collection[Place]
) -> float:
    """Logarithm of the odds of two explanations by what each leaves, where they differ."""
    found = 0.0
    for number in {n for n, _ in places}:
        found += fall(one, other, [k for k in places if k[0] == number])
    return THRESHOLDS.values * found


def fall(
    one: Mapping[Place, float], other: Mapping[Place, float], places: Collection[Place]
) -> float:
    """Mean logarithm of the factor from one explanation's errors to the other's."""
    tiny = TINY
    logs = [log(max(one[k], tiny) / max(other[k], tiny)) for k in places]
    return sum(logs) / len(logs) if logs else 0.0
