"""Find faults of single columns that the rows themselves show, without simulating any program.

The checks find columns that are a simple function of the exact values, or of another column of the
file: clipped, multiplied by a constant, smoothed, of another moment, or exchanged with another
column. The modules beside this one look for coarse grids (`grids`), rates that are differences of
their angles (`rates`), energies that are wrong sums (`sums`), wrong times (`wrong_times`), and
maneuvers that ended early (`maneuvers`). Each of these row checks takes milliseconds, so they
precede all simulations.

A row check returns its evidence, and the corrected rows: with the fault undone, a useless column
removed, or the digits replaced with a grid. The corrected rows are then diagnosed like any file. So
the fault is reported as a cause, and the error that it does not explain is reported separately.

To add a fault of a column that is a function of the exact values, write a function like `_unsigned`
that returns a `_Deviation`. Add it to `_COLUMN_FAULTS`, and its evidence to `_evidence`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP, Array
from heyoka_bike.scoring.alignment import are_even
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.output_faults import (
    ClippedColumn,
    ColumnOfAnotherManeuver,
    ColumnRatio,
    MisplacedManeuver,
    OtherColumn,
    OtherMoment,
    PartMultiplied,
    Scaled,
    SingleRows,
    SmoothedColumns,
    StepAverage,
    UnsignedColumn,
    pairs_exchanged,
)
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import (
    ENERGY,
    PARTS_OF_ENERGY,
    Undone,
    floor_of,
    is_right_column,
    places,
)
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, Trace
from heyoka_bike.scoring.units import factor, unit_told_by

# If more than this fraction of a column's rows do not fit their neighbours, they are not reported
# as single rows.
_MOST_SINGLE = 0.2
# Number of rows on each side with which a single row of large error is compared. If every third row
# has a wrong time, an error may be 3 times the error two rows further on.
_ROWS_AROUND = 5
# Number of Gauss nodes for the average over a step. Four integrate polynomials of degree 7 exactly.
_NODES_IN_STEP = 4
# A column is clipped if at least this many consecutive rows are at its bound. An extremum of a
# smooth column has one or two equal rows.
_FEWEST_CLIPPED = 5


@dataclass(frozen=True, slots=True)
class _Deviation:
    """The difference from the exact values that one simple fault makes in a column [SI].

    Attributes
    ----------
    how
        The fault: ``another``, ``unsigned``, ``ratio``, ``ratio for a time``, ``held``, ``late``,
        ``multiple``, ``clipped``, ``averaged`` or ``step average``.
    values : ndarray, shape (n,)
        Value with the fault - exact value; NaN in rows where the fault determines no value.
    about
        Numbers of the fault: factor, offset, and the first and last time, which are infinite if
        the fault does not begin or end in a run; the delay [s] and the distance of rows [s]; the
        factor of a part; the two bounds; the number of averaged rows; or 1 for the step before each
        row, 0 for the step after it.
    other
        Key of the column to which the values belong; for ``held``, ``late`` and ``multiple``, the
        part of the sum.
    of
        For ``another``: maneuver of these values; None if it is the same maneuver.
    """

    how: str
    values: Array
    about: tuple[float, ...]
    other: str = ""
    of: int | None = None


_Deviations = Mapping[tuple[int, str], _Deviation]
"""Deviations by maneuver number and column key."""


def deviating_columns(report: Report) -> Undone | None:
    """Look for columns that are exchanged, unsigned, scaled, delayed, clipped or smoothed.

    For each column the deviation that explains its error best is undone.
    """
    found: dict[tuple[int, str], _Deviation] = {}
    # Skip columns with the values of a different maneuver: they are not a function of the exact
    # values.
    others = {(x.maneuver, key) for x in of_other_maneuvers(report.maneuvers) for key in x.keys}
    for m, c in places(report):
        has_enough = c.values >= MIN_ROWS_FOR_SHAPE and c.scale
        # A column that is constant, apart from roundoff, cannot be compared as a function of exact
        # values that vary. But it may have been written in place of a different column.
        least = floor_of(c) if np.ptp(c.trace.reference) > floor_of(c) else 0.0
        faults = _COLUMN_FAULTS if np.ptp(c.trace.value) > least else _COLUMN_FAULTS[:1]
        if is_right_column(c) or not has_enough or (m.maneuver, c.key) in others:
            continue
        best = BY_FAR
        for describe in faults:
            if (deviation := describe(m, c, report)) is None:
                continue
            rows = np.isfinite(deviation.values)
            left = rms((c.trace.error - deviation.values)[rows])
            # The relief is the factor by which the fault reduces the error of the column.
            relief = rms(c.trace.error[rows]) / max(left, (c.floor or 0.0) / 2, ROUNDING * c.scale)
            # Simpler deviations are tried first. A deviation that is tried later must explain
            # clearly more of the error.
            if relief > best and left < TOLERANCE * c.scale:
                found[m.maneuver, c.key], best = deviation, AS_GOOD * relief
    found = _without_exchanged_everywhere(
        report, _of_one_ratio(report, _alike_everywhere(report, found, others))
    )
    if not found or not _is_beside_right(report, found):
        return None
    parts = []
    for m in report.maneuvers:
        values = dict(m.part.values)
        lo = dict(m.part.lo)
        for (n, key), deviation in found.items():
            if n == m.maneuver:
                values[key] = _corrected(m, m[key], deviation)
                lo.pop(key, None)
        parts.append(replace(m.part, values=values, lo=lo))
    return Undone(pairs_exchanged(_evidence(report, found)), tuple(parts), frozenset(found))


def without_ratio(report: Report, seen: ColumnRatio) -> Undone:
    """Undo the factor and the offset of a column in all maneuvers."""
    parts = []
    for m in report.maneuvers:
        values, lo = dict(m.part.values), dict(m.part.lo)
        if seen.key in values and seen.key in m:
            offset = seen.offset / _to_si(m[seen.key])
            values[seen.key] = (values[seen.key] - offset) / seen.factor
            lo.pop(seen.key, None)
        parts.append(replace(m.part, values=values, lo=lo))
    return Undone((seen,), tuple(parts))


def _alike_everywhere(
    report: Report, found: _Deviations, others: set[tuple[int, str]]
) -> _Deviations:
    """Keep only deviations of columns that are explained, or right, in every maneuver.

    One program writes all maneuvers. If a column is wrong in another maneuver without such a simple
    explanation there, it is wrong for another reason.
    """
    errors = grouped((key, report[n][key].error) for n, key in found)
    unexplained = {
        c.key for m, c in places(report)
        if (m.maneuver, c.key) not in found.keys() | others and not is_right_column(c)
        and c.key in errors and not _is_far_better(c.error, min(errors[c.key]))
    }  # fmt: skip
    return {place: d for place, d in found.items() if place[1] not in unexplained}


def _of_one_ratio(report: Report, found: _Deviations) -> _Deviations:
    """Drop numbers that differ between maneuvers; but not ratios that leave no visible error.

    One program writes all maneuvers, so a true factor or delay is the same in all of them. An
    energy that lacks a part is near a different ratio in each maneuver.
    """
    refuted = {
        key
        for key, each in grouped((key, d) for (_, key), d in found.items()).items()
        if any(d.how in ("late", "multiple") for d in each) and not _are_alike(each)
    }
    for key, each in grouped((key, n) for (n, key), d in found.items() if d.how == "ratio").items():
        columns = {n: report[n][key] for n in each}
        left = {n: c.trace.error - found[n, key].values for n, c in columns.items()}
        is_all = all(
            np.max(np.abs(left[n])) <= max(c.hidden, RIGHT * c.scale) for n, c in columns.items()
        )
        if not is_all and scaled([*columns.values()]) is None:
            refuted.add(key)
    return {place: d for place, d in found.items() if place[1] not in refuted}


def _are_alike(each: Sequence[_Deviation]) -> bool:
    """True if deviations are of the same kind, and their numbers agree visibly."""
    kinds = {(d.how, d.other) for d in each}
    numbers = np.array([d.about for d in each]) if len(kinds) == 1 else np.empty((0, 0))
    return len(kinds) == 1 and bool(
        np.all(np.ptp(numbers, axis=0) <= TOLERANCE * np.max(np.abs(numbers), axis=0))
    )


def _without_exchanged_everywhere(
    report: Report, found: _Deviations
) -> dict[tuple[int, str], _Deviation]:
    """Drop columns that are exchanged with another column in every maneuver.

    Simulated programs with this mistake are compared with such a file instead.
    """
    every = {
        key for key, places in report.by_column().items()
        if all((m.maneuver, key) in found and found[m.maneuver, key].how == "another"
               and found[m.maneuver, key].of is None for m, _ in places)
    }  # fmt: skip
    return {place: d for place, d in found.items() if place[1] not in every}


def _is_beside_right(report: Report, found: _Deviations) -> bool:
    """True if the columns without deviations are right to three digits, and far better."""
    for m in report.maneuvers:
        errors = {c.key: c.error for c in m.columns}
        mine = {key for n, key in found if n == m.maneuver}
        rest = max((x for key, x in errors.items() if key not in mine), default=0.0)
        if not all(_is_far_better(rest, errors[key]) for key in mine):
            return False
    return True


def _is_far_better(error: float, wrong: float) -> bool:
    """True if an error (in scales) is invisible, and far smaller than that of a wrong column."""
    return error <= min(TOLERANCE, wrong / CLEARLY)


def _corrected(m: ManeuverScore, c: ColumnScore, deviation: _Deviation) -> Array:
    """Return the column without a deviation, in the unit and with the sign of the file."""
    written = m.part.values[c.key]
    meant = np.array(written)
    meant[np.isfinite(written)] -= deviation.values / _to_si(c)
    return meant


def _to_si(c: ColumnScore) -> float:
    """Return the factor from written values to SI units, negative if the sign is flipped."""
    return c.as_understood.sign * factor(c.as_understood.unit)[0]


def _another(m: ManeuverScore, c: ColumnScore, report: Report) -> _Deviation | None:
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
    return _Deviation("another", deviation, (), keys[name], of)


def _unsigned(_: ManeuverScore, c: ColumnScore, __: Report) -> _Deviation | None:
    """Describe a column as the exact values without their signs."""
    right = c.trace.reference
    return _Deviation("unsigned", np.abs(right) - right, ()) if np.min(right) < 0.0 else None


def _ratio(_: ManeuverScore, c: ColumnScore, __: Report) -> _Deviation | None:
    """Describe a column as the exact values with a factor or an offset, or with both."""
    fit = scaled([c])
    if fit is None:
        return None
    right = c.trace.reference
    about = (fit.factor, fit.offset, -np.inf, np.inf)
    return _Deviation("ratio", fit.factor * right + fit.offset - right, about)


def _ratio_for_a_time(_: ManeuverScore, c: ColumnScore, __: Report) -> _Deviation | None:
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
    return _Deviation("ratio for a time", deviation, (fit.factor, fit.offset, first, last))


def _at_other_moment(m: ManeuverScore, c: ColumnScore, _: Report) -> _Deviation | None:
    """Describe a column, or a part of the mechanical energy, as that of another row.

    A part may also be that of the first row in every row, or it may be multiplied.
    """
    best: tuple[float, _Deviation] | None = None
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


def _moments(m: ManeuverScore, c: ColumnScore, error: Array) -> Iterator[_Deviation]:
    """Yield the deviations of columns that are written at another moment, the simplest first."""
    time, reference = c.trace.time, m.part.reference
    end = float(reference.duration)
    step = float(np.median(np.diff(time)))
    own = next(x.name for x in reference.definitions[c.key] if x.definition == c.definition)
    is_sum = c.key == ENERGY
    for name in PARTS_OF_ENERGY if is_sum else (own,):

        def exact(times: Array, name: str = name) -> Array:
            return reference.approximate(np.clip(times, 0.0, end), [name])[name]

        right, part = exact(time), name if is_sum else ""
        if is_sum:
            yield _Deviation("held", right[0] - right, (), part)
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
            yield _Deviation("late", late, (delay, step), part)
        if is_sum:
            by = float(right @ error) / float(right @ right)
            yield _Deviation("multiple", by * right, (1.0 + by,), part)


def _clipped(_: ManeuverScore, c: ColumnScore, __: Report) -> _Deviation | None:
    """Describe a column as the exact values clipped at its own smallest and largest value."""
    value, right = c.trace.value, c.trace.reference
    low, high = float(np.min(value)), float(np.max(value))
    least = c.hidden
    bounds = [
        low if np.min(right) < low - least else -np.inf,
        high if np.max(right) > high + least else np.inf,
    ]
    clipped = np.minimum(np.maximum(right, bounds[0]), bounds[1])
    # The exact values replace the rows at a bound, because the bound hides the motion there.
    deviation = np.where(clipped == right, 0.0, clipped - right)
    return _Deviation("clipped", deviation, tuple(bounds))


def _averaged(m: ManeuverScore, c: ColumnScore, _: Report) -> _Deviation | None:
    """Describe a column as a moving average of the exact values over evenly spaced rows.

    All definitions of the column are tried. The deviation is NaN at both ends.
    """
    time, value = c.trace.time, c.trace.value
    if c.values < m.rows or not are_even(time - time[0], float(np.ptp(time)) / (len(time) - 1)):
        return None
    names = [x.name for x in m.part.reference.definitions[c.key]]
    right = np.array([*m.part.reference.approximate(time, names).values()])
    sums = np.pad(np.cumsum(right, axis=1), ((0, 0), (1, 0)))
    best: tuple[float, _Deviation] | None = None
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
            deviation = _Deviation("averaged", whole - c.trace.reference, (float(count),))
            best = float(left[which]), deviation
    return best[1] if best else None


def _averaged_over_step(m: ManeuverScore, c: ColumnScore, _: Report) -> _Deviation | None:
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
    sides = {1.0: slice(1, None), 0.0: slice(None, -1)}
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
    return _Deviation("step average", deviation - c.trace.reference, (is_before,))


_COLUMN_FAULTS = (
    _another,
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


def single_rows(report: Report) -> Undone | None:
    """Look for single rows of a column that repeat the row before, or are far off.

    No motion stands still for a single row. These values are replaced with NaN.
    """
    found = {
        (m.maneuver, c.key): rows
        for m, c in places(report)
        if (rows := _odd_rows(m, c)) is not None
    }
    # If rows do not fit their neighbours in most columns of a maneuver, the rows are wrong as a
    # whole, not in single columns.
    wide = {
        n
        for n, keys in grouped((n, key) for n, key in found).items()
        if 2 * len(keys) > report[n].column_count
    }
    found = {place: rows for place, rows in found.items() if place[0] not in wide}
    if not found:
        return None
    alike = grouped(((key, is_held), (n, rows)) for (n, key), (rows, is_held) in found.items())
    seen = [
        SingleRows(
            key, tuple(n for n, _ in of), sum(len(rows) for _, rows in of),
            min(float(report[n].part.time[rows[0]]) for n, rows in of), is_held,
        )
        for (key, is_held), of in alike.items()
    ]  # fmt: skip
    parts = []
    for m in report.maneuvers:
        values = dict(m.part.values)
        for (n, key), (odd, _) in found.items():
            if n == m.maneuver:
                values[key] = values[key].copy()
                values[key][odd] = np.nan
        parts.append(replace(m.part, values=values))
    return Undone(tuple(seen), tuple(parts))


def _far_rows(c: ColumnScore) -> NDArray[np.intp]:
    """Return the indices of rows with an error far larger than in most rows."""
    error = np.abs(c.trace.error)
    usual = float(np.quantile(error, 1.0 - _MOST_SINGLE / 2))
    return np.flatnonzero(error > BY_FAR * max(usual, floor_of(c)))


def _odd_rows(m: ManeuverScore, c: ColumnScore) -> tuple[NDArray[np.intp], bool] | None:
    """Find single rows that do not fit their neighbours.

    Returns
    -------
    tuple or None
        Indices of the rows, and True if they repeat the row before, False if they are far off.
    """
    if c.values < m.rows or m.rows < MIN_ROWS_FOR_SHAPE or is_right_column(c):
        return None
    value, least = c.trace.value, floor_of(c)
    is_same = np.diff(value) == 0.0
    alone = is_same[1:-1] & ~is_same[:-2] & ~is_same[2:]
    # A row that equals the previous row counts as a repetition only where the column moves in one
    # direction by much more than the unit of its last digit. Near an extremum two neighbouring rows
    # may be equal.
    before, after = (value[1:-2] - value[:-3]), (value[3:] - value[2:-1])
    moves = (before * after > 0.0) & (np.minimum(np.abs(before), np.abs(after)) > CLEARLY * least)
    # Two zeros in succession are not a repetition, but small values written as zero.
    moves &= value[2:-1] != 0.0
    held = np.flatnonzero(alone & moves) + 2
    # Number of equal neighbours that the rounding to the digits written is expected to cause by
    # chance.
    chance = np.sum(moves * np.minimum(2.0 * least / np.maximum(np.abs(after), least), 1.0))
    error = np.abs(c.trace.error)
    if len(held) > CLEARLY * chance:
        # If the motion is right, also find rows that repeat the same row several times in
        # succession.
        of_before = np.abs(value[1:] - c.trace.reference[:-1]) <= MAX_ROUNDING_FLOORS * least
        more = np.flatnonzero(of_before & (error[1:] > CLEARLY * least)) + 1
        every = np.union1d(held, more)
        # If more rows repeat the row before, the column is held as a whole.
        return (every, True) if len(every) < _MOST_SINGLE * m.rows else None
    far = _far_rows(c)
    if any(
        np.isin(_far_rows(x), far).any() for x in m.columns if x is not c and x.values == m.rows
    ):
        # If the same rows of different columns are wrong, the motion is wrong, not a single column.
        return None
    turns = error[far] / (2 * np.pi)
    is_turned = c.unit == "rad" and np.all(np.abs(turns - np.rint(turns)) < TOLERANCE)
    is_single = len(far) and (len(far) == 1 or np.min(np.diff(far)) > 1) and far[0] > 0
    if not is_single or is_turned or far[-1] == m.rows - 1:
        return None
    # In a wrong motion, too, errors are far larger where the motion changes fast, but then in many
    # rows. So compare each row of large error with the rows around it.
    others = error.copy()
    others[far] = 0.0
    near = (others[max(row - _ROWS_AROUND, 0) : row + _ROWS_AROUND + 1] for row in far)
    is_far = all(error[row] > BY_FAR * np.max(x) for row, x in zip(far, near, strict=True))
    return (far, False) if is_far else None


def bounded(report: Report) -> Undone | None:
    """Look for columns that stay at a bound; the file itself shows this, whatever its motion.

    These columns are removed. None if all columns are bounded.
    """
    found = {
        (m.maneuver, c.key): bounds
        for m, c in places(report)
        if (bounds := _bounds_of(c)) is not None
    }
    if not found:
        return None
    keys = {key for _, key in found}
    if all(c.key in keys for _, c in places(report)):
        return None
    by_key = grouped(((key, low, high), n) for (n, key), (low, high) in found.items())
    seen = (
        ClippedColumn(key, tuple(of), _finite(low), _finite(high), is_right_within=False)
        for (key, low, high), of in by_key.items()
    )
    parts = (m.part.only(m.part.values.keys() - keys) for m in report.maneuvers)
    return Undone(tuple(seen), tuple(parts))


def _bounds_of(c: ColumnScore) -> tuple[float, float] | None:
    """Return the lower and the upper bound at which a column stays; None if it stays at neither.

    If the column stays at only one bound, the other is infinite. A column stays at a bound for
    several rows, and comes to it and leaves it by steps far above its digits. It stays at no other
    value, and most of its rows are between the bounds, with many different values.
    """
    value = c.trace.value
    least = CLEARLY * floor_of(c)
    starts = np.flatnonzero(np.r_[True, np.diff(value) != 0.0])
    lengths = np.diff(np.r_[starts, len(value)])
    at = value[starts]
    low, high = float(np.min(value)), float(np.max(value))
    is_bound = (at == low) | (at == high)
    inside = value[(value != low) & (value != high)]
    is_coarse = 2 * len(inside) < len(value) or 2 * len(np.unique(inside)) < len(inside)
    is_held = np.max(lengths[~is_bound], initial=0) >= _FEWEST_CLIPPED
    if c.values < MIN_ROWS_FOR_SHAPE or is_held or is_coarse:
        return None
    # The mechanical energy may rest at its exact constant value while no force does work.
    if float(np.ptp(c.trace.reference)) <= least:
        return None
    bounds = []
    for bound, inf in ((low, -np.inf), (high, np.inf)):
        # The first and the last rows do not count: a motion may begin or end at rest.
        here = np.flatnonzero((at == bound) & (lengths >= _FEWEST_CLIPPED))
        inner = here[(here > 0) & (here < len(at) - 1)]
        steps = np.minimum(np.abs(at[inner] - at[inner - 1]), np.abs(at[inner + 1] - at[inner]))
        bounds.append(bound if len(inner) and np.max(steps) > least else inf)
    return (bounds[0], bounds[1]) if np.any(np.isfinite(bounds)) else None


def _evidence(report: Report, found: _Deviations) -> Iterator[Evidence]:
    """Make the evidence of deviations, one for all deviations of the same kind and size."""
    exchanged = _other_maneuvers(report, found)
    yield from (MisplacedManeuver(n, of) for n, of in exchanged.items())
    found = {place: d for place, d in found.items() if place[0] not in exchanged}
    averaged = grouped((d.about[0], place) for place, d in found.items() if d.how == "averaged")
    for count, where in averaged.items():
        yield SmoothedColumns(tuple(f"{n}.{key}" for n, key in where), int(count))
    by_key = grouped((key, n) for n, key in found)
    for key, numbers in by_key.items():
        alike = grouped(
            ((d.how, d.other, d.of, *(float(f"{x:.5g}") for x in d.about)), n)
            for n in numbers
            for d in (found[n, key],)
        )
        for (how, other, number, *_), of in alike.items():
            about = found[of[0], key].about
            if how == "another":
                yield OtherColumn(
                    key, tuple(of), str(other), None if number is None else int(number)
                )
            elif how == "unsigned":
                yield UnsignedColumn(key, tuple(of))
            elif how in ("ratio", "ratio for a time"):
                by, more, first, last = about
                unit = _unit_of(report, key, by, more)
                yield ColumnRatio(key, tuple(of), by, more, unit, _finite(first), _finite(last))
            elif how == "step average":
                yield StepAverage(key, tuple(of), is_before=bool(about[0]))
            elif how in ("held", "late"):
                yield _moment(key, tuple(of), found[of[0], key])
            elif how == "multiple":
                yield PartMultiplied(tuple(of), str(other), about[0])
            elif how == "clipped":
                low, high = map(_finite, about)
                yield ClippedColumn(key, tuple(of), low, high, is_right_within=True)


def _moment(key: str, maneuvers: tuple[int, ...], d: _Deviation) -> OtherMoment:
    """Return the evidence of a column with the values of another moment."""
    part = d.other or None
    if d.how == "held":
        return OtherMoment(key, maneuvers, part, None)
    delay, step = d.about
    rows = round(delay / step)
    is_whole = abs(delay - rows * step) <= ROUNDING * abs(delay)
    return OtherMoment(key, maneuvers, part, delay, rows if is_whole else None)


def _other_maneuvers(report: Report, found: _Deviations) -> dict[int, int]:
    """Find maneuvers whose wrong columns all contain the values of one other maneuver.

    A single column may have been written to the wrong place, so at least half of the columns must.
    """
    exchanged = {}
    for m in report.maneuvers:
        columns = [c for c in m.compared if c.key in BENCHMARK_COLUMNS]
        wrong = [c.key for c in columns if not is_right_column(c)]
        deviations = [found.get((m.maneuver, key)) for key in wrong]
        held = {
            d.of if d is not None and d.other == key else None
            for key, d in zip(wrong, deviations, strict=True)
        }
        if len(held) == 1 and 2 * len(wrong) > m.column_count > 1:
            (of,) = held
            if of is not None:
                exchanged[m.maneuver] = of
    return exchanged


def _finite(x: float) -> float | None:
    return x if np.isfinite(x) else None


def _unit_of(report: Report, key: str, by: float, more: float) -> str | None:
    """Return the unit that is larger than a column's unit by this factor; None if there is none."""
    if more:
        return None
    _, c = report.by_column()[key][0]
    return unit_told_by(by, c.unit, c.as_understood.unit, TOLERANCE)


def of_other_maneuvers(
    maneuvers: Sequence[ManeuverScore],
) -> Iterator[ColumnOfAnotherManeuver]:
    """Find columns with the same numbers in two maneuvers, although their exact values differ."""
    for i, m in enumerate(maneuvers):
        for other in maneuvers[:i]:
            theirs = {c.key: c for c in other.columns}
            same = [c.key for c in m.columns if c.key in theirs and _are_same(c, theirs[c.key])]
            if not same:
                continue
            right, worse = sorted((m, other), key=lambda x: max(x[key].error for key in same))
            yield ColumnOfAnotherManeuver(worse.maneuver, right.maneuver, tuple(same))


def numbers_of_another_maneuver(report: Report) -> Undone | None:
    """Look for columns with the numbers of another maneuver, and leave them out.

    A maneuver is not left out as a whole.
    """
    found = [
        x
        for x in of_other_maneuvers(report.maneuvers)
        if {c.key for c in report[x.maneuver].columns} > {*x.keys}
    ]
    if not found:
        return None
    # One maneuver may contain columns of several other maneuvers.
    keys = grouped((x.maneuver, key) for x in found for key in x.keys)
    parts = (
        m.part.only(m.part.values.keys() - {*keys.get(m.maneuver, [])}) for m in report.maneuvers
    )
    return Undone(tuple(found), tuple(parts))


def _are_same(one: ColumnScore, other: ColumnScore) -> bool:
    a, b = one.trace, other.trace
    n = min(len(a.value), len(b.value))
    if (
        n < MIN_ROWS_FOR_SHAPE
        or not np.ptp(a.value)
        or not np.ptp(a.reference[:n] - b.reference[:n])
    ):
        return False
    return float(np.mean(a.value[:n] == b.value[:n])) > MOST_ROWS


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
