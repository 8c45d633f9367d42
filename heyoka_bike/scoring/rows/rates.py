"""Rates held against their own angles, whatever the motion is.

An angle and its rate may be in each other's place, and a rate may be a difference of its angle, or
that of another row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import ANGLE_OF, LATERAL
from heyoka_bike.scoring.alignment import are_even
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.output_faults import (
    OtherColumn,
    RateOfDifferences,
    RateOfOtherRow,
)
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.edits import Exchanged
from heyoka_bike.scoring.rows.local_polynomials import local_polynomials
from heyoka_bike.scoring.rows.table import Undone, is_right_column
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

LATERAL_ANGLES = {rate: angle for rate, angle in ANGLE_OF.items() if rate in LATERAL}
"""The keys of the roll and steer angles, by the keys of their rates."""

ROWS_LATE = (1.0, -1.0, 0.5, -0.5)
"""Numbers of rows by which a rate may be late that are tried."""

# Of polynomials through so few rows that a corner in the motion reaches no further.
_DEGREE_OF_SLOPES = 4


def exchanged_with_rate(report: Report) -> Undone | None:
    """An angle and its rate in each other's place.

    What is written as the angle is then the slope of what is written as the rate, whatever the
    motion.
    """
    found = [
        key for key in _rates_of(report) if all(_is_slope_of_rate(m, key) for m in report.maneuvers)
    ]
    if not found:
        return None
    angles = {key: LATERAL_ANGLES[key] for key in found}
    meant = angles | {angle: key for key, angle in angles.items()}
    numbers = tuple(m.maneuver for m in report.maneuvers)
    seen = (OtherColumn(key, numbers, other) for key, other in meant.items())
    return Undone(tuple(seen), tuple(Exchanged(meant).undo(m.part) for m in report.maneuvers))


def _is_slope_of_rate(m: ManeuverScore, key: str) -> bool:
    """True if an angle is the slope of its rate, and the rate is far from that of its angle."""
    angle_key = LATERAL_ANGLES[key]
    if key not in m or angle_key not in m:
        return False
    rate, angle = m[key], m[angle_key]
    is_whole = rate.values == angle.values == m.rows >= MIN_ROWS_FOR_SHAPE
    time = rate.trace.time
    if not is_whole or not np.all(np.diff(time) > 0.0):
        return False
    x, v = angle.trace.value, rate.trace.value
    off, off_exchanged = (
        rms(local_polynomials(time, one, _DEGREE_OF_SLOPES)[:, 1] - other) / (rms(other) or 1.0)
        for one, other in ((x, v), (v, x))
    )
    return BY_FAR * off_exchanged < min(off, 1.0)


def _rates_of(report: Report) -> list[str]:
    """The rates that the file has."""
    return [key for key in LATERAL_ANGLES if any(key in m for m in report.maneuvers)]


def _put_aside(report: Report, rates: Sequence[str], told: Mapping[str, Evidence]) -> Undone | None:
    """What is told of some rates, and the rows without these; None of none, or of both.

    Where both are wrong, whole programs that make this mistake are compared.
    """
    if not told or len(told) == len(rates) > 1:
        return None
    parts = (m.part.only(m.part.values.keys() - told.keys()) for m in report.maneuvers)
    return Undone(tuple(told.values()), tuple(parts))


def _with_its_angle(m: ManeuverScore, key: str) -> tuple[ColumnScore, ColumnScore] | None:
    """A rate and its angle, if both are there with enough values at the same times."""
    if key not in m or LATERAL_ANGLES[key] not in m:
        return None
    rate, angle = m[key], m[LATERAL_ANGLES[key]]
    is_told = rate.values >= MIN_ROWS_FOR_SHAPE
    is_told = is_told and np.array_equal(rate.trace.time, angle.trace.time)
    return (rate, angle) if is_told else None


def own_differences(report: Report) -> Undone | None:
    """A rate that is a difference of its own angle, where the other rate is not."""
    rates = _rates_of(report)
    found = {
        key: set.intersection(*(_how_differenced(m, key) for m in report.maneuvers))
        for key in rates
    }
    told = {key: RateOfDifferences(key, min(ways)) for key, ways in found.items() if ways}
    return _put_aside(report, rates, told)


def _how_differenced(m: ManeuverScore, key: str) -> set[str]:
    """``forward``, ``backward`` or ``central`` if a rate is such a difference, to its digits."""
    if (both := _with_its_angle(m, key)) is None:
        return set()
    rate, angle = both
    time, x = rate.trace.time, angle.trace.value
    if not np.all(np.diff(time) > 0.0):
        # Two rows at one time have no slope.
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
        # Where the digits tell such a difference from the slope of the angle.
        telling = np.abs(slope - smooth[rows]) > CLEARLY * least
        if np.sum(telling) >= MIN_ROWS_FOR_SHAPE and all(
            np.mean(part) > MOST_ROWS for part in (is_difference, is_difference[telling])
        ):
            found.add(how)
    return found


def shifted_rate(report: Report) -> Undone | None:
    """A rate that is that of its own angle some rows before or after, and the other one is not."""
    rates = _rates_of(report)
    each = {key: {_rows_off(m, key) for m in report.maneuvers} for key in rates}
    alike = {key: next(iter(of)) for key, of in each.items() if len(of) == 1}
    told = {key: RateOfOtherRow(key, rows) for key, rows in alike.items() if rows}
    return _put_aside(report, rates, told)


def _rows_off(m: ManeuverScore, key: str) -> float:
    """By how many rows a rate is later than the slope of its angle; 0 if not by a half or one."""
    both = _with_its_angle(m, key)
    # Beside a right rate the angle is another one.
    if both is None or is_right_column(both[0]):
        return 0.0
    rate, angle = both
    time = rate.trace.time
    step = float(np.ptp(time)) / (len(time) - 1)
    if not are_even(time - time[0], step):
        return 0.0
    powers = local_polynomials(time, angle.trace.value, _DEGREE_OF_SLOPES)
    inner = slice(_DEGREE_OF_SLOPES, -_DEGREE_OF_SLOPES)

    def off(rows: float) -> float:
        k = np.arange(1, _DEGREE_OF_SLOPES + 1)
        slope = powers[:, 1:] @ (k * (-rows * step) ** (k - 1))
        return rms((rate.trace.value - slope)[inner])

    best = min(ROWS_LATE, key=off)
    size = rms(rate.trace.value)
    is_best = BY_FAR * off(best) < min(off(0.0), TOLERANCE * BY_FAR * size)
    # Differences are nearly that, and seen as such.
    return best if is_best and not _how_differenced(m, key) else 0.0
