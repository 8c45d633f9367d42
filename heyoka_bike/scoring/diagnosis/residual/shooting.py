"""Values whose simulated motions are those of a file: Gauss and Newton's method on whole runs.

The values are those of a few parameters and forces, which the equations of motion gave along the
file's own motion. What is minimised is the sum of the logarithms of what is left in roll, steer,
their rates and the speed of each maneuver, each in parts of its size.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import spread
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS
from heyoka_bike.scoring.diagnosis.programs.program import Program, beginning, changed
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.scoring.diagnosis.residual.causes import Cause
from heyoka_bike.scoring.diagnosis.residual.linear_fits import Blocks, blocks, solve, uncertain
from heyoka_bike.scoring.diagnosis.residual.observed import STATE as KEYS
from heyoka_bike.scoring.diagnosis.residual.observed import Observed
from heyoka_bike.scoring.diagnosis.residual.terms import size_of

# Values that are found together.
_MOST = 3
_STEPS = 3
# What leaves so small a part is known well enough.
_ENOUGH = 1e-6
_COMPARED = 251
# Of a value's size, for derivatives by differences.
_SHIFT = 1e-6
# Nothing is seen of a column, or of a step, below this part.
_NOTHING = 1e-12

Errors = Callable[[Sequence[Array]], list[Array]]
"""From several sets of values to the error that each leaves, shape (blocks, rows)."""


class Shooting:
    """Whole runs of changed programs, compared with the motions of a file."""

    def __init__(self, motions: Sequence[Observed], right: Program, simulator: Simulator) -> None:
        self._motions, self._right, self._simulator = motions, right, simulator
        self._written = [np.array([m.state[key][_rows(m)] for key in KEYS]) for m in motions]

    def refined(self, causes: Sequence[Cause], *, with_others: bool = False) -> list[Cause]:
        """Causes with the values that whole runs show.

        Or, of rivals, that which leaves nothing, or also the single one with others beside it.
        """
        found = []
        for c in causes:
            found.append(self._of_values(c, c.changes))
            if with_others and found[-1][1] < _ENOUGH:
                return [found[-1][0]]
        alone = next((x for x in found if len(x[0].changes) == 1), None)
        if with_others and alone is not None:
            found.append(self._with_others(*alone))
        return [cause for cause, _ in found]

    def _with_others(self, best: Cause, left: float) -> tuple[Cause, float]:
        while len(best.changes) < _MOST:
            more, rest = self._of_values(best, self._further(best.changes))
            fall = WEIGHTS.values * len(self._motions) * float(np.log(left / rest))
            cost = WEIGHTS.fitted + WEIGHTS.unknown + WEIGHTS.said
            if fall < cost or left < WEIGHTS.beside * rest:
                break
            best, left = more, rest
        return best, left

    def _of_values(self, cause: Cause, changes: Mapping[str, float]) -> tuple[Cause, float]:
        """Values nearby that leave least, and how much that is."""
        names, start = list(changes), np.array(list(changes.values()))
        errors = self._errors(names)
        near = _size(errors([start])[0])
        if changes == cause.changes and near < _ENOUGH:
            return cause, near
        x, left, slopes = _shoot(errors, start, self._sizes(names))
        found = dict(zip(names, x.tolist(), strict=True))
        normal = _normal(left, slopes)
        off = dict(zip(names, uncertain(normal, normal.squares + normal.floors), strict=True))
        return replace(cause, changes=found, uncertain=off), _size(left)

    def _further(self, changes: Mapping[str, float]) -> dict[str, float]:
        """Values with one more parameter, that to first order leaves least of what these leave."""
        names = [*changes, *(name for name in PARAMETERS if name not in changes)]
        known = np.arange(len(changes))
        x = np.array([changes.get(name, 0.0) for name in names])
        left, slopes = _derivatives(self._errors(names), x, self._sizes(names))
        subsets = np.array([[*known, i] for i in range(len(changes), len(names))])
        steps, gains = solve(_normal(left, slopes), subsets)
        i = int(np.argmax(gains))
        values = x[subsets[i]] + steps[i]
        return dict(zip([names[k] for k in subsets[i]], values.tolist(), strict=True))

    def _sizes(self, names: Sequence[str]) -> Array:
        return np.array([size_of(self._right.bicycle, name) for name in names])

    def _errors(self, names: Sequence[str]) -> Errors:
        """Return the errors of programs in the states of all motions, in parts of each column."""

        def errors(several: Sequence[Array]) -> list[Array]:
            asked = []
            for x in several:
                p = changed(self._right, dict(zip(names, x.tolist(), strict=True)))
                asked += [
                    AskedMotion(
                        p.bicycle, beginning(p, m.number), m.time[_rows(m)], dict(p.amounts)
                    )
                    for m in self._motions
                ]
            made = iter(self._simulator.run_all(asked))
            return [np.concatenate([_parts(next(made), w) for w in self._written]) for _ in several]

        return errors


def _rows(motion: Observed) -> NDArray[np.intp]:
    return spread(len(motion.time), _COMPARED)


def _parts(columns: Mapping[str, Array], written: Array) -> Array:
    """Errors in parts of each column, shape (5, compared); those after its end are whole."""
    size = np.sqrt(np.mean(written**2, axis=1, keepdims=True)) + np.finfo(np.float64).tiny
    error = (np.array([columns[key] for key in KEYS]) - written) / size
    error = np.nan_to_num(error, nan=1.0, posinf=1.0, neginf=1.0)
    return np.pad(error, ((0, 0), (0, _COMPARED - error.shape[1])))


def _shoot(errors: Errors, x: Array, sizes: Array) -> tuple[Array, Array, Array]:
    """Values that leave least, what they leave, and its derivatives, shape (blocks, rows, n).

    The values are near enough for the derivatives to stay as they are at first.
    """
    left, slopes = _derivatives(errors, x, sizes)
    for _ in range(_STEPS):
        step = solve(_normal(left, slopes), np.arange(len(x))[None])[0][0]
        (rest,) = errors([x + step])
        if not _size(rest) < _size(left):
            break
        x, left = x + step, rest
    return x, left, slopes


def _derivatives(errors: Errors, x: Array, sizes: Array) -> tuple[Array, Array]:
    here, *moved = errors([x, *(x + np.diag(_SHIFT * sizes))])
    return here, (np.stack(moved, -1) - here[..., None]) / (_SHIFT * sizes)


def _normal(left: Array, slopes: Array) -> Blocks:
    return blocks(list(left), [-j for j in slopes], [_NOTHING] * len(left))


def _size(left: Array) -> float:
    """Geometric mean over the blocks of the root mean square that is left."""
    return float(np.exp(np.mean(np.log(np.mean(left**2, axis=1) + _NOTHING**2)) / 2))
