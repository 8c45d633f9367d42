"""Find columns with the exact values of another column, or of another maneuver."""

from __future__ import annotations

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.scoring.evidence.output_faults import OtherColumn
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Deviation
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


def another(m: ManeuverScore, c: ColumnScore, report: Report) -> Deviation | None:
    """Describe a column as the exact values of another column of its unit, or of another maneuver.

    Only default definitions are compared. Otherwise the parts of a constant sum, such as potential
    and kinetic energy, would be functions of each other.
    """
    keys = {COMPARED[key][0].name: key for key in BENCHMARK_COLUMNS}
    names = [name for name, key in keys.items() if COMPARED[key][0].unit == c.unit]
    value = c.trace.value + c.as_understood.offset
    end = float(np.max(c.trace.time))
    there = {
        (other.maneuver, name): x
        for other in report.maneuvers
        if end <= float(other.part.reference.duration)
        for name, x in other.part.reference.approximate(c.trace.time, names).items()
        if (other.maneuver, keys[name]) != (m.maneuver, c.key)
    }
    nearest = min(there, key=lambda place: rms(value - there[place]), default=None)
    if nearest is None:
        return None
    deviation = there[nearest] - c.as_understood.offset - c.trace.reference
    number, name = nearest
    of = number if number != m.maneuver else None
    return Deviation(deviation, OtherColumn(c.key, (m.maneuver,), keys[name], of))
