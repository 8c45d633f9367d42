"""Least squares of an error whose blocks have unknown sizes: linear in its unknowns, and not.

The errors of a column or an equation in a maneuver are a *block*. They are, to first order, J x
for changes x of the unknowns. What is minimised is the sum of the logarithms of what is
left in the blocks, the likelihood if the size of the rest is unknown in each: least squares, with
each block weighted by the inverse of what it has left, repeated. A thousand subsets are solved at
once from the blocks' normal equations. Where the error is not linear in the unknowns, Gauss and
Newton's method repeats this at the changed values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Self

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import SMALL_STEP, Array

# Each repetition divides what is wrong with the weights; more changes nothing that is seen.
_REPETITIONS = 12
# The normal equations are solved in binary64: below this part of a block nothing is left to see.
_VISIBLE = 1e-7
# Terms that are so many times what is there, and cancel, explain nothing.
_CANCEL = 5.0
# Of a direction that is all but fixed by the others, this part of its size is added: Levenberg.
_DAMPING = 1e-12
# An inertia of zero in the place of the largest is found in six steps, the first of which is halved
# twice. A step that promises less than this factor is not taken.
_STEPS, _HALVINGS_OF_STEP, _PROMISED = 6, 5, 1.01

Errors = Callable[[Sequence[Array]], Sequence[Sequence[Array]]]
"""From several sets of values to the blocks of the error that each set leaves."""


@dataclass(frozen=True, eq=False, slots=True)
class Blocks:
    """Normal equations of each block.

    Attributes
    ----------
    squares : ndarray, shape (B,)
        Mean square of the error.
    moments : ndarray, shape (B, U)
        Mean of J times the error.
    products : ndarray, shape (B, U, U)
        Mean of J times J.
    floors : ndarray, shape (B,)
        Mean square of what cannot be seen.
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
    """Geometric mean of the root mean squares of blocks."""
    return blocks(errors, [e[:, None] for e in errors], floors).left


@dataclass(frozen=True, eq=False, slots=True)
class Subsets:
    """Fits of some subsets of the unknowns.

    Attributes
    ----------
    members : ndarray of int, shape (K, m)
        Indices of the unknowns.
    changes : ndarray, shape (K, m)
    gains : ndarray, shape (K,)
        Geometric mean over the blocks of the factor by which the root mean square falls.
    """

    members: NDArray[np.intp]
    changes: Array
    gains: Array


def blocks(
    errors: Sequence[Array], jacobians: Sequence[Array], floors: Sequence[float] | Array
) -> Blocks:
    """Normal equations from errors, shape (n,), and Jacobians, shape (n, U), of each block."""
    return Blocks(
        squares=np.array([np.mean(e**2) for e in errors]),
        moments=np.array([j.T @ e / len(e) for e, j in zip(errors, jacobians, strict=True)]),
        products=np.array([j.T @ j / len(j) for j in jacobians]),
        floors=np.array(floors) ** 2,
    )


def best_subsets(
    b: Blocks, size: int, count: int, beside: NDArray[np.intp] | None = None
) -> Subsets:
    """The best subsets of so many unknowns, by their gains.

    Of three or more only those with one unknown `beside` these smaller subsets, if given.
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
    """Changes of the unknowns of each subset, shape (K, m), and the gains, shape (K,)."""
    rows = members[:, :, None]
    products = np.moveaxis(b.products[:, rows, members[:, None, :]], 0, 1)  # K, B, m, m
    moments = np.moveaxis(b.moments[:, members], 0, 1)  # K, B, m
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
    """The multiple of one unknown that leaves least, and by how much it lets the error fall.

    That of a block: the sum of logarithms has its least values near those, and many of them.
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
    """Solutions of the normal equations, the unknowns scaled to the same size."""
    size = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), np.finfo(np.float64).tiny))
    scaled = matrix / size[:, :, None] / size[:, None, :]
    scaled += _DAMPING * np.eye(matrix.shape[1])
    found: Array = np.linalg.solve(scaled, (vector / size)[:, :, None])[:, :, 0] / size
    return found


def uncertain(b: Blocks) -> list[float]:
    """Changes of the unknowns that would leave twice as much, whatever the others are."""
    left = b.squares + b.floors
    weighted = np.einsum("b,bij->ij", 1.0 / left, b.products) / len(left)
    size = np.sqrt(np.maximum(np.diagonal(weighted), np.finfo(np.float64).tiny))
    inverse = np.linalg.pinv(weighted / np.outer(size, size), hermitian=True)
    found: list[float] = (np.sqrt(3.0 * np.diagonal(inverse)) / size).tolist()
    return found


def linearised(errors: Errors, x: Array, sizes: Array, floors: Array) -> Blocks:
    """Normal equations of an error at some values, by differences over a part of their sizes."""
    shifts = SMALL_STEP * sizes
    here, *moved = errors([x, *(x + np.diag(shifts))])
    slopes = [
        np.nan_to_num((block[:, None] - np.stack(others, axis=-1)) / shifts)
        for block, *others in zip(here, *moved, strict=True)
    ]
    return blocks(here, slopes, floors)


def gauss_newton(errors: Errors, x: Array, sizes: Array, floors: Array) -> tuple[Array, Blocks]:
    """Values near `x` that leave least, and the normal equations there.

    A step that leaves more is halved: a light body has accelerations that turn over where its
    inertia is zero.
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
