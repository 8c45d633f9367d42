"""Elementary differentials: all that the leading error of a one-step method can consist of.

The error of a Runge-Kutta method of order p in one step is a sum, with coefficients of the method,
of the elementary differentials of order p + 1, one for each rooted tree of so many nodes; those of
linear multistep methods are among their sums (E. Hairer, S. P. Norsett, G. Wanner, *Solving
Ordinary Differential Equations I*, 2nd ed., Springer 1993, sections II.2 and III.2). A partitioned
method, such as the symplectic Euler method, treats positions and velocities differently: then each
node of the tree is one of the two (section II.15).
"""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import combinations_with_replacement, product
from math import prod

import numpy as np

from heyoka_bike.numbers.double import Array

Tree = tuple[int, tuple["Tree", ...]]
"""Colour of the root, and what hangs from it."""

# Of central differences of k-th order in binary64: error (step^2 + 1e-16 / step^k).
_STEP = {1: 1e-5, 2: 1e-4, 3: 1e-3, 4: 3e-3}


def differentials(
    slope: Callable[[Array], Array], y: Array, order: int, parts: Sequence[Sequence[int]] = ()
) -> list[Array]:
    """Elementary differentials of an order.

    Parameters
    ----------
    slope
        The right-hand side, from states of shape (n, ...) to rates.
    y : ndarray, shape (n, ...)
        States.
    order
        Nodes of the trees, 1 to 5.
    parts
        Indices of the variables that a partitioned method treats alike; all of them by default.

    Returns
    -------
    list of ndarray, shape (n, ...)
        Without those that vanish.
    """
    parts = parts or (range(len(y)),)
    known: dict[tuple[Tree, ...], Array] = {}

    def of(tree: Tree) -> Array:
        colour, branches = tree
        if branches not in known:
            known[branches] = _derivative(slope, y, [of(b) for b in branches])
        found = np.zeros_like(y)
        found[list(parts[colour])] = known[branches][list(parts[colour])]
        return found

    found = [of(tree) for tree in _trees(order, len(parts))]
    return [x for x in found if np.any(np.abs(x) > _STEP[1] * np.max(np.abs(y)))]


def _derivative(slope: Callable[[Array], Array], y: Array, along: Sequence[Array]) -> Array:
    """f^(k) applied to k directions, by central differences in all of them."""
    if not along:
        return slope(y)
    k = len(along)
    # Directions vary along the motion and by powers of ten; steps are of one size.
    steps = [_STEP[k] / (np.max(np.abs(v), axis=0) + _STEP[k]) for v in along]
    total = np.zeros_like(y)
    for signs in product((1, -1), repeat=k):
        shift = sum(s * h * v for s, h, v in zip(signs, steps, along, strict=True))
        total += prod(signs) * slope(y + shift)
    found: Array = total / (2**k * prod(steps))
    return found


@lru_cache
def _trees(nodes: int, colours: int) -> tuple[Tree, ...]:
    """Rooted trees with coloured nodes."""
    return tuple(
        (colour, branches) for branches in _forests(nodes - 1, colours) for colour in range(colours)
    )


def _forests(nodes: int, colours: int) -> Iterator[tuple[Tree, ...]]:
    """Multisets of trees with so many nodes together."""
    for sizes in _partitions(nodes, nodes):
        groups = [
            combinations_with_replacement(_trees(size, colours), sizes.count(size))
            for size in sorted(set(sizes))
        ]
        for chosen in product(*groups):
            yield tuple(tree for group in chosen for tree in group)


def _partitions(total: int, largest: int) -> Iterator[tuple[int, ...]]:
    if total == 0:
        yield ()
    for first in range(min(total, largest), 0, -1):
        for rest in _partitions(total - first, first):
            yield (first, *rest)
