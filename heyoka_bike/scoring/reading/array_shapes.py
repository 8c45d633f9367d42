"""Arrays of several maneuvers, and of columns without their time, as plain ones."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.scoring.reading.column_names import TIME, is_maneuver, recognise

# What Simulink calls the outputs of a model; its states may have the same shape.
_OUTPUTS = ("yout", "simout", "y")


def is_time(name: str) -> bool:
    """Whether the name is that of the times."""
    return recognise(name) == (TIME, None)


def is_vector(x: Any) -> bool:
    """Whether an array is a column; MATLAB has no arrays of one dimension."""
    return len(x.shape) == 1 or (len(x.shape) == 2 and 1 in x.shape)


def length(x: Any) -> int:
    """Number of values of a column."""
    return max(x.shape, default=0)


def maneuver_axis(shape: Sequence[int], count: int, width: int) -> tuple[int, int] | None:
    """Axes of the maneuvers and of the columns of an array of three; None if they cannot be told.

    Where several lengths fit, the order is maneuvers, rows, columns, or else rows, columns,
    maneuvers, MATLAB's.
    """
    for maneuvers, rows, columns in ((0, 1, 2), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        if shape[maneuvers] == count and shape[columns] == width and shape[rows] > 0:
            return maneuvers, columns
    return None


def one_maneuver(array: NDArray[Any], axes: tuple[int, int], i: int) -> NDArray[Any]:
    """Rows and columns of a maneuver, of an array of three axes."""
    maneuvers, columns = axes
    table: NDArray[Any] = np.take(array, i, maneuvers)
    return table if columns - (maneuvers < columns) == 1 else table.T


def over_maneuvers(members: Mapping[str, Any], count: int) -> tuple[int, list[str]] | None:
    """Axis of the maneuvers of columns such as ``roll_angle`` of shape (3, n), and their names.

    None if there are none such. There is one time for all maneuvers, or one of the same shape.
    """
    arrays = {name: x for name, x in members.items() if not isinstance(x, Mapping)}
    time = next((x for name, x in arrays.items() if is_time(name)), None)
    known = [n for n in arrays if (k := recognise(n)) and k[1] is None and not is_time(n)]
    shapes = {tuple(arrays[name].shape) for name in known}
    if time is None or len(shapes) != 1 or len(shape := shapes.pop()) != 2:
        return None
    if is_vector(time):
        axes = [axis for axis in (0, 1) if shape[1 - axis] == length(time) != shape[axis]]
    else:
        axes = [axis for axis in (0, 1) if shape[axis] == count != shape[1 - axis]]
        axes = axes if tuple(time.shape) == shape else []
    if not axes:
        return None
    axis = axes[0]
    has_numbers = any(is_maneuver(n) and length(x) == shape[axis] for n, x in arrays.items())
    if shape[axis] != count and not (has_numbers and 1 < shape[axis] < count):
        return None
    return axis, [name for name, x in arrays.items() if tuple(x.shape) == shape]


def beside_a_time(arrays: Mapping[str, Any], widths: Sequence[int]) -> tuple[str, str, bool] | None:
    """Names of the times and of an array of all other columns, and whether its columns are rows.

    None if there is no such pair, or more than one.
    """
    times = [name for name, x in arrays.items() if is_time(name) and is_vector(x)]
    if len(times) != 1:
        return None
    n = length(arrays[times[0]])
    tables = {
        name: tuple(x.shape) != (n, x.shape[1])
        for name, x in arrays.items()
        if len(x.shape) == 2 and any(tuple(x.shape) in ((n, w - 1), (w - 1, n)) for w in widths)
    }
    if len(tables) > 1:
        tables = {name: turn for name, turn in tables.items() if name.lower() in _OUTPUTS}
    if len(tables) != 1:
        return None
    ((name, is_turned),) = tables.items()
    return times[0], name, is_turned
