"""The results of a row check (`Undone`) and of a fault of a column (`Deviation`).

Further, functions on columns that several checks use.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import scale_words
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, Place
from heyoka_bike.scoring.units import factor

ENERGY, PARTS_OF_ENERGY = "mechanical_energy", ("potential_energy", "kinetic_energy")
"""Keys of the mechanical energy, and of the columns whose sum it is."""


@dataclass(frozen=True, slots=True)
class Undone:
    """The changes that a row check found in the rows, and the rows with these changes undone.

    Attributes
    ----------
    seen : tuple of Evidence
        The changes.
    parts : tuple of Part
        The corrected rows, by maneuver.
    filled : frozenset of (int, str)
        Maneuvers and keys of the columns whose corrected values were computed from the motion with
        which the rows were compared. They do not show which motion the file has.
    """

    seen: tuple[Evidence, ...]
    parts: tuple[Part, ...]
    filled: frozenset[tuple[int, str]] = frozenset()


Check = Callable[[Report], Undone | None]
"""A function that looks for one kind of change in the rows of a report; None if it sees none."""


@dataclass(frozen=True, slots=True)
class Deviation:
    """The difference from the exact values that one simple fault makes in a column [SI].

    Attributes
    ----------
    values : ndarray, shape (n,)
        Value with the fault - exact value; NaN in rows where the fault determines no value.
    seen : Evidence
        The fault in this column of this maneuver. Evidence of several maneuvers that differs only
        in its place is reported once.
    is_of_program
        True if one program makes this fault in all maneuvers with the same numbers. Such a
        deviation is dropped if the numbers of the maneuvers differ.
    """

    values: Array
    seen: Evidence
    is_of_program: bool = False


@dataclass(frozen=True, slots=True)
class Remainder(Evidence):
    """The largest error that remains after the reported faults are corrected.

    Attributes
    ----------
    max_rel_error
        The error relative to the scale of its column.
    place
        Maneuver and column of the error (``2.roll_angle``).
    """

    max_rel_error: float
    place: str

    code = "remainder"

    def message(self) -> str:
        number, _, key = self.place.partition(".")
        return (
            "No other fault is visible. With the faults above corrected, the largest error is "
            f"{scale_words(self.max_rel_error, key)}, in maneuver {number}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"max_rel_error": self.max_rel_error, "place": self.place}


def worst(report: Report) -> Remainder:
    """Return the largest error relative to the scale of its column, with its place."""
    errors = ((c.error, f"{m.maneuver}.{c.key}") for m, c in places(report))
    return Remainder(*max(errors, default=(0.0, "")))


def floor_of(c: ColumnScore) -> float:
    """Return the resolution limit of a column, or the roundoff of its values if larger [SI]."""
    return max(c.floor or 0.0, ROUNDING * c.scale)


def to_si(c: ColumnScore) -> float:
    """Return the factor from written values to SI units, negative if the sign is flipped."""
    return c.as_understood.sign * factor(c.as_understood.unit)[0]


def own_name(m: ManeuverScore, c: ColumnScore) -> str:
    """Return the name of the reference's column with the definition of a column of the file."""
    definitions = m.part.reference.definitions[c.key]
    return next(d.name for d in definitions if d.definition == c.definition)


def finite(x: float) -> float | None:
    """Return a number, or None if it is infinite."""
    return x if np.isfinite(x) else None


def is_right_column(c: ColumnScore) -> bool:
    """True if the error of a column is within its digits or the roundoff of binary64."""
    return c.is_hidden or (c.max_rel_error is not None and c.error < ROUNDING)


def places(report: Report) -> Iterator[Place]:
    """Iterate over the columns of the benchmark that have values, with their maneuvers."""
    return ((m, c) for m, c in report.places if c.key in BENCHMARK_COLUMNS)


def whole_columns(m: ManeuverScore) -> list[ColumnScore]:
    """List the columns with a known definition and a value in every row."""
    return [c for c in m.columns if c.values == m.rows and c.is_known and c.scale]
