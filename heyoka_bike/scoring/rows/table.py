"""The result of a look at the rows, `Undone`, and measures of columns that several looks use."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.output_faults import Remainder
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, Place


@dataclass(frozen=True, slots=True)
class Undone:
    """The changes that were seen in the rows, and the rows with these changes undone.

    Attributes
    ----------
    seen : tuple of Evidence
    parts : tuple of Part
    """

    seen: tuple[Evidence, ...]
    parts: tuple[Part, ...]


RowCheck = Callable[[Report], Undone | None]
"""A function that looks for one kind of change in the rows of a report; None if it sees none."""


def worst(report: Report) -> Remainder:
    """The largest error of a column, in its scale, and where it is."""
    errors = ((c.error, f"{m.maneuver}.{c.key}") for m, c in places(report))
    return Remainder(*max(errors, default=(0.0, "")))


def floor_of(c: ColumnScore) -> float:
    """Return the floor of a column, but at least the roundoff of computing its values [SI]."""
    return max(c.floor or 0.0, ROUNDING * c.scale)


def is_right_column(c: ColumnScore) -> bool:
    """True if a column is as right as its digits, or binary64 arithmetic, can be."""
    return c.is_hidden or (c.max_rel_error is not None and c.error < ROUNDING)


def places(report: Report) -> Iterator[Place]:
    """Columns of the benchmark with values."""
    return ((m, c) for m, c in report.places if c.key in BENCHMARK_COLUMNS)


def whole_columns(m: ManeuverScore) -> list[ColumnScore]:
    """Columns with a value in every row, whose definition is known."""
    return [c for c in m.columns if c.values == m.rows and c.is_known and c.scale]
