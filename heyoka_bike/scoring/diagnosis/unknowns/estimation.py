"""Parameters and start that explain a file: as few of them as will do.

Every one, two and three of the unknowns are tried to first order (`linear_fits`), over the
beginning of the runs and over all of them, and the best are refined by simulation: Gauss-Newton on
the sum of the logarithms of the errors, with Levenberg's damping. A fit is worth a word only if it
explains far more than one of integration error ever does, and another unknown only if it explains
three times more.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.sensitivities import UNKNOWNS, Sensitivities
from heyoka_bike.scoring.diagnosis.unknowns.linear_fits import Blocks, best_subsets, blocks, solve
from heyoka_bike.scoring.measures import rms

# Fits of fifty correct programs (tests/correct_programs.py) explain a factor of at most 3, 4 and 5
# with one, two and three unknowns if they hold three maneuvers; of one maneuver, or by the start of
# one, 9, 21 and 30. A fit must explain some three times that.
_LEAST = 10.0
_LEAST_OF_ONE_MANEUVER = 25.0
# Each further unknown must explain so many times more.
_FURTHER = 3.0
_MOST = 3
# Of each number of unknowns and each window, so many are refined.
_REFINED = 3
# Parts of the run: large changes are of first order in the beginning only.
_WINDOWS = (0.15, 1.0)
# Where no fit of whole runs shows, those of so much of them are tried, each from the last: a change
# that makes another motion of ten seconds is of first order in the first.
_GROWING = (0.05, 0.1, 0.2, 0.4)
# Errors of so much of the size of a column are of another motion, not of first order.
_LARGE = 0.3
# Rows that a part must have: fewer are little more than the start.
_FEWEST_ROWS = 4
_ITERATIONS = 12
# Levenberg's damping of a step that fails, and how often it grows tenfold before giving up.
_DAMPING = 1e-3
_TRIALS = 6
# A refinement ends when the mean logarithm of the errors falls by less than this.
_CONVERGED = 1e-3
# What is left is doubled.
_DOUBLED = 2.0 * np.log(2.0)
# Differences over this part of an unknown are derivatives to some 8 digits.
_STEP = 1e-5
# What the roundoff of two simulations differs by, in scales.
_ROUNDOFF = 1e-12
# Of the rows, so many must be reached: a motion that falls may end a moment sooner than the file's.
_REACHED = 0.8

Unknown = tuple[str, int | None]
"""Name as in `sensitivities.UNKNOWNS` or `applied.FORCES`, and the maneuver whose start it is, or
None."""
Place = tuple[int, str]
"""A maneuver's number and a column's key."""
Columns = Mapping[Place, Array]
Errors = Callable[[Sequence[Mapping[Unknown, float]], float], list[Columns]]
"""From several changes of the unknowns to the errors that each leaves [SI]; NaN where the motion
has ended. What is asked for together takes less time, and so does a part of the runs: of the first
part only, given from 0 to 1, errors are needed."""


@dataclass(frozen=True, eq=False, slots=True)
class FitProblem:
    """What is to be explained.

    Attributes
    ----------
    errors : mapping of (int, str) to ndarray, shape (n,)
        Of each maneuver and column, written minus expected [SI]; NaN where a row does not count.
    jacobians : mapping of (int, str) to ndarray, shape (n, U)
        Derivatives of the column, as understood, with respect to `unknowns`.
    scales, floors : mapping of (int, str) to float
        Size of each column, and what its digits cannot tell [SI].
    times : mapping of int to ndarray, shape (n,)
        Of the rows of each maneuver [s].
    unknowns : tuple of Unknown
    sizes : ndarray, shape (U,)
        Of the unknowns; one for those that are zero.
    """

    errors: Columns
    jacobians: Columns
    scales: Mapping[Place, float]
    floors: Mapping[Place, float]
    times: Mapping[int, Array]
    unknowns: tuple[Unknown, ...]
    sizes: Array


@dataclass(frozen=True, slots=True)
class Fit:
    """Some unknowns, and how much their changes explain.

    Attributes
    ----------
    changes : mapping of Unknown to float
        [SI]
    uncertain : mapping of Unknown to float
        A further change by so much would leave twice the error [SI].
    gain, relief
        Factor by which the root mean square errors fall: geometric mean over all columns of all
        maneuvers, and over those of the maneuvers that the unknowns touch.
    """

    changes: Mapping[Unknown, float]
    uncertain: Mapping[Unknown, float]
    gain: float
    relief: float

    @property
    def is_of_one_maneuver(self) -> bool:
        """Whether the unknowns are the start of one maneuver."""
        numbers = {number for _, number in self.changes}
        return len(numbers) == 1 and None not in numbers


@dataclass(frozen=True, slots=True)
class Estimate:
    """What fits explain a file.

    Attributes
    ----------
    fits : tuple of Fit
        The best first; the file cannot tell the others from it. Empty if none is worth a word.
    gain_of_all
        What all unknowns together would explain, to first order.
    singular_values : tuple of float
        Of the weighted Jacobian with each unknown in units of its size: a relative change of a
        combination by the inverse of its singular value is as large as what the best fit leaves.
    is_first_order
        Whether nothing could be simulated.
    """

    fits: tuple[Fit, ...]
    gain_of_all: float
    singular_values: tuple[float, ...]
    is_first_order: bool


def unknowns_of(maneuvers: Sequence[int]) -> tuple[Unknown, ...]:
    """The parameters, and the start of each maneuver."""
    starts = [(f"initial_{key}", number) for number in maneuvers for key in START]
    return (*((symbol, None) for symbol in PARAMETERS), *starts)


def jacobian(
    sensitivities: Sensitivities, number: int, time: Array, names: Sequence[str],
    unknowns: Sequence[Unknown],
) -> Mapping[str, Array]:  # fmt: skip
    """Derivatives of columns of a maneuver with respect to the unknowns, shape (n, U)."""
    order = {name: i for i, name in enumerate(UNKNOWNS)}
    at = sensitivities[number]
    found = at.evaluate(np.clip(time, at.breaks[0], at.breaks[-1]), names)
    here = [i for i, (_, maneuver) in enumerate(unknowns) if maneuver in (None, number)]
    made = {}
    for name, values in found.items():
        made[name] = np.zeros((len(time), len(unknowns)))
        made[name][:, here] = np.nan_to_num(values[:, [order[unknowns[i][0]] for i in here]])
    return made


def estimate(
    problem: FitProblem, errors: Errors | None = None, worth: float = 1.0,
    is_enough: Callable[[Fit], bool] = lambda _: False,
) -> Estimate:  # fmt: skip
    """Find the fewest unknowns that explain a file.

    Parameters
    ----------
    problem : Problem
    errors : Errors, optional
        By simulation; without it everything is to first order.
    worth
        What is explained otherwise: fits must promise more to be refined.
    is_enough
        Whether a fit leaves nothing for another unknown to explain.
    """
    whole = _blocks(problem, 1.0)
    used = np.flatnonzero(whole.products.any(axis=(0, 2)))
    gain_of_all = float(solve(whole, used[None])[1][0])
    best: list[Fit] = []
    for size in range(1, _MOST + 1):
        if best and is_enough(best[0]):
            break
        known = max(worth, best[0].gain if best else 1.0)
        starts = _beginnings(problem, size)
        promise = float(best_subsets(whole, size, 1).gains[0])
        if best and errors is not None:
            further, gain = _one_more(problem, errors, best[0])
            starts = further | starts
            promise = max(promise, gain)
        if size > 1 and promise < _FURTHER * known:
            break
        found = [_Refinement(problem, errors, m).run(x) for m, x in _distinct(starts)]
        is_shown = any(_is_shown(problem, f) for f in found)
        if errors is not None and not is_shown and _is_another_motion(problem):
            found += _grown(problem, errors, size)
        found.sort(key=lambda f: -f.gain)
        if not _is_shown(problem, found[0]) or found[0].gain < (_FURTHER if best else 1.0) * known:
            continue
        best = [f for f in found if 2.0 * f.gain > found[0].gain]
    return Estimate(
        fits=tuple(best),
        gain_of_all=gain_of_all,
        singular_values=_singular_values(problem),
        is_first_order=errors is None,
    )


def left_by(problem: FitProblem, errors: Errors | None, fit: Fit) -> Columns:
    """What a fit leaves of the errors [SI]."""
    if errors is not None:
        return errors([fit.changes], 1.0)[0]
    return _first_order(problem, [fit.changes], 1.0)[0]


def in_scales(problem: FitProblem, left: Columns) -> dict[Place, float]:
    """Root mean square of what is left of each column, in its size."""
    good = {k: np.isfinite(e) for k, e in left.items()}
    return {k: rms(e[good[k]]) / problem.scales[k] for k, e in left.items() if good[k].any()}


def _first_order(
    problem: FitProblem, several: Sequence[Mapping[Unknown, float]], window: float
) -> list[Columns]:
    found: list[Columns] = []
    for changes in several:
        x = np.array([changes.get(u, 0.0) for u in problem.unknowns])
        found.append({k: e - problem.jacobians[k] @ x for k, e in problem.errors.items()})
    return found


def _is_shown(problem: FitProblem, fit: Fit) -> bool:
    """Whether integration errors are never explained so well."""
    alone = fit.is_of_one_maneuver or len(problem.times) == 1
    least = _LEAST_OF_ONE_MANEUVER if alone else _LEAST
    return fit.relief > least * _FURTHER ** (len(fit.changes) - 1)


def begun(time: Array, window: float) -> NDArray[np.bool]:
    """Rows that are in the first part of a run."""
    within: NDArray[np.bool] = time <= time[0] + window * (time[-1] - time[0])
    return within


def _begun(problem: FitProblem, columns: Columns, window: float) -> dict[Place, Array]:
    """Columns over the first part of each run alone, NaN beyond it."""
    within = {n: begun(t, window) for n, t in problem.times.items()}
    return {k: np.where(within[k[0]], x, np.nan) for k, x in columns.items()}


def _blocks(problem: FitProblem, window: float) -> Blocks:
    """Normal equations over the first part of each run, the largest hundredth left out."""
    errors, jacobians, floors = [], [], []
    for place, error in _begun(problem, problem.errors, window).items():
        good = np.isfinite(error)
        if not good.any():
            continue
        e, j, scale = error[good], problem.jacobians[place][good], problem.scales[place]
        kept = np.argsort(np.abs(e), kind="stable")[: len(e) - len(e) // 100]
        errors.append(e[kept] / scale)
        jacobians.append(j[kept] / scale)
        floors.append(problem.floors[place] / scale)
    return blocks(errors, jacobians, floors)


_Starts = dict[tuple[int, ...], Array]
"""Subsets of the unknowns, and the changes from which to refine them."""


def _beginnings(problem: FitProblem, size: int) -> _Starts:
    """The most promising subsets of a size, to first order."""
    starts: _Starts = {}
    for window in _WINDOWS:
        found = best_subsets(_blocks(problem, window), size, _REFINED)
        for members, changes in zip(found.members, found.changes, strict=True):
            starts.setdefault(tuple(members.tolist()), changes)
    return starts


def _distinct(starts: _Starts) -> list[tuple[tuple[int, ...], Array]]:
    """One beginning of each set of unknowns, whatever their order: the first."""
    found: dict[frozenset[int], tuple[tuple[int, ...], Array]] = {}
    for members, changes in starts.items():
        found.setdefault(frozenset(members), (members, changes))
    return list(found.values())


def _one_more(problem: FitProblem, errors: Errors, best: Fit) -> tuple[_Starts, float]:
    """The unknowns that most promise to explain what a fit leaves, and the gain they promise."""
    slopes = {k: np.zeros_like(j) for k, j in problem.jacobians.items()}
    # The starts of different maneuvers are changed at once.
    names = dict.fromkeys(u for u, _ in problem.unknowns)
    of_names = [{n: i for i, (u, n) in enumerate(problem.unknowns) if u == x} for x in names]
    steps = [_STEP * float(problem.sizes[next(iter(columns.values()))]) for columns in of_names]
    moved = [
        {**best.changes, **{(name, n): best.changes.get((name, n), 0.0) + step for n in columns}}
        for name, columns, step in zip(names, of_names, steps, strict=True)
    ]
    left, *changed = errors([best.changes, *moved], 1.0)
    for columns, step, there in zip(of_names, steps, changed, strict=True):
        for place, error in there.items():
            i = columns.get(None, columns.get(place[0]))
            if i is not None:
                slopes[place][:, i] = np.nan_to_num((left[place] - error) / step)
    around = replace(problem, errors=left, jacobians=slopes)
    members = [i for i, u in enumerate(problem.unknowns) if u in best.changes]
    start = np.array([best.changes[problem.unknowns[i]] for i in members])
    subsets = np.array([[*members, i] for i in range(len(problem.unknowns)) if i not in members])
    changes, gains = solve(_blocks(around, 1.0), subsets)
    order = np.argsort(-gains, kind="stable")[:_REFINED]
    starts = {tuple(subsets[k].tolist()): changes[k] + np.append(start, 0.0) for k in order}
    return starts, best.gain * float(gains[order[0]])


def _is_another_motion(problem: FitProblem) -> bool:
    return max(in_scales(problem, problem.errors).values(), default=0.0) > _LARGE


def _grown(problem: FitProblem, errors: Errors, size: int) -> list[Fit]:
    """Fits of whole runs that begin as fits of the first moments."""
    rows = min(len(t) for t in problem.times.values())
    windows = [x for x in _GROWING if x * rows >= _FEWEST_ROWS]
    if not windows:
        return []
    first = best_subsets(_blocks(problem, windows[0]), size, _REFINED)
    found = []
    for members, changes in zip(first.members, first.changes, strict=True):
        chosen, x = tuple(members.tolist()), changes
        for window in windows:
            part = replace(problem, errors=_begun(problem, problem.errors, window))
            fit = _Refinement(part, errors, chosen, window).run(x)
            x = np.array([fit.changes[problem.unknowns[i]] for i in chosen])
        found.append(_Refinement(problem, errors, chosen).run(x))
    return found


class _Refinement:
    """Gauss-Newton over some of the unknowns."""

    def __init__(
        self, problem: FitProblem, errors: Errors | None, members: tuple[int, ...],
        window: float = 1.0,
    ) -> None:  # fmt: skip
        self._problem, self._window = problem, window
        self._members = list(members)
        self._errors = errors or partial(_first_order, problem)
        self._steps = _STEP * problem.sizes[self._members]
        self._places = list(problem.errors)

    def run(self, changes: Array) -> Fit:
        x = np.zeros(len(self._members))
        best, first, *_ = self._left(x, changes, *self._around(changes))
        if self._cost(first) < self._cost(best):
            x, best = changes, first
        for _ in range(_ITERATIONS):
            moments, products = self._normal(x, best)
            weights = 1.0 / self._squares(best)
            vector = np.einsum("b,bi->i", weights, moments)
            matrix = np.einsum("b,bij->ij", weights, products)
            scale = np.sqrt(np.maximum(np.diag(matrix), np.finfo(np.float64).tiny))
            damping, gained = 0.0, 0.0
            for _ in range(_TRIALS):
                damped = matrix / np.outer(scale, scale) + (damping + 1e-12) * np.eye(len(x))
                tried = x + np.linalg.solve(damped, vector / scale) / scale
                # Most first steps succeed: then what comes next has been asked for with them.
                left, *_ = self._left(tried, *(() if damping else self._around(tried)))
                gained = self._cost(best) - self._cost(left)
                if gained > 0:
                    x, best = tried, left
                    break
                damping = max(10 * damping, _DAMPING)
            if gained < _CONVERGED:
                break
        return self._fit(x, best)

    def _fit(self, x: Array, left: Columns) -> Fit:
        problem = self._problem
        chosen = [problem.unknowns[i] for i in self._members]
        logs = np.log(self._squares(problem.errors) / self._squares(left)) / 2
        numbers = {number for _, number in chosen}
        touched = [None in numbers or number in numbers for number, _ in self._places]
        _, products = self._normal(x, left)
        shares = np.diagonal(products, axis1=1, axis2=2) / self._squares(left)[:, None]
        return Fit(
            changes=dict(zip(chosen, x.tolist(), strict=True)),
            uncertain=dict(zip(chosen, map(_doubling, shares.T), strict=True)),
            gain=float(np.exp(np.mean(logs))),
            relief=float(np.exp(np.mean(logs[touched]))),
        )

    def _left(self, *several: Array) -> list[Columns]:
        unknowns = [self._problem.unknowns[i] for i in self._members]
        changes = [dict(zip(unknowns, x.tolist(), strict=True)) for x in several]
        return self._errors(changes, self._window)

    def _around(self, x: Array) -> list[Array]:
        return [x + np.eye(len(x))[i] * step for i, step in enumerate(self._steps)]

    def _squares(self, left: Columns) -> Array:
        """Mean square of what is left of each block, in scales, not below what can be seen.

        Infinite if a motion does not go about as far as the rows do.
        """
        found = []
        for place, error in self._problem.errors.items():
            good = np.isfinite(error)
            scale = self._problem.scales[place]
            rest = left[place][good]
            reached = np.isfinite(rest)
            if good.any() and np.mean(reached) < _REACHED:
                return np.full(len(self._places), np.inf)
            square = np.mean((rest[reached] / scale) ** 2) if good.any() else 0.0
            found.append(square + (self._problem.floors[place] / scale) ** 2)
        return np.array(found)

    def _cost(self, left: Columns) -> float:
        """Mean logarithm of what is left."""
        return float(np.mean(np.log(self._squares(left)))) / 2

    def _normal(self, x: Array, here: Columns) -> tuple[Array, Array]:
        """Moments and products of each block at x, by differences."""
        moved = self._left(*self._around(x))
        moments, products = [], []
        for place, error in self._problem.errors.items():
            good = np.isfinite(error)
            scale = self._problem.scales[place]
            e = np.nan_to_num(here[place][good]) / scale
            j = np.array(
                [
                    _seen(here[place][good] - m[place][good], scale) / step / scale
                    for m, step in zip(moved, self._steps, strict=True)
                ]
            ).reshape(len(x), -1)
            count = max(len(e), 1)
            moments.append(j @ e / count)
            products.append(j @ j.T / count)
        return np.array(moments), np.array(products)


def _seen(difference: Array, scale: float) -> Array:
    """A difference of two motions, zero where it is no more than their roundoff."""
    size = np.fmax.reduce(np.abs(difference), initial=0.0)
    found: Array = np.nan_to_num(difference)
    return found if size > _ROUNDOFF * scale else np.zeros_like(found)


def _doubling(shares: Array) -> float:
    """The change that leaves twice the error, from its mean square in what is left, by block."""
    low, high = 0.0, 1.0
    while np.mean(np.log1p(shares * high**2)) < _DOUBLED and high < 1e12:
        high *= 2.0
    for _ in range(40):
        middle = (low + high) / 2
        if np.mean(np.log1p(shares * middle**2)) < _DOUBLED:
            low = middle
        else:
            high = middle
    return high


def _singular_values(problem: FitProblem) -> tuple[float, ...]:
    """Of the Jacobian in units of the unknowns' sizes and of each column's error."""
    rows = []
    for place, error in problem.errors.items():
        good = np.isfinite(error)
        if good.any():
            size = np.sqrt(np.mean(error[good] ** 2) + problem.floors[place] ** 2)
            share = problem.jacobians[place][good] * problem.sizes / size
            rows.append(share / np.sqrt(len(share)))
    # The triangle has the same singular values as all the rows.
    triangle = np.linalg.qr(np.concatenate(rows), mode="r") / np.sqrt(len(rows))
    return tuple(np.linalg.svd(triangle, compute_uv=False).tolist())
