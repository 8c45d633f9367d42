"""Vectors and matrices of balls: norms, products of absolute values, and moving frames."""

from collections.abc import Iterable, Sequence

import flint
import numpy as np

BallVector = list[flint.arb]
Polynomial = Sequence[flint.arb_mat]
"""Matrix coefficients by power."""


def total(terms: Iterable[flint.arb]) -> flint.arb:
    """Return the sum of balls."""
    return sum(terms, flint.arb(0))


def largest(terms: Iterable[flint.arb]) -> flint.arb:
    """Return an upper bound of the largest of some nonnegative balls."""
    worst = flint.arb(0)
    for x in terms:
        worst = worst.max(x)
    return worst.upper()


def identity(n: int) -> flint.arb_mat:
    """Return the unit matrix."""
    return flint.arb_mat([[1 if i == j else 0 for j in range(n)] for i in range(n)])


def abs_times(m: flint.arb_mat, radii: BallVector) -> BallVector:
    """Return an upper bound of abs(m) radii."""
    return [
        total(abs(m[i, j]) * radii[j] for j in range(m.ncols())).upper() for i in range(m.nrows())
    ]


def norm(m: flint.arb_mat, weights: BallVector) -> flint.arb:
    """Return the matrix norm induced by the weighted maximum norm max abs(x_i) / w_i."""
    return largest(x / w for x, w in zip(abs_times(m, weights), weights, strict=True))


def weighted(x: BallVector, weights: BallVector) -> flint.arb:
    """Return the weighted maximum norm of a vector of bounds."""
    return largest(abs(a) / w for a, w in zip(x, weights, strict=True))


def perron(coefficients: Polynomial) -> BallVector:
    """Return positive weights that make the norms small: nearly the Perron vector of sum abs(m).

    Any positive weights give valid bounds; these give small ones.
    """
    n = coefficients[0].nrows()
    size = np.zeros((n, n))
    for m in coefficients:
        size += np.abs(middle(m))
    w = np.ones(n)
    for _ in range(30):
        w = w + size @ w
        w /= w.max()
    return [flint.arb(float(x)) for x in np.maximum(w, 1e-4)]


def solution(
    a: Polynomial, start: flint.arb_mat, g: Polynomial = ()
) -> tuple[list[flint.arb_mat], flint.arb_mat]:
    """Return a polynomial X that nearly solves X' = A X + G, X(0) = start, in exact coefficients.

    Also return an enclosure, for -1 <= s <= 1, of the terms of A X + G - X' of orders below that of
    A.
    """
    x, left_over = [start], 0 * start
    with_sign = flint.arb(0, 1)
    for m in range(len(a) - 1):
        right = a[0] * x[m]
        for j in range(1, m + 1):
            right += a[j] * x[m - j]
        if g:
            right += g[m]
        x.append((right * (flint.arb(1) / (m + 1))).mid())
        left_over += (right - x[-1] * (m + 1)) * with_sign
    return x, left_over


def fundamental(
    a: Polynomial, tail: flint.arb_mat, weights: BallVector
) -> tuple[list[flint.arb_mat], flint.arb, list[flint.arb_mat], flint.arb]:
    """Return polynomials near the solutions of Y' = A Y and V' = -V A, both the identity at s = 0.

    For each also return a bound on the norm of Y' - (A + tail) Y or V' + V (A + tail), -1 <= s <=
    1.
    """
    y, left_over = solution(a, identity(a[0].nrows()))
    turned_v, turned_left_over = solution([-m.transpose() for m in a], identity(a[0].nrows()))
    v = [m.transpose() for m in turned_v]
    sizes_a = [norm(m, weights) for m in a]
    rest = norm(tail, weights)

    def defect(p: Polynomial, of_low_orders: flint.arb_mat) -> flint.arb:
        sizes = [norm(m, weights) for m in p]
        # Bound on the terms of the products from order len(a) - 1 on. Y' and V' have no terms of
        # these orders, so here the products are the whole defect.
        beyond = total(x * total(sizes[len(a) - 1 - j :]) for j, x in enumerate(sizes_a))
        return (norm(of_low_orders, weights) + beyond + rest * total(sizes)).upper()

    return y, defect(y, left_over), v, defect(v, turned_left_over.transpose())


def value(p: Polynomial, s: flint.arb) -> flint.arb_mat:
    """Evaluate the polynomial at s by Horner's rule."""
    result = p[-1]
    for m in reversed(p[:-1]):
        result = result * s + m
    return result


def supremum(
    p: Polynomial, spans: int = 8, *, low: flint.arb | int = 0, high: flint.arb | int = 1
) -> flint.arb_mat:
    """Return an upper bound of abs(p(s)), entry by entry, on low <= s <= high."""
    rows, columns = p[0].nrows(), p[0].ncols()
    half = (flint.arb(high) - low) / (2 * spans)
    times = [flint.arb(low + (2 * j + 1) * half, half.upper()) for j in range(spans)]

    def entry(i: int, j: int) -> flint.arb:
        polynomial = flint.arb_poly([m[i, j] for m in p])
        return largest(abs(polynomial(s)).upper() for s in times)

    return flint.arb_mat([[entry(i, j) for j in range(columns)] for i in range(rows)])


def turned(
    end: flint.arb_mat, radii: BallVector, added: BallVector
) -> tuple[flint.arb_mat, BallVector]:
    """Return a frame and radii that contain ``end box(radii) + box(added)`` (Lohner's QR method).

    The frame is the orthogonal factor of the columns sorted by length. It is computed in floats,
    which then count as exact. Any invertible matrix would be valid.
    """
    n = end.nrows()
    scale = largest(radii)
    frame = identity(n)
    if scale > 0:
        share = np.array([float((x / scale).mid()) for x in radii])
        columns = middle(end) * share
        columns = columns[:, np.argsort(-np.linalg.norm(columns, axis=0))]
        if np.isfinite(columns).all():
            frame = flint.arb_mat([[float(x) for x in row] for row in np.linalg.qr(columns)[0]])
    inverse = frame.inv()
    moved = abs_times(inverse * end, radii)
    return frame, [(x + y).upper() for x, y in zip(moved, abs_times(inverse, added), strict=True)]


def middle(m: flint.arb_mat) -> np.ndarray:
    """Return the midpoints as floats."""
    return np.array([[float(m[i, j].mid()) for j in range(m.ncols())] for i in range(m.nrows())])
