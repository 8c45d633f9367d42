"""Trajectories of any bicycle without heyoka: NumPy makes the steps of many motions at once.

Each variable of the state, and each constant of the equations, is an array with an entry for each
motion. Steps are those of Dormand, Prince and Hairer's method of order 8 and as long for all
motions; between them a polynomial has the states and rates of six of them.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.motion.dormand_prince import FIFTH, STAGES, STEP, Row
from heyoka_bike.numbers.arithmetic import Arrays, Multiprecision
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.programs.simulator import (
    DIGITS,
    KEPT,
    Ready,
    Simulator,
    any_bicycle,
    outputs,
)

# The castering mode decays at up to 25 1/s; the benchmark's columns are good to 3e-12 of the scale.
_LONGEST = 0.01  # [s]
# Error of a step, as estimated, over the size of the state: a singularity is met.
_LOST = 1e-6
# Nodes of the polynomial: before and after, with that on either side of the time.
_NODES = 6


class Stepping(Simulator):
    """Takes the place of a `Simulator`: seconds for a motion, and little more for hundreds.

    Equations without some of their terms, or with other forces, give no motion: NaN.
    """

    lanes = 300
    is_quick = False

    def __init__(self) -> None:
        self._arithmetic = Multiprecision(DIGITS)
        self._any = any_bicycle(self._arithmetic)
        self._constants = lru_cache(KEPT)(self._compute_constants)

    def _states(self, ready: Sequence[Ready], altered: tuple[str, ...]) -> list[Array]:
        if altered:
            return [np.full((len(r.grid), len(r.state)), np.nan) for r in ready]
        equations = self._with(np.array([r.constants for r in ready]).T)
        end = max(r.grid[-1] for r in ready)
        steps = max(_NODES, int(np.ceil(end / _LONGEST)))
        start = np.array([r.state for r in ready]).T
        states, slopes = _stepped(equations, start, end / steps, steps)
        return [
            _between(states[..., i], slopes[..., i], r.grid, end / steps)
            for i, r in enumerate(ready)
        ]

    def _evaluated(self, ready: Ready, states: Array) -> Array:
        with np.errstate(all="ignore"):
            return np.array(outputs(self._with(ready.constants), list(states.T)))

    def _with(self, constants: Array) -> Equations:
        """Equations with these constants, each a number or an array."""
        left = iter(constants)
        return self._any.convert(lambda _: next(left), Arrays())


def _stepped(equations: Equations, y: Array, h: float, count: int) -> tuple[Array, Array]:
    """States and slopes after each step, shape (steps + 1, variables, motions)."""
    states, slopes = (np.full((count + 1, *y.shape), np.nan) for _ in range(2))
    with np.errstate(all="ignore"):
        for n in range(count + 1):
            k = [np.array(equations.rates_with_yaw(list(y)))]
            states[n], slopes[n] = y, k[0]
            for row in STAGES:
                k.append(np.array(equations.rates_with_yaw(list(y + h * _sum(row, k)))))
            error = h * np.max(np.abs(_sum(FIFTH, k)) / (1.0 + np.abs(y)), axis=0)
            # NaN from there on.
            y = np.where(error < _LOST, y + h * _sum(STEP, k), np.nan)
    return states, slopes


def _sum(row: Row, k: Sequence[Array]) -> Array:
    found: Array = sum((x * k[i] for i, x in row.items()), start=np.zeros_like(k[0]))
    return found


def _between(states: Array, slopes: Array, time: Array, h: float) -> Array:
    """States at some times, shape (times, variables), from those after each step."""
    first = np.clip((time / h).astype(int) - _NODES // 2 + 1, 0, len(states) - _NODES)
    t = time / h - first
    found = np.zeros((len(time), states.shape[1]))
    for i in range(_NODES):
        others = [j for j in range(_NODES) if j != i]
        # Hermite's polynomials: l_i^2 is 1 at its node, 0 with its slope at the others.
        weight = np.prod([((t - j) / (i - j)) ** 2 for j in others], axis=0)
        bend = 2.0 * sum(1.0 / (i - j) for j in others)
        found += (weight * (1.0 - bend * (t - i)))[:, None] * states[first + i]
        found += (weight * (t - i) * h)[:, None] * slopes[first + i]
    return found
