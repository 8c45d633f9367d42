"""Integrators: SciPy's, and methods of fixed step as users write them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import odeint, solve_ivp

from corpus.benchmark import TIMES, Array

Slope = Callable[[float, Array], Array]
Lean = Callable[[Array], float]
"""Function that returns the roll angle of a state."""

Method = Callable[[Slope, Array, Lean], Array]
"""Function of a slope and an initial state that returns the states, one column for each row of
`TIMES`; NaN after a fall or a stop."""

_FALLEN = 1.2
"""Roll angle at which a run ends [rad]."""


def scipy_method(name: str, rtol: float, atol: float | None = None) -> Method:
    """Use `solve_ivp`, whose own interpolation gives the rows."""

    def integrate(slope: Slope, start: Array, lean: Lean) -> Array:
        def stands(_: float, y: Array) -> float:
            return _FALLEN - abs(lean(y))

        stands.terminal = True  # type: ignore[attr-defined]
        absolute, span = rtol if atol is None else atol, (TIMES[0], TIMES[-1])
        found = solve_ivp(
            slope, span, start, name, TIMES, events=stands, rtol=rtol, atol=absolute
        )  # fmt: skip
        # A run that stopped early has only its first rows.
        states = np.full((len(start), len(TIMES)), np.nan)
        states[:, : found.y.shape[1]] = found.y
        return states

    return integrate


def odeint_as_it_comes(slope: Slope, start: Array, _: Lean) -> Array:
    """Use `odeint` with its default tolerances, 1.49e-8."""
    return np.asarray(odeint(slope, start, TIMES, tfirst=True)).T


def fixed(step: Callable[[Slope, float, Array, float], Array], per_row: int) -> Method:
    """A one-step method with `per_row` steps from row to row."""

    def integrate(slope: Slope, start: Array, _: Lean) -> Array:
        y, h, states = start, 0.01 / per_row, [start]
        for t in TIMES[:-1]:
            for i in range(per_row):
                y = step(slope, t + i * h, y, h)
            states.append(y)
        return np.array(states).T

    return integrate


def euler(slope: Slope, t: float, y: Array, h: float) -> Array:
    return y + h * slope(t, y)


def semi_implicit_euler(slope: Slope, t: float, y: Array, h: float) -> Array:
    """Compute the new speeds first (second half of the state), then the coordinates from these."""
    half = len(y) // 2
    u = y[half:] + h * slope(t, y)[half:]
    return np.concatenate([y[:half] + h * u, u])


def midpoint(slope: Slope, t: float, y: Array, h: float) -> Array:
    return y + h * slope(t + h / 2, y + h / 2 * slope(t, y))


def heun(slope: Slope, t: float, y: Array, h: float) -> Array:
    first = slope(t, y)
    return y + h / 2 * (first + slope(t + h, y + h * first))


def runge_kutta_4(slope: Slope, t: float, y: Array, h: float) -> Array:
    a = slope(t, y)
    b = slope(t + h / 2, y + h / 2 * a)
    c = slope(t + h / 2, y + h / 2 * b)
    d = slope(t + h, y + h * c)
    return y + h / 6 * (a + 2 * b + 2 * c + d)


def adams_bashforth_2(per_row: int) -> Method:
    """Two-step Adams-Bashforth method, started with one step of Heun's method."""

    def integrate(slope: Slope, start: Array, _: Lean) -> Array:
        h, states = 0.01 / per_row, [start]
        before, y = slope(0.0, start), heun(slope, 0.0, start, h)
        for i in range(1, per_row * (len(TIMES) - 1) + 1):
            if i % per_row == 0:
                states.append(y)
            now = slope(i * h, y)
            y, before = y + h * (1.5 * now - 0.5 * before), now
        return np.array(states).T

    return integrate


EXACT = scipy_method("DOP853", 1e-12)
"""Method for runs whose error should be that of the model alone."""
