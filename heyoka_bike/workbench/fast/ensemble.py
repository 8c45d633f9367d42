"""Integrate many motions of one bicycle to the same time; a vector contains eight of them.

The method is Dormand, Prince and Hairer's of order 8 with its two estimates of the error, of orders
5 and 3, as in dop853.f of E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential
Equations I, 2nd edition, Springer 1993. A vector holds eight motions, so one step of a motion costs
twelve eighths of an evaluation of the equations. Each motion has its own step sizes. The motions of
a vector end together: those that are finished wait. Motions of similar speed take similar numbers
of steps, so they share a vector.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import Constants
from heyoka_bike.bicycle.equations.initial import few_product_state, pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, benchmark
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.fast import vector_code as v
from heyoka_bike.workbench.fast.model_code import ENERGY, call_rates, columns_and_trail, rates_code
from heyoka_bike.workbench.fast.simulate import choose
from heyoka_bike.workbench.fast.vector_code import (
    ADDRESS,
    COUNT,
    LANES,
    MOST_STEPS,
    NUMBER,
    STATE_SIZE,
    function,
)

StageWeights = Mapping[int, float]


def _weights(row: Sequence[float]) -> StageWeights:
    return {stage: weight for stage, weight in enumerate(row) if weight}


_TABLE = tomllib.loads(Path(__file__).with_name("dop853.toml").read_text(encoding="utf-8"))
STAGES: tuple[StageWeights, ...] = tuple(map(_weights, _TABLE["stages"]))
"""For each stage, the weights of the slopes of earlier stages in its state."""
STEP, THIRD, FIFTH = (_weights(_TABLE[name]) for name in ("step", "third", "fifth"))

ENDS = "ends"
"""Name of the LLVM function, see `ends_source`."""

_LAST_STAGE = len(STAGES)  # index of the evaluation at the end of a step
# Safety factor, and smallest and largest factor by which the step control changes a step.
_SAFETY, _LEAST_CHANGE_OF_STEP, _MOST_CHANGE_OF_STEP = 0.9, 1 / 3, 6.0
_SHORTEST_STEP = 2.0**-30  # [s]
_FIRST_STEP = 0.1  # [s], first step divided by the root of the tolerance
# The result of a motion is kept if its relative energy drift is at most the larger of two limits:
# this multiple of the tolerance, and this roundoff. Each limit is ten times the usual drift. A step
# over a singularity causes a larger drift.
_LARGEST_STATE, _ROUNDING = 100.0, 1e-11
_NAN = float("nan")


def ends_source(equations: Equations) -> str:
    """Return the LLVM module with the function ``ends``, which integrates motions to their end.

    ``void ends(states, stride, begin, end, duration, tolerance, most, columns)`` integrates the
    motions ``begin`` to ``end``, in whole vectors. ``states`` and ``columns`` contain ``stride``
    motions, one variable after the other. A motion that cannot be continued, or takes more than
    ``most`` steps, is NaN. The constants of `equations` are in binary64.
    """
    c = v.Code(f"void @{ENDS}(ptr, i64, i64, i64, double, double, i64, ptr)")
    states, stride, begin, end, duration, tolerance, most, columns = c.arguments
    y, after, stage, lost = (c.memory() for _ in range(4))
    k = [c.memory() for _ in range(_LAST_STAGE + 1)]
    over, until = (1.0 / tolerance).spread(), duration.spread()
    first = (v.eighth_root(tolerance) * _FIRST_STEP).spread()
    group = c.variable(begin)
    with v.Loop(c) as groups:
        groups.leave(group[0] >= end)
        places = [stride * i + group[0] for i in range(len(BENCHMARK_COLUMNS))]
        y.store(states.vectors(x)[0] for x in places[: v.STATE_SIZE])
        lost.store([0.0] * v.STATE_SIZE)
        call_rates(y, k[0])
        energy = columns_and_trail(equations, y.load())[ENERGY]
        t, wish, steps = c.variable(c.vector([0.0] * v.LANES)), c.variable(first), c.variable(0)
        with v.Loop(c) as run:
            run.leave((t[0].over_places("fmin") >= duration) | (steps[0] >= most))
            now, is_ended = t[0], t[0] >= until
            # Round the new time first, so that the step is exactly the difference of two times. The
            # step is zero for motions that have reached their end.
            to = (wish[0] >= until - now).choose(until, now + wish[0])
            h = to - now
            for number, row in enumerate(STAGES, start=1):
                stage.store(v.fused(h, _slopes(k, row), y.load()))
                call_rates(stage, k[number])
            before, x = y.load(), v.fused(h, _slopes(k, STEP), lost.load())
            after.store(before + x)
            # Compensated summation: the next step adds the rounding error of this step.
            rests = x - (after.load() - before)
            fifth, third = (_square(_slopes(k, row) * over) for row in (FIFTH, THIRD))
            both = v.fused(third, 0.01, fifth).at_least(1e-300)
            error = h * fifth * v.STATE_SIZE**-0.5 / both.sqrt()
            is_good = error <= 1.0
            change = (
                (_SAFETY / v.eighth_root(error))
                .at_most(_MOST_CHANGE_OF_STEP)
                .at_least(_LEAST_CHANGE_OF_STEP)
            )
            # If the error is NaN, shorten the step as much as the step control allows.
            scaled = h * (error <= error).choose(change, _LEAST_CHANGE_OF_STEP)
            call_rates(after, k[_LAST_STAGE])
            is_lost = ~is_good & (scaled < _SHORTEST_STEP) & ~is_ended
            new = v.choose(is_good, after.load(), before)
            y.store(v.choose(is_lost, _NAN, new))
            lost.store(v.choose(is_good, rests, lost.load()))
            k[0].store(v.choose(is_good, k[_LAST_STAGE].load(), k[0].load()))
            t[0] = is_lost.choose(until, is_good.choose(to, now))
            # Keep a nonzero step for motions that have ended.
            wish[0] = is_ended.choose(first, scaled)
            steps[0] += 1
        *found, _ = columns_and_trail(equations, v.choose(t[0] >= until, y.load(), _NAN))
        # If the energy has changed, the motion has stepped over a singularity. Its result is NaN.
        allowed = energy * (tolerance * _LARGEST_STATE).at_least(_ROUNDING)
        is_kept = abs(found[ENERGY] - energy) <= allowed
        for place, value in zip(places, v.choose(is_kept, found, _NAN), strict=True):
            columns.vectors(place)[0] = value
        group[0] += v.LANES
    c.do("ret void")
    return v.module(rates_code(equations), c)


def _slopes(k: Sequence[v.Memory], row: StageWeights) -> Any:
    """Return the sum of slopes with the weights of a row of the method, for each variable."""
    return v.weighted([k[stage].load() for stage in row], list(row.values()))


def _square(errors: v.Registers) -> Any:
    """Return the squared length of a vector of errors."""
    first, *rest = errors
    return reduce(lambda found, x: v.fused(x, x, found), rest, first * first)


START = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
"""Variables of the initial conditions [rad, rad/s, m/s], each in its default definition."""

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
"""Step tolerance for each accuracy of `simulate`, measured at 10 s on the 20 starts used there. Of
4000 other starts, one in a hundred is less accurate, by up to a factor of five."""

_ARGUMENTS_OF_ENSEMBLE = None, ADDRESS, COUNT, COUNT, COUNT, NUMBER, NUMBER, COUNT, ADDRESS
# Number of motions in each job of a thread. It is small, so that the slow motions are distributed
# over the threads.
_MOTIONS_OF_A_PART = 16 * LANES


class Ensemble:
    """A compiled integrator for many motions of one bicycle.

    Parameters
    ----------
    bicycle, accuracy
        See `simulate`.
    threads
        Number of threads that integrate at the same time.

    Raises
    ------
    InputError
        An argument cannot be used.
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
        source = ends_source(Equations.binary64(bicycle, is_regular=False))
        self._ends = function(source, ENDS, *_ARGUMENTS_OF_ENSEMBLE)
        self._constants = Equations.binary64(bicycle).k

    def ends(self, starts: Array, duration: float) -> Array:
        """Return the benchmark's columns at the end of each motion.

        Parameters
        ----------
        starts : ndarray, shape (motions, 5)
            Initial conditions in the order of `START`; the pitch follows from them.
        duration
            Duration of the motions [s].

        Returns
        -------
        ndarray, shape (motions, 8)
            SI units; NaN for a motion that meets a singularity, or zero trail.
        """
        states = _states(self._constants, np.asarray(starts, dtype=float))
        order = np.argsort(states[STATE_SIZE - 1])
        count = len(order)
        # Fill up the last vector of motions with copies of its first motion.
        filled = np.concatenate([order, np.full(-count % LANES, order[-1])])
        packed = np.ascontiguousarray(states[:, filled])
        columns = np.empty((len(BENCHMARK_COLUMNS), len(filled)))
        parts = [
            range(len(filled))[i : i + _MOTIONS_OF_A_PART]
            for i in range(0, len(filled), _MOTIONS_OF_A_PART)
        ]

        def work(part: range) -> None:
            self._ends(
                packed.ctypes.data, len(filled), part.start, part.stop, duration, self._tolerance,
                MOST_STEPS, columns.ctypes.data,
            )  # fmt: skip

        if self._threads == 1:
            work(range(len(filled)))
        else:
            with ThreadPoolExecutor(self._threads) as pool:
                list(pool.map(work, parts))
        found = np.empty((count, len(BENCHMARK_COLUMNS)))
        found[order] = columns[:, :count].T
        return found


def _states(k: Constants, starts: Array) -> Array:
    """Return initial states in the variables of `few_products`, shape (6, motions)."""
    if starts.ndim != 2 or starts.shape[1] != len(START) or not len(starts):
        raise InputError(f"found starts of shape {starts.shape}, expected (motions, {len(START)})")
    roll, steer, roll_rate, steer_rate, speed = starts.T
    spin = speed / k.length
    pitch = pitch_on_the_floor(k, roll, np.zeros(len(starts)), steer)
    regular = (roll, pitch, steer, roll_rate, steer_rate, spin, np.zeros(len(starts)))
    return np.array(few_product_state(k, Arrays(), regular)[:STATE_SIZE])
