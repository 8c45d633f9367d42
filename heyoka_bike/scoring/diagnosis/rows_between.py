"""Find rows that repeat other rows, or are interpolated between fewer rows."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import mode
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers, named
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.rows.maneuvers import last_step
from heyoka_bike.scoring.rows.table import is_right_column
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# Rows count as repeated, or as interpolated between fewer rows, if the fraction of such rows
# exceeds the first value. The second value is a number of parts of the run: the fraction must be
# exceeded in all parts but one.
_BETWEEN, _PARTS_OF_RUN = 0.2, 4
# Largest distance of two right rows between which other rows may be interpolated [rows].
_MOST_BETWEEN = 200


@dataclass(frozen=True, slots=True)
class RowsBetween(Evidence):
    """Rows were interpolated between other rows, or repeat the row before.

    Attributes
    ----------
    maneuvers : tuple of int
    order
        0 if rows repeat the row before, 1 if they are on straight lines between other rows, 2 if
        they are on curves between other rows.
    share
        Fraction of the rows that are repeated or interpolated.
    keys : tuple of str
        The angles and rates that show it; empty if most show it, and none of the others is right.
    every
        If one row in this many is right, from the first one on, this number; otherwise 0.
    """

    maneuvers: tuple[int, ...]
    order: int
    share: float
    keys: tuple[str, ...] = ()
    every: int = 0

    code = "rows_between"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.order > 1:
            return (
                f"Only every {_ordinal(self.every)} row of {maneuvers(self.maneuvers)} is right: "
                "the rows between were interpolated, or belong to other times. Write the "
                "integrator's own steps, or a dense output that is as accurate as the steps"
            )
        made = "interpolated" if self.order else "held"
        better = (
            f"They were {made}, not computed. Write the integrator's own steps, or a dense output "
            "that is as accurate as the steps"
        )
        share, where = f"At least {100 * self.share:.0f} %", maneuvers(self.maneuvers)
        if self.keys:
            what = "lie on straight lines between others" if self.order else "repeat the one before"
            return f"{share} of the values of {named(self.keys)} in {where} {what}. {better}"
        what = "lie on straight lines between other rows" if self.order else "repeat the row before"
        return f"{share} of the rows of {where} {what}, in most angles and rates. {better}"

    def numbers(self) -> Mapping[str, Any]:
        where = {"maneuver": self.maneuvers[0], "maneuvers": list(self.maneuvers)}
        numbers = {"order": self.order, "share": self.share, "columns": list(self.keys)}
        return {**where, **numbers, "every": self.every}


def _ordinal(count: int) -> str:
    ends = {1: "st", 2: "nd", 3: "rd"}
    return f"{count}{'th' if 10 < count % 100 < 14 else ends.get(count % 10, 'th')}"


def held_or_interpolated(maneuvers: Sequence[ManeuverScore]) -> Iterator[RowsBetween]:
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
    counts = [count for c in lateral if (count := _right_rows(c))]
    every = mode(counts) if counts else 1
    if 2 * counts.count(every) <= len(lateral) or not _are_right(m, every):
        every = 0
    for order in (1, 2):
        shares = {c.key: x for c in lateral if (x := _flat(c, order)) > _BETWEEN}
        if shares:
            # A right column shows that the rows as a whole were computed.
            are_most = len(shares) > max(len(lateral) / 2, 1)
            named = tuple(shares) if not are_most or any(map(is_right_column, lateral)) else ()
            return RowsBetween((m.maneuver,), order - 1, min(shares.values()), named, every)
    if every:
        return RowsBetween((m.maneuver,), 2, 1.0 - 1.0 / every, (), every)
    return None


def _are_right(m: ManeuverScore, every: int) -> bool:
    """True if one row in this many is right in all columns, as far as a plot shows."""
    rows = slice(None, None, every)
    return all(
        np.nanmax(np.abs(c.trace.error[rows]), initial=0.0) <= TOLERANCE * c.scale
        for c in m.columns
    )


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
