"""The scores of a result file, for each column and each maneuver: numbers and names only."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, log10
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from heyoka_bike.bicycle.aliases import key_of
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.display import Displayed, IdentityMapping
from heyoka_bike.errors import unknown_word
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring import grades
from heyoka_bike.scoring.evidence.base import MAX_LOG10_ODDS, Odds
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.ratios import ODDS_CLAIMED

if TYPE_CHECKING:
    from heyoka_bike.scoring.alignment import Part


@dataclass(frozen=True, slots=True)
class Measures:
    """Measures of a column's error; None where nothing could be compared.

    Formulas and sources are in docs/measures.md.

    Attributes
    ----------
    max_abs_error
        Largest absolute error over the rows [SI unit of the column].
    time_of_max
        Time of the largest error [s].
    rms_error
        Root of the mean squared error of the rows [SI unit].
    max_rel_error
        Largest absolute error divided by the column's scale, the largest absolute value of the
        reference over its whole run.
    scd
        Significant correct digits, -log10 of `max_rel_error`, at most 32.
    mescd
        Mixed-error significant correct digits, -log10 max abs(e) / (1 + abs(reference)) in SI
        units, at most 32.
    time_to_tolerance
        First time at which the error exceeds 1e-3 of the scale [s]; None if it never does.
    """

    max_abs_error: float | None
    time_of_max: float | None
    rms_error: float | None
    max_rel_error: float | None
    scd: float | None
    mescd: float | None
    time_to_tolerance: float | None


@dataclass(frozen=True, slots=True)
class Reading:
    """One interpretation of a written column, and its errors.

    Attributes
    ----------
    definition
        The definition of the quantity with which the column is compared.
    sign
        1, or -1 if the sign is flipped.
    unit
        Unit of the written values.
    offset
        Constant by which the written values exceed the definition, in the SI unit of the column.
    measures : Measures
    """

    definition: str
    sign: int
    unit: str
    offset: float
    measures: Measures


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another definition of a column, and the largest error under it.

    Attributes
    ----------
    definition
    max_abs_error
        Largest absolute error [SI unit].
    log10_odds
        Odds of the chosen definition against this one, over all maneuvers of the file together, as
        a decimal logarithm. They are below zero if this one is likelier, but not likely enough to
        give up the default. None if unknown.
    """

    definition: str
    max_abs_error: float | None
    log10_odds: float | None = None


@dataclass(frozen=True, slots=True)
class Growth:
    """Largest error in one part of the run.

    Attributes
    ----------
    t_start, t_end
        The part of the run [s].
    max_abs_error
        Largest absolute error [SI unit]; None without rows in this part.
    """

    t_start: float
    t_end: float
    max_abs_error: float | None


@dataclass(frozen=True, eq=False, slots=True)
class Trace:
    """A column over time in SI units, in its best interpretation; for rules and figures.

    Attributes
    ----------
    time, value, error : ndarray, shape (n,)
        Rows with a finite value only; the error is exact to a few digits even where it is far
        below the last digit of the value.
    """

    time: Array
    value: Array
    error: Array

    @property
    def reference(self) -> Array:
        """The exact values in these rows, in binary64."""
        return self.value - self.error


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class ColumnScore:
    """Score of one column of one maneuver: ``column.scd``, ``column.max_abs_error``.

    Its measures are those of `as_understood`.

    Attributes
    ----------
    key
        Name of the column (``roll_angle``).
    unit
        SI unit of all errors, UDUNITS spelling.
    as_written : Reading
        The column read in the default definition in SI units, with the default sign and zero.
    as_understood : Reading
        The column read in the definition, sign, unit and offset that fit best.
    floor
        The resolution limit [SI unit]: the largest error of correctly rounded values; None if
        unknown.
    alternatives : tuple of Alternative
        The other definitions, with the same sign, unit and offset.
    indistinguishable : tuple of str
        Definitions that fit as well, so none of them is claimed.
    growth : tuple of Growth
        Largest error in each tenth of the reference's run.
    values, missing
        Number of values that were compared, and of values that are not finite.
    trace : Trace
    scale
        Largest absolute value of the reference over its whole run [SI unit].
    unexplained
        Largest part of an error that rounding to the digits of its row does not explain [SI unit].
    resolution
        Largest error of a value rounded to the digits of its row [SI unit]; larger than the floor
        if rows have different numbers of digits.
    is_contradicted
        True if no choice of axes gives the signs of this and other columns.
    none_odds
        Odds of the definition against any unknown one, as a decimal logarithm, see `definitions`;
        None if the column has only one definition.
    """

    key: str
    unit: str
    as_written: Reading
    as_understood: Reading
    floor: float | None
    alternatives: tuple[Alternative, ...]
    indistinguishable: tuple[str, ...]
    growth: tuple[Growth, ...]
    values: int
    missing: int
    trace: Trace
    scale: float
    unexplained: float
    resolution: float
    is_contradicted: bool = False
    none_odds: float | None = None

    @property
    def is_known(self) -> bool:
        """True if the odds of the definition against an unknown one are at least 20 to 1.

        Otherwise, the column is compared with the nearest definition.
        """
        return self.none_odds is None or self.none_odds >= log10(ODDS_CLAIMED)

    @property
    def definition(self) -> str:
        """The definition that fits the column best."""
        return self.as_understood.definition

    @property
    def scd(self) -> float | None:
        """Significant correct digits, see `Measures`."""
        return self.as_understood.measures.scd

    @property
    def mescd(self) -> float | None:
        """Mixed-error significant correct digits, see `Measures`."""
        return self.as_understood.measures.mescd

    @property
    def max_abs_error(self) -> float | None:
        """Largest absolute error [SI unit]."""
        return self.as_understood.measures.max_abs_error

    @property
    def time_of_max(self) -> float | None:
        """Time of the largest absolute error [s]."""
        return self.as_understood.measures.time_of_max

    @property
    def rms_error(self) -> float | None:
        """Root of the mean squared error [SI unit]."""
        return self.as_understood.measures.rms_error

    @property
    def max_rel_error(self) -> float | None:
        """Largest absolute error divided by the column's scale."""
        return self.as_understood.measures.max_rel_error

    @property
    def error(self) -> float:
        """Largest error divided by the column's scale; 0 if nothing was compared."""
        return self.max_rel_error or 0.0

    @property
    def hidden(self) -> float:
        """Largest error that rounding to the digits written explains [SI unit]; 0 if unknown."""
        return grades.MAX_ROUNDING_FLOORS * (self.floor or 0.0)

    @property
    def is_hidden(self) -> bool:
        """True if rounding to the digits written explains the largest error."""
        return self.is_at_floor(grades.MAX_ROUNDING_FLOORS)

    @property
    def time_to_tolerance(self) -> float | None:
        """First time at which the error exceeds 1e-3 of the scale [s]; None if it never does."""
        return self.as_understood.measures.time_to_tolerance

    @property
    def grade(self) -> Grade:
        """The grade: right, undecided, close or wrong, see `grades.grade`."""
        return grades.grade(
            self.max_abs_error,
            unexplained=self.unexplained,
            resolution=self.resolution,
            scale=self.scale,
            is_contradicted=self.is_contradicted,
        )

    @property
    def is_right(self) -> bool:
        """True if the column has six correct digits, and is written with as many."""
        return self.grade == Grade.RIGHT

    def shown(self, metric: str) -> float | None:
        """Return a measure, limited to the best value that the digits written can show."""
        found: float | None = getattr(self.as_understood.measures, metric)
        least = self.resolution
        if metric == "time_to_tolerance":
            found = inf if found is None else found
            return 0.0 if least > grades.TOLERANCE * self.scale else found
        if found is None or metric == "rms_error":
            return found
        if metric in ("scd", "mescd"):
            size = self.scale if metric == "scd" else 1.0 + self.scale
            return min(found, grades.digits_of(least, size))
        return max(found, least / (self.scale or inf) if metric == "max_rel_error" else least)

    def __repr__(self) -> str:
        if self.scd is None:
            return f"<{self.key}: nothing compared>"
        shown = grades.digits_text(self.scd)
        found = f"{shown} correct digits, largest error {self.max_abs_error:.2g} {self.unit}"
        return f"<{self.key} ({self.definition}): {found}>"

    def is_at_floor(self, times: float = 1.0) -> bool:
        """True if the error is at most this many times the resolution limit."""
        error = self.as_understood.measures.max_abs_error
        return error is not None and self.floor is not None and error <= times * self.floor


def odds_of(c: ColumnScore) -> Odds | None:
    """Return the odds of a column's definition against the likeliest other one; None if unknown.

    Definitions that the file cannot distinguish from it do not count. An unknown definition counts
    if it is the likeliest and the odds against it are below a million to one.
    """
    told = [
        (a.log10_odds, a.definition)
        for a in c.alternatives
        if a.log10_odds is not None and a.definition not in c.indistinguishable
    ]
    if not told:
        return None
    sure, definition = min(told)
    if c.none_odds is not None and c.none_odds < min(sure, MAX_LOG10_ODDS):
        return Odds(c.none_odds, None)
    return Odds(sure, definition)


def also_open(columns: Sequence[ColumnScore]) -> tuple[str, ...]:
    """Return the names of the other definitions that remain possible in any maneuver."""
    names = dict.fromkeys(name for c in columns for name in c.indistinguishable)
    return tuple(name for name in names if name != columns[0].definition)


@dataclass(frozen=True, slots=True)
class Consistency:
    """Consistency of the file's columns with each other; None where the columns do not show it.

    Attributes
    ----------
    energy_sum
        Largest abs(potential + kinetic - mechanical energy) [J].
    energy_sum_floor
        The part of this difference that rounding of the written values explains [J].
    roll_rate, steer_rate
        Difference of the rate from the derivative of the file's angle, root mean square over the
        steps [rad/s]. None if the rate's definition is not the derivative of the angle's.
    contradicted
        Rates that are not the derivatives of the file's angles: the difference is larger than
        rounding, and at least twice as large as the derivative of the angle's error.
    """

    energy_sum: float | None
    energy_sum_floor: float | None
    roll_rate: float | None
    steer_rate: float | None
    contradicted: tuple[str, ...] = ()


class Worst(NamedTuple):
    """The column with the fewest correct digits.

    Attributes
    ----------
    maneuver
        Number of the maneuver.
    column
        Key of the column.
    scd
        Correct digits of the column.
    """

    maneuver: int
    column: str
    scd: float


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class ManeuverScore(Displayed, IdentityMapping[str, ColumnScore]):
    """Score of one maneuver: ``maneuver["roll_angle"]`` is the score of one of its columns.

    Attributes
    ----------
    maneuver
        Number from 1.
    name
    rows
        Number of rows that were compared.
    t_start, t_end
        First and last time with a value in every column [s].
    coverage
        Fraction of the reference's run covered by such rows. Two of them cover the time between
        them if they are no farther apart than `Reference.most_apart`. 0 without such rows.
    gap
        The longest time in the run without such a row [s].
    step
        Median distance of the rows [s]; None for a single row.
    performance
        Eq. (1) of the benchmark, 100 (max E - min E) / E0 [%], with the file's own mechanical
        energy E above the floor and its first value E0; None for fewer than two rows, or if E0 = 0.
    performance_limit
        The benchmark's limit on eq. (1) [%]; None for maneuvers that it does not judge.
    consistency : Consistency
    columns : tuple of ColumnScore
        The columns of the file, in the order of `columns.COMPARED`.
    part : Part
        The rows that were compared, as written.
    meets_limit
        True if the maneuver passes the benchmark's limit on eq. (1), see `verdict.claim`; None
        without a limit or an energy.
    """

    maneuver: int
    name: str
    rows: int
    t_start: float
    t_end: float
    coverage: float
    gap: float
    step: float | None
    performance: float | None
    performance_limit: float | None
    consistency: Consistency
    columns: tuple[ColumnScore, ...]
    part: Part
    meets_limit: bool | None = None

    _view: ClassVar[str] = "maneuver"

    def __getitem__(self, key: str) -> ColumnScore:
        for column in self.columns:
            if column.key == key:
                return column
        # Also accept the names that files use for columns, such as roll or phi.
        meant = key_of(str(key))
        if meant is not None and meant != key and meant in list(self):
            return self[meant]
        raise KeyError(unknown_word(str(key), list(self), "column "))

    def __iter__(self) -> Iterator[str]:
        return (column.key for column in self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def compared(self) -> tuple[ColumnScore, ...]:
        """The columns with compared values."""
        return tuple(c for c in self.columns if c.values)

    @property
    def column_count(self) -> int:
        """Number of the benchmark's eight columns that have compared values."""
        return sum(c.key in BENCHMARK_COLUMNS for c in self.compared)

    @property
    def worst(self) -> Worst | None:
        """The column with the fewest correct digits; None if nothing was compared."""
        found = (Worst(self.maneuver, c.key, c.scd) for c in self.columns if c.scd is not None)
        return min(found, key=lambda w: w.scd, default=None)


Place = tuple[ManeuverScore, ColumnScore]
"""A maneuver, and one of its columns."""
