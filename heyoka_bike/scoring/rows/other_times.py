"""Compare columns with the reference at times other than those written."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP, Array
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# Largest change of the time scale that is fitted, and largest shift relative to the length of the
# run. A larger change or shift is found when the file is read, or looks like a different motion.
_LARGEST = 0.2
# Number of times in the run, evenly spaced, at which the motion is compared with each row. The
# fastest motion of the benchmark decays in a twentieth of a second, which is five of these times.
_TIMES_TRIED = 1001


class AtOtherTimes:
    """Some columns and rows of a maneuver, compared with the reference at any times."""

    def __init__(
        self, m: ManeuverScore, columns: Sequence[ColumnScore], rows: slice = slice(None)
    ) -> None:
        self.columns = columns
        self.time = m.part.time[rows]
        self.end = float(m.part.reference.duration)
        self._reference = m.part.reference
        self._names = [
            next(d.name for d in self._reference.definitions[c.key] if d.definition == c.definition)
            for c in self.columns
        ]
        self._values = np.array([c.trace.value[rows] / c.scale for c in self.columns])

    def off(self, meant: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the errors in scales at the times `meant`, and True for rows within the run."""
        rows = (meant >= 0.0) & (meant <= self.end)
        return self._values - self._exact(np.clip(meant, 0.0, self.end)), rows

    def _exact(self, times: Array) -> Array:
        """Return the exact columns at times within the run, in scales."""
        right = self._reference.approximate(times, self._names)
        each = [right[n] / c.scale for n, c in zip(self._names, self.columns, strict=True)]
        return np.array(each)

    def nearest(self) -> Array:
        """Return for each row the time at which the exact columns are nearest to it [s].

        The best of many times of the run is improved by Newton's method.
        """
        every = np.linspace(0.0, self.end, _TIMES_TRIED)
        there = self._exact(every)
        squares = np.sum(there**2, axis=0)
        best = [
            np.argmin(squares[:, None] - 2.0 * there.T @ rows, axis=0)
            for rows in np.array_split(self._values, -(-len(self.time) // _TIMES_TRIED), axis=1)
        ]
        meant: Array = every[np.concatenate(best)]
        for _ in range(ROUNDS_OF_NEWTON):
            off, _ = self.off(meant)
            slope = (self.off(meant + SMALL_STEP)[0] - off) / SMALL_STEP
            # At rest any time is as near as any other, and the slope is zero. Do not divide by it.
            size = np.maximum(np.sum(slope**2, axis=0), np.finfo(np.float64).tiny)
            step = -np.sum(slope * off, axis=0) / size
            meant = np.clip(meant + np.clip(step, -every[1], every[1]), 0.0, self.end)
        return meant

    def left(self, meant: Array) -> Array:
        """Return the RMS error of each column at given times; NaN without a row within the run."""
        errors, rows = self.off(meant)
        return np.array([rms(x[rows]) for x in errors])


def meant_by(time: Array, clock: Array) -> Array:
    """Convert times by a clock: ``time * (1 + clock[0]) + clock[1]`` [s]."""
    return time * (1.0 + float(clock[0])) + float(clock[1])


def fitted_clock(every: Sequence[AtOtherTimes], of: Sequence[int]) -> Array | None:
    """Fit a clock, the scale minus one and the shift [s], by Newton's method.

    Parameters
    ----------
    every
        Columns of one or several maneuvers, which share the clock.
    of
        Indices of the unknowns to fit: 0 for the scale, 1 for the shift. The other one stays 0.

    Returns
    -------
    ndarray, shape (2,), or None
        The clock for `meant_by`; None if it exceeds `_LARGEST` or an error is not finite.
    """
    clock = np.zeros(2)
    end = max(wrong.end for wrong in every)
    for _ in range(ROUNDS_OF_NEWTON):
        errors, slopes = [], []
        for wrong in every:
            here, rows = wrong.off(meant_by(wrong.time, clock))
            errors.append(here[:, rows].ravel())
            each = []
            for i in of:
                there = clock.copy()
                there[i] += SMALL_STEP
                moved = wrong.off(meant_by(wrong.time, there))[0]
                each.append(((moved - here) / SMALL_STEP)[:, rows].ravel())
            slopes.append(np.array(each))
        matrix, goal = np.concatenate(slopes, axis=1).T, -np.concatenate(errors)
        if not (np.isfinite(matrix).all() and np.isfinite(goal).all()):
            return None
        clock[list(of)] += np.linalg.lstsq(matrix, goal, rcond=None)[0]
        if max(abs(clock[0]), abs(clock[1]) / end) > _LARGEST:
            return None
    return clock
