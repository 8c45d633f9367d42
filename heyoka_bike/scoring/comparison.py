"""Written values minus the reference, as exactly as their errors need.

Few values are compared with the reference in hi + lo. Very many are compared in plain binary64
first, good to 1e-15 of the column's scale, then with `evaluate_many`, good to 1e-27, and with all
digits only where the error is so small that this would show: the error of a column is always right
to a tenth of a percent of its largest.

`rounding` is what the digits written allow, each row by its own digits. Digits are counted on some
rows of a long file, and others may have more: those are not rounded. Digits that are zero in every
row of a column that varies are no digits, however many are written.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, Double, two_sum
from heyoka_bike.reference.values import Values
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.units import factor

FEW = 100_000
"""Up to so many values hi + lo of the reference is always evaluated, and by one thread."""

# Errors, in scales, from which on the plain reference will do, and that of `evaluate_many`.
_PLAIN_WILL_DO, _MANY_WILL_DO = 1e-12, 1e-24
# Rows at a time.
_BLOCK = 32_768
# Rows that tell at once that a column has no few digits in common, and the most places of these.
_FIRST_ROWS = 64
_MOST_PLACES = 13
# Larger multiples are told from other numbers by nothing in binary64, whose quotients are right to
# so many last digits.
_TOLD = 1e13
_LAST_DIGITS = 8


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


def rounding(part: Part, key: str, unit: str) -> tuple[Array, float | None]:
    """Half the distance of neighbouring written numbers.

    Returns
    -------
    half : ndarray, shape (n,) or (1,)
        At each row, or at the largest value for all rows [SI unit].
    floor : float or None
        The largest error of values that are all rounded alike [SI unit], 0 if some rows have more
        digits than the others; None if unknown.
    """
    quantum, values = part.quantum.get(key), part.values[key]
    is_finite = np.isfinite(values)
    if quantum is None or not is_finite.any():
        return np.zeros(1), None
    largest = np.max(np.abs(values[is_finite]), keepdims=True)
    spacing, is_rounded = quantum.at(largest), np.ones(1, dtype=bool)
    if quantum.base == 10:
        spacing = quantum.at(values)
        is_rounded = _are_multiples(values, spacing) | ~is_finite
    elif key in part.lo:
        # hi + lo, of twice as many bits.
        spacing = spacing * np.finfo(np.float64).eps
    common = _in_common(values[is_finite], float(largest[0]))
    spacing = np.where(spacing < common / 2, common, spacing)
    half = np.where(is_rounded, spacing, 0.0) / 2 * factor(unit)[0]
    return half, float(np.max(half)) if is_rounded.all() else 0.0


def _in_common(values: Array, largest: float) -> float:
    """The power of ten of which all values are multiples; 0 if there is none.

    Values that are all the same multiple, within what binary64 can tell, show no such digits.
    """
    varies = np.ptp(values)
    for places in range(_MOST_PLACES):
        unit = 10.0**-places
        if (
            varies > unit / 2
            and largest / unit < _TOLD
            and all(_are_multiples(some, unit).all() for some in (values[:_FIRST_ROWS], values))
        ):
            return unit
    return 0.0


def _are_multiples(values: Array, of: Array | float) -> NDArray[np.bool_]:
    with np.errstate(divide="ignore", invalid="ignore"):
        quotients = np.abs(values / of)
        rest = np.abs(quotients - np.rint(quotients))
        found = (rest <= _LAST_DIGITS * np.spacing(quotients)) | (values == 0.0)
    return np.asarray(found)
