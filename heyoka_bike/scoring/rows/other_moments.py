"""Find columns, and parts of the mechanical energy, that are computed at another moment."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP, Array
from heyoka_bike.scoring.evidence.output_faults import OtherMoment, PartMultiplied
from heyoka_bike.scoring.grades import RIGHT, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import AS_GOOD, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import ENERGY, PARTS_OF_ENERGY, Deviation, floor_of
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


def at_other_moment(m: ManeuverScore, c: ColumnScore, _: Report) -> Deviation | None:
    """Describe a column, or a part of the mechanical energy, as that of another row.

    A part may also be that of the first row in every row, or it may be multiplied.
    """
    best: tuple[float, Deviation] | None = None
    error = c.trace.error + c.as_understood.offset
    for deviation in _moments(m, c, error):
        rest = (error - deviation.values)[np.isfinite(deviation.values)]
        # A filter resembles a delay, and an energy without a body resembles a multiple. Only values
        # that are then right belong to another moment.
        is_right = len(rest) > MOST_ROWS * len(error) and (
            np.max(np.abs(rest)) <= max(c.hidden, RIGHT * c.scale)
        )
        if not is_right:
            continue
        left = max(rms(rest), floor_of(c))
        if best is None or AS_GOOD * left < best[0]:
            best = left, deviation
    if best is None:
        return None
    return replace(best[1], values=best[1].values - c.as_understood.offset)


def _moments(m: ManeuverScore, c: ColumnScore, error: Array) -> Iterator[Deviation]:
    """Yield the deviations of columns that are written at another moment, the simplest first."""
    time, reference = c.trace.time, m.part.reference
    end = float(reference.duration)
    step = float(np.median(np.diff(time)))
    own = next(x.name for x in reference.definitions[c.key] if x.definition == c.definition)
    is_sum, where = c.key == ENERGY, (m.maneuver,)
    for name in PARTS_OF_ENERGY if is_sum else (own,):

        def exact(times: Array, name: str = name) -> Array:
            return reference.approximate(np.clip(times, 0.0, end), [name])[name]

        right, part = exact(time), name if is_sum else None
        if is_sum:
            yield Deviation(right[0] - right, OtherMoment(c.key, where, part, None))
        delay = 0.0
        for _ in range(ROUNDS_OF_NEWTON):
            late = exact(time - delay)
            slope = (exact(time - delay - SMALL_STEP) - late) / SMALL_STEP
            size = float(slope @ slope)
            delay += float(slope @ (error - late + right)) / size if size else 0.0
        count = round(delay / step)
        if is_whole := count != 0 and abs(delay / step - count) < TOLERANCE:
            delay = count * step
        # The error of an integrator may resemble a delay. So without any other column, which would
        # show this error, the values must be exactly those of another row.
        if 0.0 < abs(delay) < end and (is_whole or m.column_count > 1):
            meant = time - delay
            is_within = (meant >= 0.0) & (meant <= end)
            late = np.where(is_within, exact(meant) - right, np.nan)
            moment = OtherMoment(c.key, where, part, delay, count if is_whole else None)
            yield Deviation(late, moment, is_of_program=True)
        if is_sum:
            by = float(right @ error) / float(right @ right)
            multiplied = PartMultiplied(where, name, 1.0 + by)
            yield Deviation(by * right, multiplied, is_of_program=True)
