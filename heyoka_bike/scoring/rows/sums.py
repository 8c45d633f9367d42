"""Compare the mechanical energy with the sum of its parts in the file, whatever the motion is."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, RIGHT
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.other_moments import OtherMoment, PartMultiplied
from heyoka_bike.scoring.rows.table import (
    ENERGY,
    PARTS_OF_ENERGY,
    Undone,
    floor_of,
    is_right_column,
)
from heyoka_bike.scoring.scores import ManeuverScore

_Changes = Sequence[Array]
"""What a fault adds to the mechanical energy, by maneuver; NaN in rows where this is not known."""


@dataclass(frozen=True, eq=False, slots=True)
class _Sum:
    """The mechanical energy of a maneuver and its parts, all with their own zeros [J].

    Attributes
    ----------
    parts : mapping of str to ndarray, shape (n,)
    off : ndarray, shape (n,)
        The mechanical energy minus the sum of its parts.
    least
        Largest value of `off` that the digits explain.
    """

    parts: Mapping[str, Array]
    off: Array
    least: float

    def is_explained(self, change: Array) -> bool:
        """True if a change of the sum explains all of `off`, which is far above rounding."""
        rows = np.isfinite(change)
        left = np.max(np.abs(self.off - change)[rows])
        return bool(left <= self.least) and rms(self.off[rows]) > CLEARLY * self.least


def own_sum(report: Report) -> Undone | None:
    """Look for a mechanical energy that contains a part of another row, or a multiple of a part.

    The fault must be the same in all maneuvers. The mechanical energy is then left out.
    """
    sums = [x for m in report.maneuvers if (x := _sum(m)) is not None]
    if len(sums) < len(report.maneuvers):
        return None
    for key in PARTS_OF_ENERGY:
        for seen, changes in _faults(report, key, sums):
            if all(x.is_explained(change) for x, change in zip(sums, changes, strict=True)):
                parts = (m.part.without({ENERGY}) for m in report.maneuvers)
                return Undone((seen,), tuple(parts))
    return None


def _faults(
    report: Report, key: str, sums: Sequence[_Sum]
) -> Iterator[tuple[OtherMoment | PartMultiplied, _Changes]]:
    """Yield the faults with which a part may be added, and what they add to the sums."""
    numbers, step = tuple(report), report.maneuvers[0].step
    each = [x.parts[key] for x in sums]
    yield OtherMoment(ENERGY, numbers, key, None), [x[0] - x for x in each]
    if step:
        late = OtherMoment(ENERGY, numbers, key, step, 1)
        yield late, [np.r_[np.nan, x[:-1] - x[1:]] for x in each]
        early = OtherMoment(ENERGY, numbers, key, -step, -1)
        yield early, [np.r_[x[1:] - x[:-1], np.nan] for x in each]
    part, off = np.concatenate(each), np.concatenate([x.off for x in sums])
    more = float(part @ off) / float(part @ part)
    # The difference of the energies is a mistake of the library, which simulations find.
    if abs(more + 2.0) > RIGHT:
        yield PartMultiplied(numbers, key, 1.0 + more), [more * x for x in each]


def _sum(m: ManeuverScore) -> _Sum | None:
    """Return the sum of a maneuver; None if it is not in the file, or a part is the wrong column.

    A part is the wrong column unless the sum of the parts is clearly nearer to the exact energy
    than the mechanical energy in the file.
    """
    keys = (ENERGY, *PARTS_OF_ENERGY)
    if any(key not in m or m[key].values < m.rows for key in keys) or m.rows < MIN_ROWS_FOR_SHAPE:
        return None
    columns = [m[key] for key in keys]
    errors = [c.trace.error for c in columns]
    if is_right_column(columns[0]) or rms(errors[0]) <= CLEARLY * rms(errors[1] + errors[2]):
        return None
    total, *parts = (c.trace.value + c.as_understood.offset for c in columns)
    least = MAX_ROUNDING_FLOORS * sum(map(floor_of, columns))
    return _Sum(dict(zip(PARTS_OF_ENERGY, parts, strict=True)), total - parts[0] - parts[1], least)
