"""Small errors along the reference motion: how a force on the state shows in the columns.

A method of order p with step h follows, to leading order, y' = f(y) + h^p d(y). Its error e obeys
e' = f'(y) e + d along the exact motion. `Motion` has the exact states on a grid, carries such
forces d through the linear equation, all maneuvers and forces at once, and turns the error of the
state into those of the columns.
"""

from collections.abc import Sequence

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS, FOLLOWING
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.following import following
from heyoka_bike.reference.load import Reference

NAMES: tuple[str, ...] = tuple(c.name for c in (*COLUMNS, *FOLLOWING))

STATES = 7
"""Roll, pitch, steer, roll rate, steer rate, spin, yaw."""
SPIN = 5
VELOCITIES = (3, 4, SPIN)
POSITIONS = (0, 1, 2, 6)

_STEPS = 1000
# Classical Runge-Kutta steps in one of the grid: 2.5 ms are good to 1e-8, differences to 1e-5.
_INNER = 4
# Central differences of smooth functions of order one: error 1e-10 from both sides.
_SHIFT = 1e-5
_AT_ONCE = 2000  # states


class Variations:
    """The reference motion on an even grid of each maneuver, and what follows from it.

    Attributes
    ----------
    equations : Equations
        Binary64.
    values : mapping of str to float
        Parameters by symbol.
    step : ndarray, shape (maneuvers,)
        Of the grid [s].
    states : ndarray, shape (7, maneuvers, points)
    """

    def __init__(self, reference: Reference) -> None:
        bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
        self.values = {s: float(x) for s, x in bicycle.values.items()}
        self.equations = Equations.binary64(bicycle)
        self._numbers = tuple(reference)
        self.step = np.array([float(reference[n].duration) for n in reference]) / _STEPS
        self.states = np.stack([self._states(reference, n) for n in reference], axis=1)
        self._transitions = self._make_transitions()
        self._derivatives = self._make_derivatives()

    def _states(self, reference: Reference, number: int) -> Array:
        m = reference[number]
        names = ("roll_angle", "pitch", "steer_angle", "roll_rate", "steer_rate", "forward_speed",
                 "yaw")  # fmt: skip
        found = m.approximate(np.linspace(0.0, float(m.duration), _STEPS + 1), names)
        state = np.stack([found[name] for name in names])
        state[SPIN] /= float(self.equations.k.rear.r * self.equations.k.length)
        return state

    def slope(self, y: Array) -> Array:
        """Rates of states of shape (7, ...)."""
        states = np.ascontiguousarray(y.reshape(STATES, -1))
        found = np.empty_like(states)
        # Some at a time, so that what is computed of them stays in the processor's cache.
        for i in range(0, states.shape[1], _AT_ONCE):
            part = slice(i, i + _AT_ONCE)
            found[:, part] = self.equations.rates_with_yaw(list(states[:, part]))
        return found.reshape(y.shape)

    def flow(self, y: Array, h: Array | float) -> Array:
        """A step of the classical Runge-Kutta method; h broadcasts over (maneuvers, points)."""
        k1 = self.slope(y)
        k2 = self.slope(y + h / 2 * k1)
        k3 = self.slope(y + h / 2 * k2)
        k4 = self.slope(y + h * k3)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    def outputs(self, y: Array) -> Array:
        """All columns, shape (columns, ...)."""
        found = self.equations.columns(list(y))
        every = {**found, **following(found, self.values)}
        return np.stack([every[name] for name in NAMES])

    def respond(self, forces: Sequence[Array]) -> Array:
        """Errors of the columns under forces on the state.

        Parameters
        ----------
        forces : sequence of ndarray, shape (7, maneuvers, points)
            Added to the rates of the state [1/s times its unit].

        Returns
        -------
        ndarray, shape (columns, forces, maneuvers, points)
        """
        # Points first, so that each step is one product of small matrices.
        pushes = np.ascontiguousarray(np.stack(forces, axis=1).transpose(3, 2, 0, 1))
        pushes *= self.step[:, None, None] / 2
        errors = np.zeros_like(pushes)
        for n, transition in enumerate(self._transitions):
            errors[n + 1] = transition @ (errors[n] + pushes[n]) + pushes[n + 1]
        found: Array = np.einsum("cjmn,nmjk->ckmn", self._derivatives, errors, optimize=True)
        return found

    def at(self, shapes: Array, number: int, name: str, time: Array) -> Array:
        """Rows of a response at some times of a maneuver, shape (times, forces)."""
        i = self._numbers.index(number)
        grid = self.step[i] * np.arange(_STEPS + 1)
        rows = shapes[NAMES.index(name), :, i]
        return np.stack([np.interp(time, grid, row) for row in rows], axis=1)

    def _make_transitions(self) -> Array:
        """How an error is carried over each step, shape (points - 1, maneuvers, 7, 7)."""
        y = self._shifted()[..., :-1]
        h = self.step[:, None] / _INNER
        for _ in range(_INNER):
            y = self.flow(y, h)
        found = (y[:, :STATES] - y[:, STATES:]) / (2 * _SHIFT)
        return np.ascontiguousarray(found.transpose(3, 2, 0, 1))

    def _make_derivatives(self) -> Array:
        """Derivatives of the columns, shape (columns, 7, maneuvers, points)."""
        y = self.outputs(self._shifted())
        found: Array = (y[:, :STATES] - y[:, STATES:]) / (2 * _SHIFT)
        return found

    def _shifted(self) -> Array:
        """The states with each variable raised, then with each lowered: (7, 14, ...)."""
        shifts = _SHIFT * np.concatenate([np.eye(STATES), -np.eye(STATES)], axis=1)
        return self.states[:, None] + shifts[:, :, None, None]
