"""Definitions of a program's own: columns that mean something that is not known here.

A column that means something that is not known here is far worse than all others of a right motion.
A wrong model or a rough integrator moves all columns. Where the columns with one meaning only have
many digits, and one with several meanings has few, the motion is right and the meaning is not among
those known. That is said instead of looking for a cause. Roll and steer move together, and the
speed and the energies with their squares only: these may be right beside a motion that is not, so
that one of the former must be right.
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
"""Columns of one motion are wrong by parts of their scales that differ by up to 100 (the steer rate
follows the fastest mode, the energies hardly move): one that is worse by more means another
thing."""


def unknown_definitions(report: Report) -> Iterator[DefinitionUnknown]:
    """Columns whose definition is not known, of a motion that is right."""
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
"""Of the error of a column, in parts of the column."""


def typical(c: ColumnScore) -> float:
    """Median error over the size of the column: a few bad rows are no other meaning."""
    size = rms(c.trace.reference) or 1.0
    return float(median(np.abs(c.trace.error))) / size


def far_worse(
    m: ManeuverScore, keys: Collection[str], size: Size = typical
) -> tuple[frozenset[str], float]:
    """Columns among `keys` that are far worse than all others of a maneuver, whose motion is right.

    A column of roll and steer shows that; or the potential energy, which wrong angles would make
    wrong by their square.

    Returns
    -------
    keys : frozenset of str
        The most of them that are; empty if none is.
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
    """True if a potential energy is right by far more than the square of an error of angles.

    In parts of what it varies by, as the angles are of their size.
    """
    heights = [c for c in others if c.key == "potential_energy" and np.ptp(c.trace.reference)]
    return any(
        BY_FAR * float(np.max(np.abs(c.trace.error))) < error**2 * float(np.ptp(c.trace.reference))
        for c in heights
    )


def is_far(c: ColumnScore, limit: float, times: float = FAR_WORSE, size: Size = typical) -> bool:
    """True if a column is so many times worse than a limit, and than its digits allow."""
    return size(c) > times * limit and not c.is_hidden


def _largest(columns: Sequence[ColumnScore]) -> float:
    return max((c.error for c in columns), default=0.0)
