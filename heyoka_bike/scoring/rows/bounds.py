"""Find columns that stay at a bound.

The file itself shows a bound, whatever its motion is (`bounded`). Comparison with the exact values
shows whether the values within the bounds are right (`clipped`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import number_in_unit
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Deviation, Undone, finite, floor_of, places
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# A column is clipped if at least this many consecutive rows are at its bound. An extremum of a
# smooth column has one or two equal rows.
_FEWEST_CLIPPED = 5


@dataclass(frozen=True, slots=True)
class ClippedColumn(Evidence):
    """A column is clipped at one or two bounds.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    low, high
        The bounds [SI unit]; None without such a bound.
    is_right_within
        True if all other values are right, and the exact values of the clipped rows exceed the
        bounds.
    """

    key: str
    maneuvers: tuple[int, ...]
    low: float | None
    high: float | None
    is_right_within: bool

    code = "clipped_column"
    severity = Severity.WARNING

    def message(self) -> str:
        unit = COMPARED[self.key][0].unit
        at = " and ".join(number_in_unit(x, unit) for x in (self.low, self.high) if x is not None)
        where_else = (
            " where the exact values go further. All its other values are right. Remove the limit"
            if self.is_right_within
            else (
                ", clipped in the output or held by a stop in the model. The other columns are "
                "diagnosed without this one"
            )
        )
        return f"{self.key} of {maneuvers(self.maneuvers)} stays at {at}{where_else}"

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers)}
        bounds = {"low": self.low, "high": self.high}
        return {**where, **bounds, "is_right_within": self.is_right_within}


def bounded(report: Report) -> Undone | None:
    """Look for columns that stay at a bound; the file itself shows this, whatever its motion.

    These columns are removed. None if all columns are bounded.
    """
    found = {
        (m.maneuver, c.key): bounds
        for m, c in places(report)
        if (bounds := _bounds_of(c)) is not None
    }
    if not found:
        return None
    keys = {key for _, key in found}
    if all(c.key in keys for _, c in places(report)):
        return None
    by_key = grouped(((key, low, high), n) for (n, key), (low, high) in found.items())
    seen = (
        ClippedColumn(key, tuple(of), finite(low), finite(high), is_right_within=False)
        for (key, low, high), of in by_key.items()
    )
    parts = (m.part.without(keys) for m in report.maneuvers)
    return Undone(tuple(seen), tuple(parts))


def _bounds_of(c: ColumnScore) -> tuple[float, float] | None:
    """Return the lower and the upper bound at which a column stays; None if it stays at neither.

    If the column stays at only one bound, the other is infinite. A column stays at a bound for
    several rows, and comes to it and leaves it by steps far above its digits. It stays at no other
    value, and most of its rows are between the bounds, with many different values.
    """
    value = c.trace.value
    least = CLEARLY * floor_of(c)
    starts = np.flatnonzero(np.r_[True, np.diff(value) != 0.0])
    lengths = np.diff(np.r_[starts, len(value)])
    at = value[starts]
    low, high = float(np.min(value)), float(np.max(value))
    is_bound = (at == low) | (at == high)
    inside = value[(value != low) & (value != high)]
    is_coarse = 2 * len(inside) < len(value) or 2 * len(np.unique(inside)) < len(inside)
    is_held = np.max(lengths[~is_bound], initial=0) >= _FEWEST_CLIPPED
    if c.values < MIN_ROWS_FOR_SHAPE or is_held or is_coarse:
        return None
    # The mechanical energy may rest at its exact constant value while no force does work.
    if float(np.ptp(c.trace.reference)) <= least:
        return None
    bounds = []
    for bound, inf in ((low, -np.inf), (high, np.inf)):
        # The first and the last rows do not count: a motion may begin or end at rest.
        here = np.flatnonzero((at == bound) & (lengths >= _FEWEST_CLIPPED))
        inner = here[(here > 0) & (here < len(at) - 1)]
        steps = np.minimum(np.abs(at[inner] - at[inner - 1]), np.abs(at[inner + 1] - at[inner]))
        bounds.append(bound if len(inner) and np.max(steps) > least else inf)
    return (bounds[0], bounds[1]) if np.any(np.isfinite(bounds)) else None


def clipped(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the exact values clipped at its own smallest and largest value."""
    value, right = c.trace.value, c.trace.reference
    low, high = float(np.min(value)), float(np.max(value))
    least = c.hidden
    low = low if np.min(right) < low - least else -np.inf
    high = high if np.max(right) > high + least else np.inf
    limited = np.minimum(np.maximum(right, low), high)
    # The exact values replace the rows at a bound, because the bound hides the motion there.
    deviation = np.where(limited == right, 0.0, limited - right)
    bounds = finite(low), finite(high)
    return Deviation(deviation, ClippedColumn(c.key, (m.maneuver,), *bounds, is_right_within=True))
