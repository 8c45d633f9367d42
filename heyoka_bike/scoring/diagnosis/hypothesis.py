"""Hypotheses: causes that may explain a file, and the errors that they leave."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, log
from typing import TYPE_CHECKING

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MANEUVERS, MISTAKES
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, Place, fall, log_ratio
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, OF_THE_STATE, is_plausible
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, TOLERANCE
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY

if TYPE_CHECKING:
    from heyoka_bike.numbers.double import Array
    from heyoka_bike.scoring.definitions import Understandings
    from heyoka_bike.scoring.diagnosis.programs.program import Cause, FittedValue


KNOWN = log(len(MISTAKES) + len(EQUATION_MISTAKES))
UNKNOWN = log(len(PARAMETERS) + sum(f.is_fitted for f in FORCES.values()) + len(OF_THE_STATE))
OF_START = log(len(START) * MANEUVERS)
"""Logarithms of the prior odds against a mistake of the library, a parameter or force, and an
initial value. Each is the logarithm of their number: of mistakes, unknowns, or initial values."""


def log_odds_before(mistakes: Collection[Cause]) -> float:
    """Return the logarithm of the prior odds for some mistakes against none."""
    limits, cost = THRESHOLDS, 0.0
    for m in mistakes:
        one = OF_START if m.kind == "start" else UNKNOWN
        # A term that is missing as a whole is as likely as a mistake of the library.
        known = max(len(m.found), 1) - m.fitted
        cost += (limits.value_cost + one) * m.fitted + KNOWN * known
    return -cost - limits.further_cause_cost * max(len(mistakes) - 1, 0)


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """Causes that may explain a file, with the errors that they leave.

    Attributes
    ----------
    mistakes : tuple of Cause
        Empty for the correct program.
    before, after : mapping of (int, str) to float
        Typical error at each place, relative to the correct program and to this one, over the same
        rows; in scales of the column, or relative to the accelerations.
    changed : tuple of (int, str)
        The places at which this program differs from the correct one.
    floors : mapping of (int, str) to float
        Resolution limits, in scales.
    reaches_the_end
        True if the simulated motion covers at least half of the file's rows.
    expected : sequence of mapping of str to ndarray
        For each part of the file, the columns that this program writes, at the compared rows.
    understood : mapping of str to Understanding
        The definitions of the file's columns that fit this program best.
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
    def found(self) -> tuple[FittedValue, ...]:
        """The fitted values; empty if one of the causes is not a fitted value."""
        each = [m.found for m in self.mistakes]
        return tuple(x for found in each for x in found) if all(each) else ()

    @property
    def count(self) -> int:
        """Largest number of causes that act in one maneuver; initial values act in only one."""
        starts = Counter(x.maneuver for x in self.found if x.maneuver is not None)
        others = sum(max(len(m.found), 1) for m in self.mistakes) - starts.total()
        return max(starts.values(), default=0) + others

    @property
    def parts(self) -> frozenset[str]:
        """Codes of the mistakes, and names of the fitted values."""
        each = ([x.name for x in m.found] or [m.code] for m in self.mistakes)
        return frozenset(name for names in each for name in names)

    @property
    def gain(self) -> float:
        """Factor by which the typical error falls: geometric mean over maneuvers and columns."""
        return exp(fall(self.before, self.after, self.before))

    @property
    def relief(self) -> float:
        """Factor by which the typical error falls in the columns that the mistakes change."""
        return exp(fall(self.before, self.after, self.changed))

    @property
    def log_odds(self) -> float:
        """Log odds of this hypothesis against "none of the known causes"."""
        plausible = all(is_plausible(x.name, x.value) for x in self.found)
        if not self.reaches_the_end or not self.changed or not plausible:
            return float("-inf")
        # In a file of few rows, the number of independent values is the number of rows minus two:
        # the first row is given, and one value sets the size of the error.
        rows = [len(next(iter(columns.values()))) - 2 for columns in self.expected]
        share = min(1.0, max(rows, default=1000) / THRESHOLDS.independent_values)
        seen = share * log_ratio(self.before, self.after, self.changed)
        return seen + log_odds_before(self.mistakes)

    @property
    def is_possible(self) -> bool:
        """True if nothing in the file contradicts this hypothesis.

        It reduces the typical error, makes no column clearly worse, and leaves only a few columns
        far off.
        """
        floor = ROUNDING
        return (
            self.gain > 1.0
            and all(
                self.after[k] < AS_GOOD * max(self.before[k], floor, self.floors.get(k, 0.0))
                for k in self.before
            )
            and sum(x > MEANINGLESS_ERROR for x in self.after.values())
            <= THRESHOLDS.max_far_off * len(self.after)
        )

    @property
    def unexplained(self) -> Place | None:
        """A column that mistakes of the output should correct but do not; None if there is none.

        A column that they change must not remain much farther off than the motion. If a column that
        they do not change is wrong, they must explain far more of those that they change.
        """
        if any(m.kind != "output" for m in self.mistakes):
            return None
        others = {k: x for k, x in self.after.items() if k not in self.changed}
        worst = max(others, key=others.__getitem__, default=None)
        if worst is not None and others[worst] > TOLERANCE and self.relief < BY_FAR:
            return worst
        lateral = max([x for (_, key), x in self.after.items() if key in LATERAL], default=0.0)
        limit = CLEARLY * max(lateral, THRESHOLDS.negligible_error)
        # A mistake of the output explains nothing if, even before its correction, the columns that
        # it changes are much less wrong than roll and steer.
        if self.changed and CLEARLY * max(self.before[k] for k in self.changed) < lateral:
            return self.changed[0]
        for k in self.changed:
            is_large = self.after[k] > max(limit, MAX_ROUNDING_FLOORS * self.floors.get(k, 0.0))
            if k[1] not in LATERAL and is_large and self.before[k] < BY_FAR * self.after[k]:
                return k
        return None

    @property
    def is_exhaustive(self) -> bool:
        """True if the remaining errors are negligible, so no further cause could explain more."""
        return bool(self.after) and all(
            x <= max(THRESHOLDS.negligible_error, MAX_ROUNDING_FLOORS * self.floors.get(k, 0.0))
            for k, x in self.after.items()
        )
