"""Data frames, datasets and maneuvers by number as plain mappings.

They are known by what they can do: none of the packages that make them is imported.
"""

from collections.abc import Iterable, Mapping
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.arrays.packed import StoredArray
from heyoka_bike.scoring.reading.names.columns import is_time
from heyoka_bike.scoring.reading.request import Request


def by_name(x: Any) -> Mapping[str, Any] | None:
    """What has columns as a mapping of their names; None of anything else."""
    if isinstance(x, Mapping):
        # Of a dataset of xarray the time is a coordinate.
        return {_name(name): y for name, y in {**getattr(x, "coords", {}), **x}.items()}
    if isinstance(x, type):
        return None
    if callable(table := getattr(x, "table", None)):
        found = table()
        return found if isinstance(found, Mapping) else {"": found}
    if not (hasattr(x, "__getitem__") and isinstance(getattr(x, "columns", None), Iterable)):
        return None
    # Columns of pyarrow are the arrays themselves.
    frame = {str(name): x[name] for name in getattr(x, "column_names", x.columns)}
    index = getattr(x, "index", None)
    name = getattr(index, "name", None)
    if isinstance(name, str) and is_time(name) and not any(map(is_time, frame)):
        return {name: index, **frame}
    return frame


def as_array(x: Any, request: Request) -> Any:
    """An array, if it is not read later.

    Raises
    ------
    InputError
        It is no array.
    """
    if isinstance(x, StoredArray) or type(x) is np.ndarray:
        return x
    try:
        # Of a matrix every part is a matrix, too.
        array: NDArray[Any] = np.asarray(x) if isinstance(x, np.matrix) else np.asanyarray(x)
    except (ValueError, TypeError, OverflowError):
        said = f"found a {type(x).__name__} that is no array, expected real numbers"
        raise request.error(said) from None
    # Words one by one may be decimals, and the first that is none can be named.
    is_words = array.dtype.kind == "U" and array.shape and not hasattr(x, "dtype")
    return array.astype(object) if is_words else array


def members_of(source: Any, request: Request) -> Mapping[str, Any]:
    """What has columns as a mapping of their names; an array as the only one, without a name.

    Raises
    ------
    InputError
        Nothing that has columns: what it is, and what was expected.
    """
    if (members := by_name(source)) is not None:
        return members
    if isinstance(source, list | tuple) and any(by_name(x) is not None for x in source):
        raise InputError(
            f"found a list of {type(source[0]).__name__}, expected them by number, such as "
            "{1: ..., 2: ...}"
        )
    array = as_array(source, request)
    if array.dtype.kind == "O" and not array.shape:
        raise InputError(
            f"found a {type(source).__name__}, expected the path of a file, an array, columns by "
            "name, or a data frame"
        )
    return {"": array}


def _name(name: Any) -> str:
    return f"maneuver_{name}" if isinstance(name, Integral) else str(name)
