"""Faults that make a column a simple function of the exact values, or of another column.

Each fault is a function of a column. It returns the deviation from the exact values that the fault
makes, with its evidence. `deviating_columns` tries all of them, and undoes the one that explains
the error of the column best.

To add a fault, write a function like `_unsigned`, and add it to `COLUMN_FAULTS`. A new code also
needs a class of evidence in `output_faults`, with a field `maneuvers` for the maneuvers that show
the fault. In several maneuvers, floats of the same fault may differ by rounding; all other fields
must be equal.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP, Array
from heyoka_bike.scoring.alignment import are_even
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.output_faults import (
    ClippedColumn,
    ColumnRatio,
    OtherColumn,
    OtherMoment,
    PartMultiplied,
    Scaled,
    SmoothedColumns,
    StepAverage,
    UnsignedColumn,
)
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.scaled_columns import scaled
from heyoka_bike.scoring.rows.table import ENERGY, PARTS_OF_ENERGY, finite, floor_of
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, Trace
from heyoka_bike.scoring.units import unit_told_by

# Number of Gauss nodes for the average over a step. Four integrate polynomials of degree 7 exactly.
_NODES_IN_STEP = 4


@dataclass(frozen=True, slots=True)
class Deviation:
    """The difference from the exact values that one simple fault makes in a column [SI].

    Attributes
    ----------
    values : ndarray, shape (n,)
        Value with the fault - exact value; NaN in rows where the fault determines no value.
    evidence : Evidence
        The fault in this column of this maneuver. Evidence of several maneuvers that differs only
        in its place is reported once.
    is_of_program
        True if one program makes this fault in all maneuvers with the same numbers. Such a
        deviation is dropped if the numbers of the maneuvers differ.
    """

    values: Array
    evidence: Evidence
    is_of_program: bool = False


def another(m: ManeuverScore, c: ColumnScore, report: Report) -> Deviation | None:
    """Describe a column as the exact values of another column of its unit, or of another maneuver.

    Only default definitions are compared. Otherwise the parts of a constant sum, such as potential
    and kinetic energy, would be functions of each other.
    """
    keys = {COMPARED[key][0].name: key for key in BENCHMARK_COLUMNS}
    names = [name for name, key in keys.items() if COMPARED[key][0].unit == c.unit]
    value = c.trace.value + c.as_understood.offset
    end = float(np.max(c.trace.time))
    there = {
        (other.maneuver, name): x
        for other in report.maneuvers
        if end <= float(other.part.reference.duration)
        for name, x in other.part.reference.approximate(c.trace.time, names).items()
        if (other.maneuver, keys[name]) != (m.maneuver, c.key)
    }
    nearest = min(there, key=lambda place: rms(value - there[place]), default=None)
    if nearest is None:
        return None
    deviation = there[nearest] - c.as_understood.offset - c.trace.reference
    number, name = nearest
    of = number if number != m.maneuver else None
    return Deviation(deviation, OtherColumn(c.key, (m.maneuver,), keys[name], of))


def _unsigned(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the exact values without their signs."""
    right = c.trace.reference
    if np.min(right) >= 0.0:
        return None
    return Deviation(np.abs(right) - right, UnsignedColumn(c.key, (m.maneuver,)))


def _ratio(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the exact values with a factor or an offset, or with both."""
    fit = scaled([c])
    if fit is None:
        return None
    right = c.trace.reference
    return Deviation(fit.factor * right + fit.offset - right, _column_ratio(m, c, fit))


def _ratio_for_a_time(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
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
    ratio = replace(_column_ratio(m, c, fit), since=finite(first), until=finite(last))
    return Deviation(deviation, ratio)


def _column_ratio(m: ManeuverScore, c: ColumnScore, fit: Scaled) -> ColumnRatio:
    """Return the evidence of a factor and an offset in all rows."""
    unit = None
    if not fit.offset:
        unit = unit_told_by(fit.factor, c.unit, c.as_understood.unit, TOLERANCE)
    return ColumnRatio(c.key, (m.maneuver,), fit.factor, fit.offset, unit)


def _clipped(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the exact values clipped at its own smallest and largest value."""
    value, right = c.trace.value, c.trace.reference
    low, high = float(np.min(value)), float(np.max(value))
    least = c.hidden
    low = low if np.min(right) < low - least else -np.inf
    high = high if np.max(right) > high + least else np.inf
    clipped = np.minimum(np.maximum(right, low), high)
    # The exact values replace the rows at a bound, because the bound hides the motion there.
    deviation = np.where(clipped == right, 0.0, clipped - right)
    bounds = finite(low), finite(high)
    return Deviation(deviation, ClippedColumn(c.key, (m.maneuver,), *bounds, is_right_within=True))


def _averaged(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as a moving average of the exact values over evenly spaced rows.

    All definitions of the column are tried. The deviation is NaN at both ends.
    """
    time, value = c.trace.time, c.trace.value
    if c.values < m.rows or not are_even(time - time[0], float(np.ptp(time)) / (len(time) - 1)):
        return None
    names = [x.name for x in m.part.reference.definitions[c.key]]
    right = np.array([*m.part.reference.approximate(time, names).values()])
    sums = np.pad(np.cumsum(right, axis=1), ((0, 0), (1, 0)))
    best: tuple[float, Deviation] | None = None
    # A moving average has no value in the first and the last rows. Try averages that lose at most a
    # tenth of the rows at each end.
    for half in range(1, int(len(time) / CLEARLY)):
        count = 2 * half + 1
        smooth = (sums[:, count:] - sums[:, :-count]) / count
        left = np.sqrt(np.mean((value[half:-half] - smooth) ** 2, axis=1))
        which = int(np.argmin(left))
        if best is None or left[which] < best[0]:
            whole = np.full_like(time, np.nan)
            whole[half:-half] = smooth[which]
            smoothed = SmoothedColumns((f"{m.maneuver}.{c.key}",), count)
            best = float(left[which]), Deviation(whole - c.trace.reference, smoothed)
    return best[1] if best else None


def _averaged_over_step(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the average over the step before or after each row.

    The average is that of the motion, such as a distance divided by the step, or that of the values
    at both ends of the step. All definitions of the column are tried. The deviation is NaN in the
    row without a step on this side. None if the value in the middle of the step fits better.
    """
    time, step = c.trace.time, np.diff(c.trace.time)
    if c.values < m.rows or not np.all(step > 0.0):
        return None
    names = [x.name for x in m.part.reference.definitions[c.key]]

    def average(places: Array, weights: Array) -> Array:
        """Return averages of each definition over weighted places between 0 and 1 in each step."""
        at = time[:-1] + np.multiply.outer(places, step)
        found = m.part.reference.approximate(at.ravel(), names).values()
        return np.array([weights @ x.reshape(at.shape) for x in found])

    nodes, weights = np.polynomial.legendre.leggauss(_NODES_IN_STEP)
    middle = average(np.array([0.5]), np.ones(1))
    ends = average(np.array([0.0, 1.0]), np.array([0.5, 0.5]))
    averages = [*middle, *ends, *average((1.0 + nodes) / 2, weights / 2)]
    sides = {True: slice(1, None), False: slice(None, -1)}
    left = {
        (is_before, i): rms(c.trace.value[rows] - x)
        for is_before, rows in sides.items()
        for i, x in enumerate(averages)
    }
    is_before, which = min(left, key=lambda k: left[k])
    if which < len(middle):
        return None
    deviation = np.full_like(time, np.nan)
    deviation[sides[is_before]] = averages[which]
    return Deviation(deviation - c.trace.reference, StepAverage(c.key, (m.maneuver,), is_before))


def _at_other_moment(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column, or a part of the mechanical energy, as that of another row.

    A part may also be that of the first row in every row, or it may be multiplied.
    """
    best: tuple[float, Deviation] | None = None
    error = c.trace.error + c.as_understood.offset
    for deviation in _moments(m, c, error):
        rest = (error - deviation.values)[np.isfinite(deviation.values)]
        # A filter resembles a delay, and an energy without a body resembles a multiple. Only values
        # that are then right belong to another moment.
        is_right = len(rest) > MOST_ROWS * len(error) and (
            np.max(np.abs(rest)) <= max(c.hidden, RIGHT * c.scale)
        )
        if not is_right:
            continue
        left = max(rms(rest), floor_of(c))
        if best is None or AS_GOOD * left < best[0]:
            best = left, deviation
    if best is None:
        return None
    return replace(best[1], values=best[1].values - c.as_understood.offset)


def _moments(m: ManeuverScore, c: ColumnScore, error: Array) -> Iterator[Deviation]:
    """Yield the deviations of columns that are written at another moment, the simplest first."""
    time, reference = c.trace.time, m.part.reference
    end = float(reference.duration)
    step = float(np.median(np.diff(time)))
    own = next(x.name for x in reference.definitions[c.key] if x.definition == c.definition)
    is_sum, where = c.key == ENERGY, (m.maneuver,)
    for name in PARTS_OF_ENERGY if is_sum else (own,):

        def exact(times: Array, name: str = name) -> Array:
            return reference.approximate(np.clip(times, 0.0, end), [name])[name]

        right, part = exact(time), name if is_sum else None
        if is_sum:
            yield Deviation(right[0] - right, OtherMoment(c.key, where, part, None))
        delay = 0.0
        for _ in range(ROUNDS_OF_NEWTON):
            late = exact(time - delay)
            slope = (exact(time - delay - SMALL_STEP) - late) / SMALL_STEP
            size = float(slope @ slope)
            delay += float(slope @ (error - late + right)) / size if size else 0.0
        count = round(delay / step)
        if is_whole := count != 0 and abs(delay / step - count) < TOLERANCE:
            delay = count * step
        # The error of an integrator may resemble a delay. So without any other column, which would
        # show this error, the values must be exactly those of another row.
        if 0.0 < abs(delay) < end and (is_whole or m.column_count > 1):
            meant = time - delay
            is_within = (meant >= 0.0) & (meant <= end)
            late = np.where(is_within, exact(meant) - right, np.nan)
            moment = OtherMoment(c.key, where, part, delay, count if is_whole else None)
            yield Deviation(late, moment, is_of_program=True)
        if is_sum:
            by = float(right @ error) / float(right @ right)
            multiplied = PartMultiplied(where, name, 1.0 + by)
            yield Deviation(by * right, multiplied, is_of_program=True)


COLUMN_FAULTS = (
    another,
    _unsigned,
    _ratio,
    _clipped,
    _averaged,
    _averaged_over_step,
    _at_other_moment,
    _ratio_for_a_time,
)
"""Functions that describe the deviation which one fault makes in a column; None if it makes none.

They are tried in this order, the simplest fault first.
"""
