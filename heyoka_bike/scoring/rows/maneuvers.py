"""Whole maneuvers that are not as meant: reversed, ended early, or to the other side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.evidence.output_faults import Mirrored, RowsRepeated, RowsReversed
from heyoka_bike.scoring.grades import FEWEST_TELLING_ROWS, FLOORS_OF_ROUNDING, RIGHT, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY, FEW_COLUMNS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.edits import Mirrored as MirroredRows
from heyoka_bike.scoring.rows.edits import Reversed
from heyoka_bike.scoring.rows.table import Undone, max_rel_error
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.scoring.units import factor


def stopped(report: Report) -> Undone | None:
    """Maneuvers whose last rows repeat one another in all columns: the motion ended before them."""
    ended = {x.maneuver: x for x in standing_still(report.maneuvers) if x.are_all}
    if not ended:
        return None
    parts = (
        m.part.at(slice(m.rows - ended[m.maneuver].rows + 1)) if m.maneuver in ended else m.part
        for m in report.maneuvers
    )
    return Undone(tuple(ended.values()), tuple(parts))


def mirrored(report: Report) -> Undone | None:
    """Maneuvers whose columns of roll and steer are all turned round, beside others that are not.

    That is the right motion of a start to the other side, which has the same speed and energies.
    """
    turned = [m for m in report.maneuvers if _is_mirrored(m)]
    if not turned or len(turned) == len(report.maneuvers):
        return None
    numbers = tuple(m.maneuver for m in turned)
    parts = (MirroredRows().undo(m.part) if m in turned else m.part for m in report.maneuvers)
    return Undone((Mirrored(numbers),), tuple(parts))


def _is_mirrored(m: ManeuverScore) -> bool:
    lateral = [c for c in m.columns if c.key in LATERAL and c.values]
    return len(lateral) > 1 and all(
        rms(c.trace.value + c.trace.reference) < RIGHT * rms(c.trace.reference) for c in lateral
    )


def reversed_rows(report: Report) -> Undone | None:
    """Maneuvers whose last row, and not the first, is the start that the maneuver is given."""
    turned = [m for m in report.maneuvers if _ends_at_the_start(m)]
    if not turned:
        return None
    numbers = tuple(m.maneuver for m in turned)
    parts = (Reversed().undo(m.part) if m in turned else m.part for m in report.maneuvers)
    return Undone((RowsReversed(numbers),), tuple(parts))


def _ends_at_the_start(m: ManeuverScore) -> bool:
    """True if the last row is the given start, whatever its signs are, and the first is far off.

    Signs and definitions that a file seems to have tell nothing if its rows are reversed.
    """
    if m.rows < FEWEST_TELLING_ROWS:
        return False
    ends = []
    for key in (*LATERAL, "forward_speed"):
        if key in m and m[key].values == m.rows:
            c, written = m[key], m.part.values[key]
            unit = factor(m.part.units.get(key, c.as_understood.unit))[0]
            given = abs(float(m.part.reference.rows[key][0]))
            off = np.abs(np.abs(unit * written[[0, -1]]) - given)
            ends.append(off / max(FLOORS_OF_ROUNDING * (c.floor or 0.0), RIGHT * c.scale))
    if len(ends) <= FEW_COLUMNS:
        return False
    first, last = np.max(ends, axis=0)
    return bool(last <= 1.0 and first > BY_FAR)


def standing_still(maneuvers: Sequence[ManeuverScore]) -> Iterator[RowsRepeated]:
    """Last rows that repeat one another, in all columns or in some, of a motion that does not."""
    for m in maneuvers:
        whole = [c for c in m.columns if c.values == m.rows]
        still = {c.key: m.rows - last_step(c) for c in whole}
        # Of few digits a motion that dies away stands still for a while, too, and goes on.
        others = [
            c for c in whole
            if still[c.key] < max(FEWEST_TELLING_ROWS, AS_GOOD * _still_before(c))
        ]  # fmt: skip
        standing = [c for c in whole if c not in others and _moves(c, 0)]
        held = [c for c in standing if _moves(c, -still[c.key])]
        if not held or any(max_rel_error(c) > TOLERANCE for c in others):
            continue
        shown = held if others else standing
        rows = min(still[c.key] for c in shown)
        time = float(held[0].trace.time[m.rows - rows])
        yield RowsRepeated(m.maneuver, time, rows, tuple(c.key for c in shown), not others)


def _still_before(c: ColumnScore) -> int:
    """The most rows that hold the same number, of those before the last step."""
    return int(np.max(np.diff(np.flatnonzero(np.diff(c.trace.value))), initial=0))


def last_step(c: ColumnScore) -> int:
    """The last row that is another one than the row before; 0 if none is."""
    return int(np.max(np.flatnonzero(np.diff(c.trace.value)) + 1, initial=0))


def _moves(c: ColumnScore, first: int) -> bool:
    """True if the right column moves, from a row on."""
    return float(np.ptp(c.trace.reference[first:])) > CLEARLY * (c.floor or 0.0)
