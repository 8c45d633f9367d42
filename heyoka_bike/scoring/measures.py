"""Measures of error: pure functions of plain arrays.

The task: a program's column f(t_i) at its own times, the exact column r(t_i), and their difference
e_i = f(t_i) - r(t_i), in SI units. Nothing is interpolated, and no row weighs more than another.

- ``max``, ``rms`` and ``relative`` are in the column's unit, or divided by its *scale*, the largest
  abs(r) over the whole run of the reference (not only where the file has rows, so that a short file
  is judged by the same scale as a long one).
- ``scd`` and ``mescd`` are named after the Test Set for Initial Value Problem Solvers (Mazzia and
  Magherini, Bari, release 2.4, 2008; formerly CWI), where they are taken over the components at the
  end of the interval. Here they are taken over the rows of one column, the whole run.
- ``performance`` is eq. (1) of the IFToMM benchmark "Uncontrolled bicycle".

Perfect agreement gives errors of 0 and 32 digits, all that hi + lo can tell.
"""

from math import isfinite, sqrt

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.column_score import Growth, Measures
from heyoka_bike.scoring.verdict import MOST_DIGITS as MOST_DIGITS
from heyoka_bike.scoring.verdict import TOLERANCE as TOLERANCE
from heyoka_bike.scoring.verdict import digits as digits

ROUNDING = 1e-11
"""Of the scale: what binary64 arithmetic may leave of a run. 1e-16 in each of a million operations
that add up is 1e-13 to 1e-10; correct programs were seen to stop at 4e-14 to 2e-12."""

_PARTS = 10


def measures(t: Array, error: Array, reference: Array, scale: float) -> Measures:
    """All measures of a column.

    Parameters
    ----------
    t, error, reference : ndarray, shape (n,)
        Times [s], e and r; finite.
    scale
        Largest absolute value of the reference over its run.
    """
    if not len(error):
        return Measures(None, None, None, None, None, None, None)
    worst = int(np.argmax(np.abs(error)))
    largest = float(np.abs(error[worst]))
    relative = largest / scale if scale else None
    if largest == 0.0:
        relative = 0.0  # of a column that vanishes, too
    return Measures(
        max_abs_error=largest,
        time_of_max=float(t[worst]),
        rms_error=rms(error),
        max_rel_error=relative if relative is None or isfinite(relative) else None,
        scd=digits(relative),
        mescd=digits(float(np.max(np.abs(error) / (1.0 + np.abs(reference))))),
        time_to_tolerance=time_to_tolerance(t, error, scale),
    )


def rms(error: Array) -> float:
    """Root of the mean square, without overflow."""
    largest = float(np.maximum.reduce(np.abs(error)))
    if largest == 0.0:
        return 0.0
    # NumPy's mean, without what surrounds it: definitions are told by hundreds of these.
    return largest * sqrt(float(np.add.reduce(np.square(error / largest))) / len(error))


def time_to_tolerance(t: Array, error: Array, scale: float) -> float | None:
    """First time at which abs(e) exceeds 1e-3 of the scale [s]; None if it never does."""
    above = np.abs(error) > TOLERANCE * scale
    return float(t[np.argmax(above)]) if above.any() else None


def growth(t: Array, error: Array, duration: float) -> tuple[Growth, ...]:
    """Largest abs(e) in each tenth of the run; the end belongs to the last."""
    ends = np.linspace(0.0, duration, _PARTS + 1)
    part = np.clip(np.searchsorted(ends, t, side="right") - 1, 0, _PARTS - 1)
    found = []
    for i in range(_PARTS):
        inside = np.abs(error[part == i])
        largest = float(inside.max()) if len(inside) else None
        found.append(Growth(float(ends[i]), float(ends[i + 1]), largest))
    return tuple(found)


def performance(energy: Array, rest: Array | None = None) -> float | None:
    """Eq. (1) of the benchmark: 100 (max E - min E) / E0 [%], E0 the first value.

    Parameters
    ----------
    energy, rest : ndarray, shape (n,)
        hi + lo: what is far below the last digit of binary64 counts where it was written.

    Notes
    -----
    It sees the energy only: a program can pass it with a motion that is wrong by a third, and fail
    it with output of few digits. None of fewer than two values, or with E0 = 0.

    References
    ----------
    IFToMM Technical Committee for Multibody Dynamics, Library of Computational Benchmark
    Problems, problem "Uncontrolled bicycle".
    """
    if len(energy) < 2 or energy[0] == 0.0:
        return None
    change = energy - energy[0]
    if rest is not None:
        # Neighbouring numbers: their difference is exact where the rest counts.
        change = change + (rest - rest[0])
    found = 100.0 * float(np.ptp(change)) / abs(float(energy[0]))
    return found if isfinite(found) else None
