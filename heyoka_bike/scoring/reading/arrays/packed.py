"""Packed numbers: integers or short numbers that stand for values with a scale and an offset.

Source: NetCDF Climate and Forecast (CF) Metadata Conventions, version 1.11, section 8.1 (packed
data) and section 2.5.1 (missing data).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

_MISSING_VALUES = ("_FillValue", "missing_value")
_SCALE_FACTOR, _ADD_OFFSET = "scale_factor", "add_offset"


class Steps(np.ndarray):
    """An array of multiples of a step plus an offset; parts of the array keep the step.

    Attributes
    ----------
    step : float or None
    """

    step: float | None = None

    def __array_finalize__(self, other: Any) -> None:
        """Copy the step of the array from which this array is created."""
        self.step = getattr(other, "step", None)


@dataclass(frozen=True, slots=True)
class StoredArray:
    """An array with a known type and shape that is read from the file only when it is used."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    read: Callable[[], Any]

    def __getitem__(self, index: tuple[()]) -> Any:
        return self.read()


def unpacked(source: Any, attributes: Mapping[str, Any]) -> Any:
    """Return the array; if its numbers are packed or mark missing values, unpack them on reading.

    Parameters
    ----------
    source
        The packed numbers: an object with a type and a shape.
    attributes
        Attributes of the array, by the names in the CF conventions.
    """
    is_packed = _SCALE_FACTOR in attributes or _ADD_OFFSET in attributes
    if source.dtype.kind not in "iuf" or not (is_packed or {*_MISSING_VALUES} & {*attributes}):
        return source
    is_as_it_was = source.dtype.kind == "f" and not is_packed
    dtype = source.dtype if is_as_it_was else np.dtype(np.float64)
    missing = [x for n in _MISSING_VALUES if n in attributes for x in np.ravel(attributes[n])]
    step = float(np.ravel(attributes.get(_SCALE_FACTOR, 1))[0])
    offset = float(np.ravel(attributes.get(_ADD_OFFSET, 0))[0])

    def read() -> Any:
        packed = np.asarray(source[()])
        values: Any = packed.astype(dtype)
        if is_packed:
            # Divide by the inverse of the step if it is an integer. Then 3 steps of 0.1 are 0.3,
            # and not the next number above it.
            inverse = np.rint(1 / step) if step else 0.0
            is_reciprocal = inverse and 1 / inverse == step
            values = ((values / inverse if is_reciprocal else values * step) + offset).view(Steps)
            values.step = step if packed.dtype.kind in "iu" else None
        values[np.isin(packed, missing)] = np.nan
        return values

    return StoredArray(dtype, source.shape, read)
