"""Find columns that have passed a low-pass filter of first order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np

from heyoka_bike.scoring.alignment import even_step
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers, named
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, RIGHT, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Deviation, floor_of, own_name
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class FilteredColumns(Evidence):
    """Columns are the exact values after a low-pass filter of first order.

    Attributes
    ----------
    places
        The columns (``2.roll_angle``).
    time_constant
        Time by which slow changes are late [s]. It is T in the filter T y' + y = x, to within a
        row.
    """

    places: tuple[str, ...]
    time_constant: float

    code = "filtered_columns"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self._where()}: the values have passed a low-pass filter of first order, which "
            f"makes slow changes late by {self.time_constant:.4g} s (its time constant, to within "
            "a row). Write the rows as they are computed, without a filter"
        )

    def _where(self) -> str:
        """List the columns, those of the same maneuvers together."""
        by_key = grouped((place.split(".")[1], int(place.split(".")[0])) for place in self.places)
        alike = grouped((tuple(numbers), key) for key, numbers in by_key.items())
        return "; ".join(f"{named(keys)} of {maneuvers(of)}" for of, keys in alike.items())

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.places), "time_constant": self.time_constant}


def filtered(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the exact values after a low-pass filter, in evenly spaced rows.

    Any discrete filter of first order is y += a (x - y) - b (x - x of the row before). Usually b is
    0. It is half of a by the trapezoidal rule, and less for an input that is linear from row to
    row. A filter resembles a delay, so it must explain the column clearly better than its delay.
    """
    time, value, exact = c.trace.time, c.trace.value, c.trace.reference
    if c.values < m.rows or len(time) < MIN_ROWS_FOR_SHAPE or (step := even_step(time)) is None:
        return None
    terms = np.column_stack([exact[1:] - value[:-1], exact[:-1] - exact[1:]])
    a, b = np.linalg.lstsq(terms, np.diff(value), rcond=None)[0].tolist()
    # The output of a low-pass filter lies within the range of its inputs, and depends on the rows
    # before.
    if not (TOLERANCE < a < 1.0 - TOLERANCE and abs(b / a - 0.5) < 0.5 + TOLERANCE):
        return None
    added = (a - b) * exact[1:] + b * exact[:-1]
    rows = accumulate(added.tolist(), lambda y, x: (1.0 - a) * y + x, initial=float(value[0]))
    output = np.fromiter(rows, np.float64, len(exact))
    if float(np.max(np.abs(value - output))) > max(c.hidden, RIGHT * c.scale):
        return None
    delay = step * ((1.0 + b) / a - 1.0)
    late, own = time >= delay, own_name(m, c)
    shifted = m.part.reference.approximate(time[late] - delay, [own])[own]
    if CLEARLY * max(rms(value - output), floor_of(c)) > rms(value[late] - shifted):
        return None
    seen = FilteredColumns((f"{m.maneuver}.{c.key}",), delay)
    return Deviation(output - exact, seen, is_of_program=True)
