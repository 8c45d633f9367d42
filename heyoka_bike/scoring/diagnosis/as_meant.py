"""Rows as they were meant: what a step that looks at the rows returns, and what is left of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.alignment import Alignment, Part
from heyoka_bike.scoring.diagnosis import followed
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.output_faults import Remainder
from heyoka_bike.scoring.grades import FLOORS_OF_ROUNDING
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class AsMeant:
    """What is seen in the rows, and the rows without it.

    Attributes
    ----------
    seen : tuple of Evidence
    parts : tuple of Part
    steps : tuple of Look
        Those that are left to try on these rows: each is taken once.
    """

    seen: tuple[Evidence, ...]
    parts: tuple[Part, ...]
    steps: tuple[Look, ...] = ()

    def alignment(self, report: Report) -> Alignment:
        """The rows as they were meant, laid beside the reference as those of the file.

        A maneuver whose columns were all put aside has nothing to lay beside it.
        """
        return Alignment(report.file, tuple(p for p in self.parts if p.has_values()), ())


def worst(report: Report) -> Remainder:
    """The largest error of a column, in its scale, and where it is."""
    errors = (
        (c.as_understood.measures.max_rel_error or 0.0, f"{m.maneuver}.{c.key}")
        for m, c in places(report)
    )
    return Remainder(*max(errors, default=(0.0, "")))


@dataclass(frozen=True, slots=True)
class Look(followed.Step):
    """A step that looks at the rows.

    Attributes
    ----------
    look : callable
        What it sees in a report; None if it sees nothing.
    """

    look: Callable[[Report], AsMeant | None]


def as_meant(report: Report, steps: Sequence[Look]) -> AsMeant | None:
    """What the first of some steps sees that sees something; None if none does."""
    for i, step in enumerate(steps, 1):
        with followed.taken(step) as told:
            found = step.look(report)
            if found is not None:
                told.found = partial("; ".join, map(str, found.seen))
                return replace(found, steps=tuple(steps[i:]))
    return None


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
