"""Observed order of convergence of each column, and what Richardson's extrapolation leaves."""

from collections.abc import Sequence
from itertools import pairwise
from math import log

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.report import Convergence, Run

# An error this close to its floor is rounding, not the integrator's.
_AT_FLOOR = 4.0


def converge(runs: Sequence[Run]) -> tuple[Convergence, ...]:
    """Every column that more than one run has."""
    by_column: dict[tuple[int, str], list[ColumnScore | None]] = {}
    for i, run in enumerate(runs):
        for m in run.report.maneuvers:
            for c in m.columns:
                by_column.setdefault((m.maneuver, c.key), [None] * len(runs))[i] = c
    return tuple(
        _converge(maneuver, key, columns, [run.step for run in runs])
        for (maneuver, key), columns in sorted(
            by_column.items(), key=lambda entry: (entry[0][0], list(COMPARED).index(entry[0][1]))
        )
        if sum(c is not None for c in columns) > 1
    )


def _converge(
    maneuver: int, key: str, columns: Sequence[ColumnScore | None], steps: Sequence[float | None]
) -> Convergence:
    pairs = list(pairwise(columns))
    orders = tuple(
        _order(coarse, fine, *steps[i : i + 2]) for i, (coarse, fine) in enumerate(pairs)
    )
    last = next(c for c in reversed(columns) if c is not None)
    coarse, fine = pairs[-1]
    order, step, next_step = orders[-1], *steps[-2:]
    extrapolated = None
    if coarse and fine and order is not None and round(order) >= 1 and step and next_step:
        extrapolated = _richardson(coarse, fine, (step / next_step) ** round(order))
    return Convergence(
        maneuver=maneuver,
        key=key,
        unit=last.unit,
        definition=last.as_understood.definition,
        errors=tuple(
            None if c is None else c.as_understood.measures.max_abs_error for c in columns
        ),
        orders=orders,
        richardson_error=extrapolated,
        floor=last.floor,
    )


def _order(
    coarse: ColumnScore | None,
    fine: ColumnScore | None,
    step: float | None,
    next_step: float | None,
) -> float | None:
    """log(e1 / e2) / log(h1 / h2); None where an error is rounding only."""
    if coarse is None or fine is None or step is None or next_step is None:
        return None
    if coarse.as_understood.definition != fine.as_understood.definition:
        return None
    errors = [c.as_understood.measures.max_abs_error or 0.0 for c in (coarse, fine)]
    floors = [c.floor or 0.0 for c in (coarse, fine)]
    if any(e <= _AT_FLOOR * f or e == 0.0 for e, f in zip(errors, floors, strict=True)):
        return None
    return log(errors[0] / errors[1]) / log(step / next_step)


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
