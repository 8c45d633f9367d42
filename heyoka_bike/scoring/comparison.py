"""Written values minus the reference, as exactly as their errors need.

Few values are compared with the reference in hi + lo. Very many are compared in plain binary64
first, good to 1e-15 of the column's scale, then with `evaluate_many`, good to 1e-27, and with all
digits only where the error is so small that this would show: the error of a column is always right
to a tenth of a percent of its largest.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array, Double, two_sum
from heyoka_bike.scoring.alignment import Part

FEW = 100_000
"""Up to so many values hi + lo of the reference is always evaluated, and by one thread."""

# Errors, in scales, from which on the plain reference will do, and that of `evaluate_many`.
_PLAIN_WILL_DO, _MANY_WILL_DO = 1e-12, 1e-24
# Rows at a time.
_BLOCK = 32_768


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """Values [SI] and the column of the reference that they are compared with.

    Attributes
    ----------
    values : pair of ndarray, shape (n,)
        hi + lo; NaN where there is none.
    name
        Column of the reference.
    """

    values: Double
    name: str


def is_small(part: Part) -> bool:
    """Whether a part has few values."""
    return len(part.time) * len(part.values) <= FEW


def errors(part: Part, candidates: Sequence[Candidate]) -> list[Array]:
    """Values minus the reference at each row, of shape (n,); NaN where there is no value."""
    time: Double = (part.time, part.time_lo)
    names = list(dict.fromkeys(c.name for c in candidates))
    if is_small(part):
        exact = part.reference.continued(time, names)
        return [_difference(c.values, (exact[c.name], exact.lo[c.name])) for c in candidates]
    found = [np.empty(len(part.time)) for _ in candidates]
    for rows in _blocks(part):
        near = part.reference.approximate(part.time[rows], names)
        for c, error in zip(candidates, found, strict=True):
            np.subtract(c.values[0][rows], near[c.name], out=error[rows])
    for evaluate, will_do in (
        (part.reference.evaluate_many, _PLAIN_WILL_DO),
        (part.reference.continued, _MANY_WILL_DO),
    ):
        close = [
            i
            for i, c in enumerate(candidates)
            if _largest(found[i]) < will_do * part.reference.scale(c.name)
        ]
        names = list(dict.fromkeys(candidates[i].name for i in close))
        for rows in _blocks(part) if close else ():
            exact = evaluate((time[0][rows], time[1][rows]), names)
            for i in close:
                c = candidates[i]
                values = c.values[0][rows], c.values[1][rows]
                found[i][rows] = _difference(values, (exact[c.name], exact.lo[c.name]))
    return found


def largest_errors(part: Part, candidates: Sequence[Candidate]) -> list[float]:
    """Largest absolute error of each candidate, in plain binary64."""
    names = list(dict.fromkeys(c.name for c in candidates))
    found = [0.0] * len(candidates)
    for rows in _blocks(part):
        near = part.reference.approximate(part.time[rows], names)
        for i, c in enumerate(candidates):
            found[i] = max(found[i], _largest(c.values[0][rows] - near[c.name]))
    return found


def _blocks(part: Part) -> Iterator[slice]:
    for start in range(0, len(part.time), _BLOCK):
        yield slice(start, start + _BLOCK)


def _difference(values: Double, exact: Double) -> Array:
    difference, rest = two_sum(values[0], -exact[0])
    error: Array = difference + (rest + (values[1] - exact[1]))
    return error


def _largest(error: Array) -> float:
    return float(np.fmax.reduce(np.abs(error), initial=0.0))
