"""Vectors by name, of arrays in any shape: columns, one array of all, groups of the maneuvers.

Columns are binary numbers, packed or not by the CF conventions, or decimals as text. Packed numbers
are smaller ones, with a scale and an offset.

Data frames and datasets are known by what they can do: none of the packages that make them is
imported. An axis of an array may be that of the maneuvers. A long table has a row for each value,
with its time and the name of what it is a value of.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from math import prod
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array, two_sum
from heyoka_bike.scoring.evidence import Reason, Transposed
from heyoka_bike.scoring.reading import headings, quanta
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.results import Vector, Vectors
from heyoka_bike.scoring.reading.text import Dialect, rests

# Ten million rows of 25 numbers; more is what a damaged header says.
MOST_BYTES = 2 * 10**9
"""Size of the largest array that is read."""

_REFUSED = {
    "b": "truth values", "c": "complex numbers", "m": "time differences", "M": "dates",
    "O": "Python objects", "S": "text", "U": "text", "T": "text", "V": "records",
}  # fmt: skip
_POINT = Dialect("", ".")
# Numbers of a column of which digits are counted.
_COUNTED = 2000
# Of these the digits beyond binary64 are looked at.
_LOOKED_AT = 40
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


@dataclass(frozen=True, slots=True)
class StoredArray:
    """An array of this type and shape, read when it is wanted."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    read: Callable[[], Any]

    def __getitem__(self, index: tuple[()]) -> Any:
        return self.read()


def unpacked(source: Any, attributes: Mapping[str, Any]) -> Any:
    """The array, which unpacks its numbers if they are packed or stand for what is missing.

    Parameters
    ----------
    source
        What has the packed numbers: anything with a type and a shape.
    attributes
        Of the array, by the names of the conventions.
    """
    is_packed = _SCALE in attributes or _OFFSET in attributes
    if source.dtype.kind not in "iuf" or not (is_packed or {*_MISSING} & {*attributes}):
        return source
    is_as_it_was = source.dtype.kind == "f" and not is_packed
    dtype = source.dtype if is_as_it_was else np.dtype(np.float64)
    missing = [x for n in _MISSING if n in attributes for x in np.ravel(attributes[n])]
    step = float(np.ravel(attributes.get(_SCALE, 1))[0])
    offset = float(np.ravel(attributes.get(_OFFSET, 0))[0])

    def read() -> Any:
        packed = np.asarray(source[()])
        values: Any = packed.astype(dtype)
        if is_packed:
            # So 3 steps of 0.1 are 0.3, and not the next number above it.
            inverse = np.rint(1 / step) if step else 0.0
            is_whole = inverse and 1 / inverse == step
            values = ((values / inverse if is_whole else values * step) + offset).view(Steps)
            values.step = step if packed.dtype.kind in "iu" else None
        values[np.isin(packed, missing)] = np.nan
        return values

    return StoredArray(dtype, source.shape, read)


def read_array(source: Any, request: Request) -> NDArray[Any]:
    """An array of real numbers, or of Python objects that may be decimals, in memory.

    Raises
    ------
    InputError
        Of another kind, empty or too large.
    """
    dtype = source.dtype
    if dtype.kind not in "fiuO" and not dtype.names:
        raise refused(dtype, request)
    size = prod(source.shape) * dtype.itemsize
    if size > MOST_BYTES:
        raise request.error(f"found an array of {size} bytes, expected at most {MOST_BYTES}")
    array = np.ma.filled(source[()], np.nan) if dtype.kind == "f" else np.asanyarray(source[()])
    if array.size == 0:
        raise request.error("found an empty array, expected rows")
    return array


def read_column(source: Any, lo: Any, is_time: bool, request: Request) -> Vector:
    """A column; its rest beyond binary64 may be another one.

    Raises
    ------
    InputError
        Not real numbers, or a rest of another length.
    """
    array = read_array(source, request).ravel()
    if step := getattr(array, "step", None):
        return quanta.column_of_steps(np.asarray(array), step)
    if array.dtype.kind == "O":
        numbers = _decimals(array, request)
        if lo is None:
            return _decimal_column(numbers, is_time)
        array = np.array(numbers, dtype=np.float64)
    bits = 53 if array.dtype.kind != "f" else int(np.finfo(array.dtype).nmant) + 1
    remainder: Array | None = None
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        values: Array = array.astype(np.float64)
        if lo is not None:
            remainder = read_column(lo, None, False, request).values
            if remainder.shape != values.shape:
                raise request.error(
                    f"found {len(values)} values and {len(remainder)} of their second parts, "
                    "expected the same number"
                )
            values, remainder = two_sum(values, remainder)
            bits = 2 * bits
        elif bits > 53:
            remainder = (array - values).astype(np.float64)
    if remainder is not None:
        remainder[~np.isfinite(values)] = 0.0
    column = quanta.binary_column(values, remainder, bits)
    return column if lo is None else replace(column, significant=None)


def read_maneuvers(source: Any, request: Request) -> Array:
    """The numbers in a column of maneuvers, as numbers or as names; NaN where there is none."""
    if source.dtype.kind not in "OSUT":
        return read_column(source, None, False, request).values
    found: list[float] = []
    for x in np.asarray(source[()]).ravel().tolist():
        text = x.decode("latin-1") if isinstance(x, bytes) else str(x)
        number = headings.group_number(text)
        found.append(float(_POINT.number(text) or "nan") if number is None else number)
    return np.array(found, dtype=np.float64)


def _decimals(array: NDArray[Any], request: Request) -> list[str]:
    """Objects as decimals that `float` reads."""
    items: list[Any] = array.tolist()
    for x in items:
        if isinstance(x, bool) or not isinstance(x, str | int | float | Decimal | None):
            raise refused(np.dtype(bool) if isinstance(x, bool) else array.dtype, request)
    numbers = _POINT.numbers(["nan" if x is None else str(x).strip().lower() for x in items])
    found = [number for number in numbers if number is not None]
    if len(found) < len(items):
        i = numbers.index(None)
        raise request.error(f"row {i + 1}: found {quoted(items[i])}, expected a number")
    return found


def _decimal_column(numbers: Sequence[str], is_time: bool) -> Vector:
    some = [x for x in numbers if x != "nan"]
    looked_at = some[:: max(1, len(some) // _LOOKED_AT)]
    is_exact = bool(some) and quanta.are_beyond_binary64(looked_at, is_time)
    values = np.array(numbers, dtype=np.float64)
    values[np.isnan(values)] = np.inf
    lo = rests(numbers, values) if is_time or is_exact else None
    written = numbers[:: max(1, len(numbers) // _COUNTED)]
    column = quanta.written_column(values, lo, written, is_time)
    return replace(column, significant=None) if is_time and is_exact else column


def refused(dtype: np.dtype[Any], request: Request) -> InputError:
    """Return the error for values that are no real numbers."""
    found = _REFUSED.get(dtype.kind, str(dtype))
    return request.error(f"found {found}, expected real numbers")


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


_ALTERNATES = frozenset(c.name for c in COLUMNS)


def tables(source: Any, request: Request) -> list[Vectors]:
    """The vectors in an array or in a mapping of names to arrays, or to such mappings.

    Parameters
    ----------
    source
        An array of rows and columns, or of maneuvers, rows and columns; an array with named fields;
        or a mapping of names to columns, to one array of all columns, or of ``maneuver_N`` to any
        of these. Columns may have an axis for the maneuvers, and the rest beyond binary64 beside
        them (``time_lo``). The time may stand beside an array of the other columns. Python's
        objects are decimals.
    request
        The request to read it.

    Raises
    ------
    InputError
        Not columns of real numbers.
    """
    if (members := by_name(source)) is None:
        if isinstance(source, list | tuple) and any(by_name(x) is not None for x in source):
            raise InputError(
                f"found a list of {type(source[0]).__name__}, expected them by number, such as "
                "{1: ..., 2: ...}"
            )
        array = as_array(source, request)
        if array.dtype.kind == "O" and not array.shape:
            raise InputError(
                f"found a {type(source).__name__}, expected the path of a file, an array, columns "
                "by name, or a data frame"
            )
        members = {"": array}
    group = ArrayGroup(members, request)
    found = _search(group)
    if not found:
        raise _refusal(group)
    return found


def _search(group: ArrayGroup, depth: int = 0) -> list[Vectors]:
    """The tables in a group, or in one of those in it; nothing without any."""
    group = by_maneuver(pivoted(group))
    if parts := group.of_maneuvers():
        of_each = [_table(part) for part in parts]
        found = [table for table in of_each if table]
        if found and None in of_each:
            raise _refusal(parts[of_each.index(None)])
        return _with_known_beside(found, group)
    if table := _table(group):
        return [table]
    inner = group.groups.values() if depth < DEEPEST else ()
    below = [found for x in inner if (found := _search(ArrayGroup(x, group.request), depth + 1))]
    return _with_known_beside(below[0], group) if len(below) == 1 else []


def _with_known_beside(
    found: list[Vectors], group: ArrayGroup, used: Sequence[str | None] = ()
) -> list[Vectors]:
    """The tables, the first with the evidence that arrays of known names stand beside them."""
    # A single number is a parameter.
    rows = (name for name, x in group.arrays.items() if name not in used and length(x) > 1)
    known = [name for name in rows if _is_known_column(name)]
    if not found or not known:
        return found
    lost = headings.set_aside(known, group.request, Reason.BESIDE_A_TABLE)
    return [replace(found[0], seen=(*found[0].seen, lost)), *found[1:]]


def _is_known_column(name: str) -> bool:
    """True if a name is that of a column of the benchmark, and not of a group of columns."""
    found = headings.recognise(name)
    is_column = found is not None and found[0] in BENCHMARK_COLUMNS
    return is_column and headings.group_number(name) is None


def _table(group: ArrayGroup) -> Vectors | None:
    """Columns by their names, in their order or of one array; None if there are none."""
    arrays, request = group.arrays, group.request
    vectors = {name: x for name, x in arrays.items() if is_vector(x)}
    known = [name for name in vectors if (request.known or headings.recognise)(name)]
    if request.names is None and headings.are_names(known, request):
        return _named(group, known)
    is_all = request.is_ordered and len(vectors) == len(arrays) and request.names is None
    if len(vectors) in request.widths and (request.names or is_all):
        return _by_place(vectors, request, list(vectors) if is_all else None)
    if (table := table_among(group)) or list(arrays) == [""]:
        name, is_turned, time = table or ("", False, None)
        found = _of_table(group, name, is_turned, time)
        return _with_known_beside([found], group, (name, time))[0]
    return None


def _refusal(group: ArrayGroup, depth: int = 0) -> InputError:
    """The error that says that there are no columns, in the one group that might have had them."""
    parts = group.of_maneuvers()
    if depth < DEEPEST and not parts and len(group.groups) == 1:
        parts = [ArrayGroup(x, group.request) for x in group.groups.values()]
    if depth < DEEPEST and len(parts) == 1:
        return _refusal(parts[0], depth + 1)
    found = headings.names_found([name for name in group.names if name])
    return group.request.not_columns(found)


def _named(group: ArrayGroup, known: Sequence[str]) -> Vectors:
    """Columns that are known by name, with those that say what the others mean."""
    arrays, request = group.arrays, group.request
    rows = length(arrays[known[headings.time_among(known)]])
    beside = {
        n: x for n, x in arrays.items() if headings.is_maneuver(n) or headings.is_coordinate(n)
    }
    fitting = (n for n, x in beside.items() if is_vector(x) and length(x) == rows)
    names = [*known, *fitting]
    others = [n for n in (*arrays, *group.groups) if not _goes_with(n, names)]
    return Vectors(
        _columns({n: arrays[n] for n in names}, names, request, arrays),
        names,
        is_ordered=False,
        maneuver=request.group or _maneuver_told(arrays, request),
        seen=(headings.left_out(others, request),) if others else (),
    )


def _by_place(
    vectors: Mapping[str, Any], request: Request, names: list[str] | None = None
) -> Vectors:
    """Columns in the order that was told, or that of the benchmark."""
    meant = [*(request.names or (headings.TIME,)), *([""] * len(vectors))]
    return Vectors(_columns(vectors, meant, request), names, maneuver=request.group)


def _of_table(group: ArrayGroup, name: str, is_turned: bool, time: str | None) -> Vectors:
    """The columns of an array that has all of them, or all but the times, by their place."""
    source, request, part = group.arrays[name], group.request, group.request.within(name)
    shape = tuple(source.shape)
    if len(shape) != 2:
        if source.dtype.kind not in ("fiuO" if len(shape) == 1 else "fiu"):
            raise refused(source.dtype, part)
        raise part.not_columns(f"an array of shape {shape}")
    array = read_array(source, part)
    if time is None and not {*shape} & {*request.widths}:
        raise part.wrong_width(shape[1], shape[0])
    label = f"{name}: column" if name else "column"
    first = {} if time is None else {time: group.times[time]}
    columns = enumerate(array if is_turned else array.T, 1 + len(first))
    vectors = _by_place(first | {f"{label} {j}": x for j, x in columns}, request)
    if first or not is_turned:
        return vectors
    rows, width = shape
    return replace(vectors, seen=(Transposed(rows, width),))


def _columns(
    vectors: Mapping[str, Any], meant: Sequence[str], request: Request,
    rests: Mapping[str, Any] | None = None,
) -> list[Vector]:  # fmt: skip
    """The vectors as columns of these names; the rests beyond binary64 are those of ``NAME_lo``."""
    rows = {name: length(x) for name, x in vectors.items()}
    first = next(iter(rows))
    for name, count in rows.items():
        if count != rows[first]:
            raise request.error(
                f"found {rows[first]} values of {quoted(first)} and {count} of {quoted(name)}, "
                "expected the same number"
            )
    columns = []
    for name, (label, x) in zip(meant, vectors.items(), strict=False):
        part, lo = request.within(label), (rests or {}).get(f"{label}_lo")
        if headings.is_maneuver(name):
            x, lo = read_maneuvers(x, part), None
        columns.append(read_column(x, lo, headings.is_time(name), part))
    # Of decimals, a constant column is written like the others, as in a text.
    are_decimals = any(c.significant for c in columns)
    return quanta.evened(columns, headings.time_among(meant)) if are_decimals else columns


def _maneuver_told(arrays: Mapping[str, Any], request: Request) -> int | None:
    """The number of the maneuver that stands beside columns, if it does."""
    for name, x in arrays.items():
        if headings.is_maneuver(name) and np.prod(x.shape) == 1:
            number = read_maneuvers(x, request.within(name))[0]
            return int(number) if np.isfinite(number) else None
    return None


def _goes_with(name: str, names: Sequence[str]) -> bool:
    """True if a name is one of these, or that of what files of the reference have beside them."""
    stem = name.removesuffix("_lo").removesuffix("_bound")
    is_beside = stem in _ALTERNATES or name == "dense" or headings.is_maneuver(name)
    return name in names or stem in names or is_beside
