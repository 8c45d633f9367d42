"""Fit of the residual of the equations by a torque that is a function of one variable.

Regularised friction, a stiffening spring, play, a stop: each is a torque on the steer axis, or one
that leans the bicycle, and depends on one angle or one rate. No list of such laws is needed. The
function is odd, because left and right are alike. It is piecewise linear, and its values at some
places are found by least squares. Twenty values explain much by chance, so the values found in one
half of the run must also explain the other half.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.residual.linear_fits import blocks, solve

# Ratio of neighbouring values of the variable at which a law is fitted, and number of these values.
# The smallest value is a small fraction of the largest, because regularised friction varies mostly
# near zero.
_RATIO, _PLACES = 2**0.5, 20
# Number of successive averages in a stretch of a run. A law is fitted to every other stretch and
# tested with the rest. It has two averages, because each shares half of its rows with the next one.
_STRETCH = 2


@dataclass(frozen=True, slots=True)
class Law:
    """A torque that is an odd function of one variable.

    Attributes
    ----------
    equation
        ``roll`` or ``steer``: the torque acts along the speed of this equation.
    variable
        The variable on which the torque depends, one of `forces.PLACE_IN_STATE`.
    places : tuple of float
        Values of the variable, ascending [rad or rad/s].
    values : tuple of float
        Torques at these places [N m].
    relief
        Factor by which the residual falls, a geometric mean, in the half of the run to which the
        values were not fitted.
    """

    equation: str
    variable: str
    places: tuple[float, ...]
    values: tuple[float, ...]
    relief: float


def hats(x: Array, places: Array) -> Array:
    """Evaluate odd functions that are 1 at one place and 0 at the others: (len(places), n)."""
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
    """Find the law that explains most of the residual; None if no variable changes.

    Parameters
    ----------
    variables : mapping of str to ndarray, shape (n,)
        Possible variables of a law, at the rows.
    added : mapping of str to ndarray, shape (q, n)
        Accelerations that a torque of 1 N m along the speed of each equation adds.
    averages : callable
        Function from accelerations, shape (q, n), to blocks of averages, shape (w,) each.
    left : sequence of ndarray, shape (w,)
        Residual of each block.
    floors : ndarray, shape (blocks,)
        Resolution limit of each block.
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
    """Fit values to every other stretch; return the factor by which they reduce the rest."""
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
