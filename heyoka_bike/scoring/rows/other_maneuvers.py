"""Find columns with the numbers of another maneuver in the same file, whatever the motion is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Undone
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class ColumnOfAnotherManeuver(Evidence):
    """Columns of one maneuver contain the numbers of another maneuver."""

    maneuver: int
    of: int
    keys: tuple[str, ...]

    code = "column_of_another_maneuver"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{', '.join(self.keys)} of maneuver {self.maneuver}: the numbers are those of "
            f"maneuver {self.of}. Check which run is written there"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuver": self.maneuver, "of": self.of, "columns": list(self.keys)}


def numbers_of_another_maneuver(report: Report) -> Undone | None:
    """Look for columns with the numbers of another maneuver, and leave them out.

    A maneuver is not left out as a whole.
    """
    found = [
        x
        for x in of_other_maneuvers(report.maneuvers)
        if {c.key for c in report[x.maneuver].columns} > {*x.keys}
    ]
    if not found:
        return None
    # One maneuver may contain columns of several other maneuvers.
    keys = grouped((x.maneuver, key) for x in found for key in x.keys)
    parts = (m.part.without(keys.get(m.maneuver, ())) for m in report.maneuvers)
    return Undone(tuple(found), tuple(parts))


def of_other_maneuvers(
    maneuvers: Sequence[ManeuverScore],
) -> Iterator[ColumnOfAnotherManeuver]:
    """Find columns with the same numbers in two maneuvers, although their exact values differ."""
    for i, m in enumerate(maneuvers):
        for other in maneuvers[:i]:
            theirs = {c.key: c for c in other.columns}
            same = [c.key for c in m.columns if c.key in theirs and _are_same(c, theirs[c.key])]
            if not same:
                continue
            right, worse = sorted((m, other), key=lambda x: max(x[key].error for key in same))
            yield ColumnOfAnotherManeuver(worse.maneuver, right.maneuver, tuple(same))


def _are_same(one: ColumnScore, other: ColumnScore) -> bool:
    a, b = one.trace, other.trace
    n = min(len(a.value), len(b.value))
    if (
        n < MIN_ROWS_FOR_SHAPE
        or not np.ptp(a.value)
        or not np.ptp(a.reference[:n] - b.reference[:n])
    ):
        return False
    return float(np.mean(a.value[:n] == b.value[:n])) > MOST_ROWS
