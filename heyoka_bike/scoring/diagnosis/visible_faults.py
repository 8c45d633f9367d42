"""Faults that are visible without any simulation.

These are: a bicycle that falls over; repeated or interpolated rows; columns of another maneuver;
wrong initial conditions; a motion that is right only until some time; and wrong columns while the
motion is right. For columns that the benchmark does not define, no program is simulated. There the
same number in every row, a factor and an offset are recognised.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.evidence.error_shape import FallsOver, NotDiagnosed
from heyoka_bike.scoring.evidence.output_faults import (
    AnotherStart,
    ColumnBeside,
    ColumnOfAnotherManeuver,
    ColumnsApart,
    Departs,
    RowsBetween,
    RowsRepeated,
)
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.judge.own_definitions import far_worse, is_far
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.maneuvers import last_step, standing_still
from heyoka_bike.scoring.rows.other_maneuvers import of_other_maneuvers
from heyoka_bike.scoring.rows.other_times import AtOtherTimes, fitted_clock, meant_by
from heyoka_bike.scoring.rows.scaled_columns import scaled
from heyoka_bike.scoring.rows.table import ENERGY, PARTS_OF_ENERGY, is_right_column, whole_columns
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.scoring.units import unit_told_by

# Rows count as repeated, or as interpolated between fewer rows, if the fraction of such rows
# exceeds the first value. The second value is a number of parts of the run: the fraction must be
# exceeded in all parts but one.
_BETWEEN, _PARTS_OF_RUN = 0.2, 4
# Largest distance of two right rows between which other rows may be interpolated [rows].
_MOST_BETWEEN = 200
# An error that begins at the start of the run grows at most with this power of time.
_LARGEST_POWER = 20.0
# Lean of a bicycle that lies on the floor [rad].
_LEAN_OF_LYING = np.pi / 2
# A fall begins at a lean below the first value, and its lean changes from row to row by less than
# the second value [rad]. Noise changes the lean by more.
_UPRIGHT, _STRIDE = 0.1, 1.0
_GIVEN = ("roll_rate", "forward_speed")


VisibleFault = (
    FallsOver | RowsRepeated | RowsBetween | ColumnOfAnotherManeuver | AnotherStart | Departs
)
"""Faults of the benchmark's columns that are visible without simulation."""


def shown(report: Report) -> tuple[VisibleFault, ...]:
    """Return the faults of the benchmark's columns that are visible without simulation."""
    maneuvers = report.maneuvers
    found: list[VisibleFault] = [*_falls_over(maneuvers), *standing_still(maneuvers)]
    found += _between(maneuvers)
    found += of_other_maneuvers(maneuvers)
    found += _other_starts(maneuvers)
    known = {
        n
        for x in found
        if not isinstance(x, FallsOver)
        for n in ((x.maneuver,) if isinstance(x, ColumnOfAnotherManeuver) else x.maneuvers)
    }
    return (*found, *_departures([m for m in maneuvers if m.maneuver not in known]))


def _falls_over(maneuvers: Sequence[ManeuverScore]) -> Iterator[FallsOver]:
    """Find maneuvers whose lean exceeds a quarter turn, while that of the reference does not."""
    times = {}
    for m in maneuvers:
        traces = {c.key: c.trace for c in m.columns if c.values == m.rows}
        if not {"roll_angle", "potential_energy"} <= traces.keys():
            continue
        roll, height = traces["roll_angle"], traces["potential_energy"]
        # A low potential energy shows that the bicycle has really fallen over, so the large angle
        # is not just in a wrong unit.
        low = height.value < MEANINGLESS_ERROR * height.reference
        lies = (
            low & (np.abs(roll.value) > _LEAN_OF_LYING) & (np.abs(roll.reference) < _LEAN_OF_LYING)
        )
        row = int(np.argmax(lies))
        way = np.abs(roll.value[: row + 1])
        if lies.any() and way[0] < _UPRIGHT and np.max(np.abs(np.diff(way))) < _STRIDE:
            times[m.maneuver] = float(roll.time[row])
    if times:
        yield FallsOver(times)


def _between(maneuvers: Sequence[ManeuverScore]) -> Iterator[RowsBetween]:
    """Find rows whose angles and rates repeat other rows, or are interpolated between fewer rows.

    It suffices if most of these columns show it, because one may be computed from the others in
    each row. If fewer columns show it, or another one is right, the evidence names them.
    """
    found = {m.maneuver: x for m in maneuvers if (x := _rows_between(m)) is not None}
    for (order, keys, every), each in grouped(
        ((x.order, x.keys, x.every), x) for x in found.values()
    ).items():
        numbers = tuple(n for x in each for n in x.maneuvers)
        yield RowsBetween(numbers, order, min(x.share for x in each), keys, every)


def _rows_between(m: ManeuverScore) -> RowsBetween | None:
    """Describe how a maneuver's rows are interpolated between fewer rows; None if they are not."""
    lateral = [c for c in m.columns if c.key in LATERAL and c.values == m.rows]
    for order in (1, 2):
        shares = {c.key: x for c in lateral if (x := _flat(c, order)) > _BETWEEN}
        if shares:
            # A right column shows that the rows as a whole were computed.
            are_most = len(shares) > max(len(lateral) / 2, 1)
            named = tuple(shares) if not are_most or any(map(is_right_column, lateral)) else ()
            return RowsBetween((m.maneuver,), order - 1, min(shares.values()), named)
    counts = {c.key: count for c in lateral if (count := _right_rows(c))}
    every = max(counts.values(), default=0)
    if every and 2 * sum(x == every for x in counts.values()) > len(lateral):
        return RowsBetween((m.maneuver,), 2, 1.0 - 1.0 / every, (), every)
    return None


def _right_rows(c: ColumnScore) -> int:
    """Return n if only every nth row, from the first on, is right; 0 if there is no such n.

    The errors of the rows between must be visible in a plot, and larger by the factor `BY_FAR`.
    """
    error = np.abs(c.trace.error)
    if float(np.max(error)) <= TOLERANCE * c.scale:
        return 0
    # The upper quartile is the error of a row between right rows, even if only half of all rows lie
    # between right rows.
    usual = float(np.quantile(error, 0.75))
    most = min(len(error) // MIN_ROWS_FOR_SHAPE, _MOST_BETWEEN)
    for every in range(2, most + 1):
        if BY_FAR * float(np.max(error[::every])) < usual:
            return every
    return 0


def _flat(c: ColumnScore, order: int) -> float:
    """Return the fraction of rows where a column is wrongly constant (order 1) or straight (2).

    Only rows count in which the exact motion changes, or curves, and only until the last change of
    the column. The share is the second smallest of the parts of the run.
    """
    tiny = MAX_ROUNDING_FLOORS * 2.0**order * (c.floor or 0.0)
    rows = slice(last_step(c) + 1)
    step = np.diff(c.trace.time[rows])
    # Suppress the warnings about two rows at the same time, between which the slope is not defined.
    with np.errstate(all="ignore"):
        found, right = (
            np.abs(np.diff(x) if order == 1 else np.diff(np.diff(x) / step) * step[1:])
            for x in (c.trace.value[rows], c.trace.reference[rows])
        )
    # Rows that are set to zero do not count as repeated.
    is_zero = (c.trace.value[rows] == 0.0)[order:]
    moves = (right > CLEARLY * tiny) & ~is_zero
    if len(moves) < MIN_ROWS_FOR_SHAPE or 2 * moves.sum() <= len(moves):
        return 0.0
    # In a column of few digits many differences are equal, so they do not show repeated rows.
    steps = np.round(found[moves & (found > np.median(right))] / (tiny or 1.0), 1)
    if 2 * len(np.unique(steps)) <= len(steps):
        return 0.0
    # In each part the changes must be far larger than the unit of the last digit, because a motion
    # that hardly moves also seems to stand still. One part of the run may be an exception: a motion
    # that decays ends on a straight line.
    parts = np.array_split(found[moves], _PARTS_OF_RUN)
    shares = [
        float(np.mean(x <= tiny))
        if (x > tiny).any() and np.median(x[x > tiny]) >= CLEARLY * tiny
        else 0.0
        for x in parts
    ]
    return sorted(shares)[1]


def are_departures(seen: Sequence[VisibleFault], report: Report) -> bool:
    """True if every wrong maneuver is right at its start, or in every nth row."""
    departs = {n for x in seen if isinstance(x, Departs) for n in x.maneuvers}
    departs |= {n for x in seen if isinstance(x, RowsBetween) and x.every for n in x.maneuvers}
    wrong = {m.maneuver for m, c in report.places if not (c.is_right or c.is_hidden)}
    return bool(departs) and departs >= wrong


def _departures(maneuvers: Sequence[ManeuverScore]) -> Iterator[Departs]:
    """Find maneuvers that are right up to some row, and soon after have errors 100 times larger.

    Maneuvers that depart in the same way are in one piece of evidence, also if their times differ.
    """
    each = (x for m in maneuvers if (x := _departure_of(m)) is not None)
    alike = grouped(
        ((x.keys, x.t_back, None if x.shift is None else f"{x.shift:.5g}"), x) for x in each
    )
    for found in alike.values():
        yield replace(
            found[0],
            maneuvers=tuple(n for x in found for n in x.maneuvers),
            t_right=tuple(t for x in found for t in x.t_right),
            times=tuple(t for x in found for t in x.times),
            before=max(x.before for x in found),
            after=max(x.after for x in found),
        )


def _departure_of(m: ManeuverScore) -> Departs | None:
    """Find where a maneuver departs from the exact motion; None if it does not."""
    whole = whole_columns(m)
    # If the motion is wrong, only columns with a single definition can be compared.
    single = [c for c in whole if len(m.part.reference.definitions[c.key]) == 1]
    found = _departs(m, whole)
    if found is None and len(single) < len(whole):
        found = _departs(m, single, tuple(c.key for c in single))
    return found


def _departs(
    m: ManeuverScore, columns: Sequence[ColumnScore], keys: tuple[str, ...] = ()
) -> Departs | None:
    """Find where columns depart from the exact ones, or None; `keys` go to the evidence."""
    if not columns:
        return None
    error = np.max([np.abs(c.trace.error) / c.scale for c in columns], axis=0)
    floor = max(ROUNDING, *((c.floor or 0.0) / c.scale for c in columns))
    off, time = np.maximum(error, floor), columns[0].trace.time
    rows = _departure(off, time)
    if rows is None or off[rows[0]] > TOLERANCE:
        return None
    last, row = rows
    # A variable step may increase the error by the factor `BY_FAR` within one step of the
    # integrator. So if rows lie between the last correct row and the first row with a large error,
    # the last correct row must be correct up to rounding, and the error must become large.
    is_right = off[last] <= max(THRESHOLDS.negligible_error, MAX_ROUNDING_FLOORS * floor)
    if row > last + 1 and not (is_right and np.max(off) > TOLERANCE / CLEARLY):
        return None
    right = float(np.max(off[: last + 1]))
    end = int(np.flatnonzero(off > BY_FAR * right)[-1]) + 1
    is_back = m.rows - end >= MIN_ROWS_FOR_SHAPE
    ahead, relief = _shift_from(m, columns, row)
    return Departs(
        (m.maneuver,),
        (float(time[last]),),
        (float(time[row]),),
        right,
        float(off[row]),
        float(time[end - 1]) if is_back else None,
        ahead if relief > THRESHOLDS.direction_factor and not is_back else None,
        keys,
    )


def _shift_from(
    m: ManeuverScore, columns: Sequence[ColumnScore], first: int
) -> tuple[float, float]:
    """Fit a time shift [s] to the rows from `first` on; return it and the relief of errors."""
    there = AtOtherTimes(m, columns, slice(first, None))
    clock = fitted_clock([there], (1,))
    if clock is None:
        return 0.0, 1.0
    left, rows = there.off(meant_by(there.time, clock))
    before, _ = there.off(there.time)
    least = float(np.finfo(np.float64).tiny)
    return float(clock[1]), rms(before[:, rows].ravel()) / max(rms(left[:, rows].ravel()), least)


def _departure(off: Array, time: Array) -> tuple[int, int] | None:
    """Return the last right row, and the first row with an error 100 times larger.

    None if the error grows no faster than an error that begins at the start.
    """
    most = np.maximum.accumulate(off)
    # For each row, index of the first row whose error exceeds all errors up to this row by the
    # factor `BY_FAR`.
    far = np.searchsorted(most, BY_FAR * most, side="right")
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for last in np.flatnonzero((far < len(off)) & (time > 0.0)):
            row = int(far[last])
            if np.log(most[row] / most[last]) > _LARGEST_POWER * np.log(time[row] / time[last]):
                # Rows count as right while the error is at most `AS_GOOD` times its largest value
                # so far.
                good = np.searchsorted(most, AS_GOOD * most[last], side="right") - 1
                return int(good), row
    return None


def other_heights(report: Report) -> tuple[AnotherStart, ...]:
    """Find first rows with a visibly wrong potential energy: a wrong mass or length shows there."""
    found = _other_starts(report.maneuvers, ("potential_energy",))
    return tuple(x for x in found if x.is_visible)


def _other_starts(
    maneuvers: Sequence[ManeuverScore], keys: Collection[str] = _GIVEN
) -> Iterator[AnotherStart]:
    """Find first rows whose roll rate or speed differs from the given initial value."""
    found: list[tuple[tuple[str, float, float, str, str | None], int]] = []
    for m in maneuvers:
        for c in m.columns:
            if c.key not in keys or not c.values or not c.is_known or c.trace.time[0] != 0.0:
                continue
            given, here = float(c.trace.reference[0]), float(c.trace.value[0])
            # A wrong motion does not show how a column is defined, so try all definitions.
            meant = m.part.reference.definitions[c.key]
            starts = m.part.reference.approximate(np.zeros(1), [x.name for x in meant])
            off = min(abs(here - float(x[0])) for x in starts.values())
            if off > max(RIGHT * abs(given), c.hidden):
                told = None
                if given:
                    ratio, taken = here / given, c.as_understood.unit
                    told = unit_told_by(ratio, c.unit, taken, RIGHT)
                found.append(((c.key, here, given, c.unit, told), m.maneuver))
    for alike, numbers in grouped(found).items():
        yield AnotherStart(tuple(numbers), *alike)


def columns_apart(report: Report) -> ColumnsApart | None:
    """Find wrong columns, if all other columns show that the motion is right."""
    each = {
        m.maneuver: far_worse(m, [c.key for c in m.columns], _whole_error) for m in report.maneuvers
    }
    apart = {key for keys, _ in each.values() for key in keys}
    if not apart or any(not keys and limit > TOLERANCE for keys, limit in each.values()):
        return None
    # If a part of the energy is wrong, the sum is wrong, too, so the sum is not a further fault.
    is_sum_with_it = ENERGY in apart and not apart.isdisjoint(PARTS_OF_ENERGY)
    if is_sum_with_it:
        apart.remove(ENERGY)
    wrong = {key: places for key, places in report.by_column().items() if key in apart}
    found = {
        key: tuple(
            m.maneuver
            for m, c in places
            if key in each[m.maneuver][0] or is_far(c, each[m.maneuver][1], CLEARLY)
        )
        for key, places in wrong.items()
    }
    fits = {key: fit for key, places in wrong.items() if (fit := scaled([c for _, c in places]))}
    units = {key: places[0][1].unit for key, places in wrong.items()}
    rest = max(limit for _, limit in each.values())
    return ColumnsApart(found, len(each), rest, fits, units, is_sum_with_it)


def _whole_error(c: ColumnScore) -> float:
    """Return the RMS error relative to the RMS of the column, so that a few bad rows count."""
    return rms(c.trace.error) / (rms(c.trace.reference) or 1.0)


def faults_in_other_columns(
    report: Report, left_out: Collection[str] = ()
) -> tuple[ColumnBeside | NotDiagnosed, ...]:
    """Return the evidence of wrong columns that the benchmark does not define.

    Parameters
    ----------
    left_out
        Keys of columns with an unknown definition. They are not assumed to be right, and are
        reported only if a factor or an offset explains them.
    """
    found: list[ColumnBeside | NotDiagnosed] = []
    others = []
    for key, places in report.by_column().items():
        wrong = [(m, c) for m, c in places if not (c.is_right or c.is_hidden)]
        if key in BENCHMARK_COLUMNS or not wrong:
            continue
        if all(_is_alone(m, c, left_out) for m, c in wrong):
            columns = {m.maneuver: c for m, c in wrong}
            found += _isolated_wrong_columns(key, columns, is_unknown=key in left_out)
        elif key not in left_out:
            others.append(key)
    if others:
        found.append(NotDiagnosed(tuple(others)))
    return tuple(found)


def _is_alone(m: ManeuverScore, c: ColumnScore, left_out: Collection[str]) -> bool:
    """True if the benchmark's columns of the maneuver are right, and this column is far off."""
    right = {*BENCHMARK_COLUMNS} - {*left_out}
    limit = max((x.error for x in m.compared if x.key in right), default=1.0)
    return limit < TOLERANCE and is_far(c, limit, CLEARLY)


def _isolated_wrong_columns(
    key: str, columns: Mapping[int, ColumnScore], *, is_unknown: bool
) -> Iterator[ColumnBeside]:
    """Yield the evidence of a column that is wrong while the benchmark's columns are right.

    `columns` has the number of the maneuver as key.
    """
    worst = max(c.error for c in columns.values())
    unit = next(iter(columns.values())).unit
    # The constant values of a column, for maneuvers in which the exact values vary.
    held = [float(c.trace.value[0]) for c in columns.values()
            if not np.ptp(c.trace.value) and np.ptp(c.trace.reference)]  # fmt: skip
    fit = scaled([*columns.values()])
    seen = ColumnBeside(key, tuple(columns), unit, worst)
    if len(held) == len(columns):
        yield replace(seen, constant=tuple(held))
    elif fit:
        yield replace(seen, fit=fit)
    elif not is_unknown:
        yield seen
