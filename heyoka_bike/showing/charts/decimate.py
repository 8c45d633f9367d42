"""Fewer points that draw the same line: the extremes within each bin of time."""

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array

Indices = NDArray[np.intp]


def envelope(x: Array, y: Array, bins: int) -> tuple[Array, Array]:
    """The smallest and the largest y of each bin of x, as the points they are, in order.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        x ascending; both finite.
    bins
        At most twice as many points are left; fewer than that come back as they are.
    """
    if len(x) <= 2 * bins:
        return x, y
    starts = _starts(x, bins)
    keep = np.zeros(len(x), dtype=bool)
    keep[_where(y, np.minimum, starts)] = True
    keep[_where(y, np.maximum, starts)] = True
    return x[keep], y[keep]


def highest(x: Array, y: Array, bins: int) -> tuple[Array, Array]:
    """The largest y of each bin of x, as the point it is; see `envelope`."""
    if len(x) <= bins:
        return x, y
    keep = _where(y, np.maximum, _starts(x, bins))
    return x[keep], y[keep]


def _starts(x: Array, bins: int) -> Indices:
    """Index of the first point of each bin that has any."""
    edges = np.linspace(x[0], x[-1], bins, endpoint=False)
    starts: Indices = np.searchsorted(x, edges)
    return np.unique(starts[starts < len(x)])


def _where(y: Array, extreme: np.ufunc, starts: Indices) -> Indices:
    """Index of the first extreme value of each bin."""
    bin_of = np.repeat(np.arange(len(starts)), np.diff(np.append(starts, len(y))))
    found = np.flatnonzero(y == extreme.reduceat(y, starts)[bin_of])
    first = np.diff(bin_of[found], prepend=-1) > 0
    return found[first]
