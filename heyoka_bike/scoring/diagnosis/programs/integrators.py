"""Usual methods of integration with a fixed step, and their errors along a motion.

A step from a state of the exact motion misses the next state by the method's local error. Local
errors are propagated along the exact motion by its variational equations. If y_i are the exact
states, e_(i+1) = J_i e_i + (local error of the step from y_i), where J_i is the derivative of the
next state with respect to the state. This gives the whole error of the method, to first order in
the error itself and to all orders in the step. NumPy makes all steps at once.

References
----------
E. Hairer, S. P. Norsett, G. Wanner (1993), Solving Ordinary Differential Equations I, II.3 to II.5.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import SMALL_STEP, Array

Rates = Callable[[Array], Array]
"""Function from states, shape (variables, n), to their time derivatives."""
Step = Callable[[Rates, Array, float | Array], Array]
"""Function from rates, states and the length of a step [s], or of each, to the next states."""

# Maximum number of fixed-point iterations in an implicit step, and the relative change at which
# they stop. With steps of 0.02 s each iteration reduces the error to less than half.
_REPETITIONS, _SETTLED = 40, 1e-14
# Up to this number of states, evaluating the equations for each by itself takes less time than for
# an array of all: 80 microseconds for a state, 490 for a short array (AMD EPYC).
_FEW_STATES = 3


@dataclass(frozen=True, slots=True)
class FixedStep:
    """A method of integration with a fixed step.

    Attributes
    ----------
    code
        Name of the method in the log of ``diagnose -v``.
    says
        Name of the method in messages.
    order
    step
        Function that makes one step.
    """

    code: str
    says: str
    order: int
    step: Step


def _runge_kutta(a: Sequence[Sequence[float]], b: Sequence[float]) -> Step:
    """Return the step function of an explicit Runge-Kutta method; `a` has a row per stage."""

    def step(f: Rates, y: Array, h: float | Array) -> Array:
        stages: list[Array] = []
        for row in a:
            stages.append(f(y + h * _sum(row, stages)) if row else f(y))
        return y + h * _sum(b, stages)

    return step


def _sum(factors: Sequence[float], stages: Sequence[Array]) -> Array:
    found: Array = sum((x * k for x, k in zip(factors, stages, strict=True) if x), 0.0 * stages[0])
    return found


def _semi_implicit(f: Rates, y: Array, h: float | Array) -> Array:
    """Make a step of semi-implicit Euler: first the new speeds, then the angles with these."""
    ahead = y.copy()
    ahead[3:6] += h * f(y)[3:6]
    return np.concatenate([y[:3], ahead[3:6], y[6:]]) + h * np.where(_ARE_ANGLES, f(ahead), 0.0)


_ARE_ANGLES = np.array([1, 1, 1, 0, 0, 0, 1], bool)[:, None]


def _theta(old: float, new: float) -> Step:
    """Return the step function of a method that weights the rates at both ends of the step."""

    def step(f: Rates, y: Array, h: float | Array) -> Array:
        now = f(y)
        known = y + h * old * now
        return _settled(lambda ahead: known + h * new * f(ahead), y + h * now)

    return step


def _implicit_midpoint(f: Rates, y: Array, h: float | Array) -> Array:
    return 2 * _settled(lambda middle: y + h / 2 * f(middle), y) - y


def _settled(better: Callable[[Array], Array], guess: Array) -> Array:
    """Iterate until the value no longer changes."""
    for _ in range(_REPETITIONS):
        guess, before = better(guess), guess
        change, size = (np.max(np.abs(x), initial=0.0) for x in (guess - before, guess))
        if not change >= _SETTLED * size:
            break
    return guess


def _adams_bashforth(weights: Sequence[float]) -> Step:
    """Return the step function of an Adams-Bashforth method; earlier rates are nearly exact."""

    def step(f: Rates, y: Array, h: float | Array) -> Array:
        found, before = y + h * weights[0] * f(y), y
        for weight in weights[1:]:
            before = _nearly_right(f, before, -h)
            found = found + h * weight * f(before)
        return found

    return step


RK4 = _runge_kutta([[], [1 / 2], [0, 1 / 2], [0, 0, 1]], [1 / 6, 1 / 3, 1 / 3, 1 / 6])
"""The classical method of order 4."""


def _nearly_right(f: Rates, y: Array, h: float | Array) -> Array:
    """Make a step far more accurate than those of the methods: two half steps of RK4."""
    return RK4(f, RK4(f, y, h / 2), h / 2)


METHODS = (
    FixedStep("explicit_euler", "explicit Euler", 1, _runge_kutta([[]], [1])),
    FixedStep("implicit_euler", "implicit Euler", 1, _theta(0.0, 1.0)),
    FixedStep("semi_implicit_euler", "semi-implicit Euler", 1, _semi_implicit),
    FixedStep("heun_2", "Heun's method", 2, _runge_kutta([[], [1]], [1 / 2, 1 / 2])),
    FixedStep(
        "explicit_midpoint", "the explicit midpoint rule", 2, _runge_kutta([[], [1 / 2]], [0, 1])
    ),
    FixedStep("ralston_2", "Ralston's method", 2, _runge_kutta([[], [2 / 3]], [1 / 4, 3 / 4])),
    FixedStep("trapezoidal", "the trapezoidal rule", 2, _theta(1 / 2, 1 / 2)),
    FixedStep("implicit_midpoint", "the implicit midpoint rule", 2, _implicit_midpoint),
    FixedStep(
        "adams_bashforth_2",
        "Adams and Bashforth's method of order 2",
        2,
        _adams_bashforth([3 / 2, -1 / 2]),
    ),
    FixedStep(
        "kutta_3",
        "Kutta's method of order 3",
        3,
        _runge_kutta([[], [1 / 2], [-1, 2]], [1 / 6, 2 / 3, 1 / 6]),
    ),
    FixedStep(
        "heun_3",
        "Heun's method of order 3",
        3,
        _runge_kutta([[], [1 / 3], [0, 2 / 3]], [1 / 4, 0, 3 / 4]),
    ),
    FixedStep(
        "shu_osher_3",
        "Shu and Osher's method of order 3",
        3,
        _runge_kutta([[], [1], [1 / 4, 1 / 4]], [1 / 6, 1 / 6, 2 / 3]),
    ),
    FixedStep(
        "bogacki_shampine_3",
        "Bogacki and Shampine's method of order 3 (ode23, RK23) with a fixed step",
        3,
        _runge_kutta([[], [1 / 2], [0, 3 / 4]], [2 / 9, 1 / 3, 4 / 9]),
    ),
    FixedStep("rk4", "the classical Runge-Kutta method of order 4 (RK4)", 4, RK4),
    FixedStep(
        "three_eighths_4",
        "Kutta's 3/8 rule of order 4",
        4,
        _runge_kutta([[], [1 / 3], [-1 / 3, 1], [1, -1, 1]], [1 / 8, 3 / 8, 3 / 8, 1 / 8]),
    ),
    FixedStep(
        "adams_bashforth_4",
        "Adams and Bashforth's method of order 4",
        4,
        _adams_bashforth([55 / 24, -59 / 24, 37 / 24, -9 / 24]),
    ),
    FixedStep(
        "dormand_prince_5",
        "Dormand and Prince's method of order 5 (ode45, RK45) with a fixed step",
        5,
        _runge_kutta(
            [
                [],
                [1 / 5],
                [3 / 40, 9 / 40],
                [44 / 45, -56 / 15, 32 / 9],
                [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
                [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
            ],
            [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
        ),
    ),
)
"""Methods that the diagnosis can recognise."""


def rates_of(equations: Equations, y: Array) -> Array:
    """Compute the time derivatives of states, shape (7, n)."""
    if y.shape[1] <= _FEW_STATES:
        return np.array([equations.rates_with_yaw([*state]) for state in y.T]).T
    made = equations.rates_with_yaw(list(y))
    return np.array([np.broadcast_to(r, y[0].shape) for r in made])


def evaluations(method: FixedStep, equations: Equations, start: Array, step: float) -> int:
    """Count the evaluations of the rates in one step."""
    count = 0

    def rates(y: Array) -> Array:
        nonlocal count
        count += 1
        return rates_of(equations, y)

    with np.errstate(all="ignore"):
        method.step(rates, start, step)
    return count


def steps_made(
    method: FixedStep, equations: Equations, start: Array, step: float, count: int
) -> Array:
    """Make `count` steps; return the initial and later states, shape (7, motions, count + 1)."""
    states = [start]
    with np.errstate(all="ignore"):
        for _ in range(count):
            states.append(method.step(partial(rates_of, equations), states[-1], step))
    return np.stack(states, axis=-1)


class Carried:
    """Propagation of the errors of methods along an exact motion.

    Parameters
    ----------
    equations : Equations
        Equations of the regular form, over arrays.
    states : ndarray, shape (7, n)
        States of the exact motion, at evenly spaced rows from the start on.
    spacing
        Distance of the rows [s].

    Attributes
    ----------
    spacing
    """

    def __init__(self, equations: Equations, states: Array, spacing: float) -> None:
        self._equations, self._states, self.spacing = equations, states, spacing
        shifts = SMALL_STEP * np.concatenate([np.zeros((7, 1)), np.eye(7)], axis=1)
        moved = (states[:, None, :-1] + shifts[:, :, None]).reshape(7, -1)
        ahead = RK4(self._rates, moved, spacing).reshape(7, 8, -1)
        slopes = (ahead[:, 1:] - ahead[:, :1]) / SMALL_STEP
        # Axes: row, component of the next state, component of the present state.
        self._slopes = np.ascontiguousarray(slopes.transpose(2, 0, 1))

    def _rates(self, y: Array) -> Array:
        return rates_of(self._equations, y)

    def errors(self, method: FixedStep, steps: int, rows: int = 1) -> Array:
        """Return the error of a method with `steps` steps per `rows` rows, shape (7, n)."""
        y = self._states[:, :-rows:rows]
        with np.errstate(all="ignore"):
            for _ in range(steps):
                y = method.step(self._rates, y, self.spacing * rows / steps)
        missed = np.zeros(self._states.shape)
        missed[:, rows::rows] = y - self._states[:, rows::rows]
        found = np.zeros(self._states.shape)
        error = np.zeros(7)
        for i, slope in enumerate(self._slopes, 1):
            error = slope @ error + missed[:, i]
            found[:, i] = error
        return found
