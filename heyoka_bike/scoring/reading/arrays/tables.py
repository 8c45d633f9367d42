"""Vectors by name, of arrays in any shape: columns, one array of all, groups of the maneuvers."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import info
from heyoka_bike.scoring.reading.arrays import shapes
from heyoka_bike.scoring.reading.arrays.columns import (
    read_array,
    read_column,
    read_maneuvers,
    refused,
)
from heyoka_bike.scoring.reading.arrays.shapes import ArrayGroup
from heyoka_bike.scoring.reading.names import headings
from heyoka_bike.scoring.reading.names.numbers import is_coordinate
from heyoka_bike.scoring.reading.quanta import evened
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.vectors import Vector, Vectors

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
    if (members := shapes.by_name(source)) is None:
        if isinstance(source, list | tuple) and any(shapes.by_name(x) is not None for x in source):
            raise InputError(
                f"found a list of {type(source[0]).__name__}, expected them by number, such as "
                "{1: ..., 2: ...}"
            )
        array = shapes.as_array(source, request)
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
    group = shapes.by_maneuver(shapes.pivoted(group))
    if parts := group.of_maneuvers():
        of_each = [_table(part) for part in parts]
        found = [table for table in of_each if table]
        if found and None in of_each:
            raise _refusal(parts[of_each.index(None)])
        return found
    if table := _table(group):
        return [table]
    inner = group.groups.values() if depth < shapes.DEEPEST else ()
    below = [found for x in inner if (found := _search(ArrayGroup(x, group.request), depth + 1))]
    return below[0] if len(below) == 1 else []


def _table(group: ArrayGroup) -> Vectors | None:
    """Columns by their names, in their order or of one array; None if there are none."""
    arrays, request = group.arrays, group.request
    vectors = {name: x for name, x in arrays.items() if shapes.is_vector(x)}
    known = [name for name in vectors if (request.known or headings.recognise)(name)]
    if request.names is None and headings.are_names(known, request):
        return _named(group, known)
    is_all = request.is_ordered and len(vectors) == len(arrays) and request.names is None
    if len(vectors) in request.widths and (request.names or is_all):
        return _by_place(vectors, request, list(vectors) if is_all else None)
    if (table := shapes.table_among(group)) or list(arrays) == [""]:
        return _of_table(group, *(table or ("", False, None)))
    return None


def _refusal(group: ArrayGroup, depth: int = 0) -> InputError:
    """The error that says that there are no columns, in the one group that might have had them."""
    parts = group.of_maneuvers()
    if depth < shapes.DEEPEST and not parts and len(group.groups) == 1:
        parts = [ArrayGroup(x, group.request) for x in group.groups.values()]
    if depth < shapes.DEEPEST and len(parts) == 1:
        return _refusal(parts[0], depth + 1)
    found = headings.names_found([name for name in group.names if name])
    return group.request.not_columns(found)


def _named(group: ArrayGroup, known: Sequence[str]) -> Vectors:
    """Columns that are known by name, with those that say what the others mean."""
    arrays, request = group.arrays, group.request
    rows = shapes.length(arrays[known[headings.time_among(known)]])
    beside = {n: x for n, x in arrays.items() if headings.is_maneuver(n) or is_coordinate(n)}
    fitting = (n for n, x in beside.items() if shapes.is_vector(x) and shapes.length(x) == rows)
    names = [*known, *fitting]
    others = [n for n in (*arrays, *group.groups) if not _goes_with(n, names)]
    return Vectors(
        _columns({n: arrays[n] for n in names}, names, request, arrays),
        names,
        is_ordered=False,
        maneuver=request.group or _maneuver_told(arrays, request),
        findings=(headings.left_out(others),) if others else (),
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
    said = f"The table has {rows} rows and {width} columns; its rows are taken as columns."
    return replace(vectors, findings=(info("transposed", said, shape=[rows, width]),))


def _columns(
    vectors: Mapping[str, Any], meant: Sequence[str], request: Request,
    rests: Mapping[str, Any] | None = None,
) -> list[Vector]:  # fmt: skip
    """The vectors as columns of these names; the rests beyond binary64 are those of ``NAME_lo``."""
    rows = {name: shapes.length(x) for name, x in vectors.items()}
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
    return evened(columns, headings.time_among(meant)) if are_decimals else columns


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
