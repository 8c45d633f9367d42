"""Sums, products, quotients and roots of double-double numbers, medians of plain ones (NumPy only).

A double-double number is the exact sum hi + lo of two binary64 ones, about 32 digits. Error-free
sums and products: Dekker (1971), doi:10.1007/BF01397083.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

Double = tuple[Array, Array]
"""hi and lo, of the same shape."""

_SPLITTER = 2.0**27 + 1.0


def median(x: ArrayLike) -> Array:
    """Median along the last axis of finite numbers.

    That of NumPy imports its masked arrays, which takes a tenth of the time of importing NumPy.
    """
    values = np.asarray(x, dtype=np.float64)
    low, high = (values.shape[-1] - 1) // 2, values.shape[-1] // 2
    ordered = np.partition(values, (low, high), axis=-1)
    return np.asarray((ordered[..., low] + ordered[..., high]) / 2)


def two_sum(a: Array, b: Array) -> Double:
    """Exact sum of two binary64 numbers."""
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


def fast_two_sum(a: Array, b: Array) -> Double:
    """Exact sum of two binary64 numbers, the first the larger one."""
    s = a + b
    return s, b - (s - a)


def split(a: Array) -> Double:
    """A binary64 number as the sum of two with 26 bits each, Dekker's way."""
    c = _SPLITTER * a
    high = c - (c - a)
    return high, a - high


def two_product(a: Array, b: Array) -> Double:
    """Exact product of two binary64 numbers (no overflow or underflow)."""
    p = a * b
    ah, al = split(a)
    bh, bl = split(b)
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


def add(x: Double, y: Double) -> Double:
    """Sum, to about 2^-104 of the larger term."""
    s, e = two_sum(x[0], y[0])
    t, f = two_sum(x[1], y[1])
    s, e = fast_two_sum(s, e + t)
    return fast_two_sum(s, e + f)


def multiply(x: Double, y: Double) -> Double:
    """Product, to about 2^-103."""
    p, e = two_product(x[0], y[0])
    return fast_two_sum(p, e + (x[0] * y[1] + x[1] * y[0]))


def divide(x: Double, y: Array, y_lo: Array | float = 0.0) -> Double:
    """Quotient by y + y_lo, to about 2^-103."""
    q = x[0] / y
    p, e = two_product(q, y)
    rest = ((x[0] - p) - e + (x[1] - q * y_lo)) / y
    return fast_two_sum(q, rest)


def root(x: Double) -> Double:
    """Square root, to about 2^-103."""
    r = np.sqrt(x[0])
    p, e = two_product(r, r)
    rest = (x[0] - p) - e + x[1]
    # That of zero is zero.
    return fast_two_sum(r, rest / np.where(r == 0, 1.0, 2 * r))
