"""Read one array as a column: real numbers, or decimals as text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array, divide, two_sum
from heyoka_bike.scoring.reading.arrays.long_numbers import long_numbers
from heyoka_bike.scoring.reading.dates import seconds_from_first
from heyoka_bike.scoring.reading.digits import (
    are_beyond_binary64,
    binary_column,
    column_of_steps,
    written_column,
)
from heyoka_bike.scoring.reading.names.heading import labelled_number
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadColumn
from heyoka_bike.scoring.reading.text.blocks import rests
from heyoka_bike.scoring.reading.text.dialects import Dialect

# The limit allows ten million rows of 25 numbers. A larger array probably has a damaged header.
MOST_BYTES = 2 * 10**9
"""Size of the largest array that is read [bytes]."""

_REFUSED = {
    "b": "truth values", "c": "complex numbers", "m": "time differences", "M": "dates",
    "O": "Python objects", "S": "text", "U": "text", "T": "text", "V": "records",
}  # fmt: skip
_WITH_POINT = Dialect("", ".")
# Maximum number of values of a column that are searched for the largest number of digits.
_NUMBERS_COUNTED = 2000
# Maximum number of values of a column that are checked for digits beyond binary64.
_NUMBERS_LOOKED_AT = 40


def refuse_too_large(source: Any, request: Request) -> None:
    """Raise an error if an array would take too much memory."""
    size = prod(source.shape) * source.dtype.itemsize
    if size > MOST_BYTES:
        raise request.error(f"found an array of {size} bytes, expected at most {MOST_BYTES}")


def read_array(source: Any, request: Request) -> NDArray[Any]:
    """Read an array of real numbers, or of Python objects that may be decimals, into memory.

    Raises
    ------
    InputError
        The array has another type, is empty or is too large.
    """
    dtype = source.dtype
    if dtype.kind not in "fiuO" and not dtype.names:
        raise refused(dtype, request)
    refuse_too_large(source, request)
    array = np.ma.filled(source[()], np.nan) if dtype.kind == "f" else np.asanyarray(source[()])
    if array.size == 0:
        raise request.error("found an empty array, expected rows")
    return array


def read_column(source: Any, lo: Any, is_time: bool, request: Request) -> ReadColumn:
    """Read an array as a column; `lo` is the array with its digits beyond binary64, or None.

    Raises
    ------
    InputError
        The values are not real numbers, or `lo` has another length.
    """
    if is_time and getattr(source, "dtype", np.dtype("f8")).kind == "m":
        return _durations(source)
    if is_time and (seconds := seconds_from_first(source)) is not None:
        return _decimal_column(seconds, True)
    array = read_array(source, request).ravel()
    if step := getattr(array, "step", None):
        return column_of_steps(np.asarray(array), step)
    if array.dtype.kind == "O":
        if (long := long_numbers(array)) and lo is None and long.bits is not None:
            hi, rest = long.as_pairs()
            # Times without digits beyond binary64 may be rounded decimals. `times.settle` decides
            # this later.
            is_exact = bool(rest.any())
            column = binary_column(hi, rest if is_exact else None, long.bits)
            return replace(column, significant=None) if is_exact else column
        numbers = long.as_decimals() if long else _decimals(array, request)
        if lo is None:
            return _decimal_column(numbers, is_time)
        array = np.array(numbers, dtype=np.float64)
    bits = 53 if array.dtype.kind != "f" else int(np.finfo(array.dtype).nmant) + 1
    remainder: Array | None = None
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        values: Array = array.astype(np.float64)
        if lo is not None:
            remainder = read_column(lo, None, False, request).values
            if remainder.shape != values.shape:
                raise request.error(
                    f"found {len(values)} values and {len(remainder)} low parts (_lo), expected as "
                    "many low parts as values"
                )
            values, remainder = two_sum(values, remainder)
            bits = 2 * bits
        elif bits > 53:
            remainder = (array - values).astype(np.float64)
            if not remainder.any():
                # The longer type contains only binary64 numbers, so nothing remains.
                remainder = None
    if remainder is not None:
        remainder[~np.isfinite(values)] = 0.0
    column = binary_column(values, remainder, bits)
    return column if lo is None else replace(column, significant=None)


def _durations(source: Any) -> ReadColumn:
    """Convert time differences of NumPy to seconds, exact to a nanosecond."""
    counts = np.asarray(source[()]).ravel().astype("m8[ns]").astype(np.int64).astype(np.float64)
    hi, lo = divide((counts, np.zeros_like(counts)), np.full(len(counts), 1e9))
    return replace(binary_column(hi, lo, 53), significant=None)


def read_maneuvers(source: Any, request: Request) -> Array:
    """Return the maneuver number of each row, from numbers or names; NaN if a row has no number."""
    if source.dtype.kind not in "OSUT":
        return read_column(source, None, False, request).values
    found: list[float] = []
    for x in np.asarray(source[()]).ravel().tolist():
        text = x.decode("latin-1") if isinstance(x, bytes) else str(x)
        number = labelled_number(text)
        found.append(float(_WITH_POINT.number(text) or "nan") if number is None else number)
    return np.array(found, dtype=np.float64)


def _decimals(array: NDArray[Any], request: Request) -> list[str]:
    """Return Python objects as decimals that `float` reads."""
    items: list[Any] = array.tolist()
    for x in items:
        if isinstance(x, bool) or not isinstance(x, str | int | float | Decimal | None):
            raise refused(np.dtype(bool) if isinstance(x, bool) else array.dtype, request)
    numbers = _WITH_POINT.numbers(["nan" if x is None else str(x).strip().lower() for x in items])
    found = [number for number in numbers if number is not None]
    if len(found) < len(items):
        i = numbers.index(None)
        raise request.error(f"row {i + 1}: found {quoted(items[i])}, expected a number")
    return found


def _decimal_column(numbers: Sequence[str], is_time: bool) -> ReadColumn:
    some = [x for x in numbers if x != "nan"]
    looked_at = some[:: max(1, len(some) // _NUMBERS_LOOKED_AT)]
    is_exact = bool(some) and are_beyond_binary64(looked_at, is_time)
    values = np.array(numbers, dtype=np.float64)
    values[np.isnan(values)] = np.inf
    lo = rests(numbers, values) if is_time or is_exact else None
    written = numbers[:: max(1, len(numbers) // _NUMBERS_COUNTED)]
    column = written_column(values, lo, written, is_time)
    return replace(column, significant=None) if is_time and is_exact else column


def refused(dtype: np.dtype[Any], request: Request) -> InputError:
    """Return the error for values that are not real numbers."""
    found = _REFUSED.get(dtype.kind, str(dtype))
    return request.error(f"found {found}, expected real numbers")
