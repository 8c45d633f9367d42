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

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, log
from typing import TYPE_CHECKING

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.scoring.alignment import HALF
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MANEUVERS, MISTAKES
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, OF_THE_STATE, is_plausible
from heyoka_bike.scoring.grades import FLOORS_OF_ROUNDING, TOLERANCE
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY

if TYPE_CHECKING:
    from heyoka_bike.numbers.double import Array
    from heyoka_bike.scoring.definitions import Understandings
    from heyoka_bike.scoring.diagnosis.programs.program import Cause, Found

Place = tuple[int, str]
"""A maneuver's number, and a column's key or the name of an equation."""


@dataclass(frozen=True, slots=True)
class Weights:
    """Constants of the diagnosis, each with the experiment that gave it.

    Attributes
    ----------
    values
        Independent values in the error of a maneuver. Errors of correct programs resemble some
        mistake of the library by up to a factor of 7 in one maneuver: odds of 400 to 1, as often as
        one of some hundred mistakes should.
    known, unknown, start
        Logarithm of the number of mistakes of the library, of parameters and forces, and of values
        of the starts: as much are the odds against one of them.
    fitted
        The same against a value that is fitted being where it is found, to some 1e-5 of its range:
        one value of a start explains errors of correct programs by up to 9, three by 30.
    further
        The same against there being a further cause.
    said
        Logarithm of the odds from which a cause is said, and from which two are told apart.
    refuted
        ... and from which one is not even said to be less likely.
    explains
        By so much the error must fall: what leaves more is a direction, no explanation.
    nearly
        By so much it must fall for a direction to be named: of a fork 1 cm to the side the term to
        first order leaves a hundredth; of tyres 2 cm wide, which no force explains, the best one
        leaves an eighth.
    strange
        What leaves more than this part of the columns off by half their scale explains no file.
    nothing
        What is left below this part needs no other cause.
    few
        Causes, or classes of them that cannot be told apart, that are worth a sentence; single
        causes that are tried with others by whole runs; and values that are found together.
    some
        Pairs of mistakes of the library that are simulated, and mistakes of the start: one that is
        made comes far nearer to the file's own start, but for what follows within the first rows.
        Of values that are found, so many are refined, half as many pairs, and a third of triples.
    many
        Mistakes of the library that are simulated where the equations do not speak against them.
    refined
        Fitted values that the equations speak for, and that are found by whole runs.
    rivals
        Causes that are tried together: of each one with each of the library in the equations, and
        of the very best by whole runs where the file does not show its motion; and sets of unknowns
        that are tried with one more.
    also
        Two mistakes that explain so many times more than each of them are compared: whole runs
        tell more of a small one beside a large one.
    promise
        To first order a large change explains little: this power of its relief is hoped for, of
        accelerations, and of whole runs, whose first quarter counts by itself.
    above
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
    known: float = log(len(MISTAKES) + len(EQUATION_MISTAKES))
    unknown: float = log(
        len(PARAMETERS) + sum(f.is_fitted for f in FORCES.values()) + len(OF_THE_STATE)
    )
    start: float = log(len(START) * MANEUVERS)
    fitted: float = 10.8
    further: float = log(100.0)
    said: float = log(1000.0)
    refuted: float = log(1e9)
    explains: float = 5.0
    nearly: float = 30.0
    strange: float = 0.25
    nothing: float = 1e-8
    few: int = 3
    some: int = 6
    many: int = 20
    refined: int = 2
    rivals: int = 12
    also: float = 1.05
    promise: tuple[float, float] = (4.0, 2.0)
    above: float = 1000.0
    shows: tuple[float, float] = (30.0, 1e-5)
    sure: float = 3.0


WEIGHTS = Weights()


def log_odds_before(mistakes: Collection[Cause]) -> float:
    """Logarithm of the odds for some mistakes against none, before the file is looked at."""
    w, cost = WEIGHTS, 0.0
    for m in mistakes:
        one = w.start if m.kind == "start" else w.unknown
        cost += (w.fitted + one) * m.fitted if m.fitted else w.known
    return -cost - w.further * max(len(mistakes) - 1, 0)


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """Causes as an explanation of a file, and what they leave of its error.

    Attributes
    ----------
    mistakes : tuple of Cause
        None of them for the correct program.
    before, after : mapping of (int, str) to float
        Typical error at each place, of the correct program and of this one, in scales of the
        column or parts of the accelerations, over the same rows.
    changed : tuple of (int, str)
        Where this program does otherwise than the correct one.
    floors : mapping of (int, str) to float
        Resolution limits, in scales.
    reaches_the_end
        True if the motion goes about as far as the rows of the file do.
    expected : sequence of mapping of str to ndarray
        Of each part of the file, the columns that this program writes, at the rows compared.
    understood : mapping of str to Understanding
        The definitions of the file's columns if this program wrote them.
    """

    mistakes: tuple[Cause, ...]
    before: Mapping[Place, float]
    after: Mapping[Place, float]
    changed: tuple[Place, ...]
    floors: Mapping[Place, float] = field(default_factory=dict)
    reaches_the_end: bool = True
    expected: Sequence[Mapping[str, Array]] = ()
    understood: Understandings = field(default_factory=dict)

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the mistakes."""
        return tuple(m.code for m in self.mistakes)

    @property
    def found(self) -> tuple[Found, ...]:
        """Values that were found in the file, if it is explained by nothing else."""
        each = [m.found for m in self.mistakes]
        return tuple(x for found in each for x in found) if all(each) else ()

    @property
    def count(self) -> int:
        """Number of causes in one maneuver: values of its start, and all others."""
        starts = Counter(x.maneuver for x in self.found if x.maneuver is not None)
        others = sum(max(len(m.found), 1) for m in self.mistakes) - starts.total()
        return max(starts.values(), default=0) + others

    @property
    def parts(self) -> frozenset[str]:
        """The mistakes by their codes, and the values that were found by their names."""
        each = ([x.name for x in m.found] or [m.code] for m in self.mistakes)
        return frozenset(name for names in each for name in names)

    @property
    def gain(self) -> float:
        """Factor by which the typical error falls: geometric mean over maneuvers and columns."""
        return exp(_fall(self.before, self.after, self.before))

    @property
    def relief(self) -> float:
        """Factor by which the typical error falls in the columns that the mistakes change."""
        return exp(_fall(self.before, self.after, self.changed))

    @property
    def log_odds(self) -> float:
        """Logarithm of the odds against "none of these"."""
        plausible = all(is_plausible(x.name, x.value) for x in self.found)
        if not self.reaches_the_end or not self.changed or not plausible:
            return float("-inf")
        # Few rows have fewer independent values: the first is given, one tells the error's size.
        rows = [len(next(iter(columns.values()))) - 2 for columns in self.expected]
        share = min(1.0, max(rows, default=1000) / WEIGHTS.values)
        seen = share * log_ratio(self.before, self.after, self.changed)
        return seen + log_odds_before(self.mistakes)

    @property
    def is_possible(self) -> bool:
        """True if nothing in the file speaks against it."""
        floor = ROUNDING
        return (
            self.gain > 1.0
            and all(
                self.after[k] < AS_GOOD * max(self.before[k], floor, self.floors.get(k, 0.0))
                for k in self.before
            )
            and sum(x > HALF for x in self.after.values()) <= WEIGHTS.strange * len(self.after)
        )

    @property
    def unexplained(self) -> Place | None:
        """A column that mistakes of what is written should make right, and do not.

        It still is much farther off than the motion. Or they do not change it, and it is wrong
        however they are: then they must explain far more of those that they change.
        """
        if any(m.kind != "output" for m in self.mistakes):
            return None
        others = {k: x for k, x in self.after.items() if k not in self.changed}
        worst = max(others, key=others.__getitem__, default=None)
        if worst is not None and others[worst] > TOLERANCE and self.relief < BY_FAR:
            return worst
        lateral = max([x for (_, key), x in self.after.items() if key in LATERAL], default=0.0)
        limit = CLEARLY * max(lateral, WEIGHTS.nothing)
        # ... or was much less so, whatever else is wrong.
        if self.changed and CLEARLY * max(self.before[k] for k in self.changed) < lateral:
            return self.changed[0]
        for k in self.changed:
            is_large = self.after[k] > max(limit, FLOORS_OF_ROUNDING * self.floors.get(k, 0.0))
            if k[1] not in LATERAL and is_large and self.before[k] < BY_FAR * self.after[k]:
                return k
        return None

    @property
    def leaves_nothing(self) -> bool:
        """True if no other cause could explain more."""
        return bool(self.after) and all(
            x <= max(WEIGHTS.nothing, FLOORS_OF_ROUNDING * self.floors.get(k, 0.0))
            for k, x in self.after.items()
        )


def log_ratio(
    one: Mapping[Place, float], other: Mapping[Place, float], places: Collection[Place]
) -> float:
    """Logarithm of the odds of two explanations by what each leaves, where they differ."""
    found = 0.0
    for number in {n for n, _ in places}:
        found += _fall(one, other, [k for k in places if k[0] == number])
    return WEIGHTS.values * found


def _fall(
    one: Mapping[Place, float], other: Mapping[Place, float], places: Collection[Place]
) -> float:
    """Mean logarithm of the factor from one to the other."""
    tiny = ROUNDING * 1e-3
    logs = [log(max(one[k], tiny) / max(other[k], tiny)) for k in places]
    return sum(logs) / len(logs) if logs else 0.0
