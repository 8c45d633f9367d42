"""Find faults in all columns of a maneuver: reversed, at rest from some row on, or mirrored."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers, named
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY, FEW_COLUMNS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.edits import Mirrored as MirroredRows
from heyoka_bike.scoring.rows.edits import Reversed
from heyoka_bike.scoring.rows.other_times import WrongColumns
from heyoka_bike.scoring.rows.table import Undone
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.scoring.units import factor


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


def stopped(report: Report) -> Undone | None:
    """Look for maneuvers that end with copies of one row in all columns; keep the first copy."""
    ended = tuple(x for x in standing_still(report.maneuvers) if x.are_all)
    if not ended:
        return None
    rows = {n: x.rows for x in ended for n in x.maneuvers}
    parts = (
        m.part.at(slice(m.rows - rows[m.maneuver] + 1)) if m.maneuver in rows else m.part
        for m in report.maneuvers
    )
    return Undone(ended, tuple(parts))


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


def mirrored(report: Report) -> Undone | None:
    """Look for maneuvers with the opposite sign in all columns of roll and steer.

    This is the exact motion after a start to the other side: speed and energies are the same. If
    all maneuvers have these signs, this is a convention, not a fault.
    """
    turned = [m for m in report.maneuvers if _is_mirrored(m)]
    if not turned or len(turned) == len(report.maneuvers):
        return None
    numbers = tuple(m.maneuver for m in turned)
    parts = (MirroredRows().undo(m.part) if m in turned else m.part for m in report.maneuvers)
    return Undone((Mirrored(numbers),), tuple(parts))


def _is_mirrored(m: ManeuverScore) -> bool:
    lateral = [c for c in m.compared if c.key in LATERAL]
    return len(lateral) > 1 and all(
        rms(c.trace.value + c.trace.reference) < RIGHT * rms(c.trace.reference) for c in lateral
    )


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


def reversed_rows(report: Report) -> Undone | None:
    """Look for maneuvers with the given initial conditions in the last row, not in the first."""
    turned = [m for m in report.maneuvers if _ends_at_the_start(m)]
    if not turned:
        return None
    numbers = tuple(m.maneuver for m in turned)
    parts = (Reversed().undo(m.part) if m in turned else m.part for m in report.maneuvers)
    return Undone((RowsReversed(numbers),), tuple(parts))


def _ends_at_the_start(m: ManeuverScore) -> bool:
    """True if the last row contains the given initial conditions, and the first is far from them.

    Few columns have these values at other times, too, so they must be right in all rows.

    Signs are ignored and default definitions assumed, because signs and definitions recognised from
    reversed rows are meaningless.
    """
    if m.rows < MIN_ROWS_FOR_SHAPE:
        return False
    ends = []
    for key in (*LATERAL, "forward_speed"):
        if key in m and m[key].values == m.rows:
            c, written = m[key], m.part.values[key]
            unit = factor(m.part.units.get(key, c.as_understood.unit))[0]
            given = abs(float(m.part.reference.rows[key][0]))
            off = np.abs(np.abs(unit * written[[0, -1]]) - given)
            ends.append(off / max(c.hidden, RIGHT * c.scale))
    if len(ends) <= FEW_COLUMNS:
        wrong = WrongColumns(m)
        return wrong.are_right(wrong.left(Reversed().meant(wrong.time, 0.0)))
    first, last = np.max(ends, axis=0)
    return bool(last <= 1.0 and first > BY_FAR)


def standing_still(maneuvers: Sequence[ManeuverScore]) -> Iterator[RowsRepeated]:
    """Find last rows that repeat the same numbers, although the exact motion goes on."""
    found: list[tuple[tuple[float, int, tuple[str, ...], bool], int]] = []
    for m in maneuvers:
        whole = [c for c in m.columns if c.values == m.rows]
        still = {c.key: m.rows - last_step(c) for c in whole}
        # With few digits, a decaying motion also repeats a value for some rows before it changes
        # again. So the rest at the end must be longer than any earlier repetition by the factor
        # `AS_GOOD`.
        others = [
            c for c in whole
            if still[c.key] < max(MIN_ROWS_FOR_SHAPE, AS_GOOD * _still_before(c))
        ]  # fmt: skip
        standing = [c for c in whole if c not in others and _moves(c, 0)]
        held = [c for c in standing if _moves(c, -still[c.key])]
        if not held or any(c.error > TOLERANCE for c in others):
            continue
        shown = held if others else standing
        rows = min(still[c.key] for c in shown)
        time = float(held[0].trace.time[m.rows - rows])
        found.append(((time, rows, tuple(c.key for c in shown), not others), m.maneuver))
    for alike, numbers in grouped(found).items():
        yield RowsRepeated(tuple(numbers), *alike)


def _still_before(c: ColumnScore) -> int:
    """Return the largest number of consecutive equal rows before the column's last change."""
    return int(np.max(np.diff(np.flatnonzero(np.diff(c.trace.value))), initial=0))


def last_step(c: ColumnScore) -> int:
    """Return the index of the last row that differs from the row before; 0 if there is none."""
    return int(np.max(np.flatnonzero(np.diff(c.trace.value)) + 1, initial=0))


def _moves(c: ColumnScore, first: int) -> bool:
    """True if the exact values vary clearly above the digits from the row `first` on."""
    return float(np.ptp(c.trace.reference[first:])) > CLEARLY * (c.floor or 0.0)
