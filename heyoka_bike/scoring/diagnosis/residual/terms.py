"""What a program may have in its equations of motion that the benchmark has not, or the reverse.

Along a motion, equations of another program give other accelerations. Their difference from the
right ones is a *term*: of a known mistake exactly, of a parameter or a force its derivative, whose
coefficient is to be found.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.programs.applied import FORCES
from heyoka_bike.scoring.diagnosis.programs.incomplete import TERMS, rates_altered
from heyoka_bike.scoring.diagnosis.programs.program import Program
from heyoka_bike.scoring.diagnosis.residual.observed import Observed, state_vector

# Of a parameter; central differences over it are derivatives to some 9 digits.
_STEP = 1e-4
# Bicycles whose constants are kept: those of the library, and of all parameters' derivatives.
_KEPT = 256
_NONE: Mapping[str, float] = {}


@dataclass(frozen=True, eq=False, slots=True)
class Term:
    """A difference of accelerations.

    Attributes
    ----------
    code
    accelerations : ndarray, shape (n,)
        In the order of `Accelerations`.
    size
        A usual size of the coefficient; zero if it is one exactly.
    """

    code: str
    accelerations: Array
    size: float = 0.0


class Accelerations:
    """Averages of what equations say of the accelerations along the motions of a file.

    Attributes
    ----------
    block : ndarray of int, shape (n,)
        Three blocks of each maneuver, in order: roll, steer, speed.
    """

    def __init__(self, motions: Sequence[Observed], program: Program) -> None:
        self._motions = motions
        self._program = program
        self._ends = np.cumsum([len(m.time) for m in motions])[:-1]
        self.block = np.concatenate(
            [
                np.full(len(m.windows), 3 * i + k)
                for i, m in enumerate(motions)
                for k in range(3)
            ]
        )
        self.right = self.of(program.bicycle)

    def observed(self) -> tuple[Array, Array]:
        """The accelerations of the file, and how uncertain they are."""
        return (
            np.concatenate([m.accelerations.ravel() for m in self._motions]),
            np.concatenate([m.uncertain.ravel() for m in self._motions]),
        )

    def of(self, bicycle: Bicycle, amounts: Mapping[str, float] = _NONE) -> Array:
        """By the equations of a bicycle, with amounts of `TERMS` left out and of `FORCES`."""
        equations = _equations(tuple(bicycle.values.items()))
        with np.errstate(all="ignore"):
            state = state_vector(
                equations,
                *(
                    np.concatenate([getattr(m, name) for m in self._motions])
                    for name in ("roll", "steer", "roll_rate", "steer_rate", "speed", "yaw")
                ),
            )
            if amounts:
                every = {**dict.fromkeys((*TERMS, *FORCES), 0.0), **amounts}
                rates = rates_altered(equations, state, every)
            else:
                rates = equations.rates(state[:6])
            each = np.array([rates[3], rates[4], rates[5] * equations.k.length])
            parts = np.split(each, self._ends, axis=1)
            return np.concatenate(
                [(x @ m.windows.T).ravel() for x, m in zip(parts, self._motions, strict=True)]
            )

    def of_program(self, code: str, program: Program) -> Term:
        """What a program with known mistakes adds."""
        amounts = dict.fromkeys(program.missing, 1.0)
        return Term(code, self.of(program.bicycle, amounts) - self.right)

    def of_parameters(self) -> list[Term]:
        """Derivatives by each of the parameters."""
        found = []
        for symbol in PARAMETERS:
            value = float(self._program.bicycle[symbol])
            step = _STEP * (abs(value) or 1.0)
            low, high = (self.of(changed(self._program.bicycle, {symbol: s * step})) for s in (-1, 1))
            found.append(Term(symbol, (high - low) / (2 * step), abs(value) or 1.0))
        return found

    def of_forces(self) -> list[Term]:
        """Accelerations by unit forces."""
        none = self.of(self._program.bicycle, {next(iter(FORCES)): 0.0})
        return [
            Term(name, self.of(self._program.bicycle, {name: 1.0}) - none, force.size)
            for name, force in FORCES.items()
        ]


@lru_cache(_KEPT)
def _equations(values: tuple[tuple[str, Exact], ...]) -> Equations:
    return Equations.binary64(Bicycle("", dict(values)))


def changed(bicycle: Bicycle, changes: Mapping[str, float]) -> Bicycle:
    """The bicycle with changes of some parameters added."""
    values = dict(bicycle.values)
    for symbol, change in changes.items():
        x = values[symbol]
        values[symbol] = replace(x, rational=x.rational + Fraction(change))
    return Bicycle(bicycle.name, values)
