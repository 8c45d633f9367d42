"""Values whose simulated motions are those of a file: Gauss and Newton's method on whole runs.

The values are those of a few parameters and forces, which the equations of motion gave along the
file's own motion, or the starts of the maneuvers, of which a file's equations say nothing. What is
minimised is the sum of the logarithms of what is left in the columns of each maneuver.
"""

from collections.abc import Callable, Sequence

import numpy as np

from heyoka_bike.numbers.double import Array

Errors = Callable[[Sequence[Array]], list[Array]]
"""From several sets of values to what each leaves, shape (blocks, rows), in the blocks' scales."""

_STEPS = 4
# Of a value's size, for derivatives by differences.
_SHIFT = 1e-6
# Blocks are told from zero down to here; a step that is smaller changes nothing.
_SMALL = 1e-12


def shoot(errors: Errors, x: Array, sizes: Array) -> tuple[Array, Array, Array]:
    """Values that leave least, what they leave, and its derivatives, shape (blocks, rows, n)."""
    best: tuple[Array, Array, Array] | None = None
    for _ in range(_STEPS):
        here, *moved = errors(
            [x, *(x + _SHIFT * s * e for s, e in zip(sizes, np.eye(len(x)), strict=True))]
        )
        if best is not None and size_of(here) > size_of(best[1]):
            break
        slopes = np.stack(
            [(m - here) / (_SHIFT * s) for m, s in zip(moved, sizes, strict=True)], -1
        )
        best = x, here, slopes
        weights = 1.0 / (np.sqrt(np.mean(here**2, axis=1)) + _SMALL)
        matrix = (slopes * sizes * weights[:, None, None]).reshape(-1, len(x))
        step = np.linalg.lstsq(matrix, -(here * weights[:, None]).ravel(), rcond=None)[0]
        if np.all(np.abs(step) < _SMALL):
            break
        x = x + step * sizes
    assert best is not None
    return best


def size_of(left: Array) -> float:
    """Geometric mean over the blocks of the root mean square that is left."""
    return float(np.exp(np.mean(np.log(np.mean(left**2, axis=1) + _SMALL**2)) / 2))


def uncertain(left: Array, slopes: Array) -> Array:
    """Changes that would leave twice as much, whatever the others are."""
    squares = np.mean(left**2, axis=1) + _SMALL**2
    rows = slopes.shape[1]
    products = np.einsum("bri,brj,b->ij", slopes, slopes, 1.0 / squares) / (rows * len(left))
    size = np.sqrt(np.maximum(np.diagonal(products), np.finfo(np.float64).tiny))
    inverse = np.linalg.pinv(products / np.outer(size, size), hermitian=True)
    found: Array = np.sqrt(3.0 * np.diagonal(inverse)) / size
    return found
