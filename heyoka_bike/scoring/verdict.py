"""The one decision of what is right: every word about a result follows these functions.

A file is right if all eight columns of the benchmark are right (see `grades`), over the whole run,
in each maneuver of the file. A column that was not compared, or a part of the run without rows, may
be wrong unseen. So such a file is not whole, whether or not its other names are understood. A file
that has a compared quantity twice, with different values, is not whole either.

Eq. (1) is met by an energy that is the file's own potential plus kinetic energy within rounding, or
the true one where one of these is not there, and that is written finely enough to show the limit.
It is a part of the true energy, whatever the first value is.
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
"""Fraction of the run that rows of a whole file cover: the first row may be missing."""

ALL_COLUMNS = len(BENCHMARK_COLUMNS)
"""Columns of each maneuver in a whole file."""

ARITHMETIC = 1e-12
"""Of an energy: what thousands of operations in binary64 may leave, with more digits, too."""


def lost(seen: Iterable[Evidence], maneuvers: Sequence[ManeuverScore]) -> tuple[LostColumn, ...]:
    """Return the columns of the result that were not compared, each once."""
    compared = {c.key for m in maneuvers for c in m.columns}
    return tuple(dict.fromkeys(column for x in seen for column in x.lost(compared)))


def is_whole(maneuvers: Sequence[ManeuverScore], not_compared: Sequence[LostColumn]) -> bool:
    """True if all eight columns were compared over the whole run, in each maneuver of the file.

    Parameters
    ----------
    maneuvers
        Their scores.
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
    """Why eq. (1) cannot be claimed as it was measured."""

    NO_ENERGY = "there is no mechanical energy"
    NOT_ITS_SUM = "the energy is not its own potential plus kinetic energy"
    NOT_TRUE = "the energy is not the true one, and its parts do not show otherwise"
    ANOTHER_START = "the energy does not begin with the true one"
    FEW_DIGITS = "it cannot be told at the digits written"


@dataclass(frozen=True, slots=True)
class Claim:
    """Eq. (1) [%] as it may be claimed, and why that is not what was measured, if it is not."""

    value: float
    reason: DoesNotCount | None = None


def claim(m: ManeuverScore, limit: float) -> Claim:
    """Return eq. (1) of a maneuver as it may be claimed against a limit [%]."""
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
        # Parts that are written more coarsely than the limit do not tell.
        apart = 0.0 if 100 * rounding <= limit * scale else None
    # An error that rounding explains does not show that the energy differs from the true one.
    true_error = (total and total.unexplained) or 0.0
    if total and "potential_energy" not in columns:
        # Any constant has another zero, if its parts do not show which.
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
    """True if the benchmark's verdict by eq. (1) is that a maneuver passes.

    None if the benchmark does not judge it so, or if there is no energy.
    """
    if m.performance is None or m.performance_limit is None:
        return None
    return claim(m, m.performance_limit).value < m.performance_limit


def is_own_energy(m: ManeuverScore) -> bool:
    """True if eq. (1) is of the file's own energy, or of the true one, whatever the limit."""
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
    """Return eq. (1) as it may be claimed; all in percent.

    Parameters
    ----------
    change
        Eq. (1) as it was measured; None without an energy.
    limit
        What is asked for.
    resolution
        The smallest change that the digits written can show.
    sum_error
        How far the energy is from potential plus kinetic energy, beyond rounding; None if one of
        these is not there, or written so coarsely that this says nothing about the limit.
    true_error
        How far it is from the exact one, beyond the rounding of its digits.
    start
        The first value of the energy, in exact ones (1, not percent).
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
