"""A torque that is left of the equations, as a function of one variable.

Friction however it is regularised, a spring that stiffens, play, a stop: each is a torque on the
steer axis, or one that leans the bicycle, that depends on one angle or one rate. No list of such
laws is needed: a function that is odd, as left and right are alike, is found by its values at some
places, on lines between them, by least squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.residual.linear_fits import blocks, solve

VARIABLES = {"roll angle": 0, "steer angle": 2, "roll rate": 3, "steer rate": 4}
"""Places in the state of what a law may depend on."""
EQUATIONS = ("roll", "steer")
"""Along whose speeds the torque acts, in order."""

# Places of a law, each so many times the one before it, down to a small part of the largest: where
# friction is regularised it changes within a small part of its range.
_RATIO, _PLACES = 2**0.5, 20


@dataclass(frozen=True, slots=True)
class Law:
    """A torque that is an odd function of one variable.

    Attributes
    ----------
    equation
        One of `EQUATIONS`.
    variable
        One of `VARIABLES`.
    places : tuple of float
        Where its values are known, ascending [rad or rad/s].
    values : tuple of float
        [N m]
    relief
        Factor by which what remains falls with it, a geometric mean.
    """

    equation: str
    variable: str
    places: tuple[float, ...]
    values: tuple[float, ...]
    relief: float


def hats(x: Array, places: Array) -> Array:
    """Odd functions that are one at a place and zero at the others, shape (len(places), n)."""
    size = np.abs(x)
    knots = np.concatenate([[0.0], places])
    found = [np.interp(size, knots, np.eye(len(knots))[k]) for k in range(1, len(knots))]
    odd: Array = np.sign(x) * np.array(found)
    return odd


def best_law(
    variables: Sequence[Array],
    added: Sequence[Array],
    left: Sequence[Array],
    averaged: Sequence[tuple[int, slice, Array]],
    floors: Array,
) -> Law | None:
    """The law that explains most; None if no variable changes.

    Parameters
    ----------
    variables : sequence of ndarray, shape (n,)
        Those of `VARIABLES`, at the rows.
    added : sequence of ndarray, shape (q, n)
        Of each of `EQUATIONS`, the accelerations that a torque of one adds.
    left : sequence of ndarray, shape (w,)
        Of each block what remains of an acceleration, averaged and weighted.
    averaged : sequence of (index, slice, ndarray of shape (w, rows))
        Of each block its acceleration, its rows, and the weighted averages of these.
    floors : ndarray, shape (blocks,)
    """
    found: Law | None = None
    for variable, x in zip(VARIABLES, variables, strict=True):
        largest = float(np.max(np.abs(x), initial=0.0))
        if not largest:
            continue
        places = largest * _RATIO ** np.arange(1.0 - _PLACES, 1.0)
        basis = hats(x, places)
        for equation, accelerations in zip(EQUATIONS, added, strict=True):
            terms = [
                (accelerations[i, rows] * basis[:, rows]) @ average.T
                for i, rows, average in averaged
            ]
            b = blocks(left, [t.T for t in terms], floors)
            used = np.flatnonzero(np.any(np.diagonal(b.products, axis1=1, axis2=2) > 0, axis=0))
            if not len(used):
                continue
            changes, gains = solve(b, used[None])
            if found is None or gains[0] > found.relief:
                found = Law(
                    equation,
                    variable,
                    tuple(places[used].tolist()),
                    tuple(changes[0].tolist()),
                    float(gains[0]),
                )
    return found
