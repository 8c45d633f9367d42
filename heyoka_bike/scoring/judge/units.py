"""Units: whether the heading of a column says the one that its values are in."""

from __future__ import annotations

from collections.abc import Iterator

from heyoka_bike.scoring.evidence import UnitContradicted
from heyoka_bike.scoring.report import Report

UNITS_APART = 0.05
"""Of the scale: a column nearer than this tells its own unit, for units differ by more."""


def headings_contradicted(report: Report) -> Iterator[UnitContradicted]:
    """Columns whose heading names another unit than the one that fits their values."""
    for key, places in report.by_column().items():
        m, first = places[0]
        unit = first.as_understood.unit
        heading = m.part.units.get(key, unit)
        far = [c.max_rel_error for _, c in places]
        if heading != unit and all(x is not None and x < UNITS_APART for x in far):
            yield UnitContradicted(key, heading, unit)
