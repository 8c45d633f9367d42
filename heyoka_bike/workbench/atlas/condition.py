"""Condition number: how much a motion magnifies a small error of its initial state.

The derivative of the motion by its start obeys a linear equation, whose coefficients are known at
the samples. Magnus' method of fourth order takes steps over two samples each: what multiplies the
derivative is the exponential of a mean of the coefficients, so that fast decay does no harm.
"""

import numpy as np

from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.parameters import START
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.atlas.runs import LATERAL, PITCH, ROLL, SPACING, SPIN, STEER, Runs
from heyoka_bike.workbench.atlas.tops import largest
from heyoka_bike.workbench.fast.vector_code import STATE

SECONDS = 10
"""The time over which the magnification is taken [s]."""

EARLY = 2
"""Samples in place of one within these seconds: magnification comes in bursts."""

_STEP = 2 * SPACING / EARLY
_TERMS = 12  # of the exponential series
_SHIFT = 1e-5  # the pitch is even about straight running: its slope is good to 1e-10
_AROUND = 2  # samples either side of the largest


def conditions(runs: Runs, samples: Array, which: Array) -> Array:
    """The largest spectral norm of the derivative by the start, up to the end of the samples.

    Of roll, steer, their rates [rad, rad/s] and speed [m/s] by their initial values, at every other
    sample; good to a few parts in a hundred at the worst, where it comes in bursts.

    Parameters
    ----------
    runs : Runs
    samples : ndarray, shape (motions, odd number of samples, 6)
        NaN after the end of a motion.
    which : ndarray, shape (motions,)
        Their bicycles.

    Returns
    -------
    ndarray, shape (motions,)
    """
    slopes = runs.slopes(samples, which)
    length = runs.equations(which).k.length * np.ones(len(samples))
    flow = _start(runs, samples[:, 0], which, length)
    found = [_seen(flow, length)]
    for i in range(0, samples.shape[1] - 2, 2):
        flow = _step(flow, *(slopes[:, i + j] for j in range(3)))
        found.append(_seen(flow, length))
    return _largest_norm(np.stack(found, axis=1))


def _step(flow: Array, begin: Array, middle: Array, end: Array) -> Array:
    mean = _STEP / 6 * (begin + 4 * middle + end)
    tilt = _STEP / 12 * (end - begin)
    exponent = mean + tilt @ mean - mean @ tilt
    found = flow
    for i in range(_TERMS, 0, -1):
        found = flow + exponent @ found / i
    return found


def _start(runs: Runs, states: Array, which: Array, length: Array) -> Array:
    """The state by the start in the order of `START`, shape (motions, 6, 5)."""
    found = np.zeros((len(states), STATE, len(START)))
    for column, row in enumerate(LATERAL):
        found[:, row, column] = 1.0
    found[:, SPIN, -1] = 1 / length
    k = runs.equations(which).k
    roll, pitch, steer = states[:, ROLL], states[:, PITCH], states[:, STEER]
    for column, (a, b) in enumerate(((_SHIFT, 0.0), (0.0, _SHIFT))):
        ahead = pitch_on_the_floor(k, roll + a, pitch, steer + b)
        found[:, PITCH, column] = (ahead - pitch_on_the_floor(k, roll - a, pitch, steer - b)) / (
            2 * _SHIFT
        )
    return found


def _seen(flow: Array, length: Array) -> Array:
    """Rows in the order of `START`, shape (motions, 5, 5)."""
    found: Array = flow[:, (*LATERAL, SPIN)].copy()
    found[:, -1] *= length[:, None]
    return found


def _largest_norm(matrices: Array) -> Array:
    """Over the times of each motion, shape (motions, times, 5, 5); those with NaN do not count.

    The spectral norm is at most Frobenius', and nearly so where one direction grows before others:
    it is found around the largest of these, and a parabola laid through what is found.
    """
    sizes = np.square(matrices).sum(axis=(2, 3))
    sizes[~np.isfinite(sizes)] = 0.0
    around = np.argmax(sizes, axis=1)[:, None] + np.arange(-_AROUND, _AROUND + 1)
    around = np.clip(around, 0, sizes.shape[1] - 1)
    chosen = np.take_along_axis(matrices, around[:, :, None, None], axis=1)
    chosen[~np.isfinite(chosen).all(axis=(2, 3))] = 0.0
    return largest(np.linalg.norm(chosen, ord=2, axis=(2, 3)))
