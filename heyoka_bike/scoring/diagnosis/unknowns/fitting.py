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
from heyoka_bike.scoring.diagnosis.programs.simulator import Motion, Simulator
from heyoka_bike.scoring.diagnosis.programs.start import initial_state
from heyoka_bike.scoring.diagnosis.unknowns.estimation import (
    Columns,
    Errors,
    Fit,
    FitProblem,
    Place,
    Unknown,
    begun,
    jacobian,
    left_by,
    unknowns_of,
)
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import Curve

# Motions that are remembered.
_KEPT = 500
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
    simulator : Simulator
        Without it nothing but `problem` and what is given can be asked for.
    """

    def __init__(
        self, numbers: Sequence[int], times: Sequence[Array],
        written: Sequence[Mapping[str, Array]], exact: Sequence[Mapping[str, Array]],
        names: Mapping[str, str], floors: Mapping[Place, float], program: Program,
        simulator: Simulator,
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
        self._simulator = simulator
        p = {s: float(x) for s, x in program.bicycle.values.items()}
        self._starts = {n: initial_state(p, program.starts[n]) for n in numbers}
        self._found: dict[tuple[object, ...], Mapping[str, Array]] = {}

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
        return self._starts[number][_STATE.index(name.removeprefix("initial_"))]

    def errors(
        self, several: Sequence[Mapping[Unknown, float]], window: float = 1.0
    ) -> list[Columns]:
        """What changed programs leave, through their difference from the correct one."""
        correct, *changed = self._motions([{}, *several], window)
        return [
            {
                (n, key): _less(error, motions[n][self.names[key]] - correct[n][self.names[key]])
                for (n, key), error in self._errors.items()
            }
            for motions in changed
        ]

    def columns(self, changes: Mapping[Unknown, float]) -> list[dict[str, Array]]:
        """What a changed program makes of each maneuver, in every definition."""
        correct, motions = self._motions([{}, changes], 1.0)
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
        self, several: Sequence[Mapping[Unknown, float]], window: float
    ) -> list[dict[int, Mapping[str, Array]]]:
        """Motions of changed programs, by maneuver; what is not known yet is simulated together."""
        keys = [[(window, *self._key(n, changes)) for n in self._numbers] for changes in several]
        asked: dict[tuple[object, ...], Motion] = {}
        for changes, found in zip(several, keys, strict=True):
            if all(key in self._found or key in asked for key in found):
                continue
            bicycle = self._bicycle(changes)
            amounts = {name: change for (name, _), change in changes.items() if name in FORCES}
            for n, t, key in zip(self._numbers, self._times, found, strict=True):
                if key not in self._found and key not in asked:
                    start = self._start(n, bicycle, changes)
                    asked[key] = Motion(bicycle, start, t[begun(t, window)], amounts)
        made = self._simulator.run_all(list(asked.values()))
        kept = {key: self._found[key] for found in keys for key in found if key in self._found}
        if len(self._found) > _KEPT:
            self._found = kept
        self._found.update(zip(asked, made, strict=True))
        return [
            {n: self._found[key] for n, key in zip(self._numbers, found, strict=True)}
            for found in keys
        ]

    def _key(self, number: int, changes: Mapping[Unknown, float]) -> tuple[object, ...]:
        """Equal for changes that make the same motion of a maneuver."""
        touching = {u: x for u, x in changes.items() if u[1] in (None, number)}
        return number, tuple(sorted(touching.items(), key=str))

    def _bicycle(self, changes: Mapping[Unknown, float]) -> Bicycle:
        values = dict(self._program.bicycle.values)
        for (name, number), change in changes.items():
            if number is None and name not in FORCES:
                x = values[name]
                values[name] = Exact(x.rational + Fraction(change), x.pi_multiple)
        return Bicycle(self._program.bicycle.name, values)

    def _start(
        self, number: int, bicycle: Bicycle, changes: Mapping[Unknown, float]
    ) -> list[float]:
        state = list(self._starts[number])
        for key in START:
            state[_STATE.index(key)] += changes.get((f"initial_{key}", number), 0.0)
        if state[2] != 0.0:
            k = Equations.binary64(bicycle).k
            state[1] = float(pitch_on_the_floor(k, state[0], 0.0, state[2]))
        return state


def _less(error: Array, moved: Array) -> Array:
    """An error less what explains its first rows; NaN in the others."""
    left = np.full_like(error, np.nan)
    left[: len(moved)] = error[: len(moved)] - moved
    return left


def _by_forces(left: Errors) -> dict[Place, list[Array]]:
    """Derivatives of the columns with respect to each force's coefficient, by differences."""
    # By the integrator that has forces, so that its own error cancels.
    steps = {name: _STEP * force.size for name, force in FORCES.items()}
    changed: list[dict[Unknown, float]] = [{(name, None): x} for name, x in steps.items()]
    without, *having = left([dict.fromkeys(((name, None) for name in FORCES), 0.0), *changed], 1.0)
    return {
        k: [
            np.nan_to_num((without[k] - moved[k]) / step)
            for moved, step in zip(having, steps.values(), strict=True)
        ]
        for k in without
    }


def best_explained(
    relief: Mapping[tuple[int, str], float], curve: Callable[[int, str], Curve]
) -> tuple[Curve, ...]:
    """In each maneuver the column whose error falls by the largest factor."""
    ranked = sorted(relief, key=relief.__getitem__, reverse=True)
    # The first in the ranking is the last to be put into its place.
    best = dict(reversed(ranked))
    return tuple(curve(number, key) for number, key in sorted(best.items()))
