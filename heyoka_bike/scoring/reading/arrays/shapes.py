"""Find which axis of an array is for the maneuvers, the rows and the columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.arrays.array_columns import read_array, read_maneuvers
from heyoka_bike.scoring.reading.arrays.groups import ArrayGroup, is_vector, length
from heyoka_bike.scoring.reading.names.heading import group_number, is_maneuver, parse_heading

# Names that Simulink gives to the outputs of a model. The array of its states may have the same
# shape.
_SIMULINK_OUTPUTS = ("yout", "simout", "y")
# Positions of the axes of maneuvers, rows and columns in an array: first the usual order in NumPy,
# then the usual order in MATLAB, then the remaining orders.
_ORDERS_OF_AXES = ((0, 1, 2), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2))


def by_maneuver(group: ArrayGroup) -> ArrayGroup:
    """Return a group with one inner group per maneuver if an array has an axis of maneuvers.

    Otherwise return the group unchanged.
    """
    if any(map(group_number, group.names)):
        return group
    parts = _columns_by_maneuver(group) or _table_by_maneuver(group)
    return ArrayGroup(parts, group.request) if parts else group


def _columns_by_maneuver(group: ArrayGroup) -> dict[str, Any]:
    """Split columns of two dimensions by maneuver; return an empty dict for other columns.

    The times have the same shape as the columns, or are one vector of n times.
    """
    arrays, request = group.arrays, group.request
    meant = [parse_heading(name) for name in arrays if name not in group.times]
    unnumbered = [x.text for x in meant if x.key is not None and x.maneuver is None]
    shapes = {tuple(arrays[name].shape) for name in unnumbered}
    if not group.times or len(shapes) != 1 or len(shape := shapes.pop()) != 2:
        return {}
    time = next(iter(group.times.values()))
    if is_vector(time):
        fitting = [i for i in (0, 1) if shape[1 - i] == length(time) != shape[i]]
    else:
        fitting = [i for i in (0, 1) if tuple(time.shape) == shape and shape[i] == request.count]
    if not fitting or len({*shape}) == 1:
        return {}
    axis, size = fitting[0], shape[fitting[0]]
    numbers = np.arange(1.0, size + 1)
    told = [n for n, x in arrays.items() if is_maneuver(n) and length(x) == size]
    if told and 1 < size <= request.count:
        numbers = read_maneuvers(arrays[told[0]], request.within(told[0]))
    elif size != request.count:
        return {}
    names = [name for name, x in arrays.items() if tuple(x.shape) == shape]
    columns = {name: read_array(arrays[name], request.within(name)) for name in names}
    members = {**arrays, **group.groups}
    others = {n: x for n, x in members.items() if n not in columns and not is_maneuver(n)}
    return {
        f"maneuver_{n:.0f}": others | {k: x.take(i, axis) for k, x in columns.items()}
        for i, n in enumerate(numbers)
    }


def _table_by_maneuver(group: ArrayGroup) -> dict[str, Any]:
    """Split an array of three dimensions by maneuver; return an empty dict without such an array.

    The array contains the times, or they are in an array of their own.
    """
    request = group.request
    widths = [w - bool(group.times) for w in (request.widths if request.names else (9,))]
    fitting = [
        (name, order)
        for name, x in group.arrays.items()
        if len(x.shape) == 3 and 0 not in x.shape
        for width in widths
        for order in _ORDERS_OF_AXES
        if x.shape[order[0]] == request.count and x.shape[order[2]] == width
    ]
    if len({name for name, _ in fitting}) != 1:
        return {}
    # If several orders of the axes fit the shape, use the first of them.
    name, order = fitting[0]
    parts = read_array(group.arrays[name], request.within(name)).transpose(order)
    return {f"maneuver_{i}": {**group.times, name: part} for i, part in enumerate(parts, 1)}


def table_among(group: ArrayGroup) -> tuple[str, bool, str | None] | None:
    """Return the name of the array that contains the columns, and whether it is transposed.

    The third item is the name of a separate array of times; None if the array contains them. Return
    None if there is no such array, or more than one.
    """
    widths = group.request.widths
    flat = {name: tuple(x.shape) for name, x in group.arrays.items() if len(x.shape) == 2}
    whole = [name for name, shape in flat.items() if {*shape} & {*widths}]
    times = [name for name, x in group.times.items() if is_vector(x)]
    if len(times) == 1:
        n = length(group.times[times[0]])
        fitting = {shape for w in widths for shape in ((n, w - 1), (w - 1, n))}
        beside = [name for name, shape in flat.items() if shape in fitting]
        if len(beside) > 1:
            beside = [name for name in beside if name.lower() in _SIMULINK_OUTPUTS]
        if len(beside) == 1 and whole in ([], beside):
            return beside[0], flat[beside[0]][0] != n, times[0]
    return (whole[0], flat[whole[0]][1] not in widths, None) if len(whole) == 1 else None
