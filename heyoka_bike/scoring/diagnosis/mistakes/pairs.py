"""Pairs of mistakes that are worth a simulation, by superposition of what each changes alone.

What is left of the file when one mistake is taken out is compared with what the other one changes
in the correct motion. For small changes that is exact; for large ones it holds for a while, so that
the first parts of the runs are ranked, too.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.numbers.double import Array

# Of the longest run; of each, this many pairs are promising.
_WINDOWS = (0.1, 0.3, 1.0)
_PROMISING = 16
# One row of so many is enough here.
_THINNED = 2
# A pair must explain so much more than either alone, mean of the logarithms over all columns: two
# rates of eight columns that get better by a factor of 1.5.
_BETTER = 0.1
# An error less than this part of the column's size makes no pair more promising.
_SMALLEST = 1e-12


@dataclass(frozen=True, eq=False, slots=True)
class Alone:
    """A mistake alone: what it makes, and how the file is understood beside it.

    Attributes
    ----------
    expected : sequence of mapping of str to ndarray
        Of each maneuver, every column by name.
    names : mapping of str to str
        The definition of each written column, by key.
    written : sequence of mapping of str to ndarray
        The columns of the file by key, SI, at the same rows; NaN where there is none.
    """

    expected: Sequence[Mapping[str, Array]]
    names: Mapping[str, str]
    written: Sequence[Mapping[str, Array]]


def promising(
    correct: Sequence[Mapping[str, Array]], alone: Sequence[Alone], times: Sequence[Array]
) -> list[tuple[int, int]]:
    """Pairs of indices of `alone`, the most promising of each window first.

    Parameters
    ----------
    correct
        What the correct program makes, as `Alone.expected`.
    alone : sequence of Alone
    times : sequence of ndarray
        Of the rows of each maneuver [s].
    """
    names = [c.name for key in BENCHMARK_COLUMNS for c in DEFINITIONS[key] if c.name in correct[0]]
    place = {name: i for i, name in enumerate(names)}
    base = _joined(correct, names, times)
    made = np.stack([_joined(r.expected, names, times) for r in alone])
    # A motion that ends changes nothing more.
    changes = np.nan_to_num(made - base)
    windows = _windows([t[::_THINNED] for t in times])
    size = np.nanmax(np.abs(base), axis=1)
    score = np.empty((len(alone), len(alone), len(_WINDOWS)))
    single = np.empty((len(alone), len(_WINDOWS)))
    for i, r in enumerate(alone):
        chosen = [place[name] for name in r.names.values()]
        left = _joined(r.written, list(r.names), times) - made[i, chosen]
        score[i] = _scores(_relative(left - changes[:, chosen], size[chosen]), windows)
        single[i] = _scores(_relative(left[None], size[chosen]), windows)[0]
    score = np.fmin(score, score.transpose(1, 0, 2))
    score[score > np.minimum(single[:, None], single[None]) - _BETTER] = np.inf
    found: dict[tuple[int, int], None] = {}
    first, second = np.triu_indices(len(alone), 1)
    for w in range(len(_WINDOWS)):
        ranked = score[first, second, w]
        order = [k for k in np.argsort(ranked)[:_PROMISING] if ranked[k] < np.inf]
        found.update(dict.fromkeys(zip(first[order].tolist(), second[order].tolist(), strict=True)))
    return list(found)


def _joined(
    parts: Sequence[Mapping[str, Array]], names: Sequence[str], times: Sequence[Array]
) -> Array:
    """Columns of all maneuvers one after the other, thinned; shape (names, rows)."""
    found = [
        np.stack([p.get(name, np.full(len(t), np.nan))[::_THINNED] for name in names])
        for p, t in zip(parts, times, strict=True)
    ]
    return np.concatenate(found, axis=1)


def _windows(times: Sequence[Array]) -> list[list[slice]]:
    """The rows of each maneuver within each window, in joined columns."""
    longest = max(float(t[-1]) for t in times)
    starts = np.cumsum([0, *(len(t) for t in times)])
    return [
        [
            slice(int(begin), int(begin + np.searchsorted(t, part * longest, side="right")))
            for begin, t in zip(starts, times, strict=False)
        ]
        for part in _WINDOWS
    ]


def _relative(errors: Array, size: Array) -> Array:
    """Errors, of shape (pairs, columns, rows), in sizes of the columns."""
    relative: Array = errors / np.where(size > 0, size, 1.0)[:, None]
    return relative


def _scores(errors: Array, windows: Sequence[Sequence[slice]]) -> Array:
    """Mean logarithm of the errors over columns and maneuvers; shape (pairs, windows).

    Errors have shape (pairs, columns, rows); NaN where the file has nothing to compare.
    """
    known = np.isfinite(errors[0])
    with np.errstate(over="ignore"):
        squares = np.where(known, errors, 0.0) ** 2
    found = []
    for slices in windows:
        logs = [
            np.log(squares[..., s].sum(axis=-1) / np.maximum(known[:, s].sum(axis=-1), 1)
                   + _SMALLEST**2)
            for s in slices
        ]  # fmt: skip
        found.append(np.mean(logs, axis=(0, 2)))
    return np.stack(found, axis=-1)
