"""Vectors by name, of arrays in any shape: columns, one array of all, groups of the maneuvers."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.errors import quoted
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.reading.arrays.columns import (
    read_array,
    read_column,
    read_maneuvers,
    refused,
)
from heyoka_bike.scoring.reading.arrays.long_tables import pivoted
from heyoka_bike.scoring.reading.arrays.shapes import (
    arrays_in,
    beside_a_time,
    by_maneuver,
    is_time,
    is_vector,
    length,
)
from heyoka_bike.scoring.reading.names.columns import (
    TIME,
    are_names,
    arrays_not_understood,
    group_number,
    is_maneuver,
    left_out,
    recognise,
)
from heyoka_bike.scoring.reading.names.numbers import is_coordinate
from heyoka_bike.scoring.reading.quanta import evened
from heyoka_bike.scoring.reading.request import Request, in_words, what_may_be_wrong
from heyoka_bike.scoring.reading.vectors import Vector, Vectors, turned

DEEPEST = 4
"""Groups in groups: of a program, of a maneuver, of its columns. A group may contain itself."""

MOST_MEMBERS = 100_000
"""Arrays and groups of a file; a group may be in itself, many times."""

_ALTERNATES = frozenset(c.name for c in COLUMNS)


def tables(source: Any, request: Request, *, is_ordered: bool = True) -> list[Vectors]:
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
        What is to be read.
    is_ordered
        Whether the order in a mapping means anything.

    Raises
    ------
    InputError
        Not columns of real numbers.
    """
    members = _members(source if isinstance(source, Mapping) else {"": source}, request)
    return [
        _vectors(group, number, request, is_ordered) for number, group in _groups(members, request)
    ]


def _groups(
    members: Mapping[str, Any], request: Request, depth: int = 0
) -> list[tuple[int | None, Mapping[str, Any]]]:
    """The members themselves, or those of each maneuver with its number."""
    members = pivoted(members, request)
    members = by_maneuver(members, request) or members
    if list(members) == [""] and isinstance(members[""], Mapping):
        members = members[""]
    groups: dict[int, str] = {}
    for name, x in members.items():
        number = group_number(name)
        if number is None or not (isinstance(x, Mapping) or len(x.shape) == 2):
            continue
        if number in groups:
            raise request.error(
                f"found maneuver {number} a second time ({quoted(name)}), expected it once"
            )
        groups[number] = name
    if groups:
        return [(n, _of_maneuver(members, groups[n], n, request)) for n in sorted(groups)]
    if depth < DEEPEST and not _is_here(members, request):
        inner = [_members(x, request) for x in members.values() if isinstance(x, Mapping)]
        if len(inner) > 1:
            inner = [x for x in inner if _is_below(x, request, depth + 1)]
        if len(inner) == 1:
            return _groups(inner[0], request, depth + 1)
    return [(None, members)]


def _of_maneuver(
    members: Mapping[str, Any], name: str, number: int, request: Request
) -> Mapping[str, Any]:
    """The members of a maneuver, with the times that may be stored once for all of them."""
    group = members[name]
    times = {n: x for n, x in arrays_in(members).items() if is_time(n.removesuffix("_lo"))}
    if isinstance(group, Mapping):
        has_time = any(is_time(str(n)) for n in group)
        return _members(
            {**({} if has_time else times), **group}, request.within(f"maneuver {number}")
        )
    is_pair = times and beside_a_time({**times, name: group}, _widths(request, number))
    return {**times, name: group} if is_pair else {"": group}


def _vectors(
    members: Mapping[str, Any], maneuver: int | None, request: Request, is_ordered: bool
) -> Vectors:
    """Those of a mapping without groups of maneuvers."""
    widths = _widths(request, maneuver)
    if maneuver is not None:
        request = request.within(f"maneuver {maneuver}")
    vectors = {name: x for name, x in arrays_in(members).items() if is_vector(x)}
    known = [name for name in vectors if (request.known or recognise)(name)]
    if request.names is None and are_names(known, request):
        return _named(members, known, maneuver, request)
    is_told = request.names is not None
    findings: tuple[Finding, ...] = ()
    is_all = is_ordered and len(vectors) == len(arrays_in(members))
    if len(vectors) in widths and (is_told or is_all):
        _check_lengths(vectors, request)
    else:
        vectors, findings = _of_one_array(members, request, widths)
        is_all = False
    meant = [*(request.names or (TIME,)), *([""] * len(vectors))]
    columns = [
        _column(name, x, None, request.within(label))
        for name, (label, x) in zip(meant, vectors.items(), strict=False)
    ]
    return Vectors(
        _evened(columns, next(j for j, name in enumerate(meant) if is_time(name))),
        list(vectors) if is_all and not is_told else None,
        maneuver=maneuver,
        findings=findings,
    )


def _of_one_array(
    members: Mapping[str, Any], request: Request, widths: Sequence[int]
) -> tuple[dict[str, Any], tuple[Finding, ...]]:
    """The columns of the one array that has all of them, or all but the time beside it."""
    if request.known is not None:
        raise request.error("found no column whose name is known, expected columns by name")
    arrays = arrays_in(members)
    whole = _whole(arrays, widths)
    pair = beside_a_time(arrays, widths)
    if pair and whole in ([], [pair[1]]):
        time, name, is_turned = pair
        array = read_array(arrays[name], request.within(name))
        columns = array if is_turned else array.T
        return {time: arrays[time]} | {
            f"{name}: column {j}": x for j, x in enumerate(columns, 2)
        }, ()
    if len(whole) == 1 or list(members) == [""]:
        name = whole[0] if whole else ""
        array, findings = _upright(arrays[name], request.within(name), widths)
        part = f"{name}: " if name else ""
        return {f"{part}column {j}": x for j, x in enumerate(array.T, 1)}, findings
    found = [*arrays, *(n for n in members if n not in arrays)]
    raise request.error(arrays_not_understood(found, request, widths))


def _named(
    members: Mapping[str, Any], known: Sequence[str], maneuver: int | None, request: Request
) -> Vectors:
    """Columns that are known by name, with those that say what the others mean."""
    arrays = arrays_in(members)
    first = next((n for n in known if is_time(n)), known[0])
    rows = length(arrays[first])
    beside = [n for n in arrays if is_maneuver(n) or is_coordinate(n)]
    names = [*known, *(n for n in beside if is_vector(arrays[n]) and length(arrays[n]) == rows)]
    if maneuver is None:
        maneuver = _maneuver_told(arrays, request)
    _check_lengths({n: arrays[n] for n in names}, request)
    columns = [_column(n, arrays[n], arrays.get(f"{n}_lo"), request.within(n)) for n in names]
    in_order = dict.fromkeys((*arrays, *members))
    others = [n for n in in_order if n not in names and not _goes_with(n, names)]
    return Vectors(
        _evened(columns, names.index(first)),
        names,
        is_ordered=False,
        maneuver=maneuver,
        findings=(left_out(others),) if others else (),
    )


def _maneuver_told(arrays: Mapping[str, Any], request: Request) -> int | None:
    """The number of the maneuver that stands beside columns, if it does."""
    for name, x in arrays.items():
        if is_maneuver(name) and np.prod(x.shape) == 1:
            number = read_maneuvers(x, request.within(name))[0]
            return int(number) if np.isfinite(number) else None
    return None


def _upright(
    source: Any, request: Request, widths: Sequence[int]
) -> tuple[NDArray[Any], tuple[Finding, ...]]:
    """The array with its columns side by side."""
    shape, both = tuple(source.shape), in_words(widths)
    if len(shape) != 2:
        if source.dtype.kind not in ("fiuO" if len(shape) == 1 else "fiu"):
            raise refused(source.dtype, request)
        raise request.error(f"found an array of shape {shape}, expected rows of {both} columns")
    array = read_array(source, request)
    rows, columns = shape
    if columns in widths:
        return array, ()
    if rows in widths:
        return array.T, (turned("array", rows, columns),)
    reason = what_may_be_wrong(columns, rows, widths)
    raise request.error(f"found {columns} columns, expected {both}{reason}")


def _column(name: str, source: Any, lo: Any, request: Request) -> Vector:
    if is_maneuver(name):
        return read_column(read_maneuvers(source, request), None, False, request)
    return read_column(source, lo, is_time(name), request)


def _widths(request: Request, maneuver: int | None) -> tuple[int, ...]:
    return request.widths if maneuver is None or request.names is not None else (9,)


def _is_here(members: Mapping[str, Any], request: Request) -> bool:
    """Whether the columns are in the mapping itself."""
    arrays = arrays_in(members)
    if are_names([name for name, x in arrays.items() if is_vector(x)], request):
        return True
    return bool(_whole(arrays, request.widths) or beside_a_time(arrays, request.widths))


def _is_below(members: Mapping[str, Any], request: Request, depth: int) -> bool:
    """Whether the columns are somewhere in the mapping."""
    if _is_here(members, request) or by_maneuver(members, request):
        return True
    if any(group_number(n) and not isinstance(x, Mapping) for n, x in members.items()):
        return True
    inner = [_members(x, request) for x in members.values() if isinstance(x, Mapping)]
    return depth < DEEPEST and any(_is_below(x, request, depth + 1) for x in inner)


def _check_lengths(vectors: Mapping[str, Any], request: Request) -> None:
    lengths = {name: length(x) for name, x in vectors.items()}
    first = next(iter(lengths))
    for name, n in lengths.items():
        if n != lengths[first]:
            raise request.error(
                f"found {lengths[first]} values of {quoted(first)} and {n} of {quoted(name)}, "
                "expected the same number"
            )


def _members(source: Mapping[Any, Any], request: Request) -> dict[str, Any]:
    """Arrays, anything with their type and shape, and mappings of these, by name."""
    members: dict[str, Any] = {}
    if len(source) > MOST_MEMBERS:
        raise request.error(
            f"found {len(source)} arrays and groups, expected at most {MOST_MEMBERS}"
        )
    for name, x in source.items():
        within = request.within(str(name))
        if not isinstance(x, Mapping) and not (hasattr(x, "dtype") and hasattr(x, "shape")):
            x = _array(x, within)
        if not isinstance(x, Mapping) and x.dtype.names:
            records = read_array(x, within).ravel()
            x = {field: records[field] for field in x.dtype.names}
        members[str(name)] = x
    return members


def _array(source: Any, request: Request) -> NDArray[Any]:
    try:
        array: NDArray[Any] = np.asanyarray(source)
    except (ValueError, TypeError, OverflowError):
        said = f"found a {type(source).__name__} that is no array, expected real numbers"
        raise request.error(said) from None
    # Words one by one may be decimals, and the first that is none can be named.
    return array.astype(object) if array.dtype.kind == "U" and array.shape else array


def _evened(columns: list[Vector], time: int) -> list[Vector]:
    """Of decimals, a constant column is written like the others, as in a text."""
    return evened(columns, time) if any(c.significant for c in columns) else columns


def _goes_with(name: str, names: Sequence[str]) -> bool:
    """Whether the files of the reference have such a dataset beside those of some names."""
    stem = name.removesuffix("_lo").removesuffix("_bound")
    return stem in names or stem in _ALTERNATES or name == "dense" or is_maneuver(name)


def _whole(arrays: Mapping[str, Any], widths: Sequence[int]) -> list[str]:
    """Names of the arrays that may be all columns."""
    return [n for n, x in arrays.items() if len(x.shape) == 2 and set(x.shape) & set(widths)]
