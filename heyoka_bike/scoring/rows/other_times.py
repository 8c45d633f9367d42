"""Compare columns with the reference at times other than those written."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP, Array
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.ratios import BY_FAR, FEW_COLUMNS
from heyoka_bike.scoring.rows.table import is_right_column, own_name, whole_columns
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
        self._names = [own_name(m, c) for c in self.columns]
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

    def nearest_of(self, times: Array) -> Array:
        """Return for each row the one of given times at which the exact columns are nearest [s].

        Only times at which one column takes the value next to that of the row are compared. A time
        that is right in all columns is among them, unless other times are as right by chance.
        """
        there = self._exact(times)
        near = []
        for exact, values in zip(there, self._values, strict=True):
            order = np.argsort(exact)
            after = np.searchsorted(exact, values, sorter=order)
            near += [order[np.maximum(after - 1, 0)], order[np.minimum(after, len(times) - 1)]]
        off = [np.max(np.abs(there[:, x] - self._values), axis=0) for x in near]
        found: Array = times[np.choose(np.argmin(off, axis=0), near)]
        return found

    def chance(self, times: Array, limit: Array) -> Array:
        """Return for each row the probability that any value is right at one of given times.

        Parameters
        ----------
        times
        limit
            Largest error of each column that counts as right, in scales.
        """
        found = np.ones(len(self.time))
        for exact, values, most in zip(self._exact(times), self._values, limit, strict=True):
            steps = np.r_[-np.inf, np.sort(exact), np.inf]
            after = np.searchsorted(steps, values)
            found = np.minimum(found, 2.0 * most / (steps[after] - steps[after - 1]))
        return found

    def left(self, meant: Array) -> Array:
        """Return the RMS error of each column at given times; NaN without a row within the run."""
        errors, rows = self.off(meant)
        return np.array([rms(x[rows]) for x in errors])


class WrongColumns(AtOtherTimes):
    """The wrong benchmark columns of a maneuver; none if it has too few rows."""

    def __init__(self, m: ManeuverScore) -> None:
        whole = whole_columns(m) if m.rows >= MIN_ROWS_FOR_SHAPE else []
        wrong = [c for c in whole if c.key in BENCHMARK_COLUMNS and not is_right_column(c)]
        super().__init__(m, wrong)

    @cached_property
    def before(self) -> Array:
        """RMS error of each column at the written times, in scales."""
        return self.left(self.time)

    @cached_property
    def floors(self) -> Array:
        """Largest error of each column that its digits hide, in scales."""
        return np.array([c.hidden / c.scale for c in self.columns])

    @property
    def count(self) -> int:
        """Number of columns that can be independent.

        Energies count as one column: if their sum is constant, each part determines the other.
        """
        energies = sum(c.key.endswith("_energy") for c in self.columns)
        return len(self.columns) - max(energies - 1, 0)

    @property
    def are_few(self) -> bool:
        """True if the columns are so few that any fit looks too good."""
        return self.count <= FEW_COLUMNS

    def are_right(self, left: Array, fitted: int = 0) -> bool:
        """True if times that leave these RMS errors, in scales, are the correct times.

        Every error must be below `TOLERANCE`, and fall by the factor `BY_FAR` or become negligible:
        fall to the digits written, or to the square of `BY_FAR` below the largest error.

        Parameters
        ----------
        left
        fitted
            Number of values fitted to few columns. Each of them must reduce an error by `BY_FAR`.
            All errors must become negligible, because a rate that is a difference of two rows
            resembles the rate half a row away.
        """
        negligible = np.maximum(self.floors, np.max(self.before, initial=0.0) / BY_FAR**2)
        falls = left <= negligible
        if not fitted:
            falls |= left * BY_FAR < self.before
        # At least one error must fall by far. It proves nothing if all errors fall only a little,
        # to the level of the written digits.
        is_shown = bool(np.any(left * BY_FAR ** max(fitted, 1) < self.before))
        return is_shown and bool(np.all(falls) and np.max(left, initial=0.0) < TOLERANCE)


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
