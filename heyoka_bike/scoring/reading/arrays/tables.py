"""Find the tables in arrays and groups of arrays: columns by name, or by place in one array."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.evidence.as_read import NotCompared, Reason, TimesOfDay, Transposed
from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.reading.arrays.array_columns import (
    read_array,
    read_column,
    read_maneuvers,
    refused,
)
from heyoka_bike.scoring.reading.arrays.groups import DEEPEST, ArrayGroup, is_vector, length
from heyoka_bike.scoring.reading.arrays.long_tables import pivoted
from heyoka_bike.scoring.reading.arrays.objects import as_array, by_name
from heyoka_bike.scoring.reading.arrays.shapes import by_maneuver, table_among
from heyoka_bike.scoring.reading.dates import first_date
from heyoka_bike.scoring.reading.digits import evened
from heyoka_bike.scoring.reading.names.heading import (
    TIME,
    are_names,
    group_number,
    is_known,
    is_maneuver,
    is_time,
    nanoseconds_beside,
    parse_heading,
    time_among,
)
from heyoka_bike.scoring.reading.names.left_out import column_within, left_out, set_aside
from heyoka_bike.scoring.reading.names.meanings import is_coordinate
from heyoka_bike.scoring.reading.names.suggestions import names_found
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadColumn, ReadTable

_ALTERNATES = frozenset(c.name for c in COLUMNS)


def tables(source: Any, request: Request) -> list[ReadTable]:
    """Return the tables in an array, or in a mapping of names to arrays or to such mappings.

    Parameters
    ----------
    source
        An array of rows and columns, or of maneuvers, rows and columns; an array with named fields;
        or a mapping of names to columns, to one array of all columns, or of ``maneuver_N`` to any
        of these. Columns may have an axis for the maneuvers. An array ``time_lo`` contains the
        digits of ``time`` beyond binary64. The times may be in an array of their own. Python
        objects are read as decimals.
    request
        The request to read it.

    Raises
    ------
    InputError
        The source does not contain columns of real numbers.
    """
    if (members := by_name(source)) is None:
        if isinstance(source, list | tuple) and any(by_name(x) is not None for x in source):
            raise InputError(
                f"found a list of {type(source[0]).__name__}, expected maneuvers by number, such "
                "as {1: ..., 2: ...}"
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


def _search(group: ArrayGroup, depth: int = 0) -> list[ReadTable]:
    """Return the tables in a group, or else in an inner group; an empty list without tables."""
    group = by_maneuver(pivoted(group))
    if parts := group.of_maneuvers():
        of_each = [_or_all_below(_table(part), part) for part in parts]
        found = [table for part in of_each for table in part]
        if found and [] in of_each:
            raise _refusal(parts[of_each.index([])])
        return _with_tables_beside(_with_known_beside(found, group), group)
    if found := _table(group):
        return _or_all_below(found, group)
    inner = group.groups.values() if depth < DEEPEST else ()
    below = [found for x in inner if (found := _search(_with_times(x, group), depth + 1))]
    return _or_all_below(_with_known_beside(below[0], group) if len(below) == 1 else [], group)


def _or_all_below(found: list[ReadTable], group: ArrayGroup) -> list[ReadTable]:
    """Return the given tables, or one table with all columns of inner groups if it has more.

    ``state/roll_angle`` and ``energy/kinetic_energy`` are columns of one table: their paths end in
    the names of columns.
    """
    request = group.request
    names = (found[0].names or ()) if found else None
    if not group.groups or request.names or len(found) > 1 or names == ():
        return found
    # If the groups contain columns of different lengths, or columns of the same name, they are not
    # parts of one table.
    with suppress(InputError):
        every = group.with_all_below()
        known = _known_vectors(every)
        is_more = len(known) > len([*filter(request.known or is_known, names or ())])
        if is_more and are_names(known, request):
            return [_named(every, known)]
        return _flag_nested_columns(found, every) if names else found
    return found


def _flag_nested_columns(found: list[ReadTable], every: ArrayGroup) -> list[ReadTable]:
    """Add evidence of the columns that inner groups contain and the only table found lacks."""
    known = {parse_heading(name).key for name in found[0].names or ()}
    paths = [name for name, x in every.arrays.items() if "." in name and length(x) > 1]
    held = [n for n in paths if column_within(n, every.request)[0] not in {None, *known}]
    return _with_evidence(found, left_out(held, every.request)) if held else found


def _known_vectors(group: ArrayGroup) -> list[str]:
    """Return the names of the one-dimensional arrays whose names are known."""
    is_column = group.request.known or is_known
    return [name for name, x in group.arrays.items() if is_vector(x) and is_column(name)]


def _with_times(members: Mapping[str, Any], group: ArrayGroup) -> ArrayGroup:
    """Return an inner group, with the times of the outer group if it has no times itself."""
    inner = ArrayGroup(members, group.request)
    rows = {length(x) for x in inner.arrays.values() if is_vector(x)}
    times = {name: x for name, x in group.times.items() if length(x) in rows}
    if inner.times or len(times) != 1:
        return inner
    with_rests = {n: x for n, x in group.arrays.items() if n.removesuffix("_lo") in times}
    return ArrayGroup({**with_rests, **members}, group.request)


def _with_known_beside(
    found: list[ReadTable],
    group: ArrayGroup,
    used: Sequence[str | None] = (),
    reason: Reason = Reason.BESIDE_A_TABLE,
) -> list[ReadTable]:
    """Add to the first table: evidence of unused arrays with known names in the same group."""
    # A single number is a parameter, not a column.
    rows = (name for name, x in group.arrays.items() if name not in used and length(x) > 1)
    known = [name for name in rows if _is_known_column(name)]
    if not known:
        return found
    return _with_evidence(found, set_aside(known, group.request, reason))


def _with_tables_beside(found: list[ReadTable], group: ArrayGroup) -> list[ReadTable]:
    """Add to the first table of maneuvers: evidence of similar columns in other arrays.

    ``maneuver_2_old/roll_angle``, or a table of the same size, may contain the actual results of
    the program.
    """
    request = group.request
    lost = [
        LostColumn(name)
        for name, x in group.arrays.items()
        if group_number(name) is None and len(x.shape) == 2 and {*x.shape} & {*request.widths}
    ]
    others = {name: x for name, x in group.groups.items() if group_number(name) is None}
    # If a name occurs twice in the other groups, do not search them for columns.
    with suppress(InputError):
        every = ArrayGroup(others, request).with_all_below()
        for name, x in every.arrays.items():
            step = name.rpartition(".")[2]
            if is_vector(x) and length(x) > 1 and _is_known_column(step):
                lost.append(LostColumn(name, parse_heading(step).key))
    if not lost:
        return found
    seen = NotCompared(Reason.BESIDE_A_TABLE, tuple(lost), request.columns_hint)
    return _with_evidence(found, seen)


def _with_evidence(found: list[ReadTable], seen: NotCompared) -> list[ReadTable]:
    """Add evidence of unused arrays to the first table."""
    return [replace(x, seen=(*x.seen, seen)) if x is found[0] else x for x in found]


def _is_known_column(name: str) -> bool:
    """True if a name is that of one of the benchmark's columns, and not of a group of columns."""
    return parse_heading(name).key in BENCHMARK_COLUMNS and group_number(name) is None


def _table(group: ArrayGroup) -> list[ReadTable]:
    """Return the table of a group as a list of length one; an empty list if there is no table.

    The columns are identified by their names. Otherwise they are vectors, or the columns of one
    array, identified by their order.
    """
    arrays, request = group.arrays, group.request
    vectors = {name: x for name, x in arrays.items() if is_vector(x)}
    known = _known_vectors(group)
    if request.names is None and are_names(known, request):
        return _with_known_beside([_named(group, known)], group, known, Reason.NO_COLUMN)
    is_all = request.is_ordered and len(vectors) == len(arrays) and request.names is None
    if len(vectors) in request.widths and (request.names or is_all):
        return [_table_by_place(vectors, request, list(vectors) if is_all else None)]
    if (table := table_among(group)) or list(arrays) == [""]:
        name, is_turned, time = table or ("", False, None)
        found = _of_table(group, name, is_turned, time)
        return _with_known_beside([found], group, (name, time))
    return []


def _refusal(group: ArrayGroup, depth: int = 0) -> InputError:
    """Return the error that there are no columns; it lists the names in the most likely group."""
    parts = group.of_maneuvers()
    if depth < DEEPEST and not parts and len(group.groups) == 1:
        parts = [ArrayGroup(x, group.request) for x in group.groups.values()]
    # The groups of several maneuvers are usually alike, so the error names what was found in the
    # first one.
    if depth < DEEPEST and parts:
        return _refusal(parts[0], depth + 1)
    found = names_found([name for name in group.names if name])
    return group.request.not_columns(found)


def _named(group: ArrayGroup, known: Sequence[str]) -> ReadTable:
    """Return a table of the columns with known names, and of columns that clarify these names."""
    arrays, request = group.arrays, group.request
    time = known[time_among(known)]
    rows, every = length(arrays[time]), list(arrays)
    beside = {n: x for n, x in arrays.items() if is_maneuver(n) or is_coordinate(n)}
    if (i := nanoseconds_beside(every, time)) is not None:
        beside[every[i]] = arrays[every[i]]
    fitting = (n for n, x in beside.items() if is_vector(x) and length(x) == rows)
    names = [*known, *fitting]
    others = [n for n in (*arrays, *group.groups) if not _goes_with(n, names)]
    return ReadTable(
        _read_columns({n: arrays[n] for n in names}, names, request, arrays),
        names,
        is_ordered=False,
        maneuver=request.group or _stated_maneuver(arrays, request),
        seen=(*_dates(arrays[time]), *([left_out(others, request)] if others else [])),
    )


def _dates(times: Any) -> tuple[TimesOfDay, ...]:
    """Return evidence that the times are times of day."""
    first = first_date(times)
    return () if first is None else (TimesOfDay(first),)


def _table_by_place(
    vectors: Mapping[str, Any], request: Request, names: list[str] | None = None
) -> ReadTable:
    """Return a table whose columns have the order that the user gave, or that of the benchmark."""
    meant = [*(request.names or (TIME,)), *([""] * len(vectors))]
    return ReadTable(_read_columns(vectors, meant, request), names, maneuver=request.group)


def _of_table(group: ArrayGroup, name: str, is_turned: bool, time: str | None) -> ReadTable:
    """Return the table in one array of all columns, perhaps with the times in another array."""
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
    vectors = _table_by_place(first | {f"{label} {j}": x for j, x in columns}, request)
    if first or not is_turned:
        return vectors
    rows, width = shape
    return replace(vectors, seen=(Transposed(rows, width),))


def _read_columns(
    vectors: Mapping[str, Any], meant: Sequence[str], request: Request,
    rests: Mapping[str, Any] | None = None,
) -> list[ReadColumn]:  # fmt: skip
    """Read vectors as columns; `rests` contains their digits beyond binary64, named ``NAME_lo``."""
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
        if is_maneuver(name):
            x, lo = read_maneuvers(x, part), None
        columns.append(read_column(x, lo, is_time(name), part))
    # A constant column of decimals has the same resolution as the other columns, as in a text file.
    are_decimals = any(c.significant for c in columns)
    return evened(columns, time_among(meant)) if are_decimals else columns


def _stated_maneuver(arrays: Mapping[str, Any], request: Request) -> int | None:
    """Return the maneuver number that a group stores as a single number; None without one."""
    for name, x in arrays.items():
        if is_maneuver(name) and np.prod(x.shape) == 1:
            number = read_maneuvers(x, request.within(name))[0]
            return int(number) if np.isfinite(number) else None
    return None


def _goes_with(name: str, names: Sequence[str]) -> bool:
    """True if a name is one of `names`, or one that reference files contain besides columns."""
    stem = name.removesuffix("_lo").removesuffix("_bound").removesuffix("_undecided")
    is_beside = stem in _ALTERNATES or name == "dense" or is_maneuver(name)
    return name in names or stem in names or is_beside
