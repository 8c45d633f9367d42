"""Columns without dense output: known at the rows, and a tiny time before and after each."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, Double
from heyoka_bike.reference.values import Values

SUMMED = 1e-10
"""Of the duration: how late a million steps summed in binary64 may be.

A time so near to a row means it, and the reference is continued over so short a time.
"""

# Rows 0.01 s apart, and a motion whose fastest part decays with 20 /s: a slope is right to 1e-6.
_NEIGHBOURS = 9


def nearest(time: Array, t: Array) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """For each of some times [s] the nearest row, and whether it means that."""
    row = np.searchsorted((time[1:] + time[:-1]) / 2, t)
    return row, np.abs(t - time[row]) <= SUMMED * time[-1]


def values_at_rows(time: Double, rows: Values, t: Double, names: Sequence[str]) -> Values:
    """Columns at times that mean a row; NaN at others.

    Parameters
    ----------
    time : pair of ndarray, shape (rows,)
        Times of the rows [s], hi + lo, evenly spaced.
    rows
        Columns there.
    t : pair of ndarray, shape (n,)
    names
        Columns.
    """
    row, is_near = nearest(time[0], t[0])
    late = (t[0] - time[0][row]) + (t[1] - time[1][row])
    hi, lo = {}, {}
    for name in names:
        values = rows.hi[name]
        slope = _slopes(values, time[0])[row] if late.any() else 0.0
        hi[name] = np.where(is_near, values[row], np.nan)
        lo[name] = rows.lo[name][row] + slope * np.where(is_near, late, 0.0)
    return Values(hi, lo)


def _slopes(values: Array, time: Array) -> Array:
    """Derivatives of a column at evenly spaced rows, by polynomials through neighbouring ones."""
    n = min(_NEIGHBOURS, len(values))
    nodes = np.arange(n, dtype=np.float64)
    powers = np.vander(nodes, increasing=True)
    weights = (powers[:, :-1] * nodes[1:]) @ np.linalg.inv(powers)[1:]
    first = np.clip(np.arange(len(values)) - n // 2, 0, len(values) - n)
    own = weights[np.arange(len(values)) - first]
    slopes: Array = np.sum(own * values[first[:, None] + np.arange(n)], axis=1)
    slopes /= time[1] - time[0]
    return slopes
