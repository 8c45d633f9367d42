"""Whatever holds columns, as a group of arrays by name, or of such groups of the maneuvers.

Data frames and datasets are known by what they can do: none of the packages that make them is
imported. An axis of an array may be that of the maneuvers. A long table has a row for each value,
with its time and the name of what it is a value of.
"""

from collections.abc import Iterable, Mapping
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import quoted
from heyoka_bike.scoring.reading.arrays.columns import StoredArray, read_array, read_maneuvers
from heyoka_bike.scoring.reading.names import headings
from heyoka_bike.scoring.reading.request import Request

DEEPEST = 4
"""Groups in groups: of a program, of a maneuver, of its columns. A group may contain itself."""

MOST_MEMBERS = 100_000
"""Arrays and groups of a file; a group may be in itself, many times."""

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
        members = {**getattr(x, "coords", {}), **x}.items()
        return {f"maneuver_{n}" if isinstance(n, Integral) else str(n): y for n, y in members}
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
    if isinstance(name, str) and headings.is_time(name) and not any(map(headings.is_time, frame)):
        return {name: index, **frame}
    return frame


def as_array(x: Any, request: Request) -> Any:
    """Return an array, or what reads one later, of what a member holds.

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


class ArrayGroup:
    """The arrays in a part of a file, and the groups of others in it.

    Parameters
    ----------
    members
        Both by name: arrays, or what becomes one, and what `by_name` knows.
    request
        The request to read this part.

    Attributes
    ----------
    request : Request
    names : list of str
        Of all members.
    arrays : dict of str to array
        Anything that has a type and a shape.
    groups : dict of str to mapping
        Their members by name.
    times : dict of str to array
        The arrays whose name is that of times.

    Raises
    ------
    InputError
        Too many members, or one that is no array.
    """

    def __init__(self, members: Mapping[str, Any], request: Request) -> None:
        if len(members) > MOST_MEMBERS:
            raise request.error(
                f"found {len(members)} arrays and groups, expected at most {MOST_MEMBERS}"
            )
        self.request, self.names = request, list(members)
        self.arrays: dict[str, Any] = {}
        self.groups: dict[str, Mapping[str, Any]] = {}
        for name, x in members.items():
            within = request.within(name)
            columns = by_name(x)
            if columns is None and (array := as_array(x, within)).dtype.names:
                records = read_array(array, within).ravel()
                columns = {field: records[field] for field in array.dtype.names}
            if columns is None:
                self.arrays[name] = array
            else:
                self.groups[name] = columns
        self.times = {name: x for name, x in self.arrays.items() if headings.is_time(name)}

    def of_maneuvers(self) -> list["ArrayGroup"]:
        """The group of each maneuver, with the times that may be stored once for all of them.

        Raises
        ------
        InputError
            A maneuver is there twice.
        """
        times = {n: x for n, x in self.arrays.items() if headings.is_time(n.removesuffix("_lo"))}
        found: dict[int, ArrayGroup] = {}
        for name in self.names:
            number, x = headings.group_number(name), self.arrays.get(name)
            if number is None or (x is not None and len(x.shape) != 2):
                continue
            if number in found:
                raise self.request.error(
                    f"found maneuver {number} a second time ({quoted(name)}), expected it once"
                )
            group = self.groups.get(name, {name if times else "": x})
            shared = {} if any(map(headings.is_time, group)) else times
            found[number] = ArrayGroup({**shared, **group}, self.request.of_maneuver(number))
        return [found[number] for number in sorted(found)]


def long_columns(names: Iterable[str]) -> dict[str, str]:
    """Names of the columns of a long table by what they have; nothing for another table."""
    found = {}
    for name in names:
        kind = "maneuver" if headings.is_maneuver(name) else _KINDS.get(name.strip().lower())
        if kind := "time" if headings.is_time(name) else kind:
            found[kind] = name
    return found if found.keys() >= {"time", "variable", "value"} else {}


def pivoted(group: ArrayGroup) -> ArrayGroup:
    """The columns of a long table, by maneuver if it has one; another group as it is.

    Raises
    ------
    InputError
        A value is there twice.
    """
    kinds = long_columns(group.names)
    if not kinds or not group.groups.keys().isdisjoint(kinds.values()):
        return group
    cells = {kind: np.ravel(group.arrays[name][()]).tolist() for kind, name in kinds.items()}
    numbers = np.full(len(cells["time"]), np.nan)
    if "maneuver" in kinds:
        numbers = read_maneuvers(group.arrays[kinds["maneuver"]], group.request)
    found: dict[str, dict[str, dict[Any, Any]]] = {}
    for number, at, x, word in zip(
        numbers, cells["time"], cells["value"], cells["variable"], strict=True
    ):
        name = word.decode("utf-8", "replace") if isinstance(word, bytes) else str(word)
        maneuver = f"maneuver_{int(number)}" if np.isfinite(number) else ""
        column = found.setdefault(maneuver, {}).setdefault(name, {})
        if at in column:
            raise group.request.error(f"found {name} at the time {at} twice, expected one value")
        column[at] = x
    wide: dict[str, dict[str, Any]] = {}
    for maneuver, columns in found.items():
        times = list(dict.fromkeys(at for column in columns.values() for at in column))
        cells = {name: [column.get(at) for at in times] for name, column in columns.items()}
        cells = {headings.TIME: times, **cells}
        wide[maneuver] = {name: np.array(x, object) for name, x in cells.items()}
    return ArrayGroup(wide.get("", wide), group.request)


def is_vector(x: Any) -> bool:
    """True if an array is a column; MATLAB has no arrays of one dimension."""
    return len(x.shape) == 1 or (len(x.shape) == 2 and 1 in x.shape)


def length(x: Any) -> int:
    """Number of values of a column."""
    return max(x.shape, default=0)


def by_maneuver(group: ArrayGroup) -> ArrayGroup:
    """Groups of the maneuvers for which arrays have an axis; the group if they have none."""
    if any(map(headings.group_number, group.names)):
        return group
    parts = _columns_by_maneuver(group) or _table_by_maneuver(group)
    return ArrayGroup(parts, group.request) if parts else group


def _columns_by_maneuver(group: ArrayGroup) -> dict[str, Any]:
    """Of columns such as ``roll_angle`` of shape (3, n), with one time or one of that shape."""
    arrays, request = group.arrays, group.request
    meant = {name: headings.recognise(name) for name in arrays if name not in group.times}
    unnumbered = [name for name, found in meant.items() if found and found[1] is None]
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
    told = [n for n, x in arrays.items() if headings.is_maneuver(n) and length(x) == size]
    if told and 1 < size <= request.count:
        numbers = read_maneuvers(arrays[told[0]], request.within(told[0]))
    elif size != request.count:
        return {}
    names = [name for name, x in arrays.items() if tuple(x.shape) == shape]
    columns = {name: read_array(arrays[name], request.within(name)) for name in names}
    members = {**arrays, **group.groups}
    others = {n: x for n, x in members.items() if n not in columns and not headings.is_maneuver(n)}
    return {
        f"maneuver_{n:.0f}": others | {k: x.take(i, axis) for k, x in columns.items()}
        for i, n in enumerate(numbers)
    }


def _table_by_maneuver(group: ArrayGroup) -> dict[str, Any]:
    """Of an array of three axes, beside its times or with them."""
    request = group.request
    widths = [w - bool(group.times) for w in (request.widths if request.names else (9,))]
    fitting = [
        (name, order)
        for name, x in group.arrays.items()
        if len(x.shape) == 3 and 0 not in x.shape
        for width in widths
        for order in _ORDERS
        if x.shape[order[0]] == request.count and x.shape[order[2]] == width
    ]
    if len({name for name, _ in fitting}) != 1:
        return {}
    # Where several orders fit, it is the first of them.
    name, order = fitting[0]
    parts = read_array(group.arrays[name], request.within(name)).transpose(order)
    return {f"maneuver_{i}": {**group.times, name: part} for i, part in enumerate(parts, 1)}


def table_among(group: ArrayGroup) -> tuple[str, bool, str | None] | None:
    """The one array that has the columns: its name, and whether its columns are rows.

    With the name of the times beside it, if it has all columns but these. None if there is no such
    array, or more than one.
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
            beside = [name for name in beside if name.lower() in _OUTPUTS]
        if len(beside) == 1 and whole in ([], beside):
            return beside[0], flat[beside[0]][0] != n, times[0]
    return (whole[0], flat[whole[0]][1] not in widths, None) if len(whole) == 1 else None
