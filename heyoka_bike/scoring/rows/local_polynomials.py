"""Polynomials through the rows near each row of a file."""

import numpy as np

from heyoka_bike.numbers.double import Array


def local_polynomials(time: Array, x: Array, degree: int) -> Array:
    """Coefficients, by row and power of the time from it, of polynomials through the rows nearest.

    Each goes through one row more than its degree; at either end they are not in the middle. Of
    columns side by side, shape (n, c), the coefficients are as well: shape (n, powers, c).
    """
    first = np.clip(np.arange(len(time)) - degree // 2, 0, len(time) - degree - 1)
    rows = first[:, None] + np.arange(degree + 1)
    apart = time[rows] - time[:, None]
    scale = np.abs(apart).max(axis=1)[:, None]
    powers = (apart / scale)[..., None] ** np.arange(degree + 1)
    near = x[rows]
    scaled = np.linalg.solve(powers, near.reshape(*rows.shape, -1))
    found = scaled / scale[..., None] ** np.arange(degree + 1)[:, None]
    return np.asarray(found.reshape(near.shape), np.float64)
