"""What a look at the rows returns: what was seen, and the rows with that undone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.output_faults import Remainder
from heyoka_bike.scoring.grades import FLOORS_OF_ROUNDING
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class Undone:
    """What is seen in the rows, and the rows without it.

    Attributes
    ----------
    seen : tuple of Evidence
    parts : tuple of Part
    """

    seen: tuple[Evidence, ...]
    parts: tuple[Part, ...]


Look = Callable[[Report], Undone | None]
"""What it sees in a report; None if it sees nothing."""


def worst(report: Report) -> Remainder:
    """The largest error of a column, in its scale, and where it is."""
    errors = (
        (c.as_understood.measures.max_rel_error or 0.0, f"{m.maneuver}.{c.key}")
        for m, c in places(report)
    )
    return Remainder(*max(errors, default=(0.0, "")))


def hidden(c: ColumnScore) -> float:
    """The error that the digits of a column, or rounding on the way, hide [SI]."""
    return max(c.floor or 0.0, ROUNDING * c.scale)


def is_right_column(c: ColumnScore) -> bool:
    """True if a column is as right as its digits, or binary64 arithmetic, can be."""
    error = c.as_understood.measures.max_rel_error
    return c.is_at_floor(FLOORS_OF_ROUNDING) or (error is not None and error < ROUNDING)


def places(report: Report) -> Iterator[tuple[ManeuverScore, ColumnScore]]:
    """Columns of the benchmark with values."""
    for m in report.maneuvers:
        for c in m.columns:
            if c.key in BENCHMARK_COLUMNS and c.values:
                yield m, c


def whole_columns(m: ManeuverScore) -> list[ColumnScore]:
    """Columns with a value in every row, whose definition is known."""
    return [c for c in m.columns if c.values == m.rows and c.is_known and c.scale]


def max_rel_error(c: ColumnScore) -> float:
    """The largest error of a column in its scale; 0 without a value."""
    return c.as_understood.measures.max_rel_error or 0.0
