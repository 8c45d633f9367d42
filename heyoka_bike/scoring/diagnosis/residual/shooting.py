"""Values whose simulated motions are those of a file: Gauss and Newton's method on whole runs.

The values are those of a few parameters and forces, which the equations of motion gave along the
file's own motion. What is minimised is the sum of the logarithms of what is left in roll, steer,
their rates and the speed of each maneuver, each in parts of its size.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import spread
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS
from heyoka_bike.scoring.diagnosis.programs.program import (
    Mistake,
    Program,
    beginning,
    changed,
    other_values,
)
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.scoring.diagnosis.residual.linear_fits import (
    Errors,
    gauss_newton,
    left,
    linearised,
    solve,
    uncertain,
)
from heyoka_bike.scoring.diagnosis.residual.observed import STATE, Observed
from heyoka_bike.scoring.diagnosis.residual.residual import size_of

# Values that are found together.
_MOST = 3
# What leaves so small a part is known well enough.
_ENOUGH = 1e-6
_COMPARED = 251
# Nothing is seen of a column below this part.
_NOTHING = 1e-12


class Shooting:
    """Whole runs of changed programs, compared with the motions of a file."""

    def __init__(self, motions: Sequence[Observed], right: Program, simulator: Simulator) -> None:
        self._motions, self._right, self._simulator = motions, right, simulator
        self._rows = [spread(len(m.time), _COMPARED) for m in motions]
        self._floors = np.full(len(motions) * len(STATE), _NOTHING)

    def refined(self, several: Iterable[Mistake], *, with_others: bool = False) -> list[Mistake]:
        """Values near some, that whole runs show.

        Or, of rivals, those that leave nothing, or also the single one with others beside it.
        """
        found = []
        for mistake in several:
            found.append(self._of_values(mistake.changes, mistake))
            if with_others and found[-1][1] < _ENOUGH:
                return [found[-1][0]]
        alone = next((x for x in found if len(x[0].found) == 1), None)
        if with_others and alone is not None:
            found.append(self._with_others(*alone))
        return [mistake for mistake, _ in found]

    def _with_others(self, best: Mistake, left: float) -> tuple[Mistake, float]:
        """Add the parameter that leaves least, as long as it leaves far less."""
        while len(best.found) < _MOST:
            more, rest = self._of_values(self._further(best.changes))
            fall = WEIGHTS.values * len(self._motions) * float(np.log(left / rest))
            cost = WEIGHTS.fitted + WEIGHTS.unknown + WEIGHTS.said
            if fall < cost or left < WEIGHTS.beside * rest:
                break
            best, left = more, rest
        return best, left

    def _of_values(
        self, changes: Mapping[str, float], known: Mistake | None = None
    ) -> tuple[Mistake, float]:
        """Values nearby that leave least, and how much that is; those that are known if enough."""
        errors, start = self._errors(changes), np.array([*changes.values()])
        if known is not None:
            near = left(errors([start])[0], self._floors)
            if near < _ENOUGH:
                return known, near
        x, b = gauss_newton(errors, start, self._sizes(changes), self._floors)
        found, off = (dict(zip(changes, v, strict=True)) for v in (x.tolist(), uncertain(b)))
        return other_values(found, off, self._right), b.left

    def _further(self, changes: Mapping[str, float]) -> dict[str, float]:
        """Values with one more parameter, that to first order leaves least of what these leave."""
        every = {**changes, **{name: 0.0 for name in PARAMETERS if name not in changes}}
        names, x = [*every], np.array([*every.values()])
        b = linearised(self._errors(names), x, self._sizes(names), self._floors)
        known = range(len(changes))
        subsets = np.array([[*known, i] for i in range(len(changes), len(names))])
        steps, gains = solve(b, subsets)
        i = int(np.argmax(gains))
        values = x[subsets[i]] + steps[i]
        return dict(zip([names[k] for k in subsets[i]], values.tolist(), strict=True))

    def _sizes(self, names: Iterable[str]) -> Array:
        return np.array([size_of(self._right.bicycle, name) for name in names])

    def _errors(self, names: Iterable[str]) -> Errors:
        """From values to the errors of their programs in the states, in parts of each column."""

        def errors(several: Sequence[Array]) -> list[list[Array]]:
            asked = []
            for x in several:
                p = changed(self._right, dict(zip(names, x.tolist(), strict=True)))
                asked += [
                    AskedMotion(p.bicycle, beginning(p, m.number), m.time[rows], dict(p.amounts))
                    for m, rows in zip(self._motions, self._rows, strict=True)
                ]
            made = iter(self._simulator.run_all(asked))
            return [
                [
                    _part(columns[key], m.state[key][rows])
                    for m, rows, columns in zip(self._motions, self._rows, made, strict=False)
                    for key in STATE
                ]
                for _ in several
            ]

        return errors


def _part(values: Array, written: Array) -> Array:
    """What is missing from a column in parts of its size; all of it after the motion's end."""
    size = float(np.sqrt(np.mean(written**2))) + float(np.finfo(np.float64).tiny)
    return np.nan_to_num((written - values) / size, nan=1.0, posinf=1.0, neginf=1.0)
