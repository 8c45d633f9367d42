"""Observed order of convergence of each column, and what Richardson's extrapolation leaves."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import log

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, warning
from heyoka_bike.scoring.report import Convergence, Run

AT_FLOOR = 4.0
"""An error of up to this many floors is rounding, not the integrator's."""


def columns_of(runs: Sequence[Run]) -> Mapping[tuple[int, str], list[ColumnScore | None]]:
    """Each maneuver and column, with its score in each run."""
    found: dict[tuple[int, str], list[ColumnScore | None]] = {}
    for i, run in enumerate(runs):
        for m in run.report.maneuvers:
            for c in m.columns:
                found.setdefault((m.maneuver, c.key), [None] * len(runs))[i] = c
    order = list(COMPARED)
    return dict(sorted(found.items(), key=lambda x: (x[0][0], order.index(x[0][1]))))


def converge(runs: Sequence[Run]) -> tuple[Convergence, ...]:
    """Every column that more than one run has."""
    steps = [run.step for run in runs]
    return tuple(
        _converge(maneuver, key, columns, steps)
        for (maneuver, key), columns in columns_of(runs).items()
        if sum(c is not None for c in columns) > 1
    )


def _converge(
    maneuver: int, key: str, columns: Sequence[ColumnScore | None], steps: Sequence[float | None]
) -> Convergence:
    sized = list(zip(columns, steps, strict=True))
    orders = tuple(_order(*coarse, *fine) for coarse, fine in pairwise(sized))
    (coarse, step), (fine, next_step) = sized[-2:]
    extrapolated = None
    if coarse and fine and step and next_step and (order := round(orders[-1] or 0.0)) >= 1:
        extrapolated = _richardson(coarse, fine, (step / next_step) ** order)
    last = next(c for c in reversed(columns) if c is not None)
    return Convergence(
        maneuver=maneuver,
        key=key,
        unit=last.unit,
        definition=last.definition,
        errors=tuple(None if c is None else c.max_abs_error for c in columns),
        orders=orders,
        richardson_error=extrapolated,
        floor=last.floor,
    )


def _order(
    coarse: ColumnScore | None,
    step: float | None,
    fine: ColumnScore | None,
    next_step: float | None,
) -> float | None:
    """log(e1 / e2) / log(h1 / h2); None where an error is rounding only."""
    if coarse is None or fine is None or step is None or next_step is None:
        return None
    before, after = coarse.max_abs_error, fine.max_abs_error
    if coarse.definition != fine.definition or not before or not after:
        return None
    if coarse.is_at_floor(AT_FLOOR) or fine.is_at_floor(AT_FLOOR):
        return None
    return log(before / after) / log(step / next_step)


def _richardson(coarse: ColumnScore, fine: ColumnScore, ratio: float) -> float | None:
    """Largest error of the extrapolated values at the times that both runs have.

    The extrapolation is linear, so it may be done on the errors themselves.
    """
    _, i, j = np.intersect1d(coarse.trace.time, fine.trace.time, return_indices=True)
    # A few common times show nothing of the others.
    if 2 * len(i) < len(coarse.trace.time):
        return None
    e1, e2 = coarse.trace.error[i], fine.trace.error[j]
    return float(np.max(np.abs(e2 + (e2 - e1) / (ratio - 1.0))))


def nothing_shared(convergence: Sequence[Convergence], what: str) -> list[Finding]:
    """A warning if no column is in two of the files or programs."""
    said = f"no maneuver has a column that two of the {what}"
    return [] if convergence else [warning("no_shared_columns", said)]
