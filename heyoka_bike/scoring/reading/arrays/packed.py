"""Numbers that a file holds as smaller ones, with a scale and an offset, by the CF conventions."""

from collections.abc import Mapping
from typing import Any

import numpy as np

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


class PackedNumbers:
    """An array of packed numbers, unpacked when it is read; of floating point none is changed.

    Parameters
    ----------
    source
        What has the packed numbers: anything with a type and a shape.
    attributes
        Of the array, by the names of the conventions.
    """

    def __init__(self, source: Any, attributes: Mapping[str, Any]) -> None:
        first = {n: np.ravel(attributes[n])[0] for n in (_SCALE, _OFFSET) if n in attributes}
        self._source, self._is_packed = source, bool(first)
        self._step, self._offset = float(first.get(_SCALE, 1)), float(first.get(_OFFSET, 0))
        self._missing = [x for n in _MISSING if n in attributes for x in np.ravel(attributes[n])]
        is_float = source.dtype.kind == "f" and not first
        self.shape, self.dtype = source.shape, source.dtype if is_float else np.dtype(np.float64)

    def __getitem__(self, index: Any) -> Any:
        packed = np.asarray(self._source[index])
        values = packed.astype(self.dtype)
        if self._is_packed:
            # So 3 steps of 0.1 are 0.3, and not the next number above it.
            inverse = np.rint(1 / self._step) if self._step else 0.0
            is_whole = inverse and 1 / inverse == self._step
            scaled = values / inverse if is_whole else values * self._step
            steps = (scaled + self._offset).view(Steps)
            steps.step = self._step if packed.dtype.kind in "iu" else None
            values = steps
        values[np.isin(packed, self._missing)] = np.nan
        return values


def unpacked(source: Any, attributes: Mapping[str, Any]) -> Any:
    """The array, which unpacks its numbers if they are packed or stand for what is missing."""
    has_any = any(name in attributes for name in (*_MISSING, _SCALE, _OFFSET))
    return PackedNumbers(source, attributes) if has_any and source.dtype.kind in "iuf" else source
