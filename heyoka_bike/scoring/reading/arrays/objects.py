"""Data frames, datasets and maneuvers by number as plain mappings of arrays.

They are known by what they can do: none of the packages that make them is imported.
"""

from collections.abc import Iterable, Mapping
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.names.columns import TIME, recognise

_DEEPEST = 4  # a mapping may contain itself


def plain(source: Any, depth: int = 0) -> Any:
    """What is given as an array, or as a mapping of names to arrays or to such mappings.

    Raises
    ------
    InputError
        Nothing that has columns.
    """
    if isinstance(source, Mapping):
        members = {**_coordinates(source), **source}
        return {_name(name): _inner(x, depth) for name, x in members.items()}
    if _is_simulation(source):
        return source.table()
    if _is_frame(source):
        # Those of pyarrow are the arrays themselves.
        names = getattr(source, "column_names", source.columns)
        frame = {str(name): np.asarray(source[name]) for name in names}
        return _index(source, frame) | frame
    if isinstance(source, list | tuple) and any(map(_has_columns, source)):
        raise InputError(
            f"found a list of {type(source[0]).__name__}, expected them by number, such as "
            "{1: ..., 2: ...}"
        )
    array = _array(source)
    if array.dtype.kind == "O" and not array.shape:
        raise InputError(
            f"found a {type(source).__name__}, expected the path of a file, an array, columns by "
            "name, or a data frame"
        )
    return array if hasattr(source, "__array__") else source


def _array(source: Any) -> NDArray[Any]:
    try:
        array = np.asanyarray(source)
        # Of a matrix every part is a matrix, too.
        return np.asarray(array) if isinstance(array, np.matrix) else array
    except (ValueError, TypeError, OverflowError):
        return np.empty(1)  # what is wrong in it is said where it is read


def _name(name: Any) -> str:
    return f"maneuver_{name}" if isinstance(name, Integral) else str(name)


def _inner(x: Any, depth: int) -> Any:
    """A member of a mapping: a column, or what has columns itself."""
    if depth < _DEEPEST and _has_columns(x):
        return plain(x, depth + 1)
    # A column of a frame is indexed by names, not as an array is.
    return _array(x) if hasattr(x, "__array__") else x


def _has_columns(x: Any) -> bool:
    return isinstance(x, Mapping) or _is_simulation(x) or _is_frame(x)


def _is_simulation(x: Any) -> bool:
    return not isinstance(x, type) and callable(getattr(x, "table", None))


def _is_frame(x: Any) -> bool:
    names = getattr(x, "columns", None)
    return not isinstance(x, type) and hasattr(x, "__getitem__") and isinstance(names, Iterable)


def _coordinates(source: Mapping[Any, Any]) -> dict[str, Any]:
    """Of a dataset of xarray, where the time is one."""
    return {str(name): x for name, x in dict(getattr(source, "coords", {})).items()}


def _index(source: Any, frame: Mapping[str, Any]) -> dict[str, Any]:
    """The index of a frame of pandas, where that is the time and no column is."""
    name = getattr(getattr(source, "index", None), "name", None)
    if any(recognise(column) == (TIME, None) for column in frame):
        return {}
    if not isinstance(name, str) or recognise(name) != (TIME, None):
        return {}
    return {name: np.asarray(source.index)}
