"""Find out whether the rows of a file are right at times other than those written.

Three row checks fit only as many unknowns as the columns determine: times that are multiples of a
step (no unknown), a scale and a shift for the whole file or for each maneuver (one or two
unknowns), and a time for each row. If the columns are few, a row can only have the time of another
row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.double import Array, multiply, two_sum
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.as_compared import TimesInLargerUnit
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import TimeShift
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.ratios import AS_GOOD, CLEARLY, FEW_COLUMNS, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.edits import Clock
from heyoka_bike.scoring.rows.other_times import AtOtherTimes, WrongColumns, fitted_clock, meant_by
from heyoka_bike.scoring.rows.table import Undone, floor_of, is_right_column, whole_columns
from heyoka_bike.scoring.scores import ManeuverScore

_PART_OF_A_ROW = 0.05
"""Smallest shift, in rows, that the message also states in rows."""

# Significant digits of a step entered by a person.
_DIGITS_OF_STEP = 3
# Rows count as unsorted if more than this fraction of them are followed by a row that belongs to an
# earlier time. A program that writes old rows again after an interruption causes only one such step
# back.
_DISORDERED = 0.05


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


def counted_rows(report: Report) -> Undone | None:
    """Look for rows that are right at multiples of a step from which the written times drift away.

    This happens if the program adds up the steps, above all in single precision.
    """
    every = [WrongColumns(m) for m in report.maneuvers]
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


def other_clocks(report: Report) -> Undone | None:
    """Look for a scale and a shift of the times, common to all maneuvers or different in each."""
    every = [WrongColumns(m) for m in report.maneuvers]
    if all(wrong.columns for wrong in every):
        common = _fitted(every)
        if common is not None or len(every) == 1:
            return common and _on_common_clock(report, *common)
    seen, parts = [], []
    for m, wrong in zip(report.maneuvers, every, strict=True):
        part = m.part
        clock = _fitted([wrong]) if wrong.columns else None
        if clock is not None:
            scale, shift = clock
            rows = shift / m.step if m.step else None
            if not _is_refuted(m, scale * part.time + shift):
                seen.append(OtherClock(m.maneuver, scale, shift, rows))
                part = _on_clock(part, scale, shift)
            elif not wrong.are_few:
                # Only the wrong columns belong to other times. All later steps leave them out.
                keys = tuple(c.key for c in wrong.columns)
                seen.append(OtherClock(m.maneuver, scale, shift, rows, keys))
                part = part.without(keys)
        parts.append(part)
    return Undone(tuple(seen), tuple(parts)) if seen else None


def _on_common_clock(report: Report, scale: float, shift: float) -> Undone | None:
    """Correct the times of all maneuvers by one clock; None if right columns refute it."""
    if any(_is_refuted(m, scale * m.part.time + shift) for m in report.maneuvers):
        return None
    step = report.maneuvers[0].step
    parts = tuple(_on_clock(m.part, scale, shift) for m in report.maneuvers)
    return Undone((OtherClock(None, scale, shift, shift / step if step else None),), parts)


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


def _beside(least: float, most: float) -> str:
    """Say how far times are before or after others, by a range, or by its mean if it is small."""
    near, far = sorted((least, most), key=abs)
    if CLEARLY * (most - least) < abs(most + least):
        near = far = (least + most) / 2
    if near * far < 0.0:
        return f"{-least:.3g} s before to {most:.3g} s after"
    span = f"{abs(far):.3g} s {'after' if far > 0.0 else 'before'}"
    return span if near == far else f"{abs(near):.3g} to {span}"


def own_times(report: Report) -> Undone | None:
    """Look for a time of its own for each row at which all its columns are right.

    The rows may be in another order, written again, or of steps other than those written. Each row
    has one unknown. Few columns always agree on some time, so they must agree on the time of
    another row.
    """
    seen: dict[int, RowTimes] = {}
    parts = []
    for m in report.maneuvers:
        part, wrong = m.part, WrongColumns(m)
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


def _own_times(m: ManeuverScore, wrong: WrongColumns) -> tuple[Array, RowTimes] | None:
    """Find the times at which all rows of a maneuver are right, and describe them, or None."""
    rows = AtOtherTimes(m, [c for c in whole_columns(m) if c.key in BENCHMARK_COLUMNS])
    grid = _grid(m) if wrong.are_few else None
    nearest = rows.nearest() if grid is None else rows.nearest_of(grid)
    least = np.array([floor_of(c) / c.scale for c in rows.columns])
    limit = CLEARLY * np.maximum(rows.left(nearest), least)
    # Keep the written time of rows that are also right at this time. Where the motion hardly
    # changes, every time is right.
    is_off = np.any(np.abs(rows.off(rows.time)[0]) > limit[:, None], axis=0)
    if grid is not None:
        # A constant column agrees with one row, so count each of the other rows once.
        others = len(np.unique(nearest[is_off]))
        chance = rows.chance(grid, limit)[is_off].sum()
        if others < max(is_off.sum() / AS_GOOD, CLEARLY * chance):
            return None
    meant = np.where(is_off, nearest, rows.time)
    left = wrong.left(meant)
    if not is_off.any() or not wrong.are_right(left, grid is not None) or _is_refuted(m, meant):
        return None
    ahead = (meant - rows.time)[is_off]
    low, high = np.quantile(ahead, ((1 - MOST_ROWS) / 2, (1 + MOST_ROWS) / 2)).tolist()
    if (
        CLEARLY * (high - low) < abs(high + low)
        and np.mean(is_off[np.argmax(is_off) :]) > MOST_ROWS
    ):
        # All rows from some time on have the same shift, which is simpler than a time for each row.
        # `diagnosis.departures` reports this shift.
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


def _grid(m: ManeuverScore) -> Array:
    """Return the times of all rows that the program may have computed.

    Rows may be lost, so the times continue at the usual distance up to the end of the run.
    """
    time, end = m.part.time, float(m.part.reference.duration)
    more = np.arange(time[-1], end + m.step / 2, m.step)[1:] if m.step else time[:0]
    found: Array = np.union1d(time, np.minimum(more, end))
    return found


def _fitted(every: Sequence[WrongColumns]) -> tuple[float, float] | None:
    """Find one scale and one shift [s] of the times with which all columns are right, or None."""
    are_few_together = sum(wrong.count for wrong in every) <= FEW_COLUMNS
    are_few_in_each = all(wrong.are_few for wrong in every)
    clocks = [(of, fitted_clock(every, of)) for of in ((1,), (0,), (0, 1))]
    found = [
        (of, c, [x.left(meant_by(x.time, c)) for x in every]) for of, c in clocks if c is not None
    ]
    # Prefer a shift alone, or otherwise a scale alone, if its error is as small as that of both
    # together. If the fit of both failed, use either one.
    least = found[-1][2] if clocks[-1][1] is not None else [np.full(1, np.inf)] * len(every)
    for of, clock, left in found:
        # A column may be computed from other rows, and so resemble its shift in every maneuver. It
        # does not resemble its scaling.
        are_few = are_few_in_each if 1 in of else are_few_together
        fitted = len(of) if are_few else 0
        if all(
            np.all(x <= np.maximum(AS_GOOD * low, wrong.floors)) and wrong.are_right(x, fitted)
            for x, low, wrong in zip(left, least, every, strict=True)
        ):
            return 1.0 + float(clock[0]), float(clock[1])
    return None
