"""Values whose simulated motions are those of a file: Gauss and Newton's method on whole runs.

The values are those of a few parameters and forces, which the equations of motion gave along the
file's own motion, or the start of a maneuver, of which its equations say nothing. What is minimised
is the sum of the logarithms of what is left in roll, steer, their rates and the speed of each
maneuver, each in parts of its size.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import spread
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS
from heyoka_bike.scoring.diagnosis.programs.beginning import beginning
from heyoka_bike.scoring.diagnosis.programs.program import (
    Found,
    Mistake,
    Program,
    changed,
    other_start,
)
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.scoring.diagnosis.programs.start import STATE
from heyoka_bike.scoring.diagnosis.residual.causes import Cause
from heyoka_bike.scoring.diagnosis.residual.linear_fits import Blocks, best_subsets, blocks, solve
from heyoka_bike.scoring.diagnosis.residual.observed import STATE as KEYS
from heyoka_bike.scoring.diagnosis.residual.observed import Observed
from heyoka_bike.scoring.diagnosis.residual.terms import size_of

# Each further value of a start must explain so many times more, and the start that is read off the
# rows explain so much; there are so many values at the most.
_FURTHER, _MOST = 3.0, 3
# By how much the right start of one maneuver must be better than the one that is given: errors of
# correct programs are explained by a factor of up to 9 by one value of it, and 30 by three.
_START = 25.0
_PLACES = [STATE.index(name) for name in START]
_STEPS = 3
# What leaves so small a part is known well enough by the equations alone.
_ENOUGH = 1e-6
_COMPARED = 251
# Of a value's size, for derivatives by differences.
_SHIFT = 1e-6
# Nothing is seen of a column, or of a step, below this part.
_NOTHING = 1e-12

Errors = Callable[[Sequence[Array]], list[Array]]
"""From several sets of values to what each leaves, shape (blocks, rows)."""


class Shooting:
    """Whole runs of changed programs, compared with the motions of a file."""

    def __init__(self, motions: Sequence[Observed], right: Program, simulator: Simulator) -> None:
        self._motions, self._right, self._simulator = motions, right, simulator

    def refined(self, cause: Cause, *, with_others: bool = False) -> Cause:
        """A cause with the values that whole runs show, and with others if they show those."""
        best, left = self._of_values(cause, cause.changes)
        while with_others and len(best.changes) < _MOST:
            more, rest = self._of_values(cause, self._further(best.changes))
            fall = WEIGHTS.values * len(self._motions) * float(np.log(left / rest))
            if not fall > WEIGHTS.fitted + WEIGHTS.unknown + WEIGHTS.said:
                break
            best, left = more, rest
        return best

    def _of_values(self, cause: Cause, changes: Mapping[str, float]) -> tuple[Cause, float]:
        """Values nearby that leave least, and how much that is."""
        names, start = list(changes), np.array(list(changes.values()))
        errors = self._errors(names)
        near = _size(errors([start])[0])
        if changes == cause.changes and near < _ENOUGH:
            return cause, near
        x, left, slopes = _shoot(errors, start, self._sizes(names))
        found = dict(zip(names, x.tolist(), strict=True))
        off = dict(zip(names, _uncertain(left, slopes).tolist(), strict=True))
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
        return self._left_by(
            self._motions,
            lambda x: changed(self._right, dict(zip(names, x.tolist(), strict=True))),
        )

    def start(self) -> Mistake | None:
        """The start that the file has, if it is another one, by the right equations."""
        began = [(m, read) for m in self._motions if (read := m.beginning()) is not None]
        # The first runs of all maneuvers are made together, and kept.
        asked = [x for m, read in began for change in (0.0 * read, read - self._given(m))
                 for x in self._asked([m], self._started(m, change))]  # fmt: skip
        self._simulator.run_all(asked)
        found = [x for motion, read in began for x in self._start_of(motion, read)]
        return other_start(found) if found else None

    def _given(self, motion: Observed) -> Array:
        state = beginning(self._right, motion.number)
        return np.array([state[i] for i in _PLACES])

    def _started(self, motion: Observed, change: Array) -> Program:
        """The right program, that starts otherwise."""
        n = motion.number
        added = tuple(zip(_PLACES, change.tolist(), strict=True))
        started = replace(self._right.starts[n], added=added)
        return replace(self._right, starts={**self._right.starts, n: started})

    def _start_of(self, motion: Observed, read: Array) -> list[Found]:
        """What differs in the start of a maneuver from what is given."""
        n, given = motion.number, self._given(motion)
        errors = self._left_by([motion], lambda x: self._started(motion, x))
        both = [0.0 * read, read - given]
        before, near = (_size(left) for left in errors(both))
        if not before > _FURTHER * near:
            return []
        x, left, slopes = _shoot(errors, both[1], np.ones(len(START)))
        if not before > _START * _size(left):
            return []
        # As few as will do, to first order around the start that was found.
        rest = left - slopes @ x
        normal = _normal(rest, slopes)
        known, found = _START / _FURTHER, []
        for size in range(1, _MOST + 1):
            best = best_subsets(normal, size, 1)
            if best.gains[0] > _FURTHER * known:
                known, members = float(best.gains[0]), best.members[0]
                part = slopes[:, :, members]
                off = _uncertain(rest + part @ best.changes[0], part)
                found = [
                    Found(f"initial_{START[i]}", n, float(given[i] + dx), float(given[i]), float(u))
                    for i, dx, u in zip(members, best.changes[0], off, strict=True)
                ]
        return found

    def _left_by(self, motions: Sequence[Observed], program: Callable[[Array], Program]) -> Errors:
        """What programs leave of the states of motions, in parts of each column."""
        written = [_states(m.state, _rows(m)) for m in motions]

        def errors(several: Sequence[Array]) -> list[Array]:
            asked = [x for p in map(program, several) for x in self._asked(motions, p)]
            made = iter(self._simulator.run_all(asked))
            return [np.concatenate([_parts(next(made), w) for w in written]) for _ in several]

        return errors

    def _asked(self, motions: Sequence[Observed], p: Program) -> list[AskedMotion]:
        return [
            AskedMotion(p.bicycle, beginning(p, m.number), m.time[_rows(m)], dict(p.amounts))
            for m in motions
        ]


def _rows(motion: Observed) -> NDArray[np.intp]:
    return spread(len(motion.time), _COMPARED)


def _states(columns: Mapping[str, Array], rows: NDArray[np.intp] | slice = slice(None)) -> Array:
    return np.array([columns[key][rows] for key in KEYS])


def _parts(columns: Mapping[str, Array], written: Array) -> Array:
    """Errors in parts of each column, shape (5, compared); those after its end are whole."""
    size = np.sqrt(np.mean(written**2, axis=1, keepdims=True)) + np.finfo(np.float64).tiny
    error = np.nan_to_num((_states(columns) - written) / size, nan=1.0, posinf=1.0, neginf=1.0)
    return np.pad(error, ((0, 0), (0, _COMPARED - error.shape[1])))


def _shoot(errors: Errors, x: Array, sizes: Array) -> tuple[Array, Array, Array]:
    """Values that leave least, what they leave, and its derivatives, shape (blocks, rows, n).

    The values are near enough for the derivatives to stay as they are at first.
    """
    left, slopes = _derivatives(errors, x, sizes)
    for _ in range(_STEPS):
        weights = 1.0 / (np.sqrt(np.mean(left**2, axis=1)) + _NOTHING)
        matrix = (slopes * sizes * weights[:, None, None]).reshape(-1, len(x))
        step = np.linalg.lstsq(matrix, -(left * weights[:, None]).ravel(), rcond=None)[0] * sizes
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


def _uncertain(left: Array, slopes: Array) -> Array:
    """Changes that would leave twice as much, whatever the others are."""
    squares = np.mean(left**2, axis=1) + _NOTHING**2
    rows = slopes.shape[1] * len(left)
    products = np.einsum("bri,brj,b->ij", slopes, slopes, 1.0 / squares) / rows
    size = np.sqrt(np.maximum(np.diagonal(products), np.finfo(np.float64).tiny))
    inverse = np.linalg.pinv(products / np.outer(size, size), hermitian=True)
    found: Array = np.sqrt(3.0 * np.diagonal(inverse)) / size
    return found
