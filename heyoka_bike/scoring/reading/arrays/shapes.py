"""Whatever holds columns, as a mapping of names to arrays, or to such mappings of the maneuvers.

Data frames and datasets are known by what they can do: none of the packages that make them is
imported. An axis of an array may be that of the maneuvers. A long table has a row for each value,
with its time and the name of what it is a value of.
"""

from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.arrays.columns import StoredArray, read_array, read_maneuvers
from heyoka_bike.scoring.reading.names.columns import (
    TIME,
    group_number,
    is_maneuver,
    is_time,
    recognise,
)
from heyoka_bike.scoring.reading.request import Request

# What Simulink calls the outputs of a model; its states may have the same shape.
_OUTPUTS = ("yout", "simout", "y")
# Axes of maneuvers, rows and columns: as NumPy's programs have them, as MATLAB's, others.
_ORDERS = ((0, 1, 2), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2))
# As pandas, R and others call the column of names and that of values.
_VARIABLE = ("variable", "name", "quantity", "signal", "column", "key", "measure")
_KINDS = {
    **dict.fromkeys(_VARIABLE, "variable"),
    **dict.fromkeys(("value", "values", "val"), "value"),
}


def by_name(x: Any) -> Mapping[str, Any] | None:
    """Return an object that has columns as a mapping of their names; None for another."""
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
    """Return columns as a mapping of their names; an array as the only one, without a name.

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


def is_long(names: Iterable[str]) -> bool:
    """True if these are names of the columns of a long table."""
    return _kinds(names).keys() >= {"time", "variable", "value"}


def _kinds(names: Iterable[str]) -> dict[str, str]:
    """The columns of a long table by what they have."""
    found = {}
    for name in names:
        kind = "time" if is_time(name) else "maneuver" if is_maneuver(name) else None
        if kind := kind or _KINDS.get(name.strip().lower()):
            found[kind] = name
    return found


def pivoted(members: Mapping[str, Any], request: Request) -> Mapping[str, Any]:
    """The columns of a long table, by maneuver if it has one; other members as they are.

    Raises
    ------
    InputError
        A value is there twice.
    """
    kinds = _kinds(members)
    if not is_long(members) or any(isinstance(members[n], Mapping) for n in kinds.values()):
        return members
    cells = {kind: np.ravel(members[name][()]).tolist() for kind, name in kinds.items()}
    maneuvers: list[int | None] = [None] * len(cells["time"])
    if "maneuver" in kinds:
        numbers = read_maneuvers(members[kinds["maneuver"]], request)
        maneuvers = [int(n) if np.isfinite(n) else None for n in numbers]
    groups: dict[int | None, dict[str, dict[Any, Any]]] = {}
    for number, at, x, word in zip(
        maneuvers, cells["time"], cells["value"], cells["variable"], strict=True
    ):
        name = word.decode("utf-8", "replace") if isinstance(word, bytes) else str(word)
        column = groups.setdefault(number, {}).setdefault(name, {})
        if at in column:
            raise request.error(f"found {name} at the time {at} twice, expected one value")
        column[at] = x
    if None in groups:
        return _wide(groups[None])
    return {f"maneuver_{number}": _wide(columns) for number, columns in groups.items()}


def _wide(columns: Mapping[str, Mapping[Any, Any]]) -> dict[str, Any]:
    """Columns by the times of their values as columns beside all times."""
    times = list(dict.fromkeys(at for column in columns.values() for at in column))
    wide = {name: [column.get(at) for at in times] for name, column in columns.items()}
    return {name: np.array(x, object) for name, x in {TIME: times, **wide}.items()}


def is_vector(x: Any) -> bool:
    """True if an array is a column; MATLAB has no arrays of one dimension."""
    return len(x.shape) == 1 or (len(x.shape) == 2 and 1 in x.shape)


def length(x: Any) -> int:
    """Number of values of a column."""
    return max(x.shape, default=0)


def arrays_in(members: Mapping[str, Any]) -> dict[str, Any]:
    """The members that are no groups of others."""
    return {name: x for name, x in members.items() if not isinstance(x, Mapping)}


def by_maneuver(members: Mapping[str, Any], request: Request) -> Mapping[str, Any]:
    """Groups of the maneuvers for which arrays have an axis; the members if they have none."""
    if any(map(group_number, members)):
        return members
    columns = _columns_by_maneuver(members, request)
    return columns or _table_by_maneuver(members, request) or members


def _columns_by_maneuver(members: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """Of columns such as ``roll_angle`` of shape (3, n), with one time or one of that shape."""
    arrays = arrays_in(members)
    times = [x for name, x in arrays.items() if is_time(name)]
    shapes = {tuple(x.shape) for name, x in arrays.items() if _is_unnumbered(name)}
    if not times or len(shapes) != 1 or len(shape := shapes.pop()) != 2:
        return {}
    fitting = [i for i in (0, 1) if _is_over_maneuvers(i, shape, times[0], request.count)]
    numbers = _numbers_along(arrays, shape[fitting[0]], request) if fitting else None
    if numbers is None:
        return {}
    names = [name for name, x in arrays.items() if tuple(x.shape) == shape]
    columns = {name: read_array(arrays[name], request.within(name)) for name in names}
    others = {n: x for n, x in members.items() if n not in columns and not is_maneuver(n)}
    return {
        f"maneuver_{n:.0f}": others | {k: x.take(i, fitting[0]) for k, x in columns.items()}
        for i, n in enumerate(numbers)
    }


def _is_unnumbered(name: str) -> bool:
    """True if the name is that of a column, and of no maneuver."""
    found = recognise(name)
    return found is not None and found[1] is None and found[0] != TIME


def _numbers_along(arrays: Mapping[str, Any], size: int, request: Request) -> Any:
    """Numbers of the maneuvers along an axis of that size; None if they are not told."""
    for name, x in arrays.items():
        if is_maneuver(name) and length(x) == size and 1 < size <= request.count:
            return read_maneuvers(x, request.within(name))
    return np.arange(1.0, size + 1) if size == request.count else None


def _is_over_maneuvers(axis: int, shape: Sequence[int], time: Any, count: int) -> bool:
    """True if an axis of columns of two is that of the maneuvers, and the other one of times."""
    size, rows = shape[axis], shape[1 - axis]
    if is_vector(time):
        return bool(rows == length(time) != size)
    return tuple(time.shape) == shape and size == count != rows


def _table_by_maneuver(members: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """Of an array of three axes, beside its times or with them."""
    arrays = arrays_in(members)
    times = {name: x for name, x in arrays.items() if is_time(name)}
    widths = [w - bool(times) for w in (request.widths if request.names else (9,))]
    fitting = [
        (name, order)
        for name, x in arrays.items()
        if len(x.shape) == 3 and 0 not in x.shape
        for width in widths
        for order in _ORDERS
        if x.shape[order[0]] == request.count and x.shape[order[2]] == width
    ]
    if len({name for name, _ in fitting}) != 1:
        return {}
    # Where several orders fit, it is the first of them.
    name, order = fitting[0]
    parts = read_array(arrays[name], request.within(name)).transpose(order)
    return {f"maneuver_{i}": {**times, name: part} for i, part in enumerate(parts, 1)}


def table_among(
    arrays: Mapping[str, Any], widths: Sequence[int]
) -> tuple[str, bool, str | None] | None:
    """The one array that has the columns: its name, and whether its columns are rows.

    With the name of the times beside it, if it has all columns but these. None if there is no such
    array, or more than one.
    """
    flat = {name: x for name, x in arrays.items() if len(x.shape) == 2}
    whole = [name for name, x in flat.items() if {*x.shape} & {*widths}]
    times = [name for name, x in arrays.items() if is_time(name) and is_vector(x)]
    if len(times) == 1:
        n = length(arrays[times[0]])
        beside = [
            name
            for name, x in flat.items()
            if any(tuple(x.shape) in ((n, w - 1), (w - 1, n)) for w in widths)
        ]
        if len(beside) > 1:
            beside = [name for name in beside if name.lower() in _OUTPUTS]
        if len(beside) == 1 and whole in ([], beside):
            return beside[0], arrays[beside[0]].shape[0] != n, times[0]
    return (whole[0], flat[whole[0]].shape[1] not in widths, None) if len(whole) == 1 else None
