"""Many motions of one bicycle to one time: as many at once as the processor's vectors hold.

Each motion has its own steps; those stepped together end together, and the ones that are done wait.
Motions of about the same speed take about as many steps, so that they are put together.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pickle import dumps, loads
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import Constants
from heyoka_bike.bicycle.equations.initial import few_product_state, pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, read_bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.motion.fast.accuracies import choose
from heyoka_bike.motion.fast.taylor_code import CLOCK, NORM, PLANS, STATE, Form, taylor_code
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.system.resources import benchmark_bicycle

START = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""What a start is given by [rad, rad/s, m/s], each in its default definition."""

_BITS = 256
_CHUNK = 2048  # motions evaluated at once
_MOST_STEPS = 100_000


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
        heyoka is not installed.
    """

    def __init__(
        self, *, bicycle: Bicycle | None = None, accuracy: str | float = 1e-6,
        threads: int = 1,
    ) -> None:  # fmt: skip
        if threads < 1:
            raise InputError(f"found {threads} threads, expected 1 or more")
        bicycle = bicycle or read_bicycle(benchmark_bicycle())
        self._plan = PLANS[choose(accuracy, PLANS)]
        self._lanes = require_heyoka().recommended_simd_size()
        self._code = taylor_code(bicycle, Form(self._plan.order, self._lanes))
        # An integrator has a state of its own: each thread needs one.
        copy = dumps(self._code.integrator)
        self._integrators = [self._code.integrator, *(loads(copy) for _ in range(threads - 1))]
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
        filled = np.concatenate([order, np.full(-count % self._lanes, order[-1])])
        packed = np.ascontiguousarray(states[:, filled])
        groups = range(0, packed.shape[1], self._lanes)
        threads = len(self._integrators)
        # Every so many groups to each thread: slow ones lie side by side.
        shares = [groups[i::threads] for i in range(threads)]

        def work(ta: Any, share: Sequence[int]) -> None:
            for begin in share:
                self._advance(ta, packed[:, begin : begin + self._lanes], duration)

        if threads == 1:
            work(self._integrators[0], shares[0])
        else:
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(work, self._integrators, shares))
        found = np.empty((count, len(BENCHMARK_COLUMNS)))
        found[order] = self._columns(packed[:, :count]).T
        return found

    def _advance(self, ta: Any, states: Array, duration: float) -> None:
        """Motions of one vector to their end, in place."""
        _put(ta, states, self._plan.norm)
        ta.propagate_until(duration, max_steps=_MOST_STEPS)
        done = require_heyoka().taylor_outcome.time_limit
        if all(result[0] == done for result in ta.propagate_res):
            states[:] = ta.state[:STATE]
            return
        # One that stops stops the others: each is followed alone.
        for lane in range(states.shape[1]):
            _put(ta, states[:, lane : lane + 1], self._plan.norm)
            ta.propagate_until(duration, max_steps=_MOST_STEPS)
            is_done = ta.propagate_res[0][0] == done
            states[:, lane] = ta.state[:STATE, 0] if is_done else np.nan

    def _columns(self, states: Array) -> Array:
        """The columns, by the polynomials of which only the constant terms are there."""
        width = self._plan.order + 1
        parts = []
        for begin in range(0, states.shape[1], _CHUNK):
            part = states[:, begin : begin + _CHUNK]
            table = np.zeros((STATE * width + 1, part.shape[1]))
            table[: STATE * width : width] = part
            parts.append(self._code.columns(table)[:-1])
        return np.concatenate(parts, axis=1)


def _put(ta: Any, states: Array, norm: float) -> None:
    ta.set_time(0.0)
    ta.state[:STATE] = states
    ta.state[CLOCK] = 0.0
    ta.state[NORM] = norm


def _states(k: Constants, starts: Array) -> Array:
    """States of the few-product form, shape (6, motions)."""
    if starts.ndim != 2 or starts.shape[1] != len(START) or not len(starts):
        raise InputError(f"found starts of shape {starts.shape}, expected (motions, {len(START)})")
    roll, steer, roll_rate, steer_rate, speed = starts.T
    spin = speed / k.length
    pitch = pitch_on_the_floor(k, roll, np.zeros(len(starts)), steer)
    regular = (roll, pitch, steer, roll_rate, steer_rate, spin, np.zeros(len(starts)))
    return np.array(few_product_state(k, Arrays(), regular)[:STATE])
