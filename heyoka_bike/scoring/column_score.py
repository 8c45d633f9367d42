"""Verdict on one column: how far it is from the reference, and how it was understood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, inf, log10

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring import verdict
from heyoka_bike.scoring.verdict import Grade

# Decimal logarithm of the odds that are put into words: nobody has tried more files than that.
_SUREST = 6
_CLAIMED = 20.0


@dataclass(frozen=True, slots=True)
class Measures:
    """Distances of a column from the reference; None where nothing could be compared.

    Formulas and sources are in docs/measures.md.

    Attributes
    ----------
    max_abs_error
        Largest absolute error over the rows [SI unit of the column].
    time_of_max
        When it occurs [s].
    rms_error
        Root of the mean squared error of the rows [SI unit].
    max_rel_error
        Largest absolute error divided by the column's scale, the largest absolute value of the
        reference over its whole run.
    scd
        Significant correct digits, -log10 of the former, at most 32.
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
    """One way to take a written column, and the errors that follow.

    Attributes
    ----------
    definition
        Which definition of the quantity it is compared with.
    sign
        1, or -1 if the written values have the other sign.
    unit
        Unit of the written values.
    offset
        What the written values have too much, in the SI unit of the column.
    measures : Measures
    """

    definition: str
    sign: int
    unit: str
    offset: float
    measures: Measures


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another definition of a column, and how far the file is from it.

    Attributes
    ----------
    definition
    max_abs_error
        [SI unit]
    log10_odds
        Odds of the definition that the column turned out to have against this one, over all
        maneuvers of the file together, as a decimal logarithm; below zero if this one is likelier,
        but not enough to give up the default. None where nothing tells.
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
        The part [s].
    max_abs_error
        [SI unit]; None without rows there.
    """

    t_start: float
    t_end: float
    max_abs_error: float | None


@dataclass(frozen=True, eq=False, slots=True)
class Trace:
    """A column over time, for figures; SI units, as understood.

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
        """The reference, to binary64."""
        return self.value - self.error


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class ColumnScore:
    """Verdict on one column of one maneuver: ``column.scd``, ``column.max_abs_error``.

    Its measures are those as understood.

    Attributes
    ----------
    key
        Name of the column (``roll_angle``).
    unit
        SI unit of all errors, UDUNITS spelling.
    as_written : Reading
        Taken as the default definition in SI units, with the default sign and zero.
    as_understood : Reading
        Taken as the definition, sign, unit and offset that fit.
    floor
        What the digits written allow at best [SI unit]: the largest error of correctly rounded
        values; None if unknown.
    alternatives : tuple of Alternative
        The other definitions, with the same sign, unit and offset.
    indistinguishable : tuple of str
        Definitions that fit as well, so that none is claimed.
    growth : tuple of Growth
        Largest error in each tenth of the reference's run.
    values, missing
        How many values were compared, and how many were not finite.
    trace : Trace
    scale
        Largest value of the reference over its whole run [SI unit].
    unexplained
        Largest error beyond what rounding to the digits of its own row explains [SI unit].
    resolution
        Largest error of a value rounded to the digits of its own row [SI unit]; of rows with
        different digits it is more than the floor.
    is_contradicted
        True if its sign and those of other columns are of no choice of axes.
    none_odds
        Odds of the definition against every one that is not known here, as a decimal logarithm, see
        `definitions`; None of a column with one definition.
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
        """True if the odds of the definition against one that is not known are 20 to 1 or more.

        If they are not, the one that the column is compared with is the nearest.
        """
        return self.none_odds is None or self.none_odds >= log10(_CLAIMED)

    @property
    def definition(self) -> str:
        """The definition that the column turned out to have."""
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
        """When it occurs [s]."""
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
    def time_to_tolerance(self) -> float | None:
        """First time at which the error exceeds 1e-3 of the scale [s]; None if it never does."""
        return self.as_understood.measures.time_to_tolerance

    @property
    def grade(self) -> Grade:
        """Right, not to be told at the digits written, close or wrong, see `verdict.grade`."""
        return verdict.grade(
            self.max_abs_error,
            unexplained=self.unexplained,
            resolution=self.resolution,
            scale=self.scale,
            is_contradicted=self.is_contradicted,
        )

    @property
    def is_right(self) -> bool:
        """True if it has six correct digits, and is written with as many."""
        return self.grade == Grade.RIGHT

    def shown(self, metric: str) -> float | None:
        """A measure as far as the digits written can show it: no better than they are."""
        found: float | None = getattr(self.as_understood.measures, metric)
        least = self.resolution
        if metric == "time_to_tolerance":
            found = inf if found is None else found
            return 0.0 if least > verdict.TOLERANCE * self.scale else found
        if found is None or metric == "rms_error":
            return found
        if metric in ("scd", "mescd"):
            size = self.scale if metric == "scd" else 1.0 + self.scale
            return min(found, verdict.digits_of(least, size))
        return max(found, least / (self.scale or inf) if metric == "max_rel_error" else least)

    def __repr__(self) -> str:
        if self.scd is None:
            return f"<{self.key}: nothing compared>"
        found = f"{self.scd:.1f} correct digits, largest error {self.max_abs_error:.2g} {self.unit}"
        return f"<{self.key} ({self.definition}): {found}>"

    def is_at_floor(self, times: float = 1.0) -> bool:
        """True if the error is no more than so many times what the digits written allow."""
        error = self.as_understood.measures.max_abs_error
        return error is not None and self.floor is not None and error <= times * self.floor


def odds(c: ColumnScore) -> str:
    """Return the odds of a column's definition against the likeliest other one, in words."""
    told = [
        (a.log10_odds, a.definition)
        for a in c.alternatives
        if a.log10_odds is not None and a.definition not in c.indistinguishable
    ]
    if not told:
        return ""
    sure, definition = min(told)
    if c.none_odds is not None and c.none_odds < min(sure, _SUREST):
        return f"{odds_words(c.none_odds)} against one that is not known here"
    return f"{odds_words(sure)} against {definition}"


def open_words(columns: Sequence[ColumnScore]) -> str:
    """Name the other definitions that the maneuvers leave open; empty if there is none."""
    names = dict.fromkeys(name for c in columns for name in c.indistinguishable)
    others = [name for name in names if name != columns[0].definition]
    return f"may also be {' or '.join(others)}" if others else ""


def odds_words(power: float) -> str:
    """Odds of which the decimal logarithm is given, as "300 to 1"."""
    if power > _SUREST:
        return f"over 10^{_SUREST} to 1"
    if power < 0.0:
        return f"1 to {10**-power:.2g}" if power > -_SUREST else f"1 to over 10^{_SUREST}"
    return f"10^{floor(power)} to 1" if power >= 3 else f"{10**power:.0f} to 1"
