"""The decision whether a file is right: all messages about a result follow these functions.

A file is right if all eight columns of the benchmark are right (see `grades`), over the whole run,
in each maneuver of the file. A column that was not compared, or a part of the run without rows, may
be wrong unseen. So such a file is not whole, whether or not its other names are understood. A file
that contains a compared quantity twice, with different values, is not whole either.

A file meets eq. (1) only if its mechanical energy equals its potential plus kinetic energy within
rounding, or equals the exact energy if one of these is absent. The energy must be written with
enough digits to show the limit. Eq. (1) is relative to the exact energy, whatever the first value
of the file is.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import TYPE_CHECKING

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.evidence.base import Evidence, LostColumn
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, Grade

if TYPE_CHECKING:
    from heyoka_bike.scoring.scores import ManeuverScore

MIN_COVERAGE = 0.99
"""Smallest fraction of the run that a whole file covers: the first row may be missing."""

ALL_COLUMNS = len(BENCHMARK_COLUMNS)
"""Number of columns of each maneuver in a whole file."""

ARITHMETIC = 1e-12
"""Relative error of an energy after thousands of operations in binary64, whatever its digits."""


def lost(seen: Iterable[Evidence], maneuvers: Sequence[ManeuverScore]) -> tuple[LostColumn, ...]:
    """Return the columns of the result file that were not compared, without duplicates."""
    compared = {c.key for m in maneuvers for c in m.columns}
    return tuple(dict.fromkeys(column for x in seen for column in x.lost(compared)))


def is_whole(maneuvers: Sequence[ManeuverScore], not_compared: Sequence[LostColumn]) -> bool:
    """True if all eight columns were compared over the whole run, in each maneuver of the file.

    Parameters
    ----------
    maneuvers
        The scores of the maneuvers.
    not_compared
        The columns of the result that were not compared, see `lost`.
    """
    has_gaps = any(c.missing for m in maneuvers for c in m.columns)
    is_covered = all(m.coverage >= MIN_COVERAGE for m in maneuvers)
    is_complete = all(m.column_count >= ALL_COLUMNS for m in maneuvers)
    return is_complete and is_covered and not has_gaps and not not_compared


def is_right(grades: Iterable[Grade], *, is_whole: bool) -> bool:
    """True if a file is whole, and each of its columns is right."""
    return is_whole and max(grades, default=Grade.UNKNOWN) == Grade.RIGHT


class DoesNotCount(Enum):
    """Reasons why the measured value of eq. (1) does not count."""

    NO_ENERGY = "there is no mechanical energy"
    NOT_ITS_SUM = "the energy is not the sum of the file's potential and kinetic energy"
    NOT_TRUE = "the energy differs from the exact one, and its parts do not confirm it"
    ANOTHER_START = "the first value of the energy differs from the exact one"
    FEW_DIGITS = "the digits written do not show the limit"


@dataclass(frozen=True, slots=True)
class Claim:
    """The value of eq. (1) that counts [%]; if it is not the measured one, the reason why."""

    value: float
    reason: DoesNotCount | None = None


def claim(m: ManeuverScore, limit: float) -> Claim:
    """Return the value [%] of eq. (1) that counts for a maneuver with this limit [%]."""
    columns = {c.key: c for c in m.compared}
    total = columns.get("mechanical_energy")
    parts = [columns[k] for k in ("potential_energy", "kinetic_energy") if k in columns]
    energy = [total] if total else parts
    scale = m.part.reference.scale("mechanical_energy")
    apart, floor = m.consistency.energy_sum, m.consistency.energy_sum_floor
    rounding = inf if floor is None else floor
    explained = MAX_ROUNDING_FLOORS * rounding + ARITHMETIC * scale
    if total is None:
        apart = 0.0
    elif apart is not None and apart <= explained:
        # If the parts of the energy are written more coarsely than the limit, their sum shows
        # nothing.
        apart = 0.0 if 100 * rounding <= limit * scale else None
    # Only the part of the error that rounding does not explain shows that the energy differs from
    # the exact energy.
    true_error = (total and total.unexplained) or 0.0
    if total and "potential_energy" not in columns:
        # Without the potential energy, a constant error of the mechanical energy could be due to a
        # different zero.
        true_error += abs(total.as_understood.offset)
    return performance(
        m.performance,
        limit,
        resolution=200 * sum(c.resolution for c in energy) / scale,
        sum_error=apart,
        true_error=100 * true_error / scale,
        start=abs(float(sum(c.trace.value[0] for c in energy))) / scale,
    )


def meets_limit(m: ManeuverScore) -> bool | None:
    """True if a maneuver passes the benchmark's limit on eq. (1).

    None if the benchmark sets no limit for this maneuver, or if the file has no energy.
    """
    if m.performance is None or m.performance_limit is None:
        return None
    return claim(m, m.performance_limit).value < m.performance_limit


def is_own_energy(m: ManeuverScore) -> bool:
    """True if there is an energy, and the file's potential and kinetic energy fit it."""
    return claim(m, inf).reason is None


def performance(
    change: float | None,
    limit: float,
    *,
    resolution: float,
    sum_error: float | None,
    true_error: float,
    start: float = 1.0,
) -> Claim:
    """Return the value of eq. (1) that counts; all numbers but `start` are in percent.

    Parameters
    ----------
    change
        The measured value of eq. (1); None without an energy.
    limit
        The limit of the benchmark or of a requirement.
    resolution
        The smallest change that the digits written can show.
    sum_error
        Difference of the energy from potential plus kinetic energy, beyond rounding; None if one
        of these is absent, or written so coarsely that the difference shows nothing about the
        limit.
    true_error
        Difference of the energy from the exact one, beyond the rounding of its digits.
    start
        Ratio of the energy's first value to the exact energy.
    """
    if change is None:
        return Claim(inf, DoesNotCount.NO_ENERGY)
    if sum_error:
        return Claim(inf, DoesNotCount.NOT_ITS_SUM)
    if sum_error is None and change < limit <= true_error:
        return Claim(true_error, DoesNotCount.NOT_TRUE)
    if change < limit <= change * start:
        return Claim(change * start, DoesNotCount.ANOTHER_START)
    if change < limit < resolution:
        return Claim(resolution, DoesNotCount.FEW_DIGITS)
    return Claim(change)
