"""Find columns of averages of the exact values: over several rows, or over one step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import even_step
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers, named
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Deviation
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# Number of Gauss nodes for the average over a step. Four integrate polynomials of degree 7 exactly.
_NODES_IN_STEP = 4


@dataclass(frozen=True, slots=True)
class SmoothedColumns(Evidence):
    """Columns are moving averages of the exact values.

    Attributes
    ----------
    places
        The columns (``2.roll_angle``).
    rows
        Number of rows in each average.
    """

    places: tuple[str, ...]
    rows: int

    code = "smoothed_columns"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{named(self.places)}: each value is a moving average of the exact values over "
            f"{self.rows} rows. Write the rows as they are computed, without a filter"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.places), "rows": self.rows}


def averaged(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as a moving average of the exact values over evenly spaced rows.

    All definitions of the column are tried. The deviation is NaN at both ends.
    """
    time, value = c.trace.time, c.trace.value
    if c.values < m.rows or even_step(time) is None:
        return None
    names = [x.name for x in m.part.reference.definitions[c.key]]
    right = np.array([*m.part.reference.approximate(time, names).values()])
    sums = np.pad(np.cumsum(right, axis=1), ((0, 0), (1, 0)))
    best: tuple[float, Deviation] | None = None
    # A moving average has no value in the first and the last rows. Try averages that lose at most a
    # tenth of the rows at each end.
    for half in range(1, int(len(time) / CLEARLY)):
        count = 2 * half + 1
        smooth = (sums[:, count:] - sums[:, :-count]) / count
        left = np.sqrt(np.mean((value[half:-half] - smooth) ** 2, axis=1))
        which = int(np.argmin(left))
        if best is None or left[which] < best[0]:
            whole = np.full_like(time, np.nan)
            whole[half:-half] = smooth[which]
            smoothed = SmoothedColumns((f"{m.maneuver}.{c.key}",), count)
            best = float(left[which]), Deviation(whole - c.trace.reference, smoothed)
    return best[1] if best else None


@dataclass(frozen=True, slots=True)
class StepAverage(Evidence):
    """Each value of a column is the average of the exact values over the step before or after it.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    is_before
        True for the step that ends at the row, False for the step that begins there.
    """

    key: str
    maneuvers: tuple[int, ...]
    is_before: bool

    code = "step_average"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key} of {maneuvers(self.maneuvers)}: each value is the average over the step "
            f"{self._side} its row. Write the value at the time of the row"
        )

    @property
    def _side(self) -> str:
        return "before" if self.is_before else "after"

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers), "step": self._side}


def averaged_over_step(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the average over the step before or after each row.

    The average is that of the motion, such as a distance divided by the step, or that of the values
    at both ends of the step. All definitions of the column are tried. The deviation is NaN in the
    row without a step on this side. None if the value in the middle of the step fits better.
    """
    time, step = c.trace.time, np.diff(c.trace.time)
    if c.values < m.rows or not np.all(step > 0.0):
        return None
    names = [x.name for x in m.part.reference.definitions[c.key]]

    def average(places: Array, weights: Array) -> Array:
        """Return averages of each definition over weighted places between 0 and 1 in each step."""
        at = time[:-1] + np.multiply.outer(places, step)
        found = m.part.reference.approximate(at.ravel(), names).values()
        return np.array([weights @ x.reshape(at.shape) for x in found])

    nodes, weights = np.polynomial.legendre.leggauss(_NODES_IN_STEP)
    middle = average(np.array([0.5]), np.ones(1))
    ends = average(np.array([0.0, 1.0]), np.array([0.5, 0.5]))
    averages = [*middle, *ends, *average((1.0 + nodes) / 2, weights / 2)]
    sides = {True: slice(1, None), False: slice(None, -1)}
    left = {
        (is_before, i): rms(c.trace.value[rows] - x)
        for is_before, rows in sides.items()
        for i, x in enumerate(averages)
    }
    is_before, which = min(left, key=lambda k: left[k])
    if which < len(middle):
        return None
    deviation = np.full_like(time, np.nan)
    deviation[sides[is_before]] = averages[which]
    return Deviation(deviation - c.trace.reference, StepAverage(c.key, (m.maneuver,), is_before))
