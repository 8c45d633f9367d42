"""Evaluation of piecewise Chebyshev polynomials, in binary64 or double-double (NumPy only).

A double-double number is the exact sum hi + lo of two binary64 numbers, about 32 digits. `clenshaw`
is the recurrence, used for a small number of times. For many times the columns of a piece are the
matrix product C T(x): their coefficients times the Chebyshev polynomials at all times. `plain_sums`
computes this product in binary64. `double_sums` returns it as hi + lo: T is computed once for all
columns in double-double arithmetic, C and T are cut into slices of 21 bits, and the products of the
leading slices are exact, whatever the order in which a library sums them.

References
----------
C. W. Clenshaw (1955), A note on the summation of Chebyshev series (the recurrence).
T. J. Dekker (1971), doi:10.1007/BF01397083 (error-free sums and products).
K. Ozaki, T. Ogita, S. Oishi, S. M. Rump (2012), Error-free transformations of matrix
multiplication, doi:10.1007/s11075-011-9478-1.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, Double, add, divide, fast_two_sum, split, two_sum

# Number of values evaluated together. With this many, the data of one step stays in the processor's
# cache.
_POINTS_AT_ONCE = 8192


def locate(breaks: Array, t: Double) -> NDArray[np.intp]:
    """Return the index of the piece of each time; a break belongs to the piece on its right."""
    piece = np.searchsorted(breaks, t[0], side="right") - 1
    # The high part of a time just before a break may equal the break; its low part is then
    # negative.
    inside = np.clip(piece, 0, len(breaks) - 2)
    before = (t[0] == breaks[inside]) & (t[1] < 0)
    found: NDArray[np.intp] = np.clip(inside - before, 0, len(breaks) - 2)
    return found


def argument(breaks: Array, piece: NDArray[np.intp], t: Double) -> Double:
    """Return the argument 2 (t - a) / (b - a) - 1 of each time in its piece."""
    a, b = breaks[piece], breaks[piece + 1]
    zero = np.zeros_like(a)
    from_middle = add(add((2.0 * t[0], 2.0 * t[1]), (-a, zero)), (-b, zero))
    return divide(from_middle, b - a)


def clenshaw(hi: Array, lo: Array, piece: NDArray[np.intp], x: Double) -> Double:
    """Return sums of c_k T_k(x) with c = hi + lo, each time in its piece.

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
    step = max(_POINTS_AT_ONCE // max(columns, 1), 1)
    for start in range(0, count, step):
        rows = slice(start, start + step)
        part = _clenshaw(c, piece[rows], (x[0][rows], x[1][rows]))
        found[0][:, rows], found[1][:, rows] = part
    return found


def _clenshaw(c: Double, piece: NDArray[np.intp], x: Double) -> Double:
    """Return b_0 of b_k = c_k + (2x b_(k+1) - b_(k+2)); coefficients have shape (N, columns, P).

    Products and sums are as in `multiply` and `add`, but intermediate values are not normalised,
    and x is split only once.
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


# Number of times evaluated together. With this many, their polynomials stay in the processor's
# cache.
_TIMES_AT_ONCE = 4096
_SLICE = 21


def plain_sums(breaks: Array, c: Array, t: Array) -> Array:
    """Return sums c_k T_k(x) in binary64, to about 1e-15 of the largest coefficient.

    Parameters
    ----------
    breaks : ndarray, shape (P + 1,)
    c : ndarray, shape (columns, P, N)
    t : ndarray, shape (n,)
        Sorted times.

    Returns
    -------
    ndarray, shape (columns, n)
    """
    found = np.empty((len(c), len(t)))
    for rows, pieces, piece in _blocks(breaks, (t, np.zeros_like(t))):
        a, b = breaks[piece], breaks[piece + 1]
        x = ((t[rows] - a) - (b - t[rows])) / (b - a)
        polynomials = np.polynomial.chebyshev.chebvander(x, c.shape[-1] - 1).T
        for p, i, j in pieces:
            found[:, rows.start + i : rows.start + j] = c[:, p] @ polynomials[:, i:j]
    return found


def double_sums(breaks: Array, c: Double, t: Double) -> Double:
    """Return sums c_k T_k(x) as hi + lo, to about 1e-27 of the largest coefficient.

    Parameters and results are as for `plain_sums`, but each is hi + lo.
    """
    columns, count = len(c[0]), len(t[0])
    found = np.empty((columns, count)), np.empty((columns, count))
    # Scale the coefficients of each column and piece to the smallest power of two that is not below
    # the largest of them.
    largest = np.max(np.abs(c[0]), axis=-1, keepdims=True)
    unit = np.exp2(np.ceil(np.log2(np.where(largest > 0, largest, 1.0))))
    slices = _slices((c[0] / unit, c[1] / unit))
    for rows, pieces, piece in _blocks(breaks, t):
        x = argument(breaks, piece, (t[0][rows], t[1][rows]))
        polynomials = _polynomials(x, c[0].shape[-1])
        t1, t2, t3 = _slices(polynomials)
        t23 = t2 + t3
        for p, i, j in pieces:
            c1, c2, c3 = (part[:, p] for part in slices)
            of = slice(i, j)
            # The first two products are exact, with at most 48 bits each. The last product is 2^-38
            # of the first one, so binary64 is sufficient for it.
            leading = c1 @ t1[:, of]
            middle = c1 @ t2[:, of] + c2 @ t1[:, of]
            last = c1 @ t3[:, of] + c2 @ t23[:, of] + c3 @ polynomials[0][:, of]
            hi, lo = two_sum(leading, middle)
            hi, lo = fast_two_sum(hi, lo + last)
            to = slice(rows.start + i, rows.start + j)
            found[0][:, to], found[1][:, to] = hi * unit[:, p], lo * unit[:, p]
    return found


_Pieces = list[tuple[int, int, int]]


def _blocks(breaks: Array, t: Double) -> Iterator[tuple[slice, _Pieces, NDArray[np.intp]]]:
    """Yield, for each block of times, its rows, its runs (piece, start, end), and their pieces."""
    piece = locate(breaks, t)
    for start in range(0, len(piece), _TIMES_AT_ONCE):
        of = piece[start : start + _TIMES_AT_ONCE]
        ends = [0, *(np.flatnonzero(np.diff(of)) + 1), len(of)]
        pieces = [(int(of[i]), i, j) for i, j in pairwise(ends)]
        yield slice(start, start + len(of)), pieces, of


def _polynomials(x: Double, count: int) -> Double:
    """Return T_0 .. T_(count - 1) of the arguments, hi + lo of shape (count, n)."""
    hi, lo = np.empty((count, len(x[0]))), np.empty((count, len(x[0])))
    hi[0], lo[0] = 1.0, 0.0
    hi[1], lo[1] = x
    times, times_lo = 2.0 * x[0], 2.0 * x[1]
    high, low = split(times)
    for k in range(2, count):
        product = times * hi[k - 1]
        t_high, t_low = split(hi[k - 1])
        rest = ((high * t_high - product) + high * t_low + low * t_high) + low * t_low
        rest += times * lo[k - 1] + times_lo * hi[k - 1]
        total, total_rest = two_sum(product, -hi[k - 2])
        total_rest += rest - lo[k - 2]
        hi[k], lo[k] = fast_two_sum(total, total_rest)
    return hi, lo


def _slices(a: Double) -> tuple[Array, Array, Array]:
    """Split numbers of size up to 1 into 21 bits, the next 21 bits, and the rest."""
    one, two = 2.0**_SLICE, 2.0 ** (2 * _SLICE)
    first = np.rint(a[0] * one) / one
    rest = a[0] - first
    second = np.rint(rest * two) / two
    return first, second, (rest - second) + a[1]
