"""Rounding errors of a column that the digits written allow, each row by its own digits.

Digits are counted on some rows of a long file, and others may have more: those are not rounded.
Digits that are zero in every row of a column that varies are no digits, however many are written.
"""

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.units import factor

# Rows that tell at once that a column has no few digits in common, and the most places of these.
_FIRST_ROWS = 64
_MOST_PLACES = 13
# Larger multiples are told from other numbers by nothing in binary64, whose quotients are right to
# so many last digits.
_TOLD = 1e13
_LAST_DIGITS = 8


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
