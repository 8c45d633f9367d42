"""Evidence of faults in the output of a motion: wrong times, rows or columns, or clipped values."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from heyoka_bike.bicycle.columns import ANGLE_OF, COMPARED
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import scale_words, short_number, unit_text
from heyoka_bike.scoring.findings import Finding, Severity, maneuvers, named, together, warning
from heyoka_bike.scoring.grades import RIGHT, TOLERANCE
from heyoka_bike.scoring.ratios import CLEARLY, MOST_ROWS

_PART_OF_A_ROW = 0.05
"""Smallest shift, in rows, that the message also states in rows."""


@dataclass(frozen=True, slots=True)
class CoarseGrid(Evidence):
    """All values of a column are multiples of a step that is far coarser than its digits.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    step
        Largest step of the maneuvers [SI unit].
    """

    key: str
    maneuvers: tuple[int, ...]
    step: float

    code = "coarse_grid"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key} of {maneuvers(self.maneuvers)}: every value is a multiple of "
            f"{_in(self.step, COMPARED[self.key][0].unit)}, far coarser than the digits written. "
            "Such a step comes from an encoder, a table or rounding. Errors below it are not judged"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers), "step": self.step}


@dataclass(frozen=True, slots=True)
class HalfPrecision(Evidence):
    """The values of columns are half-precision numbers.

    Attributes
    ----------
    keys
    are_all
        True if all values of the file that vary are half-precision numbers.
    """

    keys: tuple[str, ...]
    are_all: bool

    code = "half_precision"
    severity = Severity.WARNING

    def message(self) -> str:
        which = "All values" if self.are_all else f"The values of {named(self.keys)}"
        return (
            f"{which} are half-precision numbers (11 bits), which have three digits. Store them in "
            "double precision"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class RowsReversed(Evidence):
    """The rows of maneuvers are written from the last to the first."""

    maneuvers: tuple[int, ...]

    code = "rows_reversed"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"The rows of {maneuvers(self.maneuvers)} are in reverse order: the last row is the "
            "start of the motion. Reverse the values or the times"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class SingleRows(Evidence):
    """Single rows of a column do not fit the rows around them.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    rows
        Number of these rows.
    time
        Time of the first one [s].
    is_held
        True if each repeats the value of the row before it.
    """

    key: str
    maneuvers: tuple[int, ...]
    rows: int
    time: float
    is_held: bool

    code = "single_rows"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.rows == 1:
            what = "repeats the row before it" if self.is_held else "does not fit its neighbours"
            said = f"one row {what}, at {self.time:.6g} s"
        else:
            what = "repeat the row before them" if self.is_held else "do not fit their neighbours"
            said = f"{self.rows} single rows {what}, the first at {self.time:.6g} s"
        return (
            f"{self.key} of {maneuvers(self.maneuvers)}: {said}. Check how this column is written "
            "or measured there"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers)}
        return {**where, "rows": self.rows, "time": self.time, "is_held": self.is_held}


@dataclass(frozen=True, slots=True)
class RateOfDifferences(Evidence):
    """A rate column is a ``forward``, ``backward`` or ``central`` difference of its own angle."""

    key: str
    how: str

    code = "rate_of_differences"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key} is the {self.how} difference of {ANGLE_OF[self.key]} in every maneuver, "
            "not the rate of the motion. Write the rate that your program integrates. The other "
            "columns are diagnosed without it"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "how": self.how}


@dataclass(frozen=True, slots=True)
class Mirrored(Evidence):
    """Maneuvers are mirrored: the exact motion after a start with the opposite roll rate.

    Attributes
    ----------
    maneuvers : tuple of int
    """

    maneuvers: tuple[int, ...]

    code = "mirrored"
    severity = Severity.WARNING

    def message(self) -> str:
        is_are = "is" if len(self.maneuvers) == 1 else "are"
        return (
            f"{maneuvers(self.maneuvers).capitalize()} {is_are} the mirror image of the exact "
            "motion: all columns of roll and steer have the opposite sign, as after the opposite "
            "initial roll rate. Check the sign of the initial roll rate there"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class RateOfOtherRow(Evidence):
    """A rate column is the rate of its own angle at an earlier or later row.

    Attributes
    ----------
    key
    rows
        Delay in rows; negative if the rate is early.
    maneuvers : tuple of int
        The maneuvers with this delay; empty if all have it.
    """

    key: str
    rows: float
    maneuvers: tuple[int, ...] = ()

    code = "rate_of_other_row"
    severity = Severity.WARNING

    def message(self) -> str:
        row = "half a row" if abs(self.rows) < 1.0 else "one row"
        where = maneuvers(self.maneuvers) if self.maneuvers else "every maneuver"
        return (
            f"In {where}, each value of {self.key} is the derivative of {ANGLE_OF[self.key]} {row} "
            f"{'earlier' if self.rows > 0.0 else 'later'}. Write both for the same time. The other "
            "columns are diagnosed without this one"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "rows": self.rows, "maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class OtherClock(Evidence):
    """Rows are correct at times that differ from the written ones by a scale and a shift.

    Attributes
    ----------
    maneuver
        The maneuver with these rows; None stands for all maneuvers.
    scale, shift
        Correct time = scale * written time + shift [s].
    rows
        The shift in rows; None if the rows are not evenly spaced.
    keys
        The shifted columns, if others are correct at the written times; otherwise empty.
    """

    maneuver: int | None
    scale: float
    shift: float
    rows: float | None
    keys: tuple[str, ...] = ()

    code = "other_clock"
    severity = Severity.WARNING

    def message(self) -> str:
        scale = f"{self.scale:.7g}"
        if scale == "1" and self.shift:
            way = "later" if self.shift > 0.0 else "earlier"
            rows = self.rows and round(self.rows, 2)
            in_rows = ""
            if rows and abs(self.rows or 0.0) >= _PART_OF_A_ROW:
                in_rows = " (one row)" if abs(rows) == 1 else f" ({abs(rows):g} rows)"
            when = f"each row belongs to a time {abs(self.shift):.6g} s{in_rows} {way}"
            saved = ", and whether a row is saved before or after the step"
        else:
            saved = ""
            sign = "minus" if self.shift < 0.0 else "plus"
            more = f" {sign} {abs(self.shift):.3g} s" if self.shift else ""
            when = f"the correct times are {scale} times those written{more}"
        rows_of, times_of = "The rows", "the times"
        if self.keys:
            rows_of = f"The rows of {', '.join(self.keys)}"
        if self.maneuver is not None:
            rows_of, times_of = (
                f"{rows_of} of maneuver {self.maneuver}",
                f"{times_of} of this maneuver",
            )
        return (
            f"{rows_of} are correct, but not at the times written: {when}. Check how "
            f"{times_of} are written{saved}"
        )

    def numbers(self) -> Mapping[str, Any]:
        numbers = {"scale": self.scale, "shift": self.shift, "rows": self.rows}
        return {"maneuver": self.maneuver, "columns": list(self.keys), **numbers}


@dataclass(frozen=True, slots=True)
class TimesAddedUp(Evidence):
    """The rows are correct at multiples of a step, but the written times drift from the multiples.

    Attributes
    ----------
    step
        The step [s].
    creep
        Largest distance of a written time from its multiple of the step [s].
    is_single
        True if adding up the step in single precision gives the written times.
    """

    step: float
    creep: float
    is_single: bool

    code = "times_added_up"
    severity = Severity.WARNING

    def message(self) -> str:
        how = (
            "as if steps were added up in single precision"
            if self.is_single
            else "as if steps were added up or rounded"
        )
        return (
            f"The rows are correct at multiples of {self.step:g} s, but the written times drift "
            f"away from these by up to {self.creep:.2g} s, {how}. Compute each time as the row "
            "number multiplied by the step"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"step": self.step, "creep": self.creep, "is_single": self.is_single}


@dataclass(frozen=True, slots=True)
class ColumnRatio(Evidence):
    """A column is a factor times the exact values, plus an offset.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    factor, offset
        Written value = factor * exact value + offset [SI unit].
    unit
        The unit with this factor; None if no known unit has it.
    since, until
        The first and the last time of the rows with this factor and offset [s]; None if they begin
        with the first row, or end with the last.
    """

    key: str
    maneuvers: tuple[int, ...]
    factor: float
    offset: float
    unit: str | None
    since: float | None = None
    until: float | None = None

    code = "column_ratio"
    severity = Severity.WARNING

    def message(self) -> str:
        where = f"{self._span()}{self.key} of {maneuvers(self.maneuvers)}"
        if abs(self.factor + 1.0) < RIGHT and not self.offset:
            return f"{where} has the opposite sign. Check how this column is computed and written"
        relation = _scaled(Scaled(self.factor, self.offset), COMPARED[self.key][0].unit)
        unit = f", as if it were in {unit_text(self.unit)}" if self.unit else ""
        return f"{where} is {relation}{unit}. Check how this column is computed and written"

    def _span(self) -> str:
        """Return the beginning of a sentence on some rows; empty if it refers to all rows."""
        if self.since is None:
            return "" if self.until is None else f"Until {self.until:.6g} s, "
        end = "s on" if self.until is None else f"to {self.until:.6g} s"
        return f"From {self.since:.6g} {end}, "

    def numbers(self) -> Mapping[str, Any]:
        numbers = {"factor": self.factor, "offset": self.offset, "unit": self.unit}
        where = {"column": self.key, "maneuvers": list(self.maneuvers)}
        return {**where, **numbers, "since": self.since, "until": self.until}


@dataclass(frozen=True, slots=True)
class OtherColumn(Evidence):
    """A column contains the exact values of another column, in some maneuvers.

    Attributes
    ----------
    key
        Key of the column in the file.
    maneuvers : tuple of int
    other
        Key of the column to which its values belong.
    of_maneuver
        Maneuver of those values; None if it is the same maneuver.
    is_exchanged
        True if the other column contains the exact values of this one, too.
    """

    key: str
    maneuvers: tuple[int, ...]
    other: str
    of_maneuver: int | None = None
    is_exchanged: bool = False

    code = "other_column"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.is_exchanged:
            return (
                f"{self.key} and {self.other} of {maneuvers(self.maneuvers)} are exchanged. Check "
                "the order in which columns are written there"
            )
        of = f" of maneuver {self.of_maneuver}" if self.of_maneuver is not None else ""
        return (
            f"{self.key} of {maneuvers(self.maneuvers)} contains the values of {self.other}{of}. "
            "Check the order in which columns are written there"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers)}
        of = {"other": self.other, "of_maneuver": self.of_maneuver}
        return {**where, **of, "is_exchanged": self.is_exchanged}


def pairs_exchanged(seen: Iterable[Evidence]) -> tuple[Evidence, ...]:
    """Replace two columns that contain the values of each other with one piece of evidence."""
    found: list[Evidence] = []
    for x in seen:
        if isinstance(x, OtherColumn) and x.of_maneuver is None:
            back = OtherColumn(x.other, x.maneuvers, x.key)
            if back in found:
                found[found.index(back)] = replace(back, is_exchanged=True)
                continue
        found.append(x)
    return tuple(found)


def _in_words(key: str) -> str:
    return key.replace("_", " ")


@dataclass(frozen=True, slots=True)
class OtherMoment(Evidence):
    """A column, or a part of the mechanical energy, has the exact values of another moment.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    part
        Key of the part of the sum; None for the column itself.
    delay
        Time by which the values are late [s]; negative if they are early; None if all of them are
        those of the first row.
    rows
        The delay in rows, if it is a whole number of rows.
    """

    key: str
    maneuvers: tuple[int, ...]
    part: str | None
    delay: float | None
    rows: int | None = None

    code = "other_moment"
    severity = Severity.WARNING

    def message(self) -> str:
        where = f"{self.key} of {maneuvers(self.maneuvers)}"
        has = f"contains the {_in_words(self.part)}" if self.part else "has the exact value"
        return (
            f"{where} {has} {self._when()}. Check when it is computed: all values of a row belong "
            "to the same state"
        )

    def _when(self) -> str:
        if self.delay is None:
            return "of the first row in every row"
        way = "before" if self.delay > 0.0 else "after"
        if self.rows is None:
            return f"{abs(self.delay):.4g} s {way} the time of the row"
        return f"of the row {way}" if abs(self.rows) == 1 else f"of {abs(self.rows)} rows {way}"

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers), "part": self.part}
        return {**where, "delay": self.delay, "rows": self.rows}


@dataclass(frozen=True, slots=True)
class PartMultiplied(Evidence):
    """The mechanical energy contains a multiple of one of its parts.

    Attributes
    ----------
    maneuvers : tuple of int
    part
        Key of the part.
    factor
    """

    maneuvers: tuple[int, ...]
    part: str
    factor: float

    code = "part_multiplied"
    severity = Severity.WARNING

    def message(self) -> str:
        times = "lacks" if abs(self.factor) < RIGHT else f"contains {self.factor:.6g} times"
        return (
            f"mechanical_energy of {maneuvers(self.maneuvers)} {times} the {_in_words(self.part)}. "
            "Check how the sum is computed"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": "mechanical_energy", "maneuvers": list(self.maneuvers)}
        return {**where, "part": self.part, "factor": self.factor}


@dataclass(frozen=True, slots=True)
class MisplacedManeuver(Evidence):
    """The columns of a maneuver contain the values of another maneuver.

    Attributes
    ----------
    maneuver
        Number under which the values are written.
    of_maneuver
        Number of the maneuver whose values they are.
    """

    maneuver: int
    of_maneuver: int

    code = "other_maneuver"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"Maneuver {self.maneuver} has the values of maneuver {self.of_maneuver}. Check the "
            "initial speed and roll rate of each maneuver, and the order in which they are written"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "of_maneuver": self.of_maneuver}


@dataclass(frozen=True, slots=True)
class UnsignedColumn(Evidence):
    """A column contains the exact values without their signs, in some maneuvers.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    """

    key: str
    maneuvers: tuple[int, ...]

    code = "unsigned_column"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key} of {maneuvers(self.maneuvers)} has the exact values without their signs. "
            "Look for an absolute value, or the square root of a square, in the code that computes "
            "and writes it"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class ClippedColumn(Evidence):
    """A column is clipped at one or two bounds.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    low, high
        The bounds [SI unit]; None without such a bound.
    is_right_within
        True if all other values are right, and the exact values of the clipped rows exceed the
        bounds.
    """

    key: str
    maneuvers: tuple[int, ...]
    low: float | None
    high: float | None
    is_right_within: bool

    code = "clipped_column"
    severity = Severity.WARNING

    def message(self) -> str:
        unit = COMPARED[self.key][0].unit
        at = " and ".join(_in(x, unit) for x in (self.low, self.high) if x is not None)
        where_else = (
            " where the exact values go further. All its other values are right. Remove the limit"
            if self.is_right_within
            else (
                ", clipped in the output or held by a stop in the model. The other columns are "
                "diagnosed without this one"
            )
        )
        return f"{self.key} of {maneuvers(self.maneuvers)} stays at {at}{where_else}"

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers)}
        bounds = {"low": self.low, "high": self.high}
        return {**where, **bounds, "is_right_within": self.is_right_within}


@dataclass(frozen=True, slots=True)
class EnergyOfOtherMotion(Evidence):
    """An energy differs from the energy of the motion in the file.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    off
        Largest difference from the energy that follows from the file's angles, rates and speed [J].
    """

    key: str
    maneuvers: tuple[int, ...]
    off: float

    code = "energy_of_other_motion"
    severity = Severity.WARNING

    def message(self) -> str:
        other = "inertias and lengths" if self.key == "kinetic_energy" else "lengths and gravity"
        return (
            f"{self.key} of {maneuvers(self.maneuvers)} does not fit the motion in the file. The "
            "energy computed from the file's angles, rates and speed differs by up to "
            f"{short_number(self.off)} J, far more than the errors of these columns explain. Check "
            f"with which masses, {other} this energy is computed, and whether both wheels stay on "
            "the floor and roll"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers), "off": self.off}


@dataclass(frozen=True, slots=True)
class SmoothedColumns(Evidence):
    """Columns are moving averages of the exact values.

    Attributes
    ----------
    places
        The columns (``2.roll_angle``).
    rows
        Number of rows in each average.
    """

    places: tuple[str, ...]
    rows: int

    code = "smoothed_columns"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{named(self.places)}: each value is a moving average of the exact values over "
            f"{self.rows} rows. Write the rows as they are computed, without a filter"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.places), "rows": self.rows}


@dataclass(frozen=True, slots=True)
class StepAverage(Evidence):
    """Each value of a column is the average of the exact values over the step before or after it.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    is_before
        True for the step that ends at the row, False for the step that begins there.
    """

    key: str
    maneuvers: tuple[int, ...]
    is_before: bool

    code = "step_average"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key} of {maneuvers(self.maneuvers)}: each value is the average over the step "
            f"{self._side} its row. Write the value at the time of the row"
        )

    @property
    def _side(self) -> str:
        return "before" if self.is_before else "after"

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers), "step": self._side}


@dataclass(frozen=True, slots=True)
class Remainder(Evidence):
    """The largest error that remains after the reported faults are corrected.

    Attributes
    ----------
    max_rel_error
        The error relative to the scale of its column.
    place
        Maneuver and column of the error (``2.roll_angle``).
    """

    max_rel_error: float
    place: str

    code = "remainder"

    def message(self) -> str:
        number, _, key = self.place.partition(".")
        return (
            "No other fault is visible. With the faults above corrected, the largest error is "
            f"{scale_words(self.max_rel_error, key)}, in maneuver {number}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"max_rel_error": self.max_rel_error, "place": self.place}


@dataclass(frozen=True, slots=True)
class RowsRepeated(Evidence):
    """The last rows of maneuvers repeat the same numbers, although the exact motion goes on.

    Attributes
    ----------
    maneuvers : tuple of int
    time
        Time of the first of these rows [s].
    rows
        Number of these rows.
    keys
        The columns that repeat.
    are_all
        True if all columns repeat: the motion in the file ended there.
    """

    maneuvers: tuple[int, ...]
    time: float
    rows: int
    keys: tuple[str, ...]
    are_all: bool

    code = "rows_repeated"
    severity = Severity.WARNING

    def message(self) -> str:
        which = maneuvers(self.maneuvers)
        which = f"rows of {which}" if self.are_all else f"values of {named(self.keys)} of {which}"
        why = (
            "The simulation ended there, and its last row was written again. Run it to the end"
            if self.are_all
            else "Check why your program stops updating them"
        )
        return (
            f"From {self.time:.6g} s on, the {which} do not change any more ({self.rows} rows). "
            f"{why}"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"maneuver": self.maneuvers[0], "maneuvers": list(self.maneuvers)}
        return {**where, "time": self.time, "rows": self.rows, "columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class RowsBetween(Evidence):
    """Rows were interpolated between other rows, or repeat the row before.

    Attributes
    ----------
    maneuvers : tuple of int
    order
        0 if rows repeat the row before, 1 if they are on straight lines between other rows, 2 if
        they are on curves between other rows.
    share
        Fraction of the rows that are repeated or interpolated.
    keys : tuple of str
        The angles and rates that show it; empty if most show it, and none of the others is right.
    every
        If rows are on curves, one row in this many is right; otherwise 0.
    """

    maneuvers: tuple[int, ...]
    order: int
    share: float
    keys: tuple[str, ...] = ()
    every: int = 0

    code = "rows_between"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.every:
            return (
                f"Only every {_ordinal(self.every)} row of {maneuvers(self.maneuvers)} is right: "
                "the rows between were interpolated, or belong to other times. Write the "
                "integrator's own steps, or a dense output that is as accurate as the steps"
            )
        made = "interpolated" if self.order else "held"
        better = (
            f"They were {made}, not computed. Write the integrator's own steps, or a dense output "
            "that is as accurate as the steps"
        )
        share, where = f"At least {100 * self.share:.0f} %", maneuvers(self.maneuvers)
        if self.keys:
            what = "lie on straight lines between others" if self.order else "repeat the one before"
            return f"{share} of the values of {named(self.keys)} in {where} {what}. {better}"
        what = "lie on straight lines between other rows" if self.order else "repeat the row before"
        return f"{share} of the rows of {where} {what}, in most angles and rates. {better}"

    def numbers(self) -> Mapping[str, Any]:
        where = {"maneuver": self.maneuvers[0], "maneuvers": list(self.maneuvers)}
        numbers = {"order": self.order, "share": self.share, "columns": list(self.keys)}
        return {**where, **numbers, "every": self.every}


def _ordinal(count: int) -> str:
    ends = {1: "st", 2: "nd", 3: "rd"}
    return f"{count}{'th' if 10 < count % 100 < 14 else ends.get(count % 10, 'th')}"


@dataclass(frozen=True, slots=True)
class Departs(Evidence):
    """A motion is right up to some row, and soon after this row its error is 100 times larger.

    Attributes
    ----------
    maneuvers : tuple of int
    t_right, times : tuple of float
        By maneuver: times of the last right row, and of the first row that is far off [s].
    before, after
        Largest error until `t_right`, and the largest error at `times`, relative to the scales.
    t_back
        Time of the last row that is off, if later rows are right again [s]; otherwise None.
    shift
        If the later rows are the exact motion at shifted times: exact time - written time [s].
        Otherwise None.
    keys : tuple of str
        The columns with only one definition, if only these show it; otherwise empty.
    """

    maneuvers: tuple[int, ...]
    t_right: tuple[float, ...]
    times: tuple[float, ...]
    before: float
    after: float
    t_back: float | None = None
    shift: float | None = None
    keys: tuple[str, ...] = ()

    code = "departs"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.t_back is not None:
            what = (
                f", and the rows until {self.t_back:.6g} s are wrong. All later rows are right: "
                "look only at the wrong ones"
            )
        elif self.shift is not None:
            why = "skipped" if self.shift > 0.0 else "repeated"
            what = (
                f". From there on, rows contain the exact motion {_later(self.shift)}: rows or "
                f"steps were {why}"
            )
        else:
            what = (
                ". Look for a force, contact or event that begins then: a mistake from the start "
                "would show before"
            )
        by = f" ({named(self.keys)})" if self.keys else ""
        is_one_time = len({*self.t_right}) == len({*self.times}) == 1
        times = self.t_right[:1] if is_one_time else self.t_right
        until = together([f"{t:.6g}" for t in times])
        but, when = ("but", f" at {self.times[0]:.6g} s") if is_one_time else ("then", "")
        are, up_to = ("is", "") if len(self.maneuvers) == 1 else ("are", "up to ")
        return (
            f"{maneuvers(self.maneuvers).capitalize()}{by} {are} right until {until} s, {but} off "
            f"by {up_to}{self.after:.2g} of a column's largest value{when}{what}"
        )

    def numbers(self) -> Mapping[str, Any]:
        numbers = {
            "before": self.before,
            "after": self.after,
            "shift": self.shift,
            "columns": list(self.keys),
        }
        first = {"maneuver": self.maneuvers[0], "time": self.times[0]}
        times = {str(n): t for n, t in zip(self.maneuvers, self.times, strict=True)}
        return {**first, "maneuvers": list(self.maneuvers), "times": times, **numbers}


@dataclass(frozen=True, slots=True)
class RowTimes:
    """The rows of a maneuver that are right at times other than those written.

    Attributes
    ----------
    rows, of
        The number of these rows, and of all rows.
    first, last
        Written times of the first and the last of these rows [s].
    ahead : (float, float)
        Range of exact time - written time, for nine in ten of these rows [s].
    example : (float, float)
        Written time and exact time of the row that is farthest off [s].
    relief
        The factor by which the exact times reduce the error.
    is_disordered
        True if the exact times are in another order than the rows.
    """

    rows: int
    of: int
    first: float
    last: float
    ahead: tuple[float, float]
    example: tuple[float, float]
    relief: float
    is_disordered: bool


@dataclass(frozen=True, slots=True)
class OtherTimes(Evidence):
    """Rows are the exact motion, each at a time other than the one written.

    Attributes
    ----------
    found : mapping of int to RowTimes
        The rows, by maneuver number.
    """

    found: Mapping[int, RowTimes]

    code = "other_times"
    severity = Severity.WARNING

    def message(self) -> str:
        rows, of = sum(x.rows for x in self.found.values()), sum(x.of for x in self.found.values())
        unsorted = next((n for n, x in self.found.items() if x.is_disordered), None)
        if unsorted is not None:
            written, exact = self.found[unsorted].example
            return (
                "The rows contain the exact motion, but not in the order of their times. In "
                f"maneuver {unsorted}, for example, the row at {written:.6g} s belongs to "
                f"{exact:.6g} s. Check how rows are sorted (times as text?) and joined"
            )
        least = min(x.ahead[0] for x in self.found.values())
        most = max(x.ahead[1] for x in self.found.values())
        when = _beside(least, most)
        if rows < MOST_ROWS * of:
            number, first = next(iter(self.found.items()))
            return (
                f"{rows} of {of} rows are right for other times, {when} the written ones. In "
                f"maneuver {number}, these are the rows from {first.first:.6g} to "
                f"{first.last:.6g} s. Check whether rows are skipped, or old values written again"
            )
        return (
            f"Each row is right for a time {when} the written one. Check "
            "how the times are written, and whether rows are saved before or after a step, and at "
            "the requested times or at the nearest steps"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "ahead": {str(n): x.ahead for n, x in self.found.items()},
            "relief": [x.relief for x in self.found.values()],
            "rows": {str(n): x.rows for n, x in self.found.items()},
        }


@dataclass(frozen=True, slots=True)
class ColumnOfAnotherManeuver(Evidence):
    """Columns of one maneuver contain the numbers of another maneuver."""

    maneuver: int
    of: int
    keys: tuple[str, ...]

    code = "column_of_another_maneuver"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{', '.join(self.keys)} of maneuver {self.maneuver}: the numbers are those of "
            f"maneuver {self.of}. Check which run is written there"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "of": self.of, "columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class AnotherStart(Evidence):
    """The first row differs from the given initial conditions of the maneuver.

    Attributes
    ----------
    maneuvers : tuple of int
    key
    found, given
        Value of the first row, and the given value, in the unit of the column.
    unit
    told
        The unit in which the found number would be the given value; None if there is no such unit.
    """

    maneuvers: tuple[int, ...]
    key: str
    found: float
    given: float
    unit: str
    told: str | None

    @property
    def is_visible(self) -> bool:
        """True if the difference would be visible in a plot of the column."""
        return abs(self.found - self.given) > TOLERANCE * abs(self.given)

    code = "another_start"
    severity = Severity.WARNING

    def message(self) -> str:
        said = (
            f"In the first row, {self.key} of {maneuvers(self.maneuvers)} is {self.found:.9g} "
            f"{unit_text(self.unit)}; the given initial value is {self.given:.9g}"
        )
        if self.told:
            said += (
                f". The ratio is {self.found / self.given:.6g}, as if the value were in "
                f"{unit_text(self.told)}"
            )
        return said

    def numbers(self) -> Mapping[str, Any]:
        where = {"maneuver": self.maneuvers[0], "maneuvers": list(self.maneuvers)}
        numbers = {"found": self.found, "given": self.given, "unit": self.told}
        return {**where, "column": self.key, **numbers}


@dataclass(frozen=True, slots=True)
class Scaled:
    """A relation: written value = factor * exact value + offset [SI]."""

    factor: float
    offset: float


@dataclass(frozen=True, slots=True)
class ColumnsApart(Evidence):
    """A few columns are wrong, while all other columns are right.

    Attributes
    ----------
    columns : mapping of str to tuple of int
        The maneuvers in which each column is wrong, by its key.
    every
        Number of maneuvers in the file.
    error_of_others
        Largest error of the other columns, relative to the scale.
    fits : mapping of str to Scaled
        The columns that a factor or an offset explains, by key.
    units : mapping of str to str
        Unit of each column, by its key.
    is_sum_with_it
        True if the mechanical energy is wrong only because one of its parts is.
    is_rest
        True if other faults of the file are named beside this.
    """

    columns: Mapping[str, tuple[int, ...]]
    every: int
    error_of_others: float
    fits: Mapping[str, Scaled]
    units: Mapping[str, str]
    is_sum_with_it: bool
    is_rest: bool = False

    code = "columns_apart"
    severity = Severity.WARNING

    def message(self) -> str:
        only = together(
            [
                key if len(numbers) == self.every else f"{key} of {maneuvers(numbers)}"
                for key, numbers in self.columns.items()
            ]
        )
        is_one = len(self.columns) == 1
        scales = "; ".join(
            f"{'it' if is_one else key} is {_scaled(x, self.units[key])}"
            for key, x in self.fits.items()
        )
        start = "Otherwise only" if self.is_rest else "Only"
        are, these = ("is", "this column is") if is_one else ("are", "these columns are")
        of_sum = (
            f". mechanical_energy is wrong only because it contains {only if is_one else 'them'}"
            if self.is_sum_with_it
            else ""
        )
        return (
            f"{start} {only} {are} wrong{scales and ': '}{scales}{of_sum}. All other columns agree "
            f"with the exact motion to within {self.error_of_others:.1g} of their largest values, "
            "so the integrator and the equations are correct. Check how "
            f"{these} computed and written"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "columns": {key: list(numbers) for key, numbers in self.columns.items()},
            "max_rel_error_of_others": self.error_of_others,
            "factors": {key: x.factor for key, x in self.fits.items()},
        }


@dataclass(frozen=True, slots=True)
class ColumnBeside(Evidence):
    """A column that the benchmark does not define is wrong, while the benchmark's are right.

    Attributes
    ----------
    key
    maneuvers
    unit
    max_rel_error
        Largest error relative to the scale.
    constant : tuple of float
        The number in every row of each maneuver, if the exact values vary; otherwise empty.
    fit : Scaled or None
        Factor and offset that explain the error; None if they do not explain it.
    """

    key: str
    maneuvers: tuple[int, ...]
    unit: str
    max_rel_error: float
    constant: tuple[float, ...] = ()
    fit: Scaled | None = None

    def _finding(self) -> Finding:
        alone = "while the benchmark's columns are right"
        advice = "Check how it is computed and written"
        more: dict[str, object] = {}
        if self.constant:
            numbers = " / ".join(_in(x, self.unit) for x in dict.fromkeys(self.constant))
            said = f"is {numbers} in every row, {alone}. It was not computed, or not written"
            more = {"constant": list(self.constant)}
        elif self.fit is not None:
            said = f"is {_scaled(self.fit, self.unit)}, {alone}. {advice}"
            more = {"factor": self.fit.factor, "offset": self.fit.offset}
        else:
            said = (
                f"is wrong by up to {scale_words(self.max_rel_error)}, {alone}. "
                f"Neither a factor nor an offset explains it. {advice}"
            )
        where = f"{self.key} of {maneuvers(self.maneuvers)}"
        return warning(
            "column_beside",
            f"{where} {said}",
            column=self.key,
            maneuvers=list(self.maneuvers),
            max_rel_error=self.max_rel_error,
            **more,
        )


def _later(seconds: float) -> str:
    return f"{abs(seconds):.3g} s {'later' if seconds > 0.0 else 'earlier'}"


def _beside(least: float, most: float) -> str:
    """Say how far times are before or after others, by a range, or by its mean if it is small."""
    near, far = sorted((least, most), key=abs)
    if CLEARLY * (most - least) < abs(most + least):
        near = far = (least + most) / 2
    if near * far < 0.0:
        return f"{-least:.3g} s before to {most:.3g} s after"
    span = f"{abs(far):.3g} s {'after' if far > 0.0 else 'before'}"
    return span if near == far else f"{abs(near):.3g} to {span}"


def _scaled(x: Scaled, unit: str) -> str:
    """Describe values by their factor and offset relative to the exact values."""
    times = f"{x.factor:.6g} times the exact value" if x.factor != 1.0 else "the exact value"
    sign = "minus" if x.offset < 0 else "plus"
    return times + (f" {sign} {_in(abs(x.offset), unit)}" if x.offset else "")


def _in(x: float, unit: str) -> str:
    return f"{x:.6g}" + ("" if unit == "1" else " " + unit_text(unit))
