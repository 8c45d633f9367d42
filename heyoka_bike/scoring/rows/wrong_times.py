"""Wrong times: whether the rows of a file are right at other times than those written.

Three looks, each with no more unknowns than the columns can tell: rows that are counted have none,
one scale for the whole file has one, and a scale and a shift of each maneuver have two.
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
from heyoka_bike.scoring.evidence.output_faults import OtherClock, TimesAddedUp
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY, FEW_COLUMNS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.edits import Clock
from heyoka_bike.scoring.rows.other_times import AtOtherTimes, fitted_clock, meant_by
from heyoka_bike.scoring.rows.table import Undone, floor_of, is_right_column, whole_columns
from heyoka_bike.scoring.scores import ManeuverScore

# Digits of a step that somebody chose.
_DIGITS_OF_STEP = 3


class _Wrong(AtOtherTimes):
    """The wrong columns of a maneuver."""

    def __init__(self, m: ManeuverScore) -> None:
        whole = whole_columns(m) if m.rows >= MIN_ROWS_FOR_SHAPE else []
        wrong = [c for c in whole if c.key in BENCHMARK_COLUMNS and not is_right_column(c)]
        super().__init__(m, wrong)

    @cached_property
    def before(self) -> Array:
        """What the times written leave."""
        return self.left(self.time)

    @cached_property
    def floors(self) -> Array:
        """What the digits can tell of each column."""
        return np.array([c.hidden / c.scale for c in self.columns])

    def are_right(self, left: Array) -> bool:
        """True if so little is left, and so much less than there was, that the times are meant."""
        falls = (left * BY_FAR < self.before) | (left <= self.floors)
        # To fall to the digits from next to them shows nothing.
        is_shown = bool(np.any(left * BY_FAR < self.before))
        return is_shown and bool(np.all(falls) and np.max(left, initial=0.0) < TOLERANCE)


def other_unit(report: Report) -> Undone | None:
    """Times in minutes or hours, as was seen when the file was aligned."""
    larger = next((x for x in report.seen if isinstance(x, TimesInLargerUnit)), None)
    # The evidence is empty: `diagnosed` reports the unit with the other evidence of the times.
    return None if larger is None else _at_other_times(report, (), larger.seconds, 0.0)


def late_rows(report: Report) -> Undone | None:
    """Times that are all shifted, as was seen when the file was judged."""
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
    """Rows that are the right ones of multiples of a step, from which the written times creep away.

    Times that are added up do so, above all in single precision.
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
    """A decimal step and its multiples, one for each row, that are not the times written."""
    step = float(f"{(time[-1] - time[0]) / max(len(time) - 1, 1):.{_DIGITS_OF_STEP}g}")
    if not step > 0.0:
        return None
    count = np.rint((time - time[0]) / step)
    meant = time[0] + step * count
    is_written = np.max(np.abs(time - meant)) <= np.finfo(np.float64).eps * time[-1]
    return None if is_written or np.any(np.diff(count) != 1.0) else (step, meant)


def _is_single_sum(time: Array, step: float) -> bool:
    """True if times are what adding up a step in single precision gives."""
    steps = np.full(len(time), np.float32(step))
    steps[0] = np.float32(time[0])
    return bool(np.array_equal(np.add.accumulate(steps).astype(np.float64), time))


def one_clock(report: Report) -> Undone | None:
    """Rows that are the right ones of times on one scale, where no maneuver tells its own clock."""
    every = [_Wrong(m) for m in report.maneuvers]
    counts = [len(wrong.columns) for wrong in every]
    if sum(counts) < FEW_COLUMNS or max(counts) > FEW_COLUMNS or not all(counts):
        return None
    clock = fitted_clock(every, (0,))
    if clock is None or not all(x.are_right(x.left(meant_by(x.time, clock))) for x in every):
        return None
    if any(_is_refuted(m, clock) for m in report.maneuvers):
        return None
    scale = 1.0 + float(clock[0])
    parts = tuple(_on_clock(m.part, scale, 0.0) for m in report.maneuvers)
    return Undone((OtherClock(None, scale, 0.0, None),), parts)


def other_clocks(report: Report) -> Undone | None:
    """Rows that are right at other times: by one clock for all maneuvers, or by several."""
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
            if _is_refuted(m, np.array([scale - 1.0, shift])):
                # Only the wrong columns belong to other times, and are left out of what follows.
                keys = tuple(c.key for c in _Wrong(m).columns)
                seen.append(OtherClock(m.maneuver, scale, shift, rows, keys))
                part = part.only(part.values.keys() - {*keys})
            else:
                seen.append(OtherClock(m.maneuver, scale, shift, rows))
                part = _on_clock(part, scale, shift)
        parts.append(part)
    return Undone(tuple(seen), tuple(parts))


def _common_clock(report: Report, *clocks: tuple[float, float]) -> Undone | None:
    """One clock for all maneuvers: the mean of their scales, and of their shifts."""
    scale, shift = (float(np.mean(x)) for x in zip(*clocks, strict=True))
    if any(_is_refuted(m, np.array([scale - 1.0, shift])) for m in report.maneuvers):
        return None
    step = report.maneuvers[0].step
    parts = tuple(_on_clock(m.part, scale, shift) for m in report.maneuvers)
    return Undone((OtherClock(None, scale, shift, shift / step if step else None),), parts)


def _is_refuted(m: ManeuverScore, clock: Array) -> bool:
    """True if a column that is right would be wrong at the times of a clock."""
    right = AtOtherTimes(m, [c for c in whole_columns(m) if is_right_column(c)])
    left = right.left(meant_by(right.time, clock))
    limits = [floor_of(c) / c.scale for c in right.columns]
    return bool(np.any(left > CLEARLY * np.array(limits)))


def _on_clock(part: Part, scale: float, shift: float) -> Part:
    """The rows at the times that are meant, of those that are then within the run."""
    return Clock(scale, shift).undo(part).within_run()


def _rounded(clock: tuple[float, float]) -> tuple[float, float]:
    scale, shift = clock
    return round(scale - 1, 6), float(f"{shift:.2g}")


def _own_clock(m: ManeuverScore) -> tuple[float, float] | None:
    """Scale and shift of the times that make all columns of a maneuver right."""
    wrong = _Wrong(m)
    if len(wrong.columns) <= FEW_COLUMNS:
        return None
    clocks = [fitted_clock([wrong], of) for of in ((1,), (0,), (0, 1))]
    found = [(c, wrong.left(meant_by(wrong.time, c))) for c in clocks if c is not None]
    # Where both together lead too far, nothing is held against one of them.
    least = found[-1][1] if clocks[-1] is not None else np.inf
    for clock, left in found:
        is_as_good = np.all(left <= np.maximum(AS_GOOD * least, wrong.floors))
        if is_as_good and wrong.are_right(left):
            return 1.0 + float(clock[0]), float(clock[1])
    return None
