"""Columns of arrays: binary numbers, packed or not by the CF conventions, or decimals as text.

Packed numbers are smaller ones, with a scale and an offset.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array, two_sum
from heyoka_bike.scoring.reading import quanta
from heyoka_bike.scoring.reading.names.headings import group_number
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.text.blocks import plain_row, read_rows
from heyoka_bike.scoring.reading.text.dialects import Dialect
from heyoka_bike.scoring.reading.vectors import Vector

# Ten million rows of 25 numbers; more is what a damaged header says.
MOST_BYTES = 2 * 10**9
"""Size of the largest array that is read."""

_REFUSED = {
    "b": "truth values", "c": "complex numbers", "m": "time differences", "M": "dates",
    "O": "Python objects", "S": "text", "U": "text", "T": "text", "V": "records",
}  # fmt: skip
_POINT = Dialect("", ".")
# Numbers of a column of which digits are counted.
_COUNTED = 2000
# Of these the digits beyond binary64 are looked at.
_LOOKED_AT = 40
_MISSING = ("_FillValue", "missing_value")
_SCALE, _OFFSET = "scale_factor", "add_offset"


class Steps(np.ndarray):
    """An array of multiples of a step, from an offset on; what is taken from it is one, too.

    Attributes
    ----------
    step : float or None
    """

    step: float | None = None

    def __array_finalize__(self, other: Any) -> None:
        """Keep the step of the array that this one is taken from."""
        self.step = getattr(other, "step", None)


@dataclass(frozen=True, slots=True)
class StoredArray:
    """An array of this type and shape, read when it is wanted."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    read: Callable[[], Any]

    def __getitem__(self, index: tuple[()]) -> Any:
        return self.read()


def unpacked(source: Any, attributes: Mapping[str, Any]) -> Any:
    """The array, which unpacks its numbers if they are packed or stand for what is missing.

    Parameters
    ----------
    source
        What has the packed numbers: anything with a type and a shape.
    attributes
        Of the array, by the names of the conventions.
    """
    is_packed = _SCALE in attributes or _OFFSET in attributes
    if source.dtype.kind not in "iuf" or not (is_packed or {*_MISSING} & {*attributes}):
        return source
    is_as_it_was = source.dtype.kind == "f" and not is_packed
    dtype = source.dtype if is_as_it_was else np.dtype(np.float64)
    missing = [x for n in _MISSING if n in attributes for x in np.ravel(attributes[n])]
    step = float(np.ravel(attributes.get(_SCALE, 1))[0])
    offset = float(np.ravel(attributes.get(_OFFSET, 0))[0])

    def read() -> Any:
        packed = np.asarray(source[()])
        values: Any = packed.astype(dtype)
        if is_packed:
            # So 3 steps of 0.1 are 0.3, and not the next number above it.
            inverse = np.rint(1 / step) if step else 0.0
            is_whole = inverse and 1 / inverse == step
            values = ((values / inverse if is_whole else values * step) + offset).view(Steps)
            values.step = step if packed.dtype.kind in "iu" else None
        values[np.isin(packed, missing)] = np.nan
        return values

    return StoredArray(dtype, source.shape, read)


def read_array(source: Any, request: Request) -> NDArray[Any]:
    """An array of real numbers, or of Python objects that may be decimals, in memory.

    Raises
    ------
    InputError
        Of another kind, empty or too large.
    """
    dtype = source.dtype
    if dtype.kind not in "fiuO" and not dtype.names:
        raise refused(dtype, request)
    size = prod(source.shape) * dtype.itemsize
    if size > MOST_BYTES:
        raise request.error(f"found an array of {size} bytes, expected at most {MOST_BYTES}")
    array = np.ma.filled(source[()], np.nan) if dtype.kind == "f" else np.asanyarray(source[()])
    if array.size == 0:
        raise request.error("found an empty array, expected rows")
    return array


def read_column(source: Any, lo: Any, is_time: bool, request: Request) -> Vector:
    """A column; its rest beyond binary64 may be another one.

    Raises
    ------
    InputError
        Not real numbers, or a rest of another length.
    """
    array = read_array(source, request).ravel()
    if step := getattr(array, "step", None):
        return quanta.column_of_steps(np.asarray(array), step)
    if array.dtype.kind == "O":
        numbers = _decimals(array, request)
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
                    f"found {len(values)} values and {len(remainder)} of their second parts, "
                    "expected the same number"
                )
            values, remainder = two_sum(values, remainder)
            bits = 2 * bits
        elif bits > 53:
            remainder = (array - values).astype(np.float64)
    if remainder is not None:
        remainder[~np.isfinite(values)] = 0.0
    column = quanta.binary_column(values, remainder, bits)
    return column if lo is None else column.with_exact_values()


def read_maneuvers(source: Any, request: Request) -> Array:
    """The numbers in a column of maneuvers, as numbers or as names; NaN where there is none."""
    if source.dtype.kind not in "OSUT":
        return read_column(source, None, False, request).values
    found: list[float] = []
    for x in np.asarray(source[()]).ravel().tolist():
        text = x.decode("latin-1") if isinstance(x, bytes) else str(x)
        number = group_number(text)
        found.append(float(_POINT.number(text) or "nan") if number is None else number)
    return np.array(found, dtype=np.float64)


def _decimals(array: NDArray[Any], request: Request) -> list[str]:
    """Objects as decimals that `float` reads."""
    items: list[Any] = array.tolist()
    for x in items:
        if isinstance(x, bool) or not isinstance(x, str | int | float | Decimal | None):
            raise refused(np.dtype(bool) if isinstance(x, bool) else array.dtype, request)
    numbers = _POINT.numbers(["nan" if x is None else str(x).strip() for x in items])
    found = [number for number in numbers if number is not None]
    if len(found) < len(items):
        i = numbers.index(None)
        raise request.error(f"row {i + 1}: found {quoted(items[i])}, expected a number")
    return found


def _decimal_column(numbers: Sequence[str], is_time: bool) -> Vector:
    some = [x for x in numbers if x != "nan"]
    looked_at = some[:: max(1, len(some) // _LOOKED_AT)]
    is_exact = bool(some) and quanta.are_beyond_binary64(looked_at, is_time)
    rows, exact = [plain_row([x]) for x in numbers], [0] if is_time or is_exact else []
    block = read_rows(rows, np.arange(len(rows)), None, 1, exact, _COUNTED)
    column = quanta.written_column(block.values[0], block.lo.get(0), block.written[0], is_time)
    return column.with_exact_values() if is_time and is_exact else column


def refused(dtype: np.dtype[Any], request: Request) -> InputError:
    """Return the error for values that are no real numbers."""
    found = _REFUSED.get(dtype.kind, str(dtype))
    return request.error(f"found {found}, expected real numbers")
