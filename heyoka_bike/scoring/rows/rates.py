"""Compare rates with the slopes of their own angles, whatever the motion is.

An angle and its rate may be exchanged, and a rate may be a difference of its angle, or the rate at
another row.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import ANGLE_OF, LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import even_step
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.edits import Exchanged
from heyoka_bike.scoring.rows.local_polynomials import local_polynomials
from heyoka_bike.scoring.rows.other_columns import OtherColumn, pairs_exchanged
from heyoka_bike.scoring.rows.table import Undone, is_right_column
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

LATERAL_ANGLES = {rate: angle for rate, angle in ANGLE_OF.items() if rate in LATERAL}
"""The keys of the roll and steer angles, by the keys of their rates."""

ROWS_LATE = (1.0, -1.0, 0.5, -0.5)
"""Delays of a rate that are tried, in rows."""

# Degree of the polynomials from which the slopes of angles are computed. It is low, because then a
# corner in the motion affects only a few rows.
_DEGREE_OF_SLOPES = 4


def exchanged(report: Report) -> Undone | None:
    """Look for lateral columns that are exchanged in some maneuvers, or in all.

    Whatever the motion is, each rate is the slope of its angle once the columns are in their own
    places.
    """
    meant = {m.maneuver: _exchanged(m) for m in report.maneuvers}
    numbers = grouped((place, n) for n, places in meant.items() for place in places.items())
    if not numbers:
        return None
    seen = (OtherColumn(key, tuple(each), other) for (key, other), each in numbers.items())
    parts = (Exchanged(meant[m.maneuver]).undo(m.part) for m in report.maneuvers)
    return Undone(pairs_exchanged(seen), tuple(parts))


def _exchanged(m: ManeuverScore) -> dict[str, str]:
    """Find the exchanged columns of a maneuver: by place, the key of the column written there."""
    columns = [m[key] for key in LATERAL if key in m and m[key].values == m.rows]
    if len(columns) < 2 or m.rows < MIN_ROWS_FOR_SHAPE or not np.all(np.diff(m.part.time) > 0.0):
        return {}
    values = {c.key: c.trace.value for c in columns}
    slopes = {
        key: local_polynomials(m.part.time, x, _DEGREE_OF_SLOPES)[:, 1] for key, x in values.items()
    }

    def off(meant: Mapping[str, str]) -> Array:
        """Return for each angle the distance of its slope from its rate, relative to the rate."""
        place = {meant.get(key, key): key for key in values}
        pairs = [(place[a], place[r]) for r, a in LATERAL_ANGLES.items() if {a, r} <= {*place}]
        return np.array([rms(slopes[a] - values[r]) / (rms(values[r]) or 1.0) for a, r in pairs])

    found: dict[str, str] = {}
    before = off({})
    for one, other in _exchanges(m):
        if {one, other} <= {*values}:
            meant = {one: other, other: one}
            after = off(meant)
            changed = after != before
            if changed.any() and BY_FAR * max(after[changed]) < min(1.0, *before[changed]):
                found |= meant
    return found


def _exchanges(m: ManeuverScore) -> Iterator[tuple[str, str]]:
    """Yield the pairs of lateral columns that may be exchanged in a maneuver.

    If the two angles, or the two rates, are exchanged, slopes do not show which. The start does:
    there the bicycle rolls and does not steer.
    """
    yield from LATERAL_ANGLES.items()
    rates = "roll_rate", "steer_rate"
    if m.part.time[0] == 0.0 and all(key in m for key in rates):
        roll, steer = (abs(float(m[key].trace.value[0])) for key in rates)
        if roll != steer:
            yield ("roll_angle", "steer_angle") if roll > steer else rates


def _rates_of(report: Report) -> list[str]:
    """Return the keys of the rates that the file contains."""
    return [key for key in LATERAL_ANGLES if any(key in m for m in report.maneuvers)]


def _without_wrong_rate(
    report: Report, wrong: Sequence[RateOfDifferences | RateOfOtherRow], numbers: Collection[int]
) -> Undone | None:
    """Remove a wrong rate from some maneuvers; None unless exactly one rate is wrong.

    If both are wrong, later steps try other times, and simulated programs with this mistake.
    """
    if len(wrong) != 1:
        return None
    parts = (
        m.part.without({wrong[0].key}) if m.maneuver in numbers else m.part
        for m in report.maneuvers
    )
    return Undone(tuple(wrong), tuple(parts))


def _with_its_angle(m: ManeuverScore, key: str) -> tuple[ColumnScore, ColumnScore] | None:
    """Return a rate and its angle, or None unless both have enough values at equal times."""
    if key not in m or LATERAL_ANGLES[key] not in m:
        return None
    rate, angle = m[key], m[LATERAL_ANGLES[key]]
    is_usable = rate.values >= MIN_ROWS_FOR_SHAPE
    is_usable = is_usable and np.array_equal(rate.trace.time, angle.trace.time)
    return (rate, angle) if is_usable else None


@dataclass(frozen=True, slots=True)
class RateOfDifferences(Evidence):
    """A rate column is a ``forward``, ``backward`` or ``central`` difference of its own angle."""

    key: str
    how: str

    code = "rate_of_differences"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{self.key} is the {self.how} difference of {ANGLE_OF[self.key]} in every maneuver, "
            "not the rate of the motion. Write the rate that your program integrates. The other "
            "columns are diagnosed without it"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "how": self.how}


def own_differences(report: Report) -> Undone | None:
    """Look for a rate that is a finite difference of its own angle, while the other rate is not."""
    found = {
        key: set.intersection(*(_how_differenced(m, key) for m in report.maneuvers))
        for key in _rates_of(report)
    }
    wrong = [RateOfDifferences(key, min(ways)) for key, ways in found.items() if ways]
    return _without_wrong_rate(report, wrong, [*report])


def _how_differenced(m: ManeuverScore, key: str) -> set[str]:
    """Return the finite differences of its angle (``forward``, ...) that a rate equals."""
    if (both := _with_its_angle(m, key)) is None:
        return set()
    rate, angle = both
    time, x = rate.trace.time, angle.trace.value
    if not np.all(np.diff(time) > 0.0):
        # The slope between two rows at the same time is not defined.
        return set()
    slopes = np.diff(x) / np.diff(time)
    ways = {
        "forward": (slopes, slice(0, -1)),
        "backward": (slopes, slice(1, None)),
        "central": ((x[2:] - x[:-2]) / (time[2:] - time[:-2]), slice(1, -1)),
    }
    smooth = local_polynomials(time, x, _DEGREE_OF_SLOPES)[:, 1]
    step = float(np.min(np.diff(time)))
    least = MAX_ROUNDING_FLOORS * ((rate.floor or 0.0) + 2 * (angle.floor or 0.0) / step)
    found = set()
    for how, (slope, rows) in ways.items():
        is_difference = np.abs(rate.trace.value[rows] - slope) <= least
        # Only rows in which the finite difference and the slope of the angle differ by more than
        # the digits explain distinguish the two.
        telling = np.abs(slope - smooth[rows]) > CLEARLY * least
        if np.sum(telling) >= MIN_ROWS_FOR_SHAPE and all(
            np.mean(part) > MOST_ROWS for part in (is_difference, is_difference[telling])
        ):
            found.add(how)
    return found


@dataclass(frozen=True, slots=True)
class RateOfOtherRow(Evidence):
    """A rate column is the rate of its own angle at an earlier or later row.

    Attributes
    ----------
    key
    rows
        Delay in rows; negative if the rate is early.
    maneuvers : tuple of int
        The maneuvers with this delay; empty if all have it.
    """

    key: str
    rows: float
    maneuvers: tuple[int, ...] = ()

    code = "rate_of_other_row"
    severity = Severity.WARNING

    def message(self) -> str:
        row = "half a row" if abs(self.rows) < 1.0 else "one row"
        where = maneuvers(self.maneuvers) if self.maneuvers else "every maneuver"
        return (
            f"In {where}, each value of {self.key} is the derivative of {ANGLE_OF[self.key]} {row} "
            f"{'earlier' if self.rows > 0.0 else 'later'}. Write both for the same time. The other "
            "columns are diagnosed without this one"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "rows": self.rows, "maneuvers": list(self.maneuvers)}


def shifted_rate(report: Report) -> Undone | None:
    """Look for a rate that is shifted by rows from its own angle, while the other rate is not.

    It may be shifted in some maneuvers only, if it is the slope of its angle in the others.
    """
    wrong, numbers = [], [*report]
    for key in _rates_of(report):
        each = {m.maneuver: _rows_off(m, key) for m in report.maneuvers}
        shifted = {n: x for n, x in each.items() if x[0]}
        others = [off for n, (_, off) in each.items() if n not in shifted]
        rows = {rows for rows, _ in shifted.values()}
        least = min((off for _, off in shifted.values()), default=0.0)
        if len(rows) == 1 and all(BY_FAR * off < least for off in others):
            numbers = [*shifted]
            wrong.append(RateOfOtherRow(key, rows.pop(), tuple(numbers) if others else ()))
    return _without_wrong_rate(report, wrong, numbers)


def _rows_off(m: ManeuverScore, key: str) -> tuple[float, float]:
    """Return the delay of a rate relative to the slope of its angle, and its distance from it.

    The delay is one of `ROWS_LATE`, or 0 if none fits. The distance is relative to the rate,
    infinite if it is not known.
    """
    both = _with_its_angle(m, key)
    if both is None:
        return 0.0, np.inf
    rate, angle = both
    time = rate.trace.time
    if (step := even_step(time)) is None:
        return 0.0, np.inf
    powers = local_polynomials(time, angle.trace.value, _DEGREE_OF_SLOPES)
    inner = slice(_DEGREE_OF_SLOPES, -_DEGREE_OF_SLOPES)

    def off(rows: float) -> float:
        k = np.arange(1, _DEGREE_OF_SLOPES + 1)
        slope = powers[:, 1:] @ (k * (-rows * step) ** (k - 1))
        return rms((rate.trace.value - slope)[inner])

    best = min(ROWS_LATE, key=off)
    size = rms(rate.trace.value)
    # A right rate is not shifted: then the angle is the wrong column of the two.
    is_best = not is_right_column(rate) and BY_FAR * off(best) < min(
        off(0.0), TOLERANCE * BY_FAR * size
    )
    # A finite difference is nearly the same as a shift by half a row. `own_differences` reports it.
    rows = best if is_best and not _how_differenced(m, key) else 0.0
    return rows, off(0.0) / (size or 1.0)
