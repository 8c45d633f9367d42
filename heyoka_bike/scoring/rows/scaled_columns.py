"""Find columns that are a factor times the exact values, plus an offset, and undo both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.output_faults import ColumnRatio, Scaled
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import BY_FAR
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Deviation, Undone, finite, to_si
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, Trace
from heyoka_bike.scoring.units import unit_told_by


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
