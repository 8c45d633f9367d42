"""Find columns, and parts of the mechanical energy, that are computed at another moment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP, Array
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.grades import RIGHT, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import AS_GOOD, MOST_ROWS
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import ENERGY, PARTS_OF_ENERGY, Deviation, floor_of, own_name
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore


@dataclass(frozen=True, slots=True)
class OtherMoment(Evidence):
    """A column, or a part of the mechanical energy, has the exact values of another moment.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    part
        Key of the part of the sum; None for the column itself.
    delay
        Time by which the values are late [s]; negative if they are early; None if all of them are
        those of the first row.
    rows
        The delay in rows, if it is a whole number of rows.
    """

    key: str
    maneuvers: tuple[int, ...]
    part: str | None
    delay: float | None
    rows: int | None = None

    code = "other_moment"
    severity = Severity.WARNING

    def message(self) -> str:
        where = f"{self.key} of {maneuvers(self.maneuvers)}"
        has = f"contains the {_in_words(self.part)}" if self.part else "has the exact value"
        return (
            f"{where} {has} {self._when()}. Check when it is computed: all values of a row belong "
            "to the same state"
        )

    def _when(self) -> str:
        if self.delay is None:
            return "of the first row in every row"
        way = "before" if self.delay > 0.0 else "after"
        if self.rows is None:
            return f"{abs(self.delay):.4g} s {way} the time of the row"
        return f"of the row {way}" if abs(self.rows) == 1 else f"of {abs(self.rows)} rows {way}"

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.key, "maneuvers": list(self.maneuvers), "part": self.part}
        return {**where, "delay": self.delay, "rows": self.rows}


@dataclass(frozen=True, slots=True)
class PartMultiplied(Evidence):
    """The mechanical energy contains a multiple of one of its parts.

    Attributes
    ----------
    maneuvers : tuple of int
    part
        Key of the part.
    factor
    """

    maneuvers: tuple[int, ...]
    part: str
    factor: float

    code = "part_multiplied"
    severity = Severity.WARNING

    def message(self) -> str:
        times = "lacks" if abs(self.factor) < RIGHT else f"contains {self.factor:.6g} times"
        return (
            f"mechanical_energy of {maneuvers(self.maneuvers)} {times} the {_in_words(self.part)}. "
            "Check how the sum is computed"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": "mechanical_energy", "maneuvers": list(self.maneuvers)}
        return {**where, "part": self.part, "factor": self.factor}


def _in_words(key: str) -> str:
    return key.replace("_", " ")


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
    is_sum, where = c.key == ENERGY, (m.maneuver,)
    for name in PARTS_OF_ENERGY if is_sum else (own_name(m, c),):

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
