"""Many motions side by side: sampled, with the forces of the floor and the slopes of the rates.

The equations are in their regular form, which passes where the mechanical trail is zero: motions at
the basin boundary do. Each motion has its own steps, so that what it gets does not depend on those
that share its vector.

heyoka's step law takes the order from a tolerance, and the step from the two last coefficients x
of the state: it is about e^-2 times the smaller of ``(norm / |x|)^(1 / order)``, where ``norm`` is
the largest variable of the state. To choose both freely, the state is given a constant more, the
norm: the error of a step is about e^(-2 order) of it. Another variable counts the time.

The code is unrolled, and multiplications and additions are contracted (``fast_math``): each is then
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
from heyoka_bike.workbench.fast.vector_code import STATE

ROLL, PITCH, STEER, ROLL_RATE, STEER_RATE, SPIN = range(STATE)
LATERAL = (ROLL, STEER, ROLL_RATE, STEER_RATE)
"""Variables that are zero in straight running."""

SPACING = 1 / 32
"""Time between two samples [s], a binary64 number."""
WINDOW = 160
"""Samples that are taken at a time."""

ACROSS = np.pi / 2
"""Steer angle at which the front wheel is across [rad]: from there on it has fallen."""

LEAST_TURN = 0.1
"""Where the equations are taken to end: what they divide by, in rear wheel radii, see
`turn_divisor`. A step is as long as the way to a singularity, which a coarse one could pass."""

_MOST_STEPS = 20_000  # in a window
# Places in the state of the compiled step of the time, over a power of two that keeps the clock
# exact and small against the norm in long runs, and of the norm.
_CLOCK, _NORM, _TICK = STATE, STATE + 1, 1024.0


@dataclass(frozen=True, slots=True)
class Plan:
    """Order and norm of the Taylor steps; the norm is no less than the speed."""

    order: int
    norm: float


PLANS: Mapping[str | float, Plan] = {1e-10: Plan(15, 28.0), "roundoff": Plan(19, 16.0)}
"""For the largest error of roll and steer angle [rad], their rates [rad/s] and the speed [m/s] over
10 s the fastest plan found that keeps it in the three maneuvers and 20 other starts."""


@dataclass(frozen=True, slots=True)
class _Code:
    """heyoka's: steps of a vector, normal forces, slopes of the rates."""

    step: TaylorBatch
    forces: Compiled
    slopes: Compiled


class Runs:
    """Compiled code for the motions of one bicycle, or of several.

    Parameters
    ----------
    bicycles : sequence of Bicycle
        The constants of a single one are compiled in; of several they are read as they are needed.
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
        """Those of the bicycles of some motions, in arrays."""
        if self._is_single:
            return self._one
        numbers = iter(self._numbers[:, which])
        return self._one.convert(lambda _: next(numbers), Arrays())

    def states(self, starts: Array, which: Array) -> Array:
        """States at the start, shape (motions, 6), of starts in the order of `START`."""
        roll, steer, roll_rate, steer_rate, speed = starts.T
        k = self.equations(which).k
        pitch = pitch_on_the_floor(k, roll, np.zeros(len(roll)), steer)
        return np.column_stack([roll, pitch, steer, roll_rate, steer_rate, speed / k.length])

    def forces(self, states: Array, which: Array) -> Array:
        """Normal forces on the rear and the front wheel [N], shape (motions, samples, 2)."""
        return self._evaluated(self._code.forces, states, which)

    def slopes(self, states: Array, which: Array) -> Array:
        """Derivatives of the rates by the state, shape (motions, samples, 6, 6)."""
        found = self._evaluated(self._code.slopes, states, which)
        return found.reshape(*states.shape[:2], STATE, STATE)

    def follow(
        self, states: Array, which: Array, order: Array, *,
        spacing: float = SPACING, count: int = WINDOW,
    ) -> tuple[Array, Array, Array]:  # fmt: skip
        """One window of each motion, or less: until the handlebar is turned by a right angle.

        Parameters
        ----------
        states : ndarray, shape (motions, 6)
        which : ndarray, shape (motions,)
            Their bicycles.
        order : ndarray, shape (motions,)
            Motions of neighbouring numbers share a vector; best those of about as many steps.
        spacing, count
            Time between samples [s], and how many there are after the first.

        Returns
        -------
        samples : ndarray, shape (motions, count + 1, 6)
            NaN after the end of a motion.
        ends : ndarray, shape (motions,)
            Time [s] at which the handlebar is across, or the equations end; NaN if neither.
        steps : ndarray, shape (motions,)
            How many were taken.
        """
        samples = np.full((len(states), count + 1, STATE), np.nan)
        ends = np.full(len(states), np.nan)
        steps = np.empty(len(states))
        at = np.repeat(np.arange(count + 1)[:, None] * spacing, self._code.step.lanes, axis=1)
        places = np.argsort(order, kind="stable")
        for begin in range(0, len(places), self._code.step.lanes):
            left = places[begin : begin + self._code.step.lanes]
            while len(left):
                found = self._propagate(states[left], which[left], at)
                grid, times = found.samples[:, :STATE], found.times
                # One that ends interrupts the others: they go again without it.
                # A lane may reach its end in the very step that ends another.
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
        """One window of a vector of motions."""
        step = self._code.step
        # Lanes that are free follow the first.
        free = self._code.step.lanes - len(states)
        states = np.concatenate([states, np.repeat(states[:1], free, axis=0)])
        which = np.concatenate([which, np.repeat(which[:1], free)])
        begin = np.zeros((_NORM + 1, step.lanes))
        begin[:STATE], begin[_NORM] = states.T, self._norm
        numbers = None if self._is_single else self._numbers[: step.parameters, which]
        return step.over(begin, at, numbers, most_steps=_MOST_STEPS)

    def _evaluated(self, function: Compiled, states: Array, which: Array) -> Array:
        numbers = None
        if not self._is_single:
            numbers = self._numbers[: function.parameters, np.repeat(which, states.shape[1])]
        found = function(states.reshape(-1, STATE).T, numbers)
        return np.ascontiguousarray(found.T).reshape(*states.shape[:2], -1)


@dataclass(frozen=True, slots=True)
class _Template:
    """Equations of any bicycle, into which constants are put: all are alike."""

    equations: Equations = field(compare=False)


@lru_cache(4)
def _code(constants: tuple[float | None, ...], order: int, template: _Template) -> _Code:
    """Compiled code, of constants that are compiled in, or None for those read later."""
    symbols = iter([parameter(i) if x is None else constant(x) for i, x in enumerate(constants)])
    equations = template.equations.convert(lambda _: next(symbols), Expressions())
    state = variables(equations.states)[:STATE]
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
