"""A torque that is left of the equations, as a function of one variable.

Friction however it is regularised, a spring that stiffens, play, a stop: each is a torque on the
steer axis, or one that leans the bicycle, that depends on one angle or one rate. No list of such
laws is needed: a function that is odd, as left and right are alike, is found by its values at some
places, on lines between them, by least squares. Twenty values explain much by chance: so what is
found in one half of the run has to explain the other.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.residual.linear_fits import blocks, solve

# Places of a law, each so many times the one before it, down to a small part of the largest: where
# friction is regularised it changes within a small part of its range.
_RATIO, _PLACES = 2**0.5, 20
# Averages in a stretch of a run; each has half of its rows in common with the next.
_STRETCH = 2


@dataclass(frozen=True, slots=True)
class Law:
    """A torque that is an odd function of one variable.

    Attributes
    ----------
    equation
        ``roll`` or ``steer``: along whose speed it acts.
    variable
        One of `forces.PLACE_IN_STATE`.
    places : tuple of float
        Where its values are known, ascending [rad or rad/s].
    values : tuple of float
        [N m]
    relief
        Factor by which what remains falls, a geometric mean, in the half of the run in which its
        values were not looked for.
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
    variables: Mapping[str, Array],
    added: Mapping[str, Array],
    averages: Callable[[Array], Sequence[Array]],
    left: Sequence[Array],
    floors: Array,
) -> Law | None:
    """The law that explains most; None if no variable changes.

    Parameters
    ----------
    variables : mapping of str to ndarray, shape (n,)
        What a law may depend on, at the rows.
    added : mapping of str to ndarray, shape (q, n)
        The accelerations that a torque of one adds along the speed of each equation.
    averages : callable
        From accelerations, shape (q, n), to the blocks of their averages, shape (w,) each.
    left : sequence of ndarray, shape (w,)
        Of each block what remains.
    floors : ndarray, shape (blocks,)
    """
    found: Law | None = None
    most = 0.0
    for variable, x in variables.items():
        largest = float(np.max(np.abs(x), initial=0.0))
        if not largest:
            continue
        places = largest * _RATIO ** np.arange(1.0 - _PLACES, 1.0)
        basis = hats(x, places)
        for equation, accelerations in added.items():
            each = [averages(accelerations * hat) for hat in basis]
            terms = [np.stack(block, axis=-1) for block in zip(*each, strict=True)]
            b = blocks(left, terms, floors)
            used = np.flatnonzero(np.any(np.diagonal(b.products, axis1=1, axis2=2) > 0, axis=0))
            if not len(used):
                continue
            changes, gains = solve(b, used[None])
            if gains[0] > most:
                most = float(gains[0])
                found = Law(
                    equation,
                    variable,
                    tuple(places[used].tolist()),
                    tuple(changes[0].tolist()),
                    _relief_elsewhere(left, [t[:, used] for t in terms], floors),
                )
    return found


def _relief_elsewhere(left: Sequence[Array], terms: Sequence[Array], floors: Array) -> float:
    """What values that are found in every other stretch of a run explain in the others."""
    here = [np.arange(len(x)) % (2 * _STRETCH) < _STRETCH for x in left]
    if not all(h.any() and not h.all() for h in here):
        return 1.0
    known = blocks(
        [x[h] for x, h in zip(left, here, strict=True)],
        [t[h] for t, h in zip(terms, here, strict=True)],
        floors,
    )
    changes, _ = solve(known, np.arange(terms[0].shape[1])[None])
    falls = []
    for x, t, h, floor in zip(left, terms, here, floors, strict=True):
        before, after = x[~h], x[~h] - t[~h] @ changes[0]
        falls.append(np.log((np.mean(before**2) + floor**2) / (np.mean(after**2) + floor**2)) / 2)
    return float(np.exp(np.mean(falls)))
