"""Polynomials through the rows near each row of a file."""

import numpy as np

from heyoka_bike.numbers.double import Array


def local_polynomials(time: Array, x: Array, degree: int) -> Array:
    """Compute the coefficients of a polynomial through the rows nearest to each row.

    Parameters
    ----------
    time : ndarray, shape (n,)
    x : ndarray, shape (n,) or (n, c)
        One column, or several columns side by side.
    degree
        Each polynomial goes through one row more than this. Near both ends of the time its rows
        are not centred.

    Returns
    -------
    ndarray, shape (n, degree + 1) or (n, degree + 1, c)
        By row, and by power of the time from this row.
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
