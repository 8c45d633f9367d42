"""Errors of a column, as exactly as they need to be, and the measures of them.

The task: a program's column f(t_i) at its own times, the exact column r(t_i), and their difference
e_i = f(t_i) - r(t_i), in SI units. Nothing is interpolated, and no row weighs more than another.

- ``max``, ``rms`` and ``relative`` are in the column's unit, or divided by its *scale*, the largest
  abs(r) over the whole run of the reference (not only where the file has rows, so that a short file
  is judged by the same scale as a long one).
- ``scd`` and ``mescd`` are named after the Test Set for Initial Value Problem Solvers (Mazzia and
  Magherini, Bari, release 2.4, 2008; formerly CWI), where they are taken over the components at the
  end of the interval. Here they are taken over the rows of one column, the whole run.
- ``performance`` is eq. (1) of the IFToMM benchmark "Uncontrolled bicycle".

Perfect agreement gives errors of 0 and 32 digits, all that hi + lo can tell.

Few values are compared with the reference in hi + lo. Very many are compared in plain binary64
first, good to 1e-15 of the column's scale, then with `evaluate_many`, good to 1e-27, and with all
digits only where the error is so small that this would show: the error of a column is always right
to a tenth of a percent of its largest.

`rounding` is what the digits written allow, each row by its own digits. Digits are counted on some
rows of a long file, and others may have more: those are not rounded. Digits that are zero in every
row of a column that varies are no digits, however many are written.
"""

from collections.abc import Callable, Iterator, Sequence
from math import isfinite, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, Double, two_sum
from heyoka_bike.reference.values import Values
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.grades import MOST_DIGITS as MOST_DIGITS
from heyoka_bike.scoring.grades import TOLERANCE as TOLERANCE
from heyoka_bike.scoring.grades import digits as digits
from heyoka_bike.scoring.scores import Growth, Measures
from heyoka_bike.scoring.units import factor

ROUNDING = 1e-11
"""Of the scale: what binary64 arithmetic may leave of a run. 1e-16 in each of a million operations
that add up is 1e-13 to 1e-10; correct programs were seen to stop at 4e-14 to 2e-12."""

_PARTS_OF_RUN = 10


def measures(t: Array, error: Array, reference: Array, scale: float) -> Measures:
    """All measures of a column.

    Parameters
    ----------
    t, error, reference : ndarray, shape (n,)
        Times [s], e and r; finite.
    scale
        Largest absolute value of the reference over its run.
    """
    if not len(error):
        return Measures(None, None, None, None, None, None, None)
    worst = int(np.argmax(np.abs(error)))
    largest = float(np.abs(error[worst]))
    relative = largest / scale if scale else None
    if largest == 0.0:
        relative = 0.0  # of a column that vanishes, too
    return Measures(
        max_abs_error=largest,
        time_of_max=float(t[worst]),
        rms_error=rms(error),
        max_rel_error=relative if relative is None or isfinite(relative) else None,
        scd=digits(relative),
        mescd=digits(float(np.max(np.abs(error) / (1.0 + np.abs(reference))))),
        time_to_tolerance=time_to_tolerance(t, error, scale),
    )


def rms(error: Array) -> float:
    """Root of the mean square, without overflow; NaN without values, which meets no condition."""
    if not len(error):
        return nan
    largest = float(np.maximum.reduce(np.abs(error)))
    if largest == 0.0:
        return 0.0
    # NumPy's mean, without what surrounds it: definitions are told by hundreds of these.
    return largest * sqrt(float(np.add.reduce(np.square(error / largest))) / len(error))


def time_to_tolerance(t: Array, error: Array, scale: float) -> float | None:
    """First time at which abs(e) exceeds 1e-3 of the scale [s]; None if it never does."""
    above = np.abs(error) > TOLERANCE * scale
    return float(t[np.argmax(above)]) if above.any() else None


def growth(t: Array, error: Array, duration: float) -> tuple[Growth, ...]:
    """Largest abs(e) in each tenth of the run; the end belongs to the last."""
    ends = np.linspace(0.0, duration, _PARTS_OF_RUN + 1)
    part = np.clip(np.searchsorted(ends, t, side="right") - 1, 0, _PARTS_OF_RUN - 1)
    found = []
    for i in range(_PARTS_OF_RUN):
        inside = np.abs(error[part == i])
        largest = float(inside.max()) if len(inside) else None
        found.append(Growth(float(ends[i]), float(ends[i + 1]), largest))
    return tuple(found)


def performance(energy: Array, rest: Array | None = None) -> float | None:
    """Eq. (1) of the benchmark: 100 (max E - min E) / E0 [%], E0 the first value.

    Parameters
    ----------
    energy, rest : ndarray, shape (n,)
        hi + lo: what is far below the last digit of binary64 counts where it was written.

    Notes
    -----
    It sees the energy only: a program can pass it with a motion that is wrong by a third, and fail
    it with output of few digits. None of fewer than two values, or with E0 = 0.

    References
    ----------
    IFToMM Technical Committee for Multibody Dynamics, Library of Computational Benchmark
    Problems, problem "Uncontrolled bicycle".
    """
    if len(energy) < 2 or energy[0] == 0.0:
        return None
    change = energy - energy[0]
    if rest is not None:
        # Neighbouring numbers: their difference is exact where the rest counts.
        change = change + (rest - rest[0])
    found = 100.0 * float(np.ptp(change)) / abs(float(energy[0]))
    return found if isfinite(found) else None


MAX_EXACT_VALUES = 100_000
"""Up to so many values hi + lo of the reference is always evaluated, and by one thread."""

# Errors, in scales, from which on the plain reference will do, and that of `evaluate_many`.
_MIN_ERROR_FOR_BINARY64, _MIN_ERROR_FOR_BATCH = 1e-12, 1e-24
# Rows at a time.
_ROWS_AT_ONCE = 32_768
# Rows that tell at once that a column has no few digits in common, and the most places of these.
_ROWS_TRIED_FIRST = 64
_MOST_PLACES = 13
# Larger multiples are told from other numbers by nothing in binary64, whose quotients are right to
# so many last digits.
_LARGEST_MULTIPLE_TOLD = 1e13
_LAST_DIGITS = 8


def is_small(part: Part) -> bool:
    """True if a part has few values."""
    return len(part.time) * len(part.values) <= MAX_EXACT_VALUES


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
    reference, scale = part.reference, part.reference.scale(name)

    def against(evaluate: Callable[[Double, Sequence[str]], Values]) -> Array:
        found: list[Array] = []
        for rows in _blocks(part):
            exact = evaluate((part.time[rows], part.time_lo[rows]), [name])
            difference, rest = two_sum(values[0][rows], -exact[name])
            found.append(difference + (rest + (values[1][rows] - exact.lo[name])))
        return np.concatenate(found)

    if is_small(part):
        return against(reference.continued)
    near = (reference.approximate(part.time[rows], [name])[name] for rows in _blocks(part))
    error: Array = values[0] - np.concatenate([*near])
    if _largest(error) < _MIN_ERROR_FOR_BINARY64 * scale:
        error = against(reference.evaluate_many)
    if _largest(error) < _MIN_ERROR_FOR_BATCH * scale:
        error = against(reference.continued)
    return error


def largest_errors(part: Part, values: Array, names: Sequence[str]) -> list[float]:
    """Return the largest absolute error against each column, in plain binary64."""
    found = np.zeros(len(names))
    for rows in _blocks(part):
        near = part.reference.approximate(part.time[rows], names)
        found = np.maximum(found, [_largest(values[rows] - near[name]) for name in names])
    return [float(x) for x in found]


def _blocks(part: Part) -> Iterator[slice]:
    for start in range(0, len(part.time), _ROWS_AT_ONCE):
        yield slice(start, start + _ROWS_AT_ONCE)


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
    if key not in part.lo:
        # A text may have more places than the binary64 numbers that it was written from.
        spacing = np.maximum(spacing, np.spacing(np.abs(values if len(spacing) > 1 else largest)))
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
            and largest / unit < _LARGEST_MULTIPLE_TOLD
            and all(
                _are_multiples(some, unit).all() for some in (values[:_ROWS_TRIED_FIRST], values)
            )
        ):
            return unit
    return 0.0


def _are_multiples(values: Array, of: Array | float) -> NDArray[np.bool_]:
    with np.errstate(divide="ignore", invalid="ignore"):
        quotients = np.abs(values / of)
        rest = np.abs(quotients - np.rint(quotients))
        found = (rest <= _LAST_DIGITS * np.spacing(quotients)) | (values == 0.0)
    return np.asarray(found)
