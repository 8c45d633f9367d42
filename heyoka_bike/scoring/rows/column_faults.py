"""Faults that make a column a simple function of the exact values, or of another column.

Each fault is a function of a column. It returns the deviation from the exact values that the fault
makes, with its evidence. `deviating_columns` tries all functions of `COLUMN_FAULTS`, and undoes the
fault that explains the error of the column best.

To add a fault, write a function like `_unsigned`, and add it to `COLUMN_FAULTS`. A new code also
needs a class of evidence like `UnsignedColumn`, with a field `maneuvers` for the maneuvers that
show the fault. In several maneuvers, floats of the same fault may differ by rounding; all other
fields must be equal.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.averages import averaged, averaged_over_step
from heyoka_bike.scoring.rows.bounds import clipped
from heyoka_bike.scoring.rows.filters import filtered
from heyoka_bike.scoring.rows.other_columns import another
from heyoka_bike.scoring.rows.other_moments import at_other_moment
from heyoka_bike.scoring.rows.scaled_columns import ratio, ratio_for_a_time
from heyoka_bike.scoring.rows.table import Deviation
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class UnsignedColumn(Evidence):
    """A column contains the exact values without their signs, in some maneuvers.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    """

    key: str
    maneuvers: tuple[int, ...]

    code = "unsigned_column"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key} of {maneuvers(self.maneuvers)} has the exact values without their signs. "
            "Look for an absolute value, or the square root of a square, in the code that computes "
            "and writes it"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers)}


def _unsigned(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column as the exact values without their signs."""
    right = c.trace.reference
    if np.min(right) >= 0.0:
        return None
    return Deviation(np.abs(right) - right, UnsignedColumn(c.key, (m.maneuver,)))


COLUMN_FAULTS = (
    another,
    _unsigned,
    ratio,
    clipped,
    averaged,
    averaged_over_step,
    at_other_moment,
    filtered,
    ratio_for_a_time,
)
"""Functions that describe the deviation which one fault makes in a column; None if it makes none.

They are tried in this order, the simplest fault first.
"""
