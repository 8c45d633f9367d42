"""Find columns that are a factor times the exact values, plus an offset, and undo both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import number_in_unit, unit_text
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import BY_FAR
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Deviation, Undone, finite, to_si
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, Trace
from heyoka_bike.scoring.units import unit_told_by


@dataclass(frozen=True, slots=True)
class Scaled:
    """A relation: written value = factor * exact value + offset [SI]."""

    factor: float
    offset: float

    def words(self, unit: str) -> str:
        """Describe values relative to the exact values, as "2 times the exact value plus 1 m"."""
        is_times = self.factor != 1.0
        times = f"{self.factor:.6g} times the exact value" if is_times else "the exact value"
        sign = "minus" if self.offset < 0 else "plus"
        return times + (f" {sign} {number_in_unit(abs(self.offset), unit)}" if self.offset else "")


def scaled(columns: Sequence[ColumnScore]) -> Scaled | None:
    """Fit a factor, an offset, or both, the same in all maneuvers, that explain a column.

    First a factor alone and an offset alone are tried, and the better of these is used if it
    explains the error. Otherwise both are fitted together. None if these do not explain it either.
    """
    sizes = np.concatenate([np.full(c.values, rms(c.trace.reference) or 1.0) for c in columns])
    value = np.concatenate([c.trace.value for c in columns]) / sizes
    right = np.concatenate([c.trace.reference for c in columns]) / sizes
    both = np.column_stack([right, 1.0 / sizes])

    def solved(matrix: Array, goal: Array) -> list[float]:
        return [float(x) for x in np.linalg.lstsq(matrix, goal, rcond=None)[0]]

    def left(fit: Scaled) -> float:
        return rms(value - fit.factor * right - fit.offset / sizes)

    def explains(fit: Scaled, c: ColumnScore, count: int) -> bool:
        rest = c.trace.value - fit.factor * c.trace.reference - fit.offset
        # Each fitted value must reduce the error by `BY_FAR`. In a column that is nearly zero, the
        # error is as large as the exact values. So the error that remains must also be smaller than
        # the column by this factor.
        least = min(rms(c.trace.error), rms(c.trace.value))
        return BY_FAR**count * rms(rest) < least

    one = [
        Scaled(solved(both[:, :1], value)[0], 0.0),
        Scaled(1.0, solved(both[:, 1:], value - right)[0]),
    ]
    for count, fit in ((1, min(one, key=left)), (2, Scaled(*solved(both, value)))):
        if len(value) > count and all(explains(fit, c, count) for c in columns):
            return fit
    return None


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
        relation = Scaled(self.factor, self.offset).words(COMPARED[self.key][0].unit)
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


def ratio(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the exact values with a factor or an offset, or with both."""
    fit = scaled([c])
    if fit is None:
        return None
    right = c.trace.reference
    return Deviation(fit.factor * right + fit.offset - right, _column_ratio(m, c, fit))


def ratio_for_a_time(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as right, but with a factor or an offset within one time interval."""
    time, error = c.trace.time, np.abs(c.trace.error)
    # The error before and after this time may be that of an integrator.
    least = max(c.hidden, float(np.max(error)) / BY_FAR**2)
    wrong = np.flatnonzero(error > least)
    if len(wrong) < MIN_ROWS_FOR_SHAPE:
        return None
    rows = slice(wrong[0], wrong[-1] + 1)
    within = Trace(time[rows], c.trace.value[rows], c.trace.error[rows])
    if np.ptp(within.value) == 0.0:
        return None
    fit = scaled([replace(c, trace=within, values=len(within.time))])
    if fit is None:
        return None
    right = c.trace.reference
    deviation = fit.factor * right + fit.offset - right
    # Rows near zero are right with and without the factor.
    is_off = np.abs(c.trace.error - deviation) > least
    first = float(time[rows.start]) if is_off[: rows.start].any() else -np.inf
    last = float(time[rows.stop - 1]) if is_off[rows.stop :].any() else np.inf
    deviation[(time < first) | (time > last)] = 0.0
    seen = replace(_column_ratio(m, c, fit), since=finite(first), until=finite(last))
    return Deviation(deviation, seen)


def _column_ratio(m: ManeuverScore, c: ColumnScore, fit: Scaled) -> ColumnRatio:
    """Return the evidence of a factor and an offset in all rows."""
    unit = None
    if not fit.offset:
        unit = unit_told_by(fit.factor, c.unit, c.as_understood.unit, TOLERANCE)
    return ColumnRatio(c.key, (m.maneuver,), fit.factor, fit.offset, unit)


def without_ratio(report: Report, seen: ColumnRatio) -> Undone:
    """Undo the factor and the offset of a column in all maneuvers."""

    def right(m: ManeuverScore) -> Part:
        if seen.key not in m.part.values or seen.key not in m:
            return m.part
        offset = seen.offset / to_si(m[seen.key])
        return m.part.rewritten({seen.key: (m.part.values[seen.key] - offset) / seen.factor})

    return Undone((seen,), tuple(map(right, report.maneuvers)))
