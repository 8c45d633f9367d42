"""Evaluation of piecewise Chebyshev polynomials in double-double arithmetic (NumPy only).

A double-double number is the exact sum hi + lo of two binary64 ones, about 32 digits. Error-free
sums and products: Dekker (1971), doi:10.1007/BF01397083; recurrence: Clenshaw (1955).
"""

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, Double, add, divide, fast_two_sum, split, two_sum

# Values at a time, so that what a step needs stays in the processor's cache.
_BLOCK = 8192


def locate(breaks: Array, t: Double) -> NDArray[np.intp]:
    """Index of the piece of each time; a break belongs to the piece on its right."""
    piece = np.searchsorted(breaks, t[0], side="right") - 1
    # A time rounded up to a break may lie just before it.
    inside = np.clip(piece, 0, len(breaks) - 2)
    before = (t[0] == breaks[inside]) & (t[1] < 0)
    found: NDArray[np.intp] = np.clip(inside - before, 0, len(breaks) - 2)
    return found


def argument(breaks: Array, piece: NDArray[np.intp], t: Double) -> Double:
    """Argument 2 (t - a) / (b - a) - 1 of each time in its piece."""
    a, b = breaks[piece], breaks[piece + 1]
    zero = np.zeros_like(a)
    from_middle = add(add((2.0 * t[0], 2.0 * t[1]), (-a, zero)), (-b, zero))
    return divide(from_middle, b - a)


def clenshaw(hi: Array, lo: Array, piece: NDArray[np.intp], x: Double) -> Double:
    """Sums of c_k T_k(x) with c = hi + lo, each time in its piece.

    Parameters
    ----------
    hi, lo : ndarray, shape (columns, P, N)
        Coefficients.
    piece : ndarray, shape (n,)
    x : pair of ndarray, shape (n,)
        Arguments in -1..1, hi + lo.

    Returns
    -------
    pair of ndarray, shape (columns, n)
        hi + lo, to about 1e-31 of the largest value of the piece.
    """
    columns, count = len(hi), len(piece)
    found = np.empty((columns, count)), np.empty((columns, count))
    c: Double = (np.moveaxis(hi, -1, 0), np.moveaxis(lo, -1, 0))
    step = max(_BLOCK // max(columns, 1), 1)
    for start in range(0, count, step):
        rows = slice(start, start + step)
        part = _clenshaw(c, piece[rows], (x[0][rows], x[1][rows]))
        found[0][:, rows], found[1][:, rows] = part
    return found


def _clenshaw(c: Double, piece: NDArray[np.intp], x: Double) -> Double:
    """b_k = c_k + (2x b_(k+1) - b_(k+2)), coefficients of shape (N, columns, P).

    The products and sums of `multiply` and `add`, but without normalising what is only passed on,
    and with x split once.
    """
    powers, columns, _ = c[0].shape
    times, times_lo = 2.0 * x[0], 2.0 * x[1]
    high, low = split(times)
    zero = np.zeros((columns, len(piece)))
    b1, b1_lo, b2, b2_lo = zero, zero, zero, zero
    for k in range(powers - 1, -1, -1):
        if k == 0:
            times, times_lo = x
            high, low = split(times)
        product = times * b1
        b_high, b_low = split(b1)
        rest = ((high * b_high - product) + high * b_low + low * b_high) + low * b_low
        rest += times * b1_lo + times_lo * b1
        term, term_rest = two_sum(c[0][k][:, piece], -b2)
        term_rest += c[1][k][:, piece] - b2_lo
        total, total_rest = two_sum(term, product)
        total_rest += term_rest + rest
        b2, b2_lo = b1, b1_lo
        b1, b1_lo = fast_two_sum(total, total_rest)
    return b1, b1_lo
