"""Find columns with the exact values of another column, or of another maneuver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import Deviation
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class OtherColumn(Evidence):
    """A column contains the exact values of another column, in some maneuvers.

    Attributes
    ----------
    key
        Key of the column in the file.
    maneuvers : tuple of int
    other
        Key of the column to which its values belong.
    of_maneuver
        Maneuver of those values; None if it is the same maneuver.
    is_exchanged
        True if the other column contains the exact values of this one, too.
    """

    key: str
    maneuvers: tuple[int, ...]
    other: str
    of_maneuver: int | None = None
    is_exchanged: bool = False

    code = "other_column"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.is_exchanged:
            return (
                f"{self.key} and {self.other} of {maneuvers(self.maneuvers)} are exchanged. Check "
                "the order in which columns are written there"
            )
        of = f" of maneuver {self.of_maneuver}" if self.of_maneuver is not None else ""
        return (
            f"{self.key} of {maneuvers(self.maneuvers)} contains the values of {self.other}{of}. "
            "Check the order in which columns are written there"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers)}
        of = {"other": self.other, "of_maneuver": self.of_maneuver}
        return {**where, **of, "is_exchanged": self.is_exchanged}


def pairs_exchanged(seen: Iterable[Evidence]) -> tuple[Evidence, ...]:
    """Replace two columns that contain the values of each other with one piece of evidence."""
    found: list[Evidence] = []
    for x in seen:
        if isinstance(x, OtherColumn) and x.of_maneuver is None:
            back = OtherColumn(x.other, x.maneuvers, x.key)
            if back in found:
                found[found.index(back)] = replace(back, is_exchanged=True)
                continue
        found.append(x)
    return tuple(found)


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
