"""Linear and nonlinear least squares for errors whose blocks have unknown sizes.

The errors of a column or an equation in a maneuver are a *block*. To first order they are J x for
changes x of the unknowns. The fit minimises the sum of the logarithms of the remaining errors of
the blocks, which maximises the likelihood if their sizes are unknown. This is done by repeated
least squares, with each block weighted by the inverse of its remaining mean square. A thousand
subsets are solved at once from the blocks' normal equations. If the error is not linear in the
unknowns, the Gauss-Newton method repeats this at the changed values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Self

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import SMALL_STEP, Array

# Number of repetitions of the weighted least squares. Each reduces the error of the weights; more
# repetitions would have no visible effect.
_REPETITIONS = 12
# Smallest remaining error that is visible, relative to the norm of its block. The roundoff of the
# normal equations determines this value.
_VISIBLE = 1e-7
# A subset of unknowns explains nothing if its terms are larger than the error by this factor and
# cancel each other.
_CANCEL = 5.0
# Damping (Levenberg), relative to the diagonal, of an unknown that the other unknowns nearly
# determine.
_DAMPING = 1e-12
# Maximum number of steps, maximum number of halvings of a step, and the expected gain of a step
# below which the fit ends. A fit that finds an inertia of zero in place of the largest inertia
# takes six steps, and halves the first of them twice.
_STEPS, _HALVINGS_OF_STEP, _PROMISED = 6, 5, 1.01

Errors = Callable[[Sequence[Array]], Sequence[Sequence[Array]]]
"""Function from several sets of values to the blocks of the error that each set leaves."""


@dataclass(frozen=True, eq=False, slots=True)
class Blocks:
    """Normal equations of B blocks with U unknowns.

    Attributes
    ----------
    squares : ndarray, shape (B,)
        Mean square of the error.
    moments : ndarray, shape (B, U)
        Mean of J times the error.
    products : ndarray, shape (B, U, U)
        Mean of J times J.
    floors : ndarray, shape (B,)
        Square of the resolution limit.
    """

    squares: Array
    moments: Array
    products: Array
    floors: Array

    @property
    def left(self) -> float:
        """Geometric mean of the root mean squares of the blocks."""
        return float(np.exp(np.mean(np.log(self.squares + self.floors)) / 2))

    def every(self, nth: int) -> Self:
        """Return only the first block and every nth after it."""
        each = (self.squares, self.moments, self.products, self.floors)
        return type(self)(*(x[::nth] for x in each))


def left(errors: Sequence[Array], floors: Array) -> float:
    """Return the geometric mean of the root mean squares of blocks."""
    return blocks(errors, [e[:, None] for e in errors], floors).left


@dataclass(frozen=True, eq=False, slots=True)
class Subsets:
    """Fits of K subsets with m unknowns each.

    Attributes
    ----------
    members : ndarray of int, shape (K, m)
        Indices of the unknowns.
    changes : ndarray, shape (K, m)
        Fitted changes of the unknowns.
    gains : ndarray, shape (K,)
        Geometric mean over the blocks of the factor by which the root mean square falls.
    """

    members: NDArray[np.intp]
    changes: Array
    gains: Array


def blocks(
    errors: Sequence[Array], jacobians: Sequence[Array], floors: Sequence[float] | Array
) -> Blocks:
    """Compute normal equations from errors, shape (n,), and Jacobians, shape (n, U), by block."""
    return Blocks(
        squares=np.array([np.mean(e**2) for e in errors]),
        moments=np.array([j.T @ e / len(e) for e, j in zip(errors, jacobians, strict=True)]),
        products=np.array([j.T @ j / len(j) for j in jacobians]),
        floors=np.array(floors) ** 2,
    )


def best_subsets(
    b: Blocks, size: int, count: int, beside: NDArray[np.intp] | None = None
) -> Subsets:
    """Find the `count` best subsets of `size` unknowns by their gains.

    If `beside` is given, subsets of three or more unknowns are limited to these smaller subsets
    with one more unknown.
    """
    used = np.flatnonzero(np.any(np.diagonal(b.products, axis1=1, axis2=2) > 0, axis=0))
    if beside is None or size < 3:
        every = set(combinations(used.tolist(), size))
    else:
        every = {
            tuple(sorted((*some, one)))
            for some in beside.tolist()
            for one in used.tolist()
            if one not in some
        }
    members = np.array(sorted(every), dtype=np.intp).reshape(-1, size)
    changes, gains = solve(b, members)
    terms = np.sqrt(np.diagonal(b.products, axis1=1, axis2=2))[:, members] * np.abs(changes)
    there = np.sqrt(b.squares + b.floors)[:, None]
    with np.errstate(divide="ignore"):
        times = np.exp(np.mean(np.log(np.max(terms, axis=2) / there), axis=0))
    gains = np.where((size > 1) & (times > _CANCEL), 0.0, gains)
    order = np.argsort(-gains, kind="stable")[:count]
    return Subsets(members[order], changes[order], gains[order])


def solve(b: Blocks, members: NDArray[np.intp]) -> tuple[Array, Array]:
    """Fit the unknowns of each subset; return changes, shape (K, m), and gains, shape (K,)."""
    rows = members[:, :, None]
    products = np.moveaxis(b.products[:, rows, members[:, None, :]], 0, 1)  # shape (K, B, m, m)
    moments = np.moveaxis(b.moments[:, members], 0, 1)  # shape (K, B, m)
    before = b.squares + b.floors
    least = b.floors + _VISIBLE**2 * b.squares
    left = np.broadcast_to(before, (len(members), len(before)))
    changes = np.zeros(members.shape)
    for _ in range(_REPETITIONS):
        weights = 1.0 / left
        matrix = np.einsum("kb,kbij->kij", weights, products)
        vector = np.einsum("kb,kbi->ki", weights, moments)
        changes = _solved(matrix, vector)
        explained = np.einsum("kbi,ki->kb", moments, changes)
        quadratic = np.einsum("kbij,ki,kj->kb", products, changes, changes)
        left = np.maximum(b.squares - 2 * explained + quadratic, 0.0) + least
    gains = np.exp(np.mean(np.log(before / left), axis=1) / 2)
    return changes, gains


def best_multiple(b: Blocks) -> tuple[float, float]:
    """Find the value of a single unknown with the least remaining error; return it and its gain.

    Only the best multiple of each block is tried: the sum of logarithms has its many local minima
    near these.
    """
    products, moments = b.products[:, 0, 0], b.moments[:, 0]
    there = products > np.finfo(np.float64).tiny
    tried = moments[there] / products[there]
    if not len(tried):
        return 0.0, 1.0
    before, least = b.squares + b.floors, b.floors + _VISIBLE**2 * b.squares
    with np.errstate(all="ignore"):
        left = b.squares - 2 * np.outer(tried, moments) + np.outer(tried**2, products)
        gains = np.exp(np.mean(np.log(before / (np.maximum(left, 0.0) + least)), axis=1) / 2)
    best = int(np.argmax(np.nan_to_num(gains, nan=0.0, posinf=0.0)))
    return float(tried[best]), float(gains[best])


def _solved(matrix: Array, vector: Array) -> Array:
    """Solve the normal equations, with the unknowns scaled to the same size."""
    size = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), np.finfo(np.float64).tiny))
    scaled = matrix / size[:, :, None] / size[:, None, :]
    scaled += _DAMPING * np.eye(matrix.shape[1])
    found: Array = np.linalg.solve(scaled, (vector / size)[:, :, None])[:, :, 0] / size
    return found


def uncertain(b: Blocks) -> list[float]:
    """Return the change of each unknown that doubles the error even if the others are refitted."""
    left = b.squares + b.floors
    weighted = np.einsum("b,bij->ij", 1.0 / left, b.products) / len(left)
    size = np.sqrt(np.maximum(np.diagonal(weighted), np.finfo(np.float64).tiny))
    inverse = np.linalg.pinv(weighted / np.outer(size, size), hermitian=True)
    found: list[float] = (np.sqrt(3.0 * np.diagonal(inverse)) / size).tolist()
    return found


def linearised(errors: Errors, x: Array, sizes: Array, floors: Array) -> Blocks:
    """Compute the normal equations at some values by finite differences."""
    shifts = SMALL_STEP * sizes
    here, *moved = errors([x, *(x + np.diag(shifts))])
    slopes = [
        np.nan_to_num((block[:, None] - np.stack(others, axis=-1)) / shifts)
        for block, *others in zip(here, *moved, strict=True)
    ]
    return blocks(here, slopes, floors)


def gauss_newton(errors: Errors, x: Array, sizes: Array, floors: Array) -> tuple[Array, Blocks]:
    """Find values near `x` with the least remaining error; return also the normal equations there.

    A step that increases the error is halved. This happens with a light body, whose accelerations
    change their sign where its inertia is zero.
    """
    b = linearised(errors, x, sizes, floors)
    for _ in range(_STEPS):
        steps, gains = solve(b, np.arange(len(x))[None])
        if gains[0] < _PROMISED:
            break
        for half in range(_HALVINGS_OF_STEP):
            ahead = x + steps[0] / 2.0**half
            if left(errors([ahead])[0], floors) < b.left:
                break
        else:
            break
        x, b = ahead, linearised(errors, ahead, sizes, floors)
    return x, b
