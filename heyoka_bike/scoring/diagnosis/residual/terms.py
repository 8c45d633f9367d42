"""Terms: what other equations of motion add to the accelerations of the benchmark's.

Along a motion, equations of another program give other accelerations. Their difference from the
right ones is a *term*: of a known mistake exactly, of a parameter or a force its derivative, whose
coefficient is to be found. No motion is simulated for it.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.programs.forces import (
    FORCES,
    TENSORS_TURNING,
    Moving,
    rates_altered,
)
from heyoka_bike.scoring.diagnosis.programs.program import Program, changed
from heyoka_bike.scoring.diagnosis.residual.observed import Observed, state_vector

UNKNOWNS = (*PARAMETERS, *(name for name, force in FORCES.items() if force.is_fitted))
"""Whose coefficients can be found."""

# Of a parameter or a force; differences over it are derivatives to some 6 digits.
_STEP = 1e-6
_Values = tuple[tuple[str, Exact], ...]
# Bicycles whose constants are kept: those of the library, and of the derivatives.
_KEPT = 256


class Accelerations:
    """Averages of what equations say of the accelerations along the motions of a file.

    Attributes
    ----------
    program : Program
        The right one.
    equations : Equations
        Its.
    block : ndarray of int, shape (n,)
        Three blocks of each maneuver, in order: roll, steer, speed.
    observed, uncertain : ndarray, shape (n,)
        Of the file, and by how much that is wrong, as far as it shows it.
    """

    def __init__(self, motions: Sequence[Observed], program: Program) -> None:
        self._motions = motions
        self._found: dict[object, Array] = {}
        self._pitch: dict[object, Array] = {}
        self._moving: dict[_Values, Moving] = {}
        self.program = program
        self.equations = _equations(tuple(program.bicycle.values.items()))
        self._ends = np.cumsum([len(m.time) for m in motions])[:-1]
        self.block: NDArray[np.intp] = np.concatenate(
            [np.repeat(3 * i + np.arange(3), len(m.windows)) for i, m in enumerate(motions)]
        )
        self.observed = np.concatenate([m.accelerations.ravel() for m in motions])
        self.uncertain = np.concatenate([m.uncertain.ravel() for m in motions])

    def of(self, program: Program) -> Array:
        """Return the accelerations of a program, shape (n,); NaN where it has none."""
        values = tuple(program.bicycle.values.items())
        amounts = dict(program.amounts)
        try:
            if TENSORS_TURNING in amounts:
                return self._by_equations(values, program.amounts)
            found = self._by_equations(values, ())
            return sum((x * self._by_force(values, k) for k, x in amounts.items()), start=found)
        except ZeroDivisionError:
            return np.full(len(self.block), np.nan)

    def _by_equations(self, values: _Values, amounts: tuple[tuple[str, float], ...]) -> Array:
        key = values, amounts
        if key not in self._found:
            equations = _equations(values)
            state = self._state(equations)
            with np.errstate(all="ignore"):
                rates = (
                    rates_altered(equations, state, dict(amounts))
                    if amounts
                    else equations.rates(state[:6])
                )
            self._found[key] = self._averages(equations, rates[3:6])
        return self._found[key]

    def _by_force(self, values: _Values, name: str) -> Array:
        """Return the accelerations that a unit force adds."""
        if (values, name) not in self._found:
            equations = _equations(values)
            with np.errstate(all="ignore"):
                if values not in self._moving:
                    self._moving[values] = Moving(equations, self._state(equations))
                moving = self._moving[values]
                added = moving.added(moving.powers(FORCES[name].law(moving)))
            self._found[values, name] = self._averages(equations, added)
        return self._found[values, name]

    def _state(self, equations: Equations) -> list[Array]:
        k = equations.k
        key = k.tilt, k.d1, k.d2, k.d3, k.h0, k.h1, k.h2, k.h3
        if key not in self._pitch:
            with np.errstate(all="ignore"):
                self._pitch[key] = state_vector(equations, self._column)[1]
        return state_vector(equations, self._column, self._pitch[key])

    def _averages(self, equations: Equations, rates: Sequence[Array]) -> Array:
        each = np.array([rates[0], rates[1], rates[2] * equations.k.length])
        parts = np.split(each, self._ends, axis=1)
        return np.concatenate(
            [(x @ m.windows.T).ravel() for x, m in zip(parts, self._motions, strict=True)]
        )

    def _column(self, key: str) -> Array:
        return np.concatenate([m.state[key] for m in self._motions])

    def slopes(self, program: Program, names: Sequence[str] = UNKNOWNS) -> Array:
        """Derivatives by parameters and forces at a program, shape (n, U)."""
        found = []
        here = self.of(program)
        for name in names:
            if name in FORCES:
                found.append(self._by_force(tuple(program.bicycle.values.items()), name))
                continue
            step = _STEP * size_of(self.program.bicycle, name)
            found.append((self.of(changed(program, {name: step})) - here) / step)
        return np.nan_to_num(np.array(found).T)


def size_of(bicycle: Bicycle, name: str) -> float:
    """Size of an unknown; one for starts, and for parameters that are zero."""
    if name in FORCES:
        return FORCES[name].size
    return abs(float(bicycle[name])) or 1.0 if name in bicycle.values else 1.0


def blocks_of(block: NDArray[np.intp], rows: Array) -> list[Array]:
    """Rows of each block."""
    return [rows[block == b] for b in range(int(block[-1]) + 1)]


@lru_cache(_KEPT)
def _equations(values: _Values) -> Equations:
    # Differences over 1e-6 need no more digits than these.
    return Equations.of(Bicycle("", dict(values)), Arrays())
