"""The problem that the compared codes solve, and the measures of their results.

Accuracy is measured outside of the timing, from the states at the rows, in ball arithmetic. The
state error is the largest abs(value - reference) over the rows of roll and steer angle [rad], their
rates [rad/s] and forward speed [m/s], with the reference at exactly the times of the rows.
"""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, STATE_INPUTS, Bicycle, Maneuver, benchmark
from heyoka_bike.errors import InputError
from heyoka_bike.motion.heyoka_adapter import Compiled, Expressions, constant, variables
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.load import ReferenceManeuver, load_reference
from heyoka_bike.reference.values import Values


@cache
def judged() -> int:
    """Number of the maneuver that the benchmark judges by its eq. (1)."""
    _, maneuvers = benchmark()
    return next(n for n, m in enumerate(maneuvers, 1) if m.performance_limit is not None)


@cache
def performance_limit() -> float:
    """Limit of eq. (1) of the benchmark [%]; here it applies to all maneuvers."""
    limit = benchmark()[1][judged() - 1].performance_limit
    assert limit is not None
    return float(limit)


ERROR_LIMIT = 1e-12
"""Limit of the state error in the second class of a comparison."""

Array = np.ndarray[Any, Any]
Measured = dict[str, Any]
"""A line of the report, as JSON values."""

_BITS_OF_PROBLEM = 256
_STATE_COLUMNS = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")


@dataclass(frozen=True)
class ReferenceProblem:
    """The motion to integrate, and the reference to compare with."""

    bicycle: Bicycle
    maneuver: Maneuver
    reference: ReferenceManeuver

    def start(self, number: Callable[[str], Any]) -> Array:
        """Return the initial state (without yaw); `number` makes its numbers from decimals."""
        state = initial_state(self._equations, self.maneuver)[:6]
        with self._equations.precision():
            return np.array([number(x.str(60, radius=False)) for x in state])

    @cached_property
    def times(self) -> Array:
        """Times of the rows [s], rounded to binary64."""
        return np.array([float(self.maneuver.time(i)) for i in range(self.maneuver.rows)])

    @cached_property
    def expected(self) -> Values:
        """The reference at the rounded `times`; its own rows are at the exact times."""
        return self.reference.evaluate(self.times, _STATE_COLUMNS)

    @cached_property
    def slope(self) -> tuple[Callable[[float, Array], Array], float]:
        """The right-hand side, as a function of time and state, and its building time [s]."""
        begin = time.perf_counter()
        equations = right_hand_side(self.bicycle, Precision.of("binary64"), with_yaw=False)
        compiled = Compiled([rate for _, rate in equations], [x for x, _ in equations])

        def slope(_: float, y: Array) -> Any:
            return compiled(y)

        return slope, time.perf_counter() - begin

    def columns(self, number: Callable[[str], Any] = float) -> Callable[[Array], Any]:
        """Return a function from states, shape (rows, 6), to columns, shape (8, rows)."""
        with self._equations.precision():
            equations = self._equations.convert(
                lambda x: constant(number(x.str(60, radius=False))), Expressions()
            )
        *state, _ = variables(equations.states)
        # The columns do not depend on the yaw, so it is set to zero.
        found = equations.columns([*state, constant(number("0"))])
        compiled = Compiled([found[name] for name in BENCHMARK_COLUMNS], state, number)
        return lambda states: compiled(states.T)

    def measure(self, rows: Array, expected: Values) -> tuple[float, float]:
        """Return eq. (1) [%] and the state error of a run; infinite if rows are missing."""
        if len(rows) < self.maneuver.rows:
            return math.inf, math.inf
        equations = self._equations
        total, worst = [], flint.arb(0)
        with equations.precision():
            for i, row in enumerate(rows):
                state = [flint.arb(x if isinstance(x, float) else str(x)) for x in row]
                _, u = equations.unfold(state)
                e = equations.energies(state)
                total.append(e.potential + e.kinetic)
                found = (state[0], state[2], u.p, u.steer_rate, u.v * equations.k.length)
                for name, value in zip(_STATE_COLUMNS, found, strict=True):
                    right = flint.arb(expected.hi[name][i]) + flint.arb(expected.lo[name][i])
                    worst = worst.max(abs(value - right))
            high, low = total[0], total[0]
            for value in total:
                high, low = high.max(value), low.min(value)
            performance, error = float((100 * (high - low) / total[0]).mid()), float(worst.mid())
        return (performance, error) if math.isfinite(performance + error) else (math.inf, math.inf)

    def measure_columns(self, found: Array, definitions: Mapping[str, str]) -> tuple[float, float]:
        """Return eq. (1) [%] and the state error of columns, which follow `definitions`."""
        if found.shape[1] < self.maneuver.rows or not np.isfinite(found).all():
            return math.inf, math.inf
        energy = found[BENCHMARK_COLUMNS.index("mechanical_energy")]
        worst = 0.0
        for name in _STATE_COLUMNS:
            right = self.reference.rows.hi[definitions.get(name, name)]
            worst = max(worst, float(np.abs(found[BENCHMARK_COLUMNS.index(name)] - right).max()))
        return float(100 * (energy.max() - energy.min()) / energy[0]), worst

    @cached_property
    def _equations(self) -> Equations:
        return Equations.of(self.bicycle, Balls(_BITS_OF_PROBLEM), is_regular=False)


def seconds(run: Callable[[], object]) -> float:
    """Run a function and return the time that this takes [s]."""
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


class Unavailable(Exception):  # noqa: N818
    """A code cannot run here; the message gives the reason in a few words."""


@dataclass(frozen=True)
class Trial:
    """A code that is built for a tolerance, and the measures of its accuracy and work.

    Attributes
    ----------
    run
        Function that runs the code once, including rows of all eight columns.
    tolerance
        Tolerance in the code's own sense.
    build
        Building time of the code [s].
    count
        Number of steps, or of calls of the right-hand side.
    performance, error
        Eq. (1) [%] and state error.
    order
        Taylor order, the only property of heyoka's code that depends on the tolerance.
    """

    run: Callable[[], object]
    tolerance: float
    build: float
    count: int
    performance: float
    error: float
    order: int | None = None


def benchmark_problem(folder: str | None, number: int) -> ReferenceProblem:
    """Return a maneuver of the benchmark, with its reference.

    Parameters
    ----------
    folder
        Folder of a reference dataset; by default the published one.
    number
        Number of the maneuver, from 1.

    Raises
    ------
    InputError
        The reference belongs to other inputs.
    """
    reference = load_reference(folder)
    bicycle, maneuvers = benchmark()
    maneuver = maneuvers[number - 1]
    inputs = {key: str(getattr(maneuver, key)) for key in STATE_INPUTS}
    if (
        number not in reference
        or dict(reference[number].inputs) != inputs
        or dict(reference.parameters) != {symbol: str(bicycle[symbol]) for symbol in PARAMETERS}
    ):
        raise InputError(
            f"{folder}: found a reference of other inputs, expected {maneuver.name} of the "
            f"{bicycle.name}"
        )
    return ReferenceProblem(bicycle, maneuver, reference[number])
