"""Many motions of one bicycle to one time: as many at once as a vector holds.

Each motion has its own steps; those stepped together end together, and the ones that are done wait.
Motions of about the same speed take about as many steps, so that they are put together.
"""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import Constants
from heyoka_bike.bicycle.equations.initial import few_product_state, pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, benchmark
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.fast.native import EnsembleCode
from heyoka_bike.workbench.fast.simulate import choose
from heyoka_bike.workbench.fast.vector_code import POINTS, STATE

START = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""Variables that give initial conditions [rad, rad/s, m/s], each in its default definition."""

TOLERANCES: Mapping[str | float, float] = {
    "eq1": 2e-6,
    1e-4: 1e-6,
    1e-6: 3e-8,
    1e-8: 3e-10,
    1e-10: 3e-12,
    1e-12: 2e-14,
    1e-13: 3e-15,
    "roundoff": 3e-15,
}
"""For each accuracy of `simulate` the tolerance of a step that keeps it at the ends of 10 s,
of 20 starts as there; of 4000 one in a hundred is worse, by up to a factor of five."""

# Work is handed out in parts of so many vectors, so that no thread is left with the slow motions.
_PART = 16 * POINTS


class Ensemble:
    """Compiled code for many motions of one bicycle.

    Parameters
    ----------
    bicycle, accuracy
        As for `simulate`.
    threads
        How many work at the same time.

    Raises
    ------
    InputError
        Something given cannot be used.
    MissingPackageError
        llvmlite is not installed.
    """

    def __init__(
        self, *, bicycle: Bicycle | None = None, accuracy: str | float = 1e-6,
        threads: int = 1,
    ) -> None:  # fmt: skip
        if threads < 1:
            raise InputError(f"found {threads} threads, expected 1 or more")
        bicycle = bicycle or benchmark()[0]
        self._tolerance = TOLERANCES[choose(accuracy, TOLERANCES)]
        self._threads = threads
        self._code = EnsembleCode(bicycle)
        self._constants = Equations.binary64(bicycle).k

    def ends(self, starts: Array, duration: float) -> Array:
        """The benchmark's columns of each motion at its end.

        Parameters
        ----------
        starts : ndarray, shape (motions, 5)
            In the order of `START`; the pitch follows from them.
        duration
            [s]

        Returns
        -------
        ndarray, shape (motions, 8)
            SI units; NaN for a motion that meets a singularity, or zero trail.
        """
        states = _states(self._constants, np.asarray(starts, dtype=float))
        order = np.argsort(states[STATE - 1])
        count = len(order)
        # Whole vectors: the last one is filled up with its first motion.
        filled = np.concatenate([order, np.full(-count % POINTS, order[-1])])
        packed = np.ascontiguousarray(states[:, filled])
        columns = np.empty((len(BENCHMARK_COLUMNS), len(filled)))
        parts = [range(len(filled))[i : i + _PART] for i in range(0, len(filled), _PART)]
        work = partial(
            self._code.ends, packed, columns, duration=duration, tolerance=self._tolerance
        )
        if self._threads == 1:
            work(range(len(filled)))
        else:
            with ThreadPoolExecutor(self._threads) as pool:
                list(pool.map(work, parts))
        found = np.empty((count, len(BENCHMARK_COLUMNS)))
        found[order] = columns[:, :count].T
        return found


def _states(k: Constants, starts: Array) -> Array:
    """States of the few-product form, shape (6, motions)."""
    if starts.ndim != 2 or starts.shape[1] != len(START) or not len(starts):
        raise InputError(f"found starts of shape {starts.shape}, expected (motions, {len(START)})")
    roll, steer, roll_rate, steer_rate, speed = starts.T
    spin = speed / k.length
    pitch = pitch_on_the_floor(k, roll, np.zeros(len(starts)), steer)
    regular = (roll, pitch, steer, roll_rate, steer_rate, spin, np.zeros(len(starts)))
    return np.array(few_product_state(k, Arrays(), regular)[:STATE])
