"""Find where a motion that is right at first departs from the exact motion."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers, named, together
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY
from heyoka_bike.scoring.rows.other_times import AtOtherTimes, fitted_clock, meant_by
from heyoka_bike.scoring.rows.table import whole_columns
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# An error that begins at the start of the run grows at most with this power of time.
_LARGEST_POWER = 20.0


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


def _later(seconds: float) -> str:
    return f"{abs(seconds):.3g} s {'later' if seconds > 0.0 else 'earlier'}"


def departures(maneuvers: Sequence[ManeuverScore]) -> Iterator[Departs]:
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
