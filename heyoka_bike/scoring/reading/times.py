"""Find the exact decimals that the times of a file stand for, and sort the times.

Binary times usually stand for exactly their binary64 values. But if every time is the binary64
number nearest to a multiple of a decimal step, the times stand for these multiples.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, Double, divide, multiply, two_product, two_sum
from heyoka_bike.numbers.unit import size
from heyoka_bike.scoring.evidence.as_read import TimesAsDecimals, TimesRepeated, TimesUnsorted
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.reading.digits import as_single
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadTable

# Maximum number of decimal places of a step. Steps finer than a picosecond are unlikely.
_MOST_DECIMALS = 12
_FEWEST_TIMES = 3
# Numbers of digits with which single-precision numbers are written. With fewer digits they cannot
# be recognised.
_DIGITS_OF_SINGLE = (8, 9)
# Decimal logarithm of the largest probability that the times are near multiples of a step only by
# chance.
_LOG_CHANCE = -6.0
# Number of times in the first block. They suffice to show that times are not multiples of a step.
_FIRST_TIMES = 64
# Number of times in each later block. It keeps the intermediate arrays of a long file small.
_TIMES_AT_ONCE = 1 << 16


@dataclass(frozen=True, slots=True)
class Times:
    """Exact times in ascending order.

    Attributes
    ----------
    hi, lo : ndarray, shape (n,)
        Times in ascending order [s].
    order : ndarray of int, shape (n,), or None
        Index of each time's row in the file; None if the file is in order.
    seen : tuple of Evidence
    """

    hi: Array
    lo: Array
    order: NDArray[np.intp] | None
    seen: tuple[Evidence, ...]


def settle(table: ReadTable, at: int, request: Request, unit: str = "s") -> Times:
    """Return the exact times of a table, sorted.

    Parameters
    ----------
    table
        The columns as read.
    at
        Index of the column of times.
    request
        The request to read them.
    unit
        Unit of the times, one of `UNITS_OF_TIME`.

    Raises
    ------
    InputError
        A time is not finite, or too large for its unit.
    """
    column = table.columns[at]
    seen: list[Evidence] = []
    hi, digits = column.values, column.significant
    if not (is_finite := np.isfinite(hi)).all():
        said = "found a time that is not finite, expected seconds"
        raise table.error(request, int(np.argmin(is_finite)), said, at + 1)
    rest = np.zeros(len(hi)) if column.lo is None else column.lo
    multiples = None if digits is None else as_multiples(hi, digits)
    if multiples is not None:
        places, exact_hi, exact_lo = multiples
        changed = np.flatnonzero((exact_hi != hi) | (exact_lo != rest))
        hi, rest = exact_hi, exact_lo
        if len(changed):
            seen.append(TimesAsDecimals(places, unit, len(changed), float(hi[changed[0]])))
    hi, rest = in_seconds((hi, rest), unit)
    if not (is_finite := np.isfinite(hi) & np.isfinite(rest)).all():
        said = f"found a time that is too large in {unit}, expected seconds"
        raise table.error(request, int(np.argmin(is_finite)), said, at + 1)
    order = None
    back = np.flatnonzero((hi[1:] < hi[:-1]) | ((hi[1:] == hi[:-1]) & (rest[1:] < rest[:-1])))
    if len(back):
        counted_by, line = table.place(int(back[0]) + 1)
        seen.append(TimesUnsorted(counted_by, line, len(back)))
        order = np.lexsort((rest, hi))
        hi, rest = hi[order], rest[order]
    is_repeated = (hi[1:] == hi[:-1]) & (rest[1:] == rest[:-1])
    if is_repeated.any():
        count = np.count_nonzero(np.append(is_repeated, False) | np.append(False, is_repeated))
        pairs = np.flatnonzero(is_repeated)
        rows = (pairs + k if order is None else order[pairs + k] for k in (0, 1))
        seen.append(TimesRepeated(int(count), _are_identical(table, *rows)))
    return Times(hi, rest, order, tuple(seen))


def _are_identical(table: ReadTable, rows: NDArray[np.intp], others: NDArray[np.intp]) -> bool:
    """True if each of the rows equals its counterpart among the others in every column."""
    return all(np.array_equal(x.values[rows], x.values[others], True) for x in table.columns)


def in_seconds(times: Double, unit: str) -> Double:
    """Convert times from a unit to seconds, as hi + lo."""
    return _scaled(times, _seconds(unit))


def in_unit(times: Double, unit: str) -> Double:
    """Convert times from seconds to another unit, as hi + lo."""
    return _scaled(times, 1 / _seconds(unit))


def _seconds(unit: str) -> Fraction:
    found = size(unit)
    assert found is not None
    return found[0]


def _scaled(times: Double, by: Fraction) -> Double:
    """Return the times multiplied by `by`, an integer or the inverse of one.

    Times near the largest binary64 number may become infinite.
    """
    if by == 1:
        return times
    integer = np.full(len(times[0]), float(max(by, 1 / by)))
    with np.errstate(over="ignore", invalid="ignore"):
        if by > 1:
            return multiply(times, (integer, np.zeros_like(integer)))
        return divide(times, integer)


def with_nanoseconds(table: ReadTable, at: int, beside: int) -> ReadTable:
    """Return the table with the nanoseconds of another column added to its times."""
    more = np.full(len(table.columns[beside].values), 1e9)
    hi, lo = divide((table.columns[beside].values, np.zeros_like(more)), more)
    time, rest = two_sum(table.columns[at].values, hi)
    column = replace(table.columns[at], values=time, lo=rest + lo, significant=None)
    return replace(table, columns=[*table.columns[:at], column, *table.columns[at + 1 :]])


def as_multiples(hi: Array, digits: int = 0) -> tuple[int, Array, Array] | None:
    """Return a decimal step such that all times are rounded multiples of it, and these multiples.

    The times may be rounded to binary64 or to single precision.

    Parameters
    ----------
    hi : ndarray, shape (n,)
        Times [s].
    digits
        Significant digits if the times were written as decimals, else 0.

    Returns
    -------
    (int, ndarray, ndarray) or None
        The smallest d such that all times mean k 10^-d, and the multiples k 10^-d as correctly
        rounded hi + lo. None if there is no such d up to 12, if there are fewer than three rows, or
        if it could be chance.
    """
    # Binary64 cannot represent all integers above 2^53, so larger times do not show their step.
    if len(hi) < _FEWEST_TIMES or not (np.abs(hi) < 2.0**53).all():
        return None
    single = as_single(hi)
    candidates: list[tuple[Array, type[np.floating]]] = [(hi, np.float64)]
    if (single == hi).all() or (digits in _DIGITS_OF_SINGLE and _are_written(single, hi, digits)):
        candidates.append((single, np.float32))
    # Try both precisions for each step. Otherwise single-precision numbers such as 0.0700000003,
    # read as decimals, would count as multiples of a smaller step.
    each = ((d, x, kind) for d in range(_MOST_DECIMALS + 1) for x, kind in candidates)
    found = next(((d, x) for d, x, kind in each if _are_multiples(x, d, kind)), None)
    if found is None:
        return None
    places, hi = found
    ten = 10.0**places
    exact, lo = np.empty_like(hi), np.empty_like(hi)
    for piece in _pieces(len(hi)):
        k = np.rint(hi[piece] * ten)
        exact[piece] = k / ten
        # Every term is exact, because the remainder k - 10^places exact[piece] has at most 28 bits.
        p, e = two_product(exact[piece], np.full(len(k), ten))
        lo[piece] = ((k - p) - e) / ten
    return places, exact, lo


def _are_multiples(hi: Array, places: int, kind: type[np.floating]) -> bool:
    """True if all times are the nearest numbers to multiples of 10^-places."""
    ten, chance, last = 10.0**places, 0.0, 0.0
    for piece in _pieces(len(hi)):
        times = hi[piece]
        k = np.rint(times * ten)
        # If k had more than 53 bits, the quotients would not be correctly rounded.
        if not (np.abs(k) < 2.0**53).all():
            return False
        if not ((k / ten).astype(kind).astype(np.float64) == times).all():
            return False
        # A binary number may be the nearest one to a multiple of the step by chance. The
        # probability is the spacing of the binary numbers divided by the step.
        different = times[np.diff(times, prepend=last) != 0]
        last = times[-1]
        with np.errstate(divide="ignore"):
            spacing = np.spacing(np.abs(different).astype(kind)).astype(np.float64)
            chance += float(np.minimum(np.log10(spacing * ten), 0.0).sum())
    return chance < _LOG_CHANCE


def _pieces(count: int) -> Iterator[slice]:
    """Yield slices that split the rows into blocks; a short first block usually decides.

    In most files without multiples, the first block already contains a time that is no multiple.
    """
    at, size = 0, _FIRST_TIMES
    while at < count:
        yield slice(at, at + size)
        at, size = at + size, _TIMES_AT_ONCE


def _are_written(single: Array, hi: Array, digits: int) -> bool:
    """True if the single-precision numbers, written with this many digits, give these times."""
    both = zip(single.tolist(), hi.tolist(), strict=True)
    return all(float(f"{x:.{digits - 1}e}") == time for x, time in both)
