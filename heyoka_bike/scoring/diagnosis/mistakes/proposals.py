"""Mistakes that are derived from the file itself: columns in another order.

There are too many orders to try them all. The order that fits the exact motion best is proposed,
and then judged like all other mistakes. It is the one-to-one assignment of the written columns to
quantities with the smallest product of the errors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED, DEFINITIONS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.definitions import NEAR_STEADY
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, output_mistake
from heyoka_bike.scoring.rows.edits import Columns, Stage
from heyoka_bike.scoring.units import UNITS, factor

# Units of angles and rates, which oscillate about zero. A column may contain another quantity only
# if its typical difference from this quantity is less than `MEANINGLESS_ERROR` times the quantity's
# size in these units, or less than `NEAR_STEADY` times this size in all other units.
_OSCILLATING = ("rad", "rad s-1")

# Quantities that may have been written in place of a column: those of the benchmark, and a few
# others that programs often compute.
_COLUMNS_PROPOSED = (*BENCHMARK_COLUMNS, "pitch", "yaw", "yaw_rate")


@dataclass(frozen=True, slots=True)
class _InPlace:
    """A quantity in the place of a column, and the logarithm of its relative error there."""

    cost: float
    column: Column
    sign: int
    unit: str


def columns_in_another_order(
    written: Sequence[Mapping[str, Array]], expected: Sequence[Mapping[str, Array]]
) -> Mistake | None:
    """Find the order of the columns that fits best; None if it is the correct one.

    Parameters
    ----------
    written, expected
        For each maneuver, at the same rows: the file's columns by key, and the exact columns by
        name, in every definition.
    """
    keys = [key for key in BENCHMARK_COLUMNS if any(key in w for w in written)]
    fits = [[_best_fit(key, quantity, written, expected) for quantity in _COLUMNS_PROPOSED]
            for key in keys]  # fmt: skip
    order = _assign([[fit.cost for fit in row] for row in fits])
    moved = {
        key: row[j]
        for key, row, j in zip(keys, fits, order, strict=True)
        if _COLUMNS_PROPOSED[j] != key
    }
    if not moved:
        return None

    def change(columns: Columns, _: Array) -> Columns:
        made = dict(columns)
        for key, fit in moved.items():
            values = fit.sign / factor(fit.unit)[0] * columns[fit.column.name]
            made.update({c.name: values for c in DEFINITIONS[key]})
        return made

    return output_mistake(
        "columns_" + "_".join(f"{fit.column.key}_as_{key}" for key, fit in moved.items()),
        ", and ".join(
            f"the {fit.column.long_name} is in the place of the {DEFINITIONS[key][0].long_name}"
            for key, fit in moved.items()
        ),
        "the order of the columns",
        change,
        Stage.PLACES,
    )


def _best_fit(
    key: str, quantity: str, written: Sequence[Mapping[str, Array]],
    expected: Sequence[Mapping[str, Array]],
) -> _InPlace:  # fmt: skip
    """Fit a quantity to a column, with the definition, sign and unit that fit best."""
    definitions = [c for c in COMPARED[quantity] if all(c.name in e for e in expected)]
    si = definitions[0].unit
    ways = [(unit, s) for unit in UNITS[si] for s in ((1, -1) if si in _OSCILLATING else (1,))]
    factors = np.array([sign * factor(unit)[0] for unit, sign in ways])
    cost = np.zeros((len(ways), len(definitions)))
    for w, e in zip(written, expected, strict=True):
        if key in w:
            meant = np.array([e[c.name] for c in definitions])
            cost += _distances(np.outer(factors, w[key]), meant, si, is_own=key == quantity)
    way, i = np.unravel_index(np.argmin(cost), cost.shape)
    unit, sign = ways[way]
    return _InPlace(float(cost[way, i]), definitions[i], sign, unit)


def _distances(values: Array, expected: Array, unit: str, *, is_own: bool) -> Array:
    """Return the logarithms of the typical relative errors, by factor and definition.

    A value is infinite if the error exceeds the limit, except for a column in its own place.
    """
    errors = np.abs(values[:, None] - expected)
    good = np.isfinite(errors)
    counts = good.sum(axis=2)
    size = np.sqrt(np.sum(np.where(good, expected**2, 0.0), axis=2) / np.maximum(counts, 1))
    # Index of the median of the finite errors. `sort` puts NaN last.
    middle = np.maximum(counts - 1, 0)[..., None] // 2
    typical = np.take_along_axis(np.sort(errors, axis=2), middle, axis=2)[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(np.maximum(typical / size, np.finfo(np.float64).eps))
    limit = MEANINGLESS_ERROR if unit in _OSCILLATING else NEAR_STEADY
    is_near = is_own | (typical < limit * size)
    return np.where(is_near, np.where(size > 0.0, logs, 0.0), inf)


def _assign(cost: Sequence[Sequence[float]]) -> list[int]:
    """Choose a different column of the cost matrix for each row, so that the sum is smallest."""
    best: dict[int, tuple[float, list[int]]] = {0: (0.0, [])}
    for row in cost:
        found: dict[int, tuple[float, list[int]]] = {}
        for used, (total, chosen) in best.items():
            for j, more in enumerate(row):
                after = used | 1 << j
                if used != after and total + more < found.get(after, (inf, []))[0]:
                    found[after] = total + more, [*chosen, j]
        best = found
    return min(best.values())[1]
