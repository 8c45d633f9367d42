"""What `estimation` needs of a file: errors, derivatives, and errors by simulation."""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import START, Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.sensitivities import Sensitivities
from heyoka_bike.scoring.diagnosis.programs.applied import FORCES
from heyoka_bike.scoring.diagnosis.programs.program import Program
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.scoring.diagnosis.programs.start import initial_state
from heyoka_bike.scoring.diagnosis.unknowns.estimation import (
    Errors,
    Fit,
    FitProblem,
    Place,
    Unknown,
    jacobian,
    left_by,
    unknowns_of,
)
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Curve

# Of a force's size, for derivatives by differences.
_STEP = 1e-4
_STATE = ("roll", "pitch", "steer", "roll_rate", "steer_rate", "speed")


class Fitting:
    """A file and the program that is to be changed until it explains it.

    Parameters
    ----------
    numbers : sequence of int
        Of the maneuvers in the file.
    times : sequence of ndarray, shape (n,)
        Rows of each maneuver that are compared [s].
    written : sequence of mapping of str to ndarray, shape (n,)
        Columns of each maneuver by key, as understood [SI].
    exact : sequence of mapping of str to ndarray, shape (n,)
        What the reference has for them, by name.
    names : mapping of str to str
        Name of the column, in its definition, by key.
    floors : mapping of (int, str) to float
        What the digits cannot tell [SI].
    program : Program
        The correct one.
    """

    def __init__(
        self, numbers: Sequence[int], times: Sequence[Array],
        written: Sequence[Mapping[str, Array]], exact: Sequence[Mapping[str, Array]],
        names: Mapping[str, str], floors: Mapping[Place, float], program: Program,
    ) -> None:  # fmt: skip
        self._numbers, self._times, self.names = numbers, times, names
        self._exact, self._program = exact, program
        self._errors = {
            (n, key): w[key] - e[names[key]]
            for n, w, e in zip(numbers, written, exact, strict=True)
            for key in w
        }
        self._scales = {
            (n, key): rms(e[names[key]]) or 1.0
            for n, w, e in zip(numbers, written, exact, strict=True)
            for key in w
        }
        self._floors = floors

    def problem(self, sensitivities: Sensitivities, forced: Errors | None = None) -> FitProblem:
        """The errors with their derivatives; by `applied.FORCES` too, with what forces leave."""
        unknowns = unknowns_of(self._numbers)
        jacobians = {}
        for n, t in zip(self._numbers, self._times, strict=True):
            found = jacobian(sensitivities, n, t, list(set(self.names.values())), unknowns)
            for number, key in self._errors:
                if number == n:
                    jacobians[number, key] = found[self.names[key]]
        if forced is not None:
            unknowns += tuple((name, None) for name in FORCES)
            slopes = _by_forces(forced)
            jacobians = {k: np.column_stack([j, *slopes[k]]) for k, j in jacobians.items()}
        return FitProblem(
            errors=self._errors, jacobians=jacobians, scales=self._scales, floors=self._floors,
            times=dict(zip(self._numbers, self._times, strict=True)),
            unknowns=unknowns, sizes=np.array([self._size(u) for u in unknowns]),
        )  # fmt: skip

    def _size(self, unknown: Unknown) -> float:
        if unknown[0] in FORCES:
            return FORCES[unknown[0]].size
        return abs(self.value(unknown)) or 1.0

    def value(self, unknown: Unknown) -> float:
        """Value of an unknown in the program [SI]."""
        name, number = unknown
        if name in FORCES:
            return 0.0
        if number is None:
            return float(self._program.bicycle[name])
        return self._state(number, {})[_STATE.index(name.removeprefix("initial_"))]

    def errors(self, simulator: Simulator) -> Errors:
        """What a changed program leaves, through its difference from the correct one."""
        correct = self._motions(simulator, {})

        def left(changes: Mapping[Unknown, float]) -> dict[Place, Array]:
            motions = self._motions(simulator, changes)
            return {
                (n, key): error - (motions[n][self.names[key]] - correct[n][self.names[key]])
                for (n, key), error in self._errors.items()
            }

        return left

    def columns(
        self, simulator: Simulator, changes: Mapping[Unknown, float]
    ) -> list[dict[str, Array]]:
        """What a changed program makes of each maneuver, in every definition."""
        correct, motions = self._motions(simulator, {}), self._motions(simulator, changes)
        return [
            {name: x + (motions[n][name] - correct[n][name]) for name, x in exact.items()}
            for n, exact in zip(self._numbers, self._exact, strict=True)
        ]

    def curves(self, problem: FitProblem, errors: Errors | None, fit: Fit) -> tuple[Curve, ...]:
        """What a fit leaves, in the column of each maneuver that it explains best."""
        left = left_by(problem, errors, fit)
        times = dict(zip(self._numbers, self._times, strict=True))
        good = {k: np.isfinite(e) for k, e in self._errors.items() if np.isfinite(e).any()}

        def curve(n: int, key: str) -> Curve:
            before, after = (np.abs(e[n, key][good[n, key]]) for e in (self._errors, left))
            unit = DEFINITIONS[key][0].unit
            return Curve(n, key, unit, times[n][good[n, key]], before, after)

        least = np.finfo(np.float64).tiny
        relief = {k: rms(self._errors[k][x]) / max(rms(left[k][x]), least) for k, x in good.items()}
        return best_explained(relief, curve)

    def _motions(
        self, simulator: Simulator, changes: Mapping[Unknown, float]
    ) -> dict[int, Mapping[str, Array]]:
        values = dict(self._program.bicycle.values)
        amounts = {name: change for (name, _), change in changes.items() if name in FORCES}
        for (name, number), change in changes.items():
            if number is None and name not in FORCES:
                x = values[name]
                values[name] = Exact(x.rational + Fraction(change), x.pi_multiple)
        bicycle = Bicycle(self._program.bicycle.name, values)
        found: dict[int, Mapping[str, Array]] = {}
        for n, t in zip(self._numbers, self._times, strict=True):
            state = self._state(n, changes)
            if state[2] != 0.0:
                k = Equations.binary64(bicycle).k
                state[1] = float(pitch_on_the_floor(k, state[0], 0.0, state[2]))
            found[n] = simulator.run(bicycle, state, t, amounts)
        return found

    def _state(self, number: int, changes: Mapping[Unknown, float]) -> list[float]:
        p = {s: float(x) for s, x in self._program.bicycle.values.items()}
        state = list(initial_state(p, self._program.starts[number]))
        for key in START:
            state[_STATE.index(key)] += changes.get((f"initial_{key}", number), 0.0)
        return state


def _by_forces(left: Errors) -> dict[Place, list[Array]]:
    """Derivatives of the columns with respect to each force's coefficient, by differences."""
    # By the integrator that has forces, so that its own error cancels.
    without = left(dict.fromkeys(((name, None) for name in FORCES), 0.0))
    found: dict[Place, list[Array]] = {k: [] for k in without}
    for name, force in FORCES.items():
        step = _STEP * force.size
        having = left({(name, None): step})
        for k, slopes in found.items():
            slopes.append(np.nan_to_num((without[k] - having[k]) / step))
    return found


def best_explained(
    relief: Mapping[tuple[int, str], float], curve: Callable[[int, str], Curve]
) -> tuple[Curve, ...]:
    """In each maneuver the column whose error falls by the largest factor."""
    ranked = sorted(relief, key=relief.__getitem__, reverse=True)
    # The first in the ranking is the last to be put into its place.
    best = dict(reversed(ranked))
    return tuple(curve(number, key) for number, key in sorted(best.items()))
