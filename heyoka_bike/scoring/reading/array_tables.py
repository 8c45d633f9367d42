"""Tables from arrays: by the names of columns, or by the shape of one array of all."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.reading.array_columns import (
    read_array,
    read_column,
    read_maneuvers,
    refused,
)
from heyoka_bike.scoring.reading.array_shapes import (
    beside_a_time,
    is_time,
    is_vector,
    length,
    maneuver_axis,
    one_maneuver,
    over_maneuvers,
)
from heyoka_bike.scoring.reading.column_names import (
    are_names,
    arrays_not_understood,
    group_number,
    is_maneuver,
    left_out,
    recognise,
)
from heyoka_bike.scoring.reading.expected import Expected, what_may_be_wrong, widths_in_words
from heyoka_bike.scoring.reading.numbered_names import is_coordinate
from heyoka_bike.scoring.reading.quanta import evened
from heyoka_bike.scoring.reading.written import Written, WrittenTable

DEEPEST = 4
"""Groups in groups: of a program, of a maneuver, of its columns. A group may contain itself."""

_ALTERNATES = frozenset(c.name for c in COLUMNS)


def tables(
    source: Any, path: str, expected: Expected, *, is_ordered: bool = True,
    is_transposed: bool = False,
) -> list[WrittenTable]:  # fmt: skip
    """The tables in an array or in a mapping of names to arrays, or to such mappings.

    Parameters
    ----------
    source
        An array of rows and columns, or of maneuvers, rows and columns; an array with named fields;
        or a mapping of names to columns, to one array of all columns, or of ``maneuver_N`` to any
        of these. Columns may have an axis for the maneuvers, and the rest beyond binary64 beside
        them (``time_lo``). The time may stand beside an array of the other columns. Python's
        objects are decimals.
    path
        Name of the file, for errors.
    expected
        What columns there may be.
    is_ordered
        Whether the order in a mapping means anything.
    is_transposed
        Whether arrays are stored with their axes the other way round.

    Raises
    ------
    InputError
        Not columns of real numbers.
    """
    reader = _Arrays(path, expected, is_ordered, is_transposed)
    if isinstance(source, Mapping):
        return reader.tables(_members(source, path, ""))
    array = _array(source, path)
    maneuvers = reader.along_an_axis({"array": array})
    return reader.tables(maneuvers) if maneuvers else [reader.table(array, None)]


class _Arrays:
    """Turns arrays of one file into tables."""

    def __init__(
        self, path: str, expected: Expected, is_ordered: bool, is_transposed: bool
    ) -> None:
        self.path = path
        self.expected = expected
        self.is_ordered = is_ordered
        self.is_transposed = is_transposed

    def tables(self, members: Mapping[str, Any], depth: int = 0) -> list[WrittenTable]:
        """The tables in a mapping: one, or one for each group of a maneuver."""
        members = self.along_an_axis(members) or members
        groups: dict[int, tuple[str, Any]] = {}
        for name, x in members.items():
            number = group_number(name)
            if number is None or not (isinstance(x, Mapping) or _is_table(x)):
                continue
            if number in groups:
                raise InputError(
                    f"found maneuver {number} a second time ({quoted(name)}), expected it once",
                    file=self.path,
                )
            groups[number] = name, x
        if not groups and depth < DEEPEST and not self._is_here(members):
            inner = [_members(x, self.path, "") for x in members.values() if isinstance(x, Mapping)]
            if len(inner) > 1:
                inner = [x for x in inner if self._is_below(x, depth + 1)]
            if len(inner) == 1:
                return self.tables(inner[0], depth + 1)
        if not groups:
            return [self.table(members, None)]
        # Times may be stored once for all maneuvers.
        times = {name: x for name, x in members.items() if is_time(name.removesuffix("_lo"))}
        found = []
        for number, (name, group) in sorted(groups.items()):
            if isinstance(group, Mapping) and not any(is_time(str(n)) for n in group):
                group = {**times, **group}
            elif (
                times
                and not isinstance(group, Mapping)
                and beside_a_time({**times, name: group}, self._widths(number))
            ):
                group = {**times, name: group}
            found.append(self.table(group, number, f"maneuver {number}: "))
        return found

    def along_an_axis(self, members: Mapping[str, Any]) -> dict[str, Any]:
        """Groups of the maneuvers for which arrays have an axis; nothing if they have none."""
        count = self.expected.count
        arrays = {name: x for name, x in members.items() if not isinstance(x, Mapping)}
        if any(group_number(name) for name in members):
            return {}
        if found := over_maneuvers(arrays, count):
            axis, names = found
            columns = {name: self._read(arrays[name], f"{name}: ") for name in names}
            others = {n: x for n, x in members.items() if n not in names and not is_maneuver(n)}
            size = columns[names[0]].shape[axis]
            told = next((n for n in arrays if is_maneuver(n) and length(arrays[n]) == size), None)
            numbers = np.arange(1.0, size + 1)
            if told is not None:
                numbers = read_maneuvers(arrays[told], self.path, f"{told}: ")
            return {
                f"maneuver_{n:.0f}": others | {k: x.take(i, axis) for k, x in columns.items()}
                for i, n in enumerate(numbers)
            }
        times = {name: x for name, x in arrays.items() if is_time(name)}
        widths = [w - bool(times) for w in self._widths(1)]
        cubes = {
            name: axes
            for name, x in arrays.items()
            if len(x.shape) == 3
            for width in widths
            if (axes := maneuver_axis(x.shape, count, width))
        }
        if len(cubes) != 1:
            return {}
        ((name, axes),) = cubes.items()
        cube = self._read(arrays[name], f"{name}: ")
        parts = {f"maneuver_{i + 1}": one_maneuver(cube, axes, i) for i in range(count)}
        if times:
            return {number: {**times, name: part} for number, part in parts.items()}
        return dict(parts)

    def table(self, source: Any, maneuver: int | None, where: str = "") -> WrittenTable:
        """The table in an array, or in a mapping without groups of maneuvers."""
        if isinstance(source, Mapping):
            return self._of_mapping(source, maneuver, where)
        if source.dtype.names:
            records = self._read(source, where).ravel()
            fields = {name: records[name] for name in source.dtype.names}
            return self._of_mapping(fields, maneuver, where)
        array, findings = self._upright(source, maneuver, where)
        return self._by_place(array.T, maneuver, where, findings)

    def _of_mapping(
        self, source: Mapping[Any, Any], maneuver: int | None, where: str
    ) -> WrittenTable:
        members = _members(source, self.path, where)
        inner = {name: x for name, x in members.items() if isinstance(x, Mapping)}
        arrays = {name: x for name, x in members.items() if name not in inner}
        vectors = {name: x for name, x in arrays.items() if is_vector(x)}
        widths = self._widths(maneuver)
        if self.expected.names is not None and len(vectors) in widths:
            self._check_lengths(vectors, where)
            return self._by_place(vectors.values(), maneuver, where)
        names = [name for name in vectors if recognise(name)]
        if self.expected.names is None and are_names(names):
            return self._named(arrays, inner, names, maneuver, where)
        if self.is_ordered and len(vectors) in widths and len(vectors) == len(arrays):
            self._check_lengths(vectors, where)
            return self._by_place(vectors.values(), maneuver, where, names=list(vectors))
        whole = _whole(arrays, widths)
        pair = beside_a_time(arrays, widths)
        if pair and whole in ([], [pair[1]]):
            time, others, is_turned = pair
            columns = self._read(arrays[others], f"{where}{others}: ")
            every = (arrays[time], *(columns if is_turned else columns.T))
            return self._by_place(every, maneuver, where)
        if len(whole) == 1:
            return self.table(arrays[whole[0]], maneuver, f"{where}{whole[0]}: ")
        found = [*arrays, *inner]
        said = arrays_not_understood(found, widths, self.expected.option)
        raise InputError(f"{where}{said}", file=self.path)

    def _named(
        self, arrays: Mapping[str, Any], inner: Iterable[str], known: Sequence[str],
        maneuver: int | None, where: str,
    ) -> WrittenTable:  # fmt: skip
        names = list(known)
        rows = length(arrays[next(n for n in names if is_time(n))])
        for name, x in arrays.items():
            is_told = is_maneuver(name) or is_coordinate(name)
            if is_told and is_vector(x) and length(x) == rows:
                names.append(name)
            elif is_maneuver(name) and maneuver is None and np.prod(x.shape) == 1:
                number = read_maneuvers(x, self.path, f"{where}{name}: ")[0]
                maneuver = int(number) if np.isfinite(number) else None
        self._check_lengths({n: arrays[n] for n in names}, where)
        columns = [
            self._column(n, arrays[n], arrays.get(f"{n}_lo"), f"{where}{n}: ") for n in names
        ]
        others = [n for n in (*arrays, *inner) if n not in names and not _goes_with(n, names)]
        return WrittenTable(
            _evened(columns, next(j for j, n in enumerate(names) if is_time(n))),
            names,
            ordered=False,
            maneuver=maneuver,
            findings=(left_out(others),) if others else (),
        )

    def _by_place(
        self, columns: Iterable[Any], maneuver: int | None, where: str,
        findings: tuple[Finding, ...] = (), names: list[str] | None = None,
    ) -> WrittenTable:  # fmt: skip
        meant = self.expected.names or ("time",)
        time = next(j for j, name in enumerate(meant) if is_time(name))
        found = []
        for j, x in enumerate(columns):
            kind = meant[j] if j < len(meant) else ""
            # Only of Python's objects one alone may be wrong.
            place = f"column {j + 1}: " if x.dtype.kind == "O" else ""
            name = f"{names[j]}: " if names else place
            found.append(self._column(kind, x, None, f"{where}{name}"))
        return WrittenTable(_evened(found, time), names, maneuver=maneuver, findings=findings)

    def _upright(
        self, source: Any, maneuver: int | None, where: str
    ) -> tuple[NDArray[Any], tuple[Finding, ...]]:
        """The array with its columns side by side."""
        widths = self._widths(maneuver)
        both = widths_in_words(widths)
        shape = tuple(source.shape)
        if len(shape) != 2:
            if source.dtype.kind not in ("fiuO" if len(shape) == 1 else "fiu"):
                raise refused(source.dtype, self.path, where)
            raise InputError(
                f"{where}found an array of shape {shape}, expected rows of {both} columns",
                file=self.path,
            )
        array = self._read(source, where)
        if self.is_transposed:
            array = array.T
        rows, columns = array.shape
        if columns in widths:
            return array, ()
        if rows in widths:
            finding = Finding(
                "transposed",
                f"The array has {rows} rows and {columns} columns; its rows are taken as columns.",
                Severity.INFO,
                {"shape": [rows, columns]},
            )
            return array.T, () if self.is_transposed else (finding,)
        raise InputError(
            f"{where}found {columns} columns, expected {both}"
            f"{what_may_be_wrong(columns, rows, widths)}",
            file=self.path,
        )

    def _column(self, name: str, source: Any, lo: Any, where: str) -> Written:
        if is_maneuver(name):
            values = read_maneuvers(source, self.path, where)
            return read_column(values, None, False, self.path, where)
        return read_column(source, lo, is_time(name), self.path, where)

    def _read(self, source: Any, where: str) -> NDArray[Any]:
        return read_array(source, self.path, where)

    def _widths(self, maneuver: int | None) -> Sequence[int]:
        if maneuver is None or self.expected.names is not None:
            return self.expected.widths
        return (9,)

    def _is_here(self, members: Mapping[str, Any]) -> bool:
        """Whether the columns are in the mapping itself."""
        arrays = {name: x for name, x in members.items() if not isinstance(x, Mapping)}
        if are_names([name for name, x in arrays.items() if is_vector(x)]):
            return True
        widths = self.expected.widths
        return bool(_whole(arrays, widths) or beside_a_time(arrays, widths))

    def _is_below(self, members: Mapping[str, Any], depth: int) -> bool:
        """Whether the columns are somewhere in the mapping."""
        if self._is_here(members) or self.along_an_axis(members):
            return True
        if any(group_number(n) and not isinstance(x, Mapping) for n, x in members.items()):
            return True
        inner = [_members(x, self.path, "") for x in members.values() if isinstance(x, Mapping)]
        return depth < DEEPEST and any(self._is_below(x, depth + 1) for x in inner)

    def _check_lengths(self, vectors: Mapping[str, Any], where: str) -> None:
        lengths = {name: length(x) for name, x in vectors.items()}
        first = next(iter(lengths))
        for name, n in lengths.items():
            if n != lengths[first]:
                raise InputError(
                    f"{where}found {lengths[first]} values of {quoted(first)} and {n} of "
                    f"{quoted(name)}, expected the same number",
                    file=self.path,
                )


def _array(source: Any, path: str, where: str = "") -> NDArray[Any]:
    try:
        array: NDArray[Any] = np.asanyarray(source)
    except (ValueError, TypeError, OverflowError):
        raise InputError(
            f"{where}found a {type(source).__name__} that is no array, expected real numbers",
            file=path,
        ) from None
    # Words one by one may be decimals, and the first that is none can be named.
    is_list = not hasattr(source, "dtype") and array.shape
    return array.astype(object) if array.dtype.kind == "U" and is_list else array


def _members(source: Mapping[Any, Any], path: str, where: str) -> dict[str, Any]:
    """Arrays, anything with their type and shape, and mappings of these, by name."""
    members: dict[str, Any] = {}
    for name, x in source.items():
        if isinstance(x, Mapping) or (hasattr(x, "dtype") and hasattr(x, "shape")):
            members[str(name)] = x
        else:
            members[str(name)] = _array(x, path, f"{where}{name}: ")
    return members


def _evened(columns: list[Written], time: int) -> list[Written]:
    """Of decimals, a constant column is written like the others, as in a text."""
    return evened(columns, time) if any(c.significant for c in columns) else columns


def _goes_with(name: str, names: Sequence[str]) -> bool:
    """Whether the files of the reference have such a dataset beside those of some names."""
    stem = name.removesuffix("_lo").removesuffix("_bound")
    return stem in names or stem in _ALTERNATES or name == "dense" or is_maneuver(name)


def _is_table(x: Any) -> bool:
    """Whether an array may hold several columns."""
    return bool(x.dtype.names) or len(x.shape) == 2


def _whole(arrays: Mapping[str, Any], widths: Sequence[int]) -> list[str]:
    """Names of the arrays that may be all columns."""
    return [
        name
        for name, x in arrays.items()
        if _is_table(x) and (x.dtype.names or set(x.shape) & set(widths))
    ]
