"""Integrate many motions side by side, and compute floor forces and derivatives of rates.

The equations are in their regular form, which is valid where the mechanical trail passes zero, as
it does at the basin boundary. Each motion has its own steps, so its result does not depend on the
motions that share its vector.

heyoka derives the order from a tolerance, and the step from the last two coefficients x of the
state: about e^-2 times the smaller of ``(norm / |x|)^(1 / order)``, where ``norm`` is the largest
variable of the state. To choose both freely, the state gets an additional constant, the norm: the
error of a step is about e^(-2 order) times the norm. Another variable counts the time.

The code is unrolled, and multiplications and additions are fused (``fast_math``), so each pair is
rounded once. No sum of the equations depends on the order of its terms.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.kinematics import turn_divisor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.motion.heyoka_adapter import (
    Compiled,
    Expressions,
    Lanes,
    TaylorBatch,
    as_expression,
    constant,
    parameter,
    variables,
)
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.workbench.fast.vector_code import STATE_SIZE

ROLL, PITCH, STEER, ROLL_RATE, STEER_RATE, SPIN = range(STATE_SIZE)
LATERAL = (ROLL, STEER, ROLL_RATE, STEER_RATE)
"""Variables that are zero in straight running."""

SPACING = 1 / 32
"""Time between two samples [s], a binary64 number."""
WINDOW = 160
"""Number of samples in a window."""

ACROSS = np.pi / 2
"""Steer angle at which the front wheel is crosswise [rad]; the bicycle counts as fallen."""

LEAST_TURN = 0.1
"""The equations end at this divisor [rear wheel radii], see `turn_divisor`. Steps are as
long as the distance to a singularity, which a coarse step could jump over."""

_MOST_STEPS = 20_000  # maximum number of steps in a window
# Positions of the time and the norm in the state that the compiled step integrates, and the divisor
# of the time. The divisor is a power of two, so the time remains exact. It keeps the time smaller
# than the norm in long runs.
_CLOCK, _NORM, _TICK = STATE_SIZE, STATE_SIZE + 1, 1024.0


@dataclass(frozen=True, slots=True)
class Plan:
    """Order and norm of the Taylor steps (see the module); the norm is at least the speed."""

    order: int
    norm: float


PLANS: Mapping[str | float, Plan] = {1e-10: Plan(15, 28.0), "roundoff": Plan(19, 16.0)}
"""Fastest plan found for each largest error of roll and steer angle [rad], their rates [rad/s] and
the speed [m/s] over 10 s, in the three maneuvers and 20 other starts."""


@dataclass(frozen=True, slots=True)
class _Code:
    """Functions compiled by heyoka: Taylor steps, normal forces, derivatives of the rates."""

    step: TaylorBatch
    forces: Compiled
    slopes: Compiled


class Runs:
    """Compiled code for the motions of one bicycle, or of several.

    Parameters
    ----------
    bicycles : sequence of Bicycle
        The constants of a single bicycle are compiled in; those of several are read at run time.
    plan : Plan
        Order and norm of the Taylor steps.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """

    def __init__(self, bicycles: Sequence[Bicycle], plan: Plan) -> None:
        each = [Equations.binary64(bicycle) for bicycle in bicycles]
        self._one = each[0]
        self._numbers = np.array([_constants(x) for x in each]).T
        self._is_single = len(bicycles) == 1
        self._norm = plan.norm
        compiled_in = (
            tuple(self._numbers[:, 0]) if self._is_single else (None,) * len(self._numbers)
        )
        self._code = _code(compiled_in, plan.order, _Template(self._one))

    def equations(self, which: Array) -> Equations:
        """Return the equations of the bicycles of some motions; their constants are arrays."""
        if self._is_single:
            return self._one
        numbers = iter(self._numbers[:, which])
        return self._one.convert(lambda _: next(numbers), Arrays())

    def states(self, starts: Array, which: Array) -> Array:
        """Return initial states, shape (motions, 6), for starts in the order of `START`."""
        roll, steer, roll_rate, steer_rate, speed = starts.T
        k = self.equations(which).k
        pitch = pitch_on_the_floor(k, roll, np.zeros(len(roll)), steer)
        return np.column_stack([roll, pitch, steer, roll_rate, steer_rate, speed / k.length])

    def forces(self, states: Array, which: Array) -> Array:
        """Return normal forces on the rear and front wheel [N], shape (motions, samples, 2)."""
        return self._evaluated(self._code.forces, states, which)

    def slopes(self, states: Array, which: Array) -> Array:
        """Return the Jacobian of the rates of the state, shape (motions, samples, 6, 6)."""
        found = self._evaluated(self._code.slopes, states, which)
        return found.reshape(*states.shape[:2], STATE_SIZE, STATE_SIZE)

    def follow(
        self, states: Array, which: Array, order: Array, *,
        spacing: float = SPACING, count: int = WINDOW,
    ) -> tuple[Array, Array, Array]:  # fmt: skip
        """Integrate one window of each motion, or less if the handlebar turns by a right angle.

        Parameters
        ----------
        states : ndarray, shape (motions, 6)
        which : ndarray, shape (motions,)
            Indices of their bicycles.
        order : ndarray, shape (motions,)
            Sort key: neighbours share a vector, which is fastest if they take similar numbers of
            steps.
        spacing, count
            Time between samples [s], and number of samples after the first.

        Returns
        -------
        samples : ndarray, shape (motions, count + 1, 6)
            NaN after the end of a motion.
        ends : ndarray, shape (motions,)
            Time [s] at which the handlebar is crosswise or the equations end; NaN if neither.
        steps : ndarray, shape (motions,)
            Number of steps.
        """
        samples = np.full((len(states), count + 1, STATE_SIZE), np.nan)
        ends = np.full(len(states), np.nan)
        steps = np.empty(len(states))
        at = np.repeat(np.arange(count + 1)[:, None] * spacing, self._code.step.lanes, axis=1)
        places = np.argsort(order, kind="stable")
        for begin in range(0, len(places), self._code.step.lanes):
            left = places[begin : begin + self._code.step.lanes]
            while len(left):
                found = self._propagate(states[left], which[left], at)
                grid, times = found.samples[:, :STATE_SIZE], found.times
                # If one motion ends early, the integrator stops all motions of the vector. The
                # interrupted motions are integrated again without it. A motion that has reached the
                # end of the window in the same step is complete.
                is_there = times[: len(left)] == at[-1, 0]
                is_done = is_there & np.isfinite(grid[-1, 0, : len(left)])
                is_ready = is_done | (~is_there & ~np.array(found.are_interrupted[: len(left)]))
                if not is_ready.any():
                    is_ready[:] = True
                ready = left[is_ready]
                samples[ready] = grid[:, :, : len(left)].transpose(2, 0, 1)[is_ready]
                steps[ready] = [n for n, x in zip(found.steps, is_ready, strict=False) if x]
                ends[left[is_ready & ~is_done]] = times[: len(left)][is_ready & ~is_done]
                left = left[~is_ready]
        return samples, ends, steps

    def _propagate(self, states: Array, which: Array, at: Array) -> Lanes:
        """Integrate the motions that share a vector over one window."""
        step = self._code.step
        # Unused places of the vector compute copies of the first motion.
        free = self._code.step.lanes - len(states)
        states = np.concatenate([states, np.repeat(states[:1], free, axis=0)])
        which = np.concatenate([which, np.repeat(which[:1], free)])
        begin = np.zeros((_NORM + 1, step.lanes))
        begin[:STATE_SIZE], begin[_NORM] = states.T, self._norm
        numbers = None if self._is_single else self._numbers[: step.parameters, which]
        return step.over(begin, at, numbers, most_steps=_MOST_STEPS)

    def _evaluated(self, function: Compiled, states: Array, which: Array) -> Array:
        numbers = None
        if not self._is_single:
            numbers = self._numbers[: function.parameters, np.repeat(which, states.shape[1])]
        found = function(states.reshape(-1, STATE_SIZE).T, numbers)
        return np.ascontiguousarray(found.T).reshape(*states.shape[:2], -1)


@dataclass(frozen=True, slots=True)
class _Template:
    """Equations whose constants `_code` replaces; all templates are equal as keys of its cache."""

    equations: Equations = field(compare=False)


@lru_cache(4)
def _code(constants: tuple[float | None, ...], order: int, template: _Template) -> _Code:
    """Compile the equations with given constants; None marks a constant read at run time."""
    symbols = iter([parameter(i) if x is None else constant(x) for i, x in enumerate(constants)])
    equations = template.equations.convert(lambda _: next(symbols), Expressions())
    state = variables(equations.states)[:STATE_SIZE]
    turn = turn_divisor(equations.unfold(state)[0])
    ends = [state[STEER] * state[STEER] - ACROSS * ACROSS, turn * turn - LEAST_TURN * LEAST_TURN]
    floor = forces(equations, state)
    duals = Duals(Expressions())
    rates = equations.over(duals).rates(duals.variables(state))
    slopes = [as_expression(p) for rate in rates for p in rate.slopes]
    clock, norm = variables(("clock", "norm"))
    system = [
        *zip(state, equations.rates(state), strict=True),
        (clock, constant(1 / _TICK)),
        (norm, constant(0.0)),
    ]
    return _Code(
        TaylorBatch(system, order, ends),
        Compiled([floor.rear.normal, floor.front.normal], state, is_fast=True),
        Compiled(slopes, state, is_fast=True),
    )


def _constants(equations: Equations) -> list[float]:
    found: list[float] = []

    def note(x: float) -> float:
        found.append(x)
        return x

    equations.convert(note, equations.a)
    return found
