"""Vectors and matrices of balls: norms, products of absolute values, and moving frames."""

from collections.abc import Iterable, Sequence

import flint
import numpy as np

Vector = list[flint.arb]
Polynomial = Sequence[flint.arb_mat]
"""Matrix coefficients by power."""


def total(terms: Iterable[flint.arb]) -> flint.arb:
    """Sum of balls."""
    return sum(terms, flint.arb(0))


def largest(terms: Iterable[flint.arb]) -> flint.arb:
    """Upper bound of nonnegative balls."""
    worst = flint.arb(0)
    for x in terms:
        worst = worst.max(x)
    return worst.upper()


def identity(n: int) -> flint.arb_mat:
    """Unit matrix."""
    return flint.arb_mat([[1 if i == j else 0 for j in range(n)] for i in range(n)])


def abs_times(m: flint.arb_mat, radii: Vector) -> Vector:
    """Upper bound of abs(m) radii."""
    return [
        total(abs(m[i, j]) * radii[j] for j in range(m.ncols())).upper() for i in range(m.nrows())
    ]


def norm(m: flint.arb_mat, weights: Vector) -> flint.arb:
    """Matrix norm that goes with the weighted maximum norm max abs(x_i) / w_i."""
    return largest(x / w for x, w in zip(abs_times(m, weights), weights, strict=True))


def weighted(x: Vector, weights: Vector) -> flint.arb:
    """Weighted maximum norm of a vector of bounds."""
    return largest(abs(a) / w for a, w in zip(x, weights, strict=True))


def perron(coefficients: Polynomial) -> Vector:
    """Positive weights that make the norms small: nearly the Perron vector of sum abs(m).

    Any positive weights are valid; these are only good.
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


def fundamental(a: Polynomial) -> list[flint.arb_mat]:
    """Coefficients of a polynomial that nearly solves Y' = A(s) Y, Y(0) = 1; exact numbers."""
    y = [identity(a[0].nrows())]
    for m in range(len(a) - 1):
        y.append((_coefficient(a, y, m) * (flint.arb(1) / (m + 1))).mid())
    return y


def inverse_fundamental(a: Polynomial) -> list[flint.arb_mat]:
    """Coefficients of V that nearly solves V' = -V A(s), V(0) = 1: nearly the inverse of Y."""
    v = [identity(a[0].nrows())]
    for m in range(len(a) - 1):
        v.append((_coefficient(v, a, m) * (flint.arb(-1) / (m + 1))).mid())
    return v


def _coefficient(p: Polynomial, q: Polynomial, m: int) -> flint.arb_mat:
    """Coefficient m of a product."""
    product = p[0] * q[m]
    for j in range(1, m + 1):
        product += p[j] * q[m - j]
    return product


def variational_defect(
    a: Polynomial, tail: flint.arb_mat, y: Polynomial, v: Polynomial, weights: Vector
) -> tuple[flint.arb, flint.arb]:
    """Norms of Y' - (A + tail) Y and V' + V (A + tail) on 0 <= s <= 1, by the coefficients."""
    length = len(y)
    defect_y, defect_v = flint.arb(0), flint.arb(0)
    for m in range(length - 1):
        defect_y += norm(y[m + 1] * (m + 1) - _coefficient(a, y, m), weights)
        defect_v += norm(v[m + 1] * (m + 1) + _coefficient(v, a, m), weights)
    sizes_a, sizes_y, sizes_v = ([norm(x, weights) for x in p] for p in (a, y, v))
    # Terms of the products of order length - 1 and more, which Y' and V' do not have.
    for j, x in enumerate(sizes_a):
        defect_y += x * total(sizes_y[length - 1 - j :])
        defect_v += x * total(sizes_v[length - 1 - j :])
    rest = norm(tail, weights)
    return (
        (defect_y + rest * total(sizes_y)).upper(),
        (defect_v + rest * total(sizes_v)).upper(),
    )


def value(p: Polynomial, s: flint.arb) -> flint.arb_mat:
    """The polynomial at s, by Horner's rule."""
    result = p[-1]
    for m in reversed(p[:-1]):
        result = result * s + m
    return result


def supremum(
    p: Polynomial, spans: int = 8, *, low: flint.arb | int = 0, high: flint.arb | int = 1
) -> flint.arb_mat:
    """Upper bound of abs(p(s)), entry by entry, on low <= s <= high (0 <= s <= 1)."""
    rows, columns = p[0].nrows(), p[0].ncols()
    half = (flint.arb(high) - low) / (2 * spans)
    times = [flint.arb(low + (2 * j + 1) * half, half.upper()) for j in range(spans)]

    def entry(i: int, j: int) -> flint.arb:
        polynomial = flint.arb_poly([m[i, j] for m in p])
        return largest(abs(polynomial(s)).upper() for s in times)

    return flint.arb_mat([[entry(i, j) for j in range(columns)] for i in range(rows)])


def turned(end: flint.arb_mat, radii: Vector, added: Vector) -> tuple[flint.arb_mat, Vector]:
    """A frame and radii that hold ``end box(radii) + box(added)`` (Lohner's QR method).

    The frame is the orthogonal factor of the columns in order of length, as floats made exact; any
    invertible matrix would be valid.
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
    """Midpoints as floats."""
    return np.array([[float(m[i, j].mid()) for j in range(m.ncols())] for i in range(m.nrows())])
