"""Vectors by name, of arrays in any shape: columns, one array of all, groups of the maneuvers."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import info
from heyoka_bike.scoring.reading.arrays.columns import (
    read_array,
    read_column,
    read_maneuvers,
    refused,
)
from heyoka_bike.scoring.reading.arrays.shapes import (
    arrays_in,
    as_array,
    by_maneuver,
    by_name,
    is_vector,
    length,
    members_of,
    pivoted,
    table_among,
)
from heyoka_bike.scoring.reading.names.columns import (
    TIME,
    are_names,
    group_number,
    is_maneuver,
    is_time,
    left_out,
    names_found,
    recognise,
    time_among,
)
from heyoka_bike.scoring.reading.names.numbers import is_coordinate
from heyoka_bike.scoring.reading.quanta import evened
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.vectors import Vector, Vectors

DEEPEST = 4
"""Groups in groups: of a program, of a maneuver, of its columns. A group may contain itself."""

MOST_MEMBERS = 100_000
"""Arrays and groups of a file; a group may be in itself, many times."""

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
    members = members_of(source, request)
    found = _search(members, request)
    if not found:
        raise _refusal(members, request)
    return found


def _search(members: Mapping[str, Any], request: Request, depth: int = 0) -> list[Vectors]:
    """The tables in the members, or in those of one of them; nothing without any."""
    members = by_maneuver(pivoted(_members(members, request), request), request)
    if groups := _groups(members, request):
        of_each = [_table(*group) for group in groups]
        found = [table for table in of_each if table]
        if found and None in of_each:
            raise _refusal(*groups[of_each.index(None)])
        return found
    if table := _table(members, request):
        return [table]
    inner = [x for x in members.values() if isinstance(x, Mapping) and depth < DEEPEST]
    below = [found for x in inner if (found := _search(x, request, depth + 1))]
    return below[0] if len(below) == 1 else []


def _groups(
    members: Mapping[str, Any], request: Request
) -> list[tuple[Mapping[str, Any], Request]]:
    """The members of each maneuver, with the times that may be stored once for all of them."""
    times = {n: x for n, x in arrays_in(members).items() if is_time(n.removesuffix("_lo"))}
    groups = {}
    for name, x in members.items():
        number = group_number(name)
        if number is None or not (isinstance(x, Mapping) or len(x.shape) == 2):
            continue
        if number in groups:
            raise request.error(
                f"found maneuver {number} a second time ({quoted(name)}), expected it once"
            )
        own = request.of_maneuver(number)
        group = x if isinstance(x, Mapping) else {name if times else "": x}
        shared = {} if any(map(is_time, group)) else times
        groups[number] = _members({**shared, **group}, own), own
    return [groups[number] for number in sorted(groups)]


def _table(members: Mapping[str, Any], request: Request) -> Vectors | None:
    """Columns by their names, in their order or of one array; None if there are none."""
    arrays, widths = arrays_in(members), request.widths
    vectors = {name: x for name, x in arrays.items() if is_vector(x)}
    known = [name for name in vectors if (request.known or recognise)(name)]
    if request.names is None and are_names(known, request):
        return _named(members, known, request)
    is_all = request.is_ordered and len(vectors) == len(arrays) and request.names is None
    if len(vectors) in widths and (request.names or is_all):
        return _by_place(vectors, request, list(vectors) if is_all else None)
    if (table := table_among(arrays, widths)) or list(arrays) == [""]:
        return _of_table(arrays, *(table or ("", False, None)), request)
    return None


def _refusal(members: Mapping[str, Any], request: Request, depth: int = 0) -> InputError:
    """The error that says that there are no columns, in the one group that might have had them."""
    members = _members(members, request)
    inner = [(x, request) for x in members.values() if isinstance(x, Mapping)]
    inner = _groups(members, request) or inner
    if len(inner) == 1 and depth < DEEPEST:
        ((group, part),) = inner
        return _refusal(group, part, depth + 1)
    return request.not_columns(names_found([name for name in members if name]))


def _named(members: Mapping[str, Any], known: Sequence[str], request: Request) -> Vectors:
    """Columns that are known by name, with those that say what the others mean."""
    arrays = arrays_in(members)
    rows = length(arrays[known[time_among(known)]])
    beside = [n for n in arrays if is_maneuver(n) or is_coordinate(n)]
    names = [*known, *(n for n in beside if is_vector(arrays[n]) and length(arrays[n]) == rows)]
    others = [
        name
        for name in dict.fromkeys((*arrays, *members))
        if name not in names and not _goes_with(name, names)
    ]
    return Vectors(
        _columns({n: arrays[n] for n in names}, names, request, arrays),
        names,
        is_ordered=False,
        maneuver=request.group or _maneuver_told(arrays, request),
        findings=(left_out(others),) if others else (),
    )


def _by_place(
    vectors: Mapping[str, Any], request: Request, names: list[str] | None = None
) -> Vectors:
    """Columns in the order that was told, or that of the benchmark."""
    meant = [*(request.names or (TIME,)), *([""] * len(vectors))]
    return Vectors(_columns(vectors, meant, request), names, maneuver=request.group)


def _of_table(
    arrays: Mapping[str, Any], name: str, is_turned: bool, time: str | None, request: Request
) -> Vectors:
    """The columns of an array that has all of them, or all but the times, by their place."""
    source, part = arrays[name], request.within(name)
    shape = tuple(source.shape)
    if len(shape) != 2:
        if source.dtype.kind not in ("fiuO" if len(shape) == 1 else "fiu"):
            raise refused(source.dtype, part)
        raise part.not_columns(f"an array of shape {shape}")
    array = read_array(source, part)
    if time is None and not {*shape} & {*request.widths}:
        raise part.wrong_width(shape[1], shape[0])
    label = f"{name}: column" if name else "column"
    first = {} if time is None else {time: arrays[time]}
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
    first = next(iter(vectors))
    for name, x in vectors.items():
        if length(x) != length(vectors[first]):
            raise request.error(
                f"found {length(vectors[first])} values of {quoted(first)} and {length(x)} of "
                f"{quoted(name)}, expected the same number"
            )
    columns = []
    for name, (label, x) in zip(meant, vectors.items(), strict=False):
        part, lo = request.within(label), (rests or {}).get(f"{label}_lo")
        if is_maneuver(name):
            x, lo = read_maneuvers(x, part), None
        columns.append(read_column(x, lo, is_time(name), part))
    # Of decimals, a constant column is written like the others, as in a text.
    return evened(columns, time_among(meant)) if any(c.significant for c in columns) else columns


def _maneuver_told(arrays: Mapping[str, Any], request: Request) -> int | None:
    """The number of the maneuver that stands beside columns, if it does."""
    for name, x in arrays.items():
        if is_maneuver(name) and np.prod(x.shape) == 1:
            number = read_maneuvers(x, request.within(name))[0]
            return int(number) if np.isfinite(number) else None
    return None


def _members(source: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """Arrays, anything with their type and shape, and mappings of these, by name."""
    members: dict[str, Any] = {}
    if len(source) > MOST_MEMBERS:
        raise request.error(
            f"found {len(source)} arrays and groups, expected at most {MOST_MEMBERS}"
        )
    for name, x in source.items():
        within = request.within(name)
        columns = by_name(x)
        if columns is None and (array := as_array(x, within)).dtype.names:
            records = read_array(array, within).ravel()
            columns = {field: records[field] for field in array.dtype.names}
        members[name] = array if columns is None else columns
    return members


def _goes_with(name: str, names: Sequence[str]) -> bool:
    """True if the files of the reference have such a dataset beside those of some names."""
    stem = name.removesuffix("_lo").removesuffix("_bound")
    return stem in names or stem in _ALTERNATES or name == "dense" or is_maneuver(name)
