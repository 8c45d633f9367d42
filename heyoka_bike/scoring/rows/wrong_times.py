"""Find out whether the rows of a file are right at times other than those written.

There are four row checks, and each fits only as many unknowns as the columns determine: times that
are multiples of a step (no unknown), one scale for the whole file (one unknown), a scale and a
shift for each maneuver (two unknowns), and a time for each row.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.double import Array, multiply, two_sum
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.as_compared import TimesInLargerUnit
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import TimeShift
from heyoka_bike.scoring.evidence.output_faults import (
    OtherClock,
    OtherTimes,
    RowTimes,
    TimesAddedUp,
)
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY, FEW_COLUMNS, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.edits import Clock
from heyoka_bike.scoring.rows.other_times import AtOtherTimes, fitted_clock, meant_by
from heyoka_bike.scoring.rows.table import Undone, floor_of, is_right_column, whole_columns
from heyoka_bike.scoring.scores import ManeuverScore

# Significant digits of a step entered by a person.
_DIGITS_OF_STEP = 3
# Rows count as unsorted if more than this fraction of them are followed by a row that belongs to an
# earlier time. A program that writes old rows again after an interruption causes only one such step
# back.
_DISORDERED = 0.05


class _Wrong(AtOtherTimes):
    """The wrong benchmark columns of a maneuver; none if it has too few rows."""

    def __init__(self, m: ManeuverScore) -> None:
        whole = whole_columns(m) if m.rows >= MIN_ROWS_FOR_SHAPE else []
        wrong = [c for c in whole if c.key in BENCHMARK_COLUMNS and not is_right_column(c)]
        super().__init__(m, wrong)

    @cached_property
    def before(self) -> Array:
        """RMS error of each column at the written times, in scales."""
        return self.left(self.time)

    @cached_property
    def floors(self) -> Array:
        """Largest error of each column that its digits hide, in scales."""
        return np.array([c.hidden / c.scale for c in self.columns])

    def are_right(self, left: Array) -> bool:
        """True if times that leave these RMS errors, in scales, are the correct times.

        Every error must fall by the factor `BY_FAR`, to the digits written, or to the square of
        this factor below the largest error, and be below `TOLERANCE`.
        """
        negligible = np.maximum(self.floors, np.max(self.before, initial=0.0) / BY_FAR**2)
        falls = (left * BY_FAR < self.before) | (left <= negligible)
        # At least one error must fall by the factor `BY_FAR`. It proves nothing if all errors fall
        # only a little, to the level of the written digits.
        is_shown = bool(np.any(left * BY_FAR < self.before))
        return is_shown and bool(np.all(falls) and np.max(left, initial=0.0) < TOLERANCE)


def other_unit(report: Report) -> Undone | None:
    """Correct times in minutes or hours, which the alignment has found."""
    larger = next((x for x in report.seen if isinstance(x, TimesInLargerUnit)), None)
    # No evidence is added here, because `diagnosed` reports the unit together with the other
    # evidence on the times.
    return None if larger is None else _at_other_times(report, (), larger.seconds, 0.0)


def late_rows(report: Report) -> Undone | None:
    """Correct a constant shift of all times, which the comparison with the reference has found."""
    late = next((x for x in report.seen if isinstance(x, TimeShift)), None)
    return None if late is None else _at_other_times(report, (late,), 1.0, late.shift)


def _at_other_times(
    report: Report, seen: tuple[Evidence, ...], scale: float, shift: float
) -> Undone | None:
    """Multiply the times by a scale, subtract a shift, and keep the rows within the run.

    None if a maneuver then has no row with a value.
    """
    parts = []
    for part in (m.part for m in report.maneuvers):
        factor = np.full_like(part.time, scale), np.zeros_like(part.time)
        hi, lo = multiply((part.time, part.time_lo), factor)
        time, rest = two_sum(hi, np.full_like(hi, -shift))
        parts.append(replace(part, time=time, time_lo=rest + lo).within_run())
    return Undone(seen, tuple(parts)) if all(part.has_values() for part in parts) else None


def counted_rows(report: Report) -> Undone | None:
    """Look for rows that are right at multiples of a step from which the written times drift away.

    This happens if the program adds up the steps, above all in single precision.
    """
    every = [_Wrong(m) for m in report.maneuvers]
    if not any(wrong.columns for wrong in every):
        return None
    steps, creeps, singles, parts = [], [], [], []
    for m, wrong in zip(report.maneuvers, every, strict=True):
        counted = _counted(wrong.time)
        if counted is None:
            return None
        step, meant = counted
        if wrong.columns and not wrong.are_right(wrong.left(meant)):
            return None
        steps.append(step)
        creeps.append(float(np.max(np.abs(wrong.time - meant))))
        singles.append(_is_single_sum(wrong.time, step))
        parts.append(replace(m.part, time=meant, time_lo=np.zeros_like(meant)).within_run())
    if len(set(steps)) > 1:
        return None
    return Undone((TimesAddedUp(steps[0], max(creeps), all(singles)),), tuple(parts))


def _counted(time: Array) -> tuple[float, Array] | None:
    """Find a decimal step, and one multiple for each row; None if the times are these multiples."""
    step = float(f"{(time[-1] - time[0]) / max(len(time) - 1, 1):.{_DIGITS_OF_STEP}g}")
    if not step > 0.0:
        return None
    count = np.rint((time - time[0]) / step)
    meant = time[0] + step * count
    is_written = np.max(np.abs(time - meant)) <= np.finfo(np.float64).eps * time[-1]
    return None if is_written or np.any(np.diff(count) != 1.0) else (step, meant)


def _is_single_sum(time: Array, step: float) -> bool:
    """True if adding up the step in single precision gives exactly these times."""
    steps = np.full(len(time), np.float32(step))
    steps[0] = np.float32(time[0])
    return bool(np.array_equal(np.add.accumulate(steps).astype(np.float64), time))


def one_clock(report: Report) -> Undone | None:
    """Look for one scale of all times, if single maneuvers have too few wrong columns for a fit."""
    every = [_Wrong(m) for m in report.maneuvers]
    counts = [len(wrong.columns) for wrong in every]
    if sum(counts) < FEW_COLUMNS or max(counts) > FEW_COLUMNS or not all(counts):
        return None
    clock = fitted_clock(every, (0,))
    if clock is None or not all(x.are_right(x.left(meant_by(x.time, clock))) for x in every):
        return None
    if any(_is_refuted(m, meant_by(m.part.time, clock)) for m in report.maneuvers):
        return None
    scale = 1.0 + float(clock[0])
    parts = tuple(_on_clock(m.part, scale, 0.0) for m in report.maneuvers)
    return Undone((OtherClock(None, scale, 0.0, None),), parts)


def other_clocks(report: Report) -> Undone | None:
    """Look for a scale and a shift of the times, common to all maneuvers or different in each."""
    clocks = {m.maneuver: found for m in report.maneuvers if (found := _own_clock(m)) is not None}
    same = {_rounded(clock) for clock in clocks.values()}
    if not clocks:
        return None
    if len(clocks) == len(report.maneuvers) and len(same) == 1:
        return _common_clock(report, *clocks.values())
    seen, parts = [], []
    for m in report.maneuvers:
        part = m.part
        if m.maneuver in clocks:
            scale, shift = clocks[m.maneuver]
            rows = shift / m.step if m.step else None
            if _is_refuted(m, scale * m.part.time + shift):
                # Only the wrong columns belong to other times. All later steps leave them out.
                keys = tuple(c.key for c in _Wrong(m).columns)
                seen.append(OtherClock(m.maneuver, scale, shift, rows, keys))
                part = part.only(part.values.keys() - {*keys})
            else:
                seen.append(OtherClock(m.maneuver, scale, shift, rows))
                part = _on_clock(part, scale, shift)
        parts.append(part)
    return Undone(tuple(seen), tuple(parts))


def _common_clock(report: Report, *clocks: tuple[float, float]) -> Undone | None:
    """Correct the times of all maneuvers by one clock: the mean of their scales and shifts."""
    scale, shift = (float(np.mean(x)) for x in zip(*clocks, strict=True))
    if any(_is_refuted(m, scale * m.part.time + shift) for m in report.maneuvers):
        return None
    step = report.maneuvers[0].step
    parts = tuple(_on_clock(m.part, scale, shift) for m in report.maneuvers)
    return Undone((OtherClock(None, scale, shift, shift / step if step else None),), parts)


def own_times(report: Report) -> Undone | None:
    """Look for a time of its own for each row at which all its columns are right.

    The rows may be in another order, written again, or of steps other than those written. Each row
    has one unknown, so every wrong maneuver needs more columns than the few that always agree on
    some time.
    """
    seen: dict[int, RowTimes] = {}
    parts = []
    for m in report.maneuvers:
        part, wrong = m.part, _Wrong(m)
        if wrong.columns:
            found = _own_times(m, wrong)
            if found is None:
                return None
            meant, seen[m.maneuver] = found
            order = np.argsort(meant, kind="stable")
            part = replace(part.at(order), time=meant[order], time_lo=np.zeros_like(meant))
            part = part.at_distinct_times()
        parts.append(part)
    return Undone((OtherTimes(seen),), tuple(parts)) if seen else None


def _own_times(m: ManeuverScore, wrong: _Wrong) -> tuple[Array, RowTimes] | None:
    """Find the times at which all rows of a maneuver are right, and describe them, or None."""
    rows = AtOtherTimes(m, [c for c in whole_columns(m) if c.key in BENCHMARK_COLUMNS])
    # Wrong energies count as one column: if their sum is constant, each part determines the other.
    energies = sum(c.key.endswith("_energy") for c in wrong.columns)
    if len(wrong.columns) - max(energies - 1, 0) <= FEW_COLUMNS:
        return None
    nearest = rows.nearest()
    least = np.array([floor_of(c) / c.scale for c in rows.columns])
    limit = CLEARLY * np.maximum(rows.left(nearest), least)
    # Keep the written time of rows that are also right at this time. Where the motion hardly
    # changes, every time is right.
    is_off = np.any(np.abs(rows.off(rows.time)[0]) > limit[:, None], axis=0)
    meant = np.where(is_off, nearest, rows.time)
    left = wrong.left(meant)
    if not is_off.any() or not wrong.are_right(left) or _is_refuted(m, meant):
        return None
    ahead = (meant - rows.time)[is_off]
    low, high = np.quantile(ahead, ((1 - MOST_ROWS) / 2, (1 + MOST_ROWS) / 2)).tolist()
    if (
        CLEARLY * (high - low) < abs(high + low)
        and np.mean(is_off[np.argmax(is_off) :]) > MOST_ROWS
    ):
        # All rows from some time on have the same shift, which is simpler than a time for each row.
        # `visible_faults` reports this departure.
        return None
    written, most = rows.time[is_off], int(np.argmax(np.abs(ahead)))
    return meant, RowTimes(
        rows=int(is_off.sum()),
        of=m.rows,
        first=float(written[0]),
        last=float(written[-1]),
        ahead=(low, high),
        example=(float(written[most]), float(written[most] + ahead[most])),
        relief=rms(wrong.before) / max(rms(left), ROUNDING),
        is_disordered=bool(np.mean(np.diff(meant) < -np.diff(rows.time) / 2) > _DISORDERED),
    )


def _is_refuted(m: ManeuverScore, meant: Array) -> bool:
    """True if a column that is right at the written times is wrong at the times `meant`."""
    right = AtOtherTimes(m, [c for c in whole_columns(m) if is_right_column(c)])
    left = right.left(meant)
    limits = [floor_of(c) / c.scale for c in right.columns]
    return bool(np.any(left > CLEARLY * np.array(limits)))


def _on_clock(part: Part, scale: float, shift: float) -> Part:
    """Return the rows at the times of a clock, without rows that are then outside the run."""
    return Clock(scale, shift).undo(part).within_run()


def _rounded(clock: tuple[float, float]) -> tuple[float, float]:
    scale, shift = clock
    return round(scale - 1, 6), float(f"{shift:.2g}")


def _own_clock(m: ManeuverScore) -> tuple[float, float] | None:
    """Find a scale and a shift [s] of the times with which all columns are right, or None."""
    wrong = _Wrong(m)
    if len(wrong.columns) <= FEW_COLUMNS:
        return None
    clocks = [fitted_clock([wrong], of) for of in ((1,), (0,), (0, 1))]
    found = [(c, wrong.left(meant_by(wrong.time, c))) for c in clocks if c is not None]
    # Prefer a shift alone, or otherwise a scale alone, if its error is as small as that of both
    # together. If the fit of both failed, use either one.
    least = found[-1][1] if clocks[-1] is not None else np.inf
    for clock, left in found:
        is_as_good = np.all(left <= np.maximum(AS_GOOD * least, wrong.floors))
        if is_as_good and wrong.are_right(left):
            return 1.0 + float(clock[0]), float(clock[1])
    return None
