"""Faults of a maneuver that are visible without any simulation.

These are: a bicycle that falls over, and wrong initial conditions; repeated or interpolated rows
(`rows_between`); columns of another maneuver; and a motion that is right only until some time
(`departures`).
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis.departures import Departs, departures
from heyoka_bike.scoring.diagnosis.rows_between import RowsBetween, held_or_interpolated
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import unit_text
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.grades import RIGHT, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.maneuvers import RowsRepeated, standing_still
from heyoka_bike.scoring.rows.other_maneuvers import ColumnOfAnotherManeuver, of_other_maneuvers
from heyoka_bike.scoring.scores import ManeuverScore
from heyoka_bike.scoring.units import unit_told_by

# Lean of a bicycle that lies on the floor [rad].
_LEAN_OF_LYING = np.pi / 2
# A fall begins at a lean below the first value, and its lean changes from row to row by less than
# the second value [rad]. Noise changes the lean by more.
_UPRIGHT, _STRIDE = 0.1, 1.0
# Keys of the given initial values that are not zero.
_GIVEN = ("roll_rate", "forward_speed")


@dataclass(frozen=True, slots=True)
class FallsOver(Evidence):
    """The bicycle falls over, although it does not in the exact motion.

    Attributes
    ----------
    times : mapping of int to float
        By maneuver number: the time at which the lean exceeds a quarter turn [s].
    """

    times: Mapping[int, float]

    code = "falls_over"
    severity = Severity.WARNING

    def message(self) -> str:
        times = " and ".join(f"at {t:.3g} s in maneuver {n}" for n, t in self.times.items())
        return (
            f"The bicycle falls over: its lean exceeds 90 degrees {times}. Check contact, friction "
            "and step size in the first tenths of a second, and ignore the later rows"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"times": {str(n): t for n, t in self.times.items()}}


@dataclass(frozen=True, slots=True)
class AnotherStart(Evidence):
    """The first row differs from the given initial conditions of the maneuver.

    Attributes
    ----------
    maneuvers : tuple of int
    key
    found, given
        Value of the first row, and the given value, in the unit of the column.
    unit
    told
        The unit in which the found number would be the given value; None if there is no such unit.
    """

    maneuvers: tuple[int, ...]
    key: str
    found: float
    given: float
    unit: str
    told: str | None

    @property
    def is_visible(self) -> bool:
        """True if the difference would be visible in a plot of the column."""
        return abs(self.found - self.given) > TOLERANCE * abs(self.given)

    code = "another_start"
    severity = Severity.WARNING

    def message(self) -> str:
        said = (
            f"In the first row, {self.key} of {maneuvers(self.maneuvers)} is {self.found:.9g} "
            f"{unit_text(self.unit)}; the given initial value is {self.given:.9g}"
        )
        if self.told:
            said += (
                f". The ratio is {self.found / self.given:.6g}, as if the value were in "
                f"{unit_text(self.told)}"
            )
        return said

    def numbers(self) -> Mapping[str, Any]:
        where = {"maneuver": self.maneuvers[0], "maneuvers": list(self.maneuvers)}
        numbers = {"found": self.found, "given": self.given, "unit": self.told}
        return {**where, "column": self.key, **numbers}


VisibleFault = (
    FallsOver | RowsRepeated | RowsBetween | ColumnOfAnotherManeuver | AnotherStart | Departs
)
"""Faults of the benchmark's columns that are visible without simulation."""


def shown(report: Report) -> tuple[VisibleFault, ...]:
    """Return the faults of the benchmark's columns that are visible without simulation."""
    maneuvers = report.maneuvers
    found: list[VisibleFault] = [*_falls_over(maneuvers), *standing_still(maneuvers)]
    found += held_or_interpolated(maneuvers)
    found += of_other_maneuvers(maneuvers)
    found += _other_starts(maneuvers)
    known = {
        n
        for x in found
        if not isinstance(x, FallsOver)
        for n in ((x.maneuver,) if isinstance(x, ColumnOfAnotherManeuver) else x.maneuvers)
    }
    return (*found, *departures([m for m in maneuvers if m.maneuver not in known]))


def _falls_over(maneuvers: Sequence[ManeuverScore]) -> Iterator[FallsOver]:
    """Find maneuvers whose lean exceeds a quarter turn, while that of the reference does not."""
    times = {}
    for m in maneuvers:
        traces = {c.key: c.trace for c in m.columns if c.values == m.rows}
        if not {"roll_angle", "potential_energy"} <= traces.keys():
            continue
        roll, height = traces["roll_angle"], traces["potential_energy"]
        # A low potential energy shows that the bicycle has really fallen over, so the large angle
        # is not just in a wrong unit.
        low = height.value < MEANINGLESS_ERROR * height.reference
        lies = (
            low & (np.abs(roll.value) > _LEAN_OF_LYING) & (np.abs(roll.reference) < _LEAN_OF_LYING)
        )
        row = int(np.argmax(lies))
        way = np.abs(roll.value[: row + 1])
        if lies.any() and way[0] < _UPRIGHT and np.max(np.abs(np.diff(way))) < _STRIDE:
            times[m.maneuver] = float(roll.time[row])
    if times:
        yield FallsOver(times)


def are_departures(seen: Sequence[VisibleFault], report: Report) -> bool:
    """True if every wrong maneuver is right at its start, or in every nth row."""
    departs = {n for x in seen if isinstance(x, Departs) for n in x.maneuvers}
    departs |= {n for x in seen if isinstance(x, RowsBetween) and x.every for n in x.maneuvers}
    wrong = {m.maneuver for m, c in report.places if not (c.is_right or c.is_hidden)}
    return bool(departs) and departs >= wrong


def other_heights(report: Report) -> tuple[AnotherStart, ...]:
    """Find first rows with a visibly wrong potential energy: a wrong mass or length shows there."""
    found = _other_starts(report.maneuvers, ("potential_energy",))
    return tuple(x for x in found if x.is_visible)


def _other_starts(
    maneuvers: Sequence[ManeuverScore], keys: Collection[str] = _GIVEN
) -> Iterator[AnotherStart]:
    """Find first rows whose roll rate or speed differs from the given initial value."""
    found: list[tuple[tuple[str, float, float, str, str | None], int]] = []
    for m in maneuvers:
        for c in m.columns:
            if c.key not in keys or not c.values or not c.is_known or c.trace.time[0] != 0.0:
                continue
            given, here = float(c.trace.reference[0]), float(c.trace.value[0])
            # A wrong motion does not show how a column is defined, so try all definitions.
            meant = m.part.reference.definitions[c.key]
            starts = m.part.reference.approximate(np.zeros(1), [x.name for x in meant])
            off = min(abs(here - float(x[0])) for x in starts.values())
            if off > max(RIGHT * abs(given), c.hidden):
                told = None
                if given:
                    ratio, taken = here / given, c.as_understood.unit
                    told = unit_told_by(ratio, c.unit, taken, RIGHT)
                found.append(((c.key, here, given, c.unit, told), m.maneuver))
    for alike, numbers in grouped(found).items():
        yield AnotherStart(tuple(numbers), *alike)
