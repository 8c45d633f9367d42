"""Greatest values between samples, by parabolas; and where samples pass below zero."""

import numpy as np

from heyoka_bike.numbers.double import Array


def tops(values: Array) -> tuple[Array, Array]:
    """Of the parabolas through three samples with the largest amid: tops, and their places.

    Parameters
    ----------
    values : ndarray, shape (motions, samples)

    Returns
    -------
    ndarray, shape (motions, samples - 2), twice
        Minus infinity where there is no top; places count samples from the middle one.
    """
    a, b, c = values[:, :-2], values[:, 1:-1], values[:, 2:]
    with np.errstate(invalid="ignore", divide="ignore"):
        is_top = (b >= a) & (b > c)
        bend = 2 * b - a - c
        top = np.where(is_top, b + (a - c) ** 2 / (8 * bend), -np.inf)
        return top, np.where(is_top, (c - a) / (2 * bend), 0.0)


def largest(values: Array) -> Array:
    """Along each row, between samples too."""
    found: Array = np.fmax(np.fmax.reduce(values, axis=1), tops(values)[0].max(axis=1))
    return found


def first_negative(values: Array) -> Array:
    """Where each row first passes below zero, in samples; NaN if it does not."""
    with np.errstate(invalid="ignore", divide="ignore"):
        is_below = values < 0
        i = np.argmax(is_below, axis=1)
        rows = np.arange(len(values))
        here, ahead = values[rows, i], values[rows, np.maximum(i - 1, 0)]
        # Before the first sample there is none: it is below from there.
        back = np.where(np.isfinite(ahead) & (ahead > 0), here / (here - ahead), 0.0)
        crossed = np.where(is_below.any(axis=1), i - back, np.nan)
        depth, place = tops(-values)
        is_dip = (depth > 0) & ~is_below[:, 1:-1]
        j = np.argmax(is_dip, axis=1)
        dipped = np.where(is_dip.any(axis=1), j + 1 + place[rows, j], np.nan)
    found: Array = np.fmin(crossed, dipped)
    return found
