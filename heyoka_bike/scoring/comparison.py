"""Written values minus the reference, as exactly as their errors need.

Few values are compared with the reference in hi + lo. Very many are compared in plain binary64
first, good to 1e-15 of the column's scale, then with `evaluate_many`, good to 1e-27, and with all
digits only where the error is so small that this would show: the error of a column is always right
to a tenth of a percent of its largest.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from heyoka_bike.numbers.double import Array, Double, two_sum
from heyoka_bike.reference.values import Values
from heyoka_bike.scoring.alignment import Part

FEW = 100_000
"""Up to so many values hi + lo of the reference is always evaluated, and by one thread."""

# Errors, in scales, from which on the plain reference will do, and that of `evaluate_many`.
_PLAIN_WILL_DO, _MANY_WILL_DO = 1e-12, 1e-24
# Rows at a time.
_BLOCK = 32_768


def is_small(part: Part) -> bool:
    """True if a part has few values."""
    return len(part.time) * len(part.values) <= FEW


def errors(part: Part, values: Double, name: str) -> Array:
    """Return values minus a column of the reference [SI unit], NaN where there is no value.

    Parameters
    ----------
    part : Part
        With the times of the values.
    values : pair of ndarray, shape (n,)
        Hi + lo [SI unit].
    name
        Column of the reference.
    """
    reference = part.reference
    if is_small(part):
        return _errors(part, values, name, reference.continued)
    error = np.concatenate(
        [
            values[0][rows] - reference.approximate(part.time[rows], [name])[name]
            for rows in _blocks(part)
        ]
    )
    for evaluate, will_do in (
        (reference.evaluate_many, _PLAIN_WILL_DO),
        (reference.continued, _MANY_WILL_DO),
    ):
        if _largest(error) < will_do * reference.scale(name):
            error = np.concatenate(
                [_errors(part, values, name, evaluate, rows) for rows in _blocks(part)]
            )
    return error


def largest_errors(part: Part, values: Array, names: Sequence[str]) -> list[float]:
    """Return the largest absolute error against each column, in plain binary64."""
    found = np.zeros(len(names))
    for rows in _blocks(part):
        near = part.reference.approximate(part.time[rows], names)
        found = np.maximum(found, [_largest(values[rows] - near[name]) for name in names])
    return [float(x) for x in found]


def _blocks(part: Part) -> Iterator[slice]:
    for start in range(0, len(part.time), _BLOCK):
        yield slice(start, start + _BLOCK)


def _errors(
    part: Part,
    values: Double,
    name: str,
    evaluate: Callable[[Double, Sequence[str]], Values],
    rows: slice = slice(None),
) -> Array:
    exact = evaluate((part.time[rows], part.time_lo[rows]), [name])
    difference, rest = two_sum(values[0][rows], -exact[name])
    error: Array = difference + (rest + (values[1][rows] - exact.lo[name]))
    return error


def _largest(error: Array) -> float:
    return float(np.fmax.reduce(np.abs(error), initial=0.0))
