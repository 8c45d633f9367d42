"""Tables from arrays: by the names of columns, or by the shape of one array of all."""

from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array, two_sum
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.reading.headings import (
    TIME,
    are_names,
    group_number,
    left_out,
    listed,
    recognise,
)
from heyoka_bike.scoring.reading.quanta import binary_column
from heyoka_bike.scoring.reading.written import Written, WrittenTable

# Ten million rows of 25 numbers; more is what a damaged header says.
MOST_BYTES = 2 * 10**9
"""Size of the largest array that is read."""

DEEPEST = 3
"""Groups in groups: of a program, of a maneuver, of its columns. A group may contain itself."""

_ALTERNATES = frozenset(c.name for c in COLUMNS)

_REFUSED = {
    "b": "truth values", "c": "complex numbers", "m": "time differences", "M": "dates",
    "O": "Python objects", "S": "text", "U": "text", "T": "text", "V": "records",
}  # fmt: skip


def tables(
    source: Any, path: str, fitting: Sequence[int], *, is_ordered: bool = True,
    is_transposed: bool = False,
) -> list[WrittenTable]:  # fmt: skip
    """The tables in an array or in a mapping of names to arrays, or to such mappings.

    Parameters
    ----------
    source
        A two-dimensional array, an array with named fields, or a mapping of names to columns, to
        one array of all columns, or of ``maneuver_N`` to any of these. Columns may have the rest
        beyond binary64 beside them (``time_lo``).
    path
        Name of the file, for errors.
    fitting
        Numbers of columns that are expected where they have no names.
    is_ordered
        Whether the order in a mapping means anything.
    is_transposed
        Whether arrays are stored with their axes the other way round.

    Raises
    ------
    InputError
        Not columns of real numbers.
    """
    reader = _Arrays(path, fitting, is_ordered, is_transposed)
    if not isinstance(source, Mapping):
        return [reader.table(_array(source, path), None)]
    return reader.tables(_members(source, path, ""))


class _Arrays:
    """Turns arrays of one file into tables."""

    def __init__(
        self, path: str, fitting: Sequence[int], is_ordered: bool, is_transposed: bool
    ) -> None:
        self.path = path
        self.fitting = fitting
        self.is_ordered = is_ordered
        self.is_transposed = is_transposed

    def tables(self, members: Mapping[str, Any], depth: int = 0) -> list[WrittenTable]:
        """The tables in a mapping: one, or one for each group of a maneuver."""
        groups: dict[int, Any] = {}
        for name, x in members.items():
            number = group_number(name)
            if number is None or not (isinstance(x, Mapping) or _is_table(x)):
                continue
            if number in groups:
                raise InputError(
                    f"found maneuver {number} a second time ({quoted(name)}), expected it once",
                    file=self.path,
                )
            groups[number] = x
        inner = [x for x in members.values() if isinstance(x, Mapping)]
        if not groups and len(inner) == 1 and depth < DEEPEST and not self._is_here(members):
            return self.tables(_members(inner[0], self.path, ""), depth + 1)
        if not groups:
            return [self.table(members, None)]
        # Times may be stored once for all maneuvers.
        times = {name: x for name, x in members.items() if _is_time(name.removesuffix("_lo"))}
        found = []
        for number, group in sorted(groups.items()):
            if isinstance(group, Mapping) and not any(_is_time(str(name)) for name in group):
                group = {**times, **group}
            found.append(self.table(group, number, f"maneuver {number}: "))
        return found

    def table(self, source: Any, maneuver: int | None, where: str = "") -> WrittenTable:
        """The table in an array, or in a mapping without groups of maneuvers."""
        if isinstance(source, Mapping):
            return self._of_mapping(source, maneuver, where)
        if source.dtype.names:
            records = self._read(source, where).ravel()
            fields = {name: records[name] for name in source.dtype.names}
            return self._of_mapping(fields, maneuver, where)
        array, findings = self._upright(source, maneuver, where)
        columns = [self._column(x, None, where) for x in array.T]
        return WrittenTable(columns, maneuver=maneuver, findings=findings)

    def _of_mapping(
        self, source: Mapping[Any, Any], maneuver: int | None, where: str
    ) -> WrittenTable:
        members = _members(source, self.path, where)
        inner = {name: x for name, x in members.items() if isinstance(x, Mapping)}
        arrays = {name: x for name, x in members.items() if name not in inner}
        vectors = {name: x for name, x in arrays.items() if _is_vector(x)}
        names = [name for name in vectors if recognise(name)]
        if are_names(names):
            others = [n for n in (*arrays, *inner) if n not in vectors]
            return self._named(vectors, names, others, maneuver, where)
        if self.is_ordered and len(vectors) in self.fitting and len(vectors) == len(arrays):
            columns = [self._column(x, None, f"{where}{n}: ") for n, x in vectors.items()]
            self._check_lengths(list(vectors), columns, where)
            return WrittenTable(columns, list(vectors), maneuver=maneuver)
        widths = self.fitting if maneuver is None else (9,)
        whole = _whole(arrays, widths)
        if len(whole) == 1:
            return self.table(arrays[whole[0]], maneuver, f"{where}{whole[0]}: ")
        both = " or ".join(str(n) for n in widths)
        found = listed([*arrays, *inner]) or "nothing"
        raise InputError(
            f"{where}found {found}, expected arrays named time, {', '.join(BENCHMARK_COLUMNS)}, "
            f"or one array of {both} columns",
            file=self.path,
        )

    def _is_here(self, members: Mapping[str, Any]) -> bool:
        """Whether the columns are in the mapping itself."""
        arrays = {name: x for name, x in members.items() if not isinstance(x, Mapping)}
        return are_names(list(arrays)) or bool(_whole(arrays, self.fitting))

    def _named(
        self, vectors: Mapping[str, Any], names: Sequence[str], others: Sequence[str],
        maneuver: int | None, where: str,
    ) -> WrittenTable:  # fmt: skip
        columns = [self._column(vectors[n], vectors.get(f"{n}_lo"), f"{where}{n}: ") for n in names]
        self._check_lengths(names, columns, where)
        findings: tuple[Finding, ...] = ()
        unknown = [n for n in (*vectors, *others) if n not in names and not _goes_with(n, names)]
        if unknown:
            findings = (left_out(unknown),)
        return WrittenTable(
            columns,
            list(names),
            ordered=False,
            maneuver=maneuver,
            has_exact_times=any(
                f"{n}_lo" in vectors for n in names if (k := recognise(n)) and k[0] == TIME
            ),
            findings=findings,
        )

    def _upright(
        self, source: Any, maneuver: int | None, where: str
    ) -> tuple[NDArray[Any], tuple[Finding, ...]]:
        """The array with its columns side by side."""
        widths = self.fitting if maneuver is None else (9,)
        both = " or ".join(str(n) for n in widths)
        self._check_kind(source.dtype, where)
        shape = tuple(source.shape)
        if len(shape) != 2:
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
        raise InputError(f"{where}found {columns} columns, expected {both}", file=self.path)

    def _column(self, source: Any, lo: Any, where: str) -> Written:
        array = self._read(source, where).ravel()
        bits = 53 if array.dtype.kind != "f" else int(np.finfo(array.dtype).nmant) + 1
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            values: Array = array.astype(np.float64)
            rest: Array | None = None
            if lo is not None:
                rest = self._read(lo, where).ravel().astype(np.float64)
                if rest.shape != values.shape:
                    raise InputError(
                        f"{where}found {len(values)} values and {len(rest)} of their second "
                        "parts, expected the same number",
                        file=self.path,
                    )
                values, rest = two_sum(values, rest)
                bits = 2 * bits
            elif bits > 53:
                rest = (array - values).astype(np.float64)
        if rest is not None:
            rest[~np.isfinite(values)] = 0.0
        return binary_column(values, rest, bits)

    def _read(self, source: Any, where: str) -> NDArray[Any]:
        dtype = source.dtype
        self._check_kind(dtype, where)
        _check_size(source.shape, dtype, self.path)
        array = np.ma.filled(source[()], np.nan) if dtype.kind == "f" else np.asarray(source[()])
        if array.size == 0:
            raise InputError(f"{where}found an empty array, expected rows", file=self.path)
        return array

    def _check_kind(self, dtype: np.dtype[Any], where: str) -> None:
        if dtype.kind not in "fiu" and not dtype.names:
            raise InputError(
                f"{where}found {_REFUSED.get(dtype.kind, str(dtype))}, expected real numbers",
                file=self.path,
            )

    def _check_lengths(self, names: Sequence[str], columns: Sequence[Written], where: str) -> None:
        for name, column in zip(names, columns, strict=True):
            if len(column.values) != len(columns[0].values):
                raise InputError(
                    f"{where}found {len(columns[0].values)} values of {quoted(names[0])} and "
                    f"{len(column.values)} of {quoted(name)}, expected the same number",
                    file=self.path,
                )


def _array(source: Any, path: str, where: str = "") -> NDArray[Any]:
    try:
        return np.asanyarray(source)
    except (ValueError, TypeError, OverflowError):
        raise InputError(
            f"{where}found a {type(source).__name__} that is no array, expected real numbers",
            file=path,
        ) from None


def _members(source: Mapping[Any, Any], path: str, where: str) -> dict[str, Any]:
    """Arrays, anything with their type and shape, and mappings of these, by name."""
    members: dict[str, Any] = {}
    for name, x in source.items():
        if isinstance(x, Mapping) or (hasattr(x, "dtype") and hasattr(x, "shape")):
            members[str(name)] = x
        else:
            members[str(name)] = _array(x, path, f"{where}{name}: ")
    return members


def _goes_with(name: str, names: Sequence[str]) -> bool:
    """Whether the files of the reference have such a dataset beside those of some names."""
    stem = name.removesuffix("_lo").removesuffix("_bound")
    return stem in names or stem in _ALTERNATES or name == "dense"


def _is_time(name: str) -> bool:
    return recognise(name) == (TIME, None)


def _is_vector(x: Any) -> bool:
    """Whether an array is a column; MATLAB has no arrays of one dimension."""
    return len(x.shape) == 1 or (len(x.shape) == 2 and 1 in x.shape)


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


def _check_size(shape: Sequence[int], dtype: np.dtype[Any], path: str) -> None:
    """Refuse to make room for what a damaged header says."""
    size = prod(shape) * dtype.itemsize
    if size > MOST_BYTES:
        raise InputError(
            f"found an array of {size} bytes, expected at most {MOST_BYTES}", file=path
        )
