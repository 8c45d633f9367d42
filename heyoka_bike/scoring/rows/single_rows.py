"""Find single rows of a column that repeat the row before, or are far off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Undone, floor_of, is_right_column, places
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# If more than this fraction of a column's rows do not fit their neighbours, they are not reported
# as single rows.
_MOST_SINGLE = 0.2
# Number of rows on each side with which a single row of large error is compared. If every third row
# has a wrong time, an error may be 3 times the error two rows further on.
_ROWS_AROUND = 5


@dataclass(frozen=True, slots=True)
class SingleRows(Evidence):
    """Single rows of a column do not fit the rows around them.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    rows
        Number of these rows.
    time
        Time of the first one [s].
    is_held
        True if each repeats the value of the row before it.
    """

    key: str
    maneuvers: tuple[int, ...]
    rows: int
    time: float
    is_held: bool

    code = "single_rows"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.rows == 1:
            what = "repeats the row before it" if self.is_held else "does not fit its neighbours"
            said = f"one row {what}, at {self.time:.6g} s"
        else:
            what = "repeat the row before them" if self.is_held else "do not fit their neighbours"
            said = f"{self.rows} single rows {what}, the first at {self.time:.6g} s"
        return (
            f"{self.key} of {maneuvers(self.maneuvers)}: {said}. Check how this column is written "
            "or measured there"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers)}
        return {**where, "rows": self.rows, "time": self.time, "is_held": self.is_held}


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
