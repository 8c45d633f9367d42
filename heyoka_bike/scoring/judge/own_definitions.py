"""Unknown definitions: columns with a definition of the program's own.

In a right motion, a column with an unknown definition has far larger errors than all others. A
wrong model or a rough integrator changes all columns. If the columns with only one definition have
many correct digits, and a column with several definitions has few, the motion is right and the
column has an unknown definition. This is reported instead of a cause. Speed and energies vary only
with the squares of roll and steer and may be right in a wrong motion, so at least one column of
roll or steer must be right.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.numbers.double import median
from heyoka_bike.scoring.evidence.column_meaning import DefinitionUnknown
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

FAR_WORSE = BY_FAR * CLEARLY
"""In a wrong motion, the errors of columns, in scales, differ by a factor of up to 100: the steer
rate follows the fastest mode, and the energies hardly vary. A column whose error is larger by this
factor has another definition."""


def unknown_definitions(report: Report) -> Iterator[DefinitionUnknown]:
    """Yield columns with an unknown definition in a right motion."""
    known = [c for m in report.maneuvers for c in m.columns if c.is_known]
    for key, places in report.by_column().items():
        columns = [c for _, c in places]
        if columns[0].is_known:
            continue
        yield DefinitionUnknown(
            key,
            nearest=columns[0].definition,
            log10_odds=columns[0].none_odds or 0.0,
            errors=tuple(c.max_abs_error for c in columns),
            digits_of_others=min(c.scd for c in known if c.scd is not None),
        )


Size = Callable[[ColumnScore], float]
"""A function that returns the error of a column relative to the size of the column."""


def typical(c: ColumnScore) -> float:
    """Return the median error over the rms of the column, which a few bad rows hardly change."""
    size = rms(c.trace.reference) or 1.0
    return float(median(np.abs(c.trace.error))) / size


def far_worse(
    m: ManeuverScore, keys: Collection[str], size: Size = typical
) -> tuple[frozenset[str], float]:
    """Return the columns among `keys` with far larger errors than all others, in a right motion.

    A right column of roll or steer shows that the motion is right. The potential energy shows it,
    too, because its error is the square of the error of the angles.

    Returns
    -------
    keys : frozenset of str
        The largest set of such columns; empty if there are none.
    limit : float
        Largest error of the other columns, in scales.
    """
    columns = m.compared
    ranked = sorted((c for c in columns if c.key in keys), key=size, reverse=True)
    for count in range(len(ranked), 0, -1):
        worse = ranked[:count]
        others = [c for c in columns if c not in worse]
        limit = _largest(others)
        is_shown = any(c.key in LATERAL for c in others) or _shows_lean(
            others, min(map(size, worse))
        )
        if is_shown and limit < TOLERANCE and all(is_far(c, limit, size=size) for c in worse):
            return frozenset(c.key for c in worse), limit
    return frozenset(), _largest(columns)


def _shows_lean(others: Sequence[ColumnScore], error: float) -> bool:
    """True if the error of the potential energy excludes an error of this size in the angles.

    The error of the energy would be about the square of the error of the angles; it must be far
    smaller.

    The error of the energy is relative to its variation, the error of the angles to their size.
    """
    heights = [c for c in others if c.key == "potential_energy" and np.ptp(c.trace.reference)]
    return any(
        BY_FAR * float(np.max(np.abs(c.trace.error))) < error**2 * float(np.ptp(c.trace.reference))
        for c in heights
    )


def is_far(c: ColumnScore, limit: float, times: float = FAR_WORSE, size: Size = typical) -> bool:
    """True if the error is above `times` the limit, and rounding does not explain it."""
    return size(c) > times * limit and not c.is_hidden


def _largest(columns: Sequence[ColumnScore]) -> float:
    return max((c.error for c in columns), default=0.0)
