"""Units: whether the heading of a column names the unit of its values."""

from __future__ import annotations

from collections.abc import Iterator

from heyoka_bike.scoring.evidence.column_meaning import UnitContradicted
from heyoka_bike.scoring.report import Report


def headings_contradicted(report: Report) -> Iterator[UnitContradicted]:
    """Yield columns whose heading names another unit than the one that fits their values."""
    for key, places in report.by_column().items():
        m, first = places[0]
        unit = first.as_understood.unit
        heading = m.part.units.get(key, unit)
        if heading != unit:
            yield UnitContradicted(key, heading, unit)
