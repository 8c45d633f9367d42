"""Compute the errors of a column, as exactly as necessary, and their measures.

The error of a row is e_i = f(t_i) - r(t_i), with the program's value f(t_i) and the exact value
r(t_i), both in SI units. Nothing is interpolated, and all rows have the same weight.

- ``max``, ``rms`` and ``relative`` are in the column's unit, or divided by its *scale*, the largest
  abs(r) over the whole run of the reference (not only where the file has rows, so that a short file
  is judged by the same scale as a long one).
- ``scd`` and ``mescd`` are names from the Test Set for Initial Value Problem Solvers (Mazzia and
  Magherini, Bari, release 2.4, 2008; formerly CWI), where they are taken over the components at the
  end of the interval. Here they are taken over the rows of one column, the whole run.
- ``performance`` is eq. (1) of the IFToMM benchmark "Uncontrolled bicycle".

Perfect agreement gives errors of 0 and 32 digits, the resolution of hi + lo.

Up to `MAX_EXACT_VALUES` values are compared with the reference in hi + lo. More values are compared
in binary64 first, accurate to 1e-15 of the column's scale, then with `evaluate_many`, accurate to
1e-27, and with all digits only if the error is so small that they matter. The errors of a column
are always accurate to a tenth of a percent of the largest one.

`rounding` is the error that the digits written allow, in each row by its own digits. In a long
file, digits are counted in some rows, and other rows may have more digits: these rows are not
rounded. Digits that are zero in every row of a varying column do not count, however many are
written.
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
"""Error, in scales, that binary64 arithmetic may cause in a run. A million rounding errors of 1e-16
add up to 1e-13 to 1e-10; correct programs were seen to reach 4e-14 to 2e-12."""

_PARTS_OF_RUN = 10


def measures(t: Array, error: Array, reference: Array, scale: float) -> Measures:
    """Return all measures of a column.

    Parameters
    ----------
    t, error, reference : ndarray, shape (n,)
        Times [s], errors e and exact values r; finite.
    scale
        Largest absolute value of the reference over its run.
    """
    if not len(error):
        return Measures(None, None, None, None, None, None, None)
    worst = int(np.argmax(np.abs(error)))
    largest = float(np.abs(error[worst]))
    relative = largest / scale if scale else None
    if largest == 0.0:
        relative = 0.0  # also if the scale is zero, where the quotient would be NaN
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
    """Return the root mean square, without overflow; NaN without values, so comparisons fail."""
    if not len(error):
        return nan
    largest = float(np.maximum.reduce(np.abs(error)))
    if largest == 0.0:
        return 0.0
    # NumPy's ufuncs are faster than `np.mean`. Choosing a definition computes hundreds of these
    # norms.
    return largest * sqrt(float(np.add.reduce(np.square(error / largest))) / len(error))


def time_to_tolerance(t: Array, error: Array, scale: float) -> float | None:
    """Return the first time at which abs(e) exceeds 1e-3 of the scale [s]; None if it never does.

    Parameters
    ----------
    t, error : ndarray, shape (n,)
        Times [s] and errors.
    scale
        Largest absolute value of the reference over its run.
    """
    above = np.abs(error) > TOLERANCE * scale
    return float(t[np.argmax(above)]) if above.any() else None


def growth(t: Array, error: Array, duration: float) -> tuple[Growth, ...]:
    """Return the largest abs(e) in each tenth of the run; the last tenth includes the end."""
    ends = np.linspace(0.0, duration, _PARTS_OF_RUN + 1)
    part = np.clip(np.searchsorted(ends, t, side="right") - 1, 0, _PARTS_OF_RUN - 1)
    found = []
    for i in range(_PARTS_OF_RUN):
        inside = np.abs(error[part == i])
        largest = float(inside.max()) if len(inside) else None
        found.append(Growth(float(ends[i]), float(ends[i + 1]), largest))
    return tuple(found)


def performance(energy: Array, rest: Array | None = None) -> float | None:
    """Return eq. (1) of the benchmark: 100 (max E - min E) / E0 [%], E0 the first value.

    Parameters
    ----------
    energy, rest : ndarray, shape (n,)
        The energy as hi + lo: digits beyond binary64 count if the file has them.

    Returns
    -------
    float or None
        None with fewer than two values, or with E0 = 0.

    Notes
    -----
    Eq. (1) depends on the energy only: a program can pass it with a motion that is wrong by a
    third, and fail it because it writes too few digits.

    References
    ----------
    IFToMM Technical Committee for Multibody Dynamics, Library of Computational Benchmark
    Problems, problem "Uncontrolled bicycle".
    """
    if len(energy) < 2 or energy[0] == 0.0:
        return None
    change = energy - energy[0]
    if rest is not None:
        # If the low parts matter, the energies are so close together that their difference above is
        # exact.
        change = change + (rest - rest[0])
    found = 100.0 * float(np.ptp(change)) / abs(float(energy[0]))
    return found if isfinite(found) else None


MAX_EXACT_VALUES = 100_000
"""Largest number of values that are always compared in hi + lo, and in one thread."""

# Smallest errors, relative to the scales of the columns, for which the binary64 reference, and for
# which `evaluate_many`, is accurate enough.
_MIN_ERROR_FOR_BINARY64, _MIN_ERROR_FOR_BATCH = 1e-12, 1e-24
_ROWS_AT_ONCE = 32_768
# Number of rows that usually suffice to show that a column's values are not multiples of a power of
# ten, and maximum number of decimal places of such a power.
_ROWS_TRIED_FIRST = 64
_MOST_PLACES = 13
# Largest multiple of a power of ten that binary64 can distinguish from other numbers, and largest
# error of quotients [units in the last place].
_LARGEST_MULTIPLE = 1e13
_LAST_DIGITS = 8


def is_small(part: Part) -> bool:
    """True if a part has at most `MAX_EXACT_VALUES` values."""
    return len(part.time) * len(part.values) <= MAX_EXACT_VALUES


def errors(part: Part, values: Double, name: str) -> Array:
    """Return values minus a column of the reference [SI unit]; NaN if a row has no value.

    Parameters
    ----------
    part : Part
        The rows; only their times are used.
    values : pair of ndarray, shape (n,)
        Values as hi + lo [SI unit].
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
    """Return the largest rounding error of each row: half the distance of neighbouring numbers.

    Returns
    -------
    half : ndarray, shape (n,) or (1,)
        For each row, or for all rows at the largest value [SI unit].
    floor : float or None
        The largest of these errors [SI unit], 0 if some rows have more digits than the others; None
        if unknown.
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
        # A pair hi + lo has twice as many bits as binary64.
        spacing = spacing * np.finfo(np.float64).eps
    if key not in part.lo:
        # A text may show more digits than the binary64 numbers from which the program wrote it.
        spacing = np.maximum(spacing, np.spacing(np.abs(values if len(spacing) > 1 else largest)))
    common = _in_common(values[is_finite], float(largest[0]))
    spacing = np.where(spacing < common / 2, common, spacing)
    half = np.where(is_rounded, spacing, 0.0) / 2 * factor(unit)[0]
    return half, float(np.max(half)) if is_rounded.all() else 0.0


def _in_common(values: Array, largest: float) -> float:
    """Return the largest power of ten of which all values are multiples; 0 if there is none.

    A column that varies by less than half the power of ten does not show such digits.
    """
    varies = np.ptp(values)
    for places in range(_MOST_PLACES):
        unit = 10.0**-places
        if (
            varies > unit / 2
            and largest / unit < _LARGEST_MULTIPLE
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
