"""Arrays of several maneuvers, and of columns without their time, as plain ones."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.arrays.columns import read_array, read_maneuvers
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


def is_vector(x: Any) -> bool:
    """Whether an array is a column; MATLAB has no arrays of one dimension."""
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
    found = _columns_by_maneuver(members, request) or _table_by_maneuver(members, request)
    return found or members


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
    """Whether the name is that of a column, and of no maneuver."""
    found = recognise(name)
    return found is not None and found[1] is None and found[0] != TIME


def _numbers_along(arrays: Mapping[str, Any], size: int, request: Request) -> Any:
    """Numbers of the maneuvers along an axis of that size; None if they are not told."""
    for name, x in arrays.items():
        if is_maneuver(name) and length(x) == size and 1 < size <= request.count:
            return read_maneuvers(x, request.within(name))
    return np.arange(1.0, size + 1) if size == request.count else None


def _is_over_maneuvers(axis: int, shape: Sequence[int], time: Any, count: int) -> bool:
    """Whether an axis of columns of two is that of the maneuvers, and the other one of times."""
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
