"""Python objects that contain columns by name, or an array.

Data frames and datasets are recognised by their methods and attributes, so none of the packages
that define them is imported.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.scoring.reading.arrays.packed import StoredArray
from heyoka_bike.scoring.reading.names.heading import is_time
from heyoka_bike.scoring.reading.request import Request


def by_name(x: Any) -> Mapping[str, Any] | None:
    """Return the columns of an object as a mapping from their names; None if it has no names."""
    if isinstance(x, Mapping):
        # In a dataset of xarray, the time is a coordinate.
        members = {**getattr(x, "coords", {}), **x}.items()
        return {f"maneuver_{n}" if isinstance(n, Integral) else str(n): y for n, y in members}
    if isinstance(x, type):
        return None
    if callable(table := getattr(x, "table", None)):
        found = table()
        return found if isinstance(found, Mapping) else {"": found}
    if not (hasattr(x, "__getitem__") and isinstance(getattr(x, "columns", None), Iterable)):
        return None
    # The attribute `columns` of a pyarrow table contains arrays, so their names are read from
    # `column_names`.
    frame = {str(name): x[name] for name in getattr(x, "column_names", x.columns)}
    index = getattr(x, "index", None)
    name = getattr(index, "name", None)
    if isinstance(name, str) and is_time(name) and not any(map(is_time, frame)):
        return {name: index, **frame}
    return frame


def as_array(x: Any, request: Request) -> Any:
    """Return an object as an array, or as a `StoredArray` that is read later.

    Raises
    ------
    InputError
        The object is not an array.
    """
    if isinstance(x, StoredArray) or type(x) is np.ndarray:
        return x
    if all(hasattr(x, name) for name in ("rows", "cols", "tolist")):
        # This is a matrix of mpmath or SymPy. NumPy would round its numbers to binary64.
        x = np.array(x.tolist(), dtype=object)
    try:
        # Every part of a NumPy matrix is a matrix itself, so convert it to an ordinary array.
        array: NDArray[Any] = np.asarray(x) if isinstance(x, np.matrix) else np.asanyarray(x)
    except (ValueError, TypeError, OverflowError):
        said = f"found a {type(x).__name__} that is not an array, expected real numbers"
        raise request.error(said) from None
    # A list of words may contain decimals. As Python objects, the words are converted one by one,
    # and an error can name the first that is not a number.
    is_words = array.dtype.kind == "U" and array.shape and not hasattr(x, "dtype")
    return array.astype(object) if is_words else array
