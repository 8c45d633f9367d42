"""MATLAB's and Simulink's files: variables, structures, and what blocks log.

Versions 5 to 7 are elements, each a type, a length and so many bytes, compressed or not; version 4
is a header and its bytes for each matrix (*MAT-File Format*, The MathWorks). Text is an array of
strings, a structure a mapping, an array or cell array of structures a list of these, another cell
array an array of objects, an object of a class the name of that. Sparse matrices and functions are
left out. Files of version 7.3 are HDF5.
"""

import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import chain
from math import prod
from struct import unpack_from
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.arrays.columns import read_array
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.formats import hdf5, is_hdf5_of_matlab
from heyoka_bike.scoring.reading.formats.hdf5 import OfClass
from heyoka_bike.scoring.reading.names.columns import is_known
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.table import ReadTable

# Types of elements.
_NUMBERS = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
    16: "u1", 17: "u2", 18: "u4",
}  # fmt: skip
_MATRIX, _COMPRESSED, _UTF8 = 14, 15, 16
# Classes of arrays, and a bit of their flags.
_CELL, _STRUCTURE, _OBJECT, _CLASS_OF_TEXT, _OF_CLASS = 1, 2, 3, 4, 17
_CLASSES = dict(enumerate(("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"), 6))
_COMPLEX = 0x800
_BYTES_OF_HEADER = 128
# Memory that an array takes at least, and a character at most.
_LEAST_BYTES, _WIDEST = 200, 8
# Of version 4.
_NUMBERS_4 = ("f8", "f4", "i4", "i2", "u2", "u1")
_FULL_4, _TEXT_4 = 0, 1
_Element = tuple[int, memoryview]


def matlab_variables(data: bytes, most: int) -> dict[str, Any]:
    """The variables of a file by name.

    Parameters
    ----------
    data
        The file.
    most
        Bytes that it may unpack to.

    Raises
    ------
    ValueError
        Damaged, or larger than that; other errors of Python's, too, for damaged bytes.
    """
    end = data[126:_BYTES_OF_HEADER]
    if end not in (b"IM", b"MI"):
        found = [*_version_4(memoryview(data))]
    else:
        version_5 = _Version5("<" if end == b"IM" else ">", most)
        found = [*version_5.variables(memoryview(data)[_BYTES_OF_HEADER:])]
    counts = Counter(name for name, _ in found)
    if again := next((name for name, count in counts.items() if count > 1), ""):
        raise ValueError(f"two variables {again}")
    return dict(found)


class _Version5:
    def __init__(self, order: str, room: int) -> None:
        self._order, self._room = order, room

    def variables(self, data: memoryview) -> Iterator[tuple[str, Any]]:
        for kind, body in self._elements(data):
            if kind == _COMPRESSED:
                kind, body = _next(self._elements(self._unpacked(body)))
            if kind == _MATRIX:
                name, value = self._matrix(body)
                if name and value is not None:
                    yield name, value

    def _claim(self, size: int) -> None:
        """Take so many bytes of those that there may be."""
        self._room -= size
        if self._room < 0:
            raise ValueError("it unpacks to too many bytes")

    def _elements(self, data: memoryview) -> Iterator[_Element]:
        at = 0
        while at < len(data):
            kind, size = unpack_from(f"{self._order}II", data, at)
            start, following = at + 8, at + 8 + size
            if kind >> 16:
                # As few bytes as fit beside their type and length.
                kind, size, start, following = kind & 0xFFFF, kind >> 16, at + 4, at + 8
            elif kind != _COMPRESSED:
                following += -size % 8
            if start + size > min(following, len(data)):
                raise ValueError(f"{size} bytes promised at byte {at} are not there")
            yield kind, data[start : start + size]
            at = following

    def _unpacked(self, data: memoryview) -> memoryview:
        beginning = zlib.decompressobj().decompress(data, 8)
        size: int = unpack_from(f"{self._order}II", beginning)[1] + 8
        self._claim(size)
        # With a padding, and never more than was promised.
        unpacker = zlib.decompressobj()
        unpacked = unpacker.decompress(data, size + 8)
        if not unpacker.eof:
            raise ValueError("compressed bytes do not end where they should")
        return memoryview(unpacked)

    def _matrix(self, data: memoryview) -> tuple[str, Any]:
        """Name and value of an array; None for what is left out."""
        self._claim(_LEAST_BYTES)
        if not data:
            return "", np.empty((0, 0))
        parts = self._elements(data)
        flags = int(self._numbers(_next(parts))[0])
        kind = flags & 0xFF
        if kind == _OF_CLASS:
            name, _, of = (bytes(_next(parts)[1]).decode("latin-1") for _ in range(3))
            return name, OfClass(of)
        if kind not in (_CELL, _STRUCTURE, _OBJECT, _CLASS_OF_TEXT, *_CLASSES):
            return "", None
        shape = [int(n) for n in self._numbers(_next(parts))]
        if min(shape, default=0) < 0:
            raise ValueError("an array of negative size")
        name = bytes(_next(parts)[1]).decode("latin-1")
        if kind == _OBJECT:
            _next(parts)
        if dtype := _CLASSES.get(kind):
            # Numbers are kept in the smallest type that holds them.
            values = self._numbers(_next(parts))
            if values.dtype != dtype:
                self._claim(values.size * np.dtype(dtype).itemsize)
                values = values.astype(dtype)
            if flags & _COMPLEX:
                values = values + 1j * self._numbers(_next(parts))
            return name, values.reshape(shape, order="F")
        if kind == _CLASS_OF_TEXT:
            return name, self._text(_next(parts), shape)
        if kind == _CELL:
            found = _together([self._value(parts) for _ in range(prod(shape))])
            is_array = isinstance(found, np.ndarray)
            return name, found.reshape(shape, order="F") if is_array else found
        return name, self._structures(parts, prod(shape))

    def _value(self, parts: Iterator[_Element]) -> Any:
        kind, data = _next(parts)
        if kind != _MATRIX:
            raise ValueError("an element that is no array")
        return self._matrix(data)[1]

    def _structures(self, parts: Iterator[_Element], count: int) -> Any:
        length = int(self._numbers(_next(parts))[0])
        names = bytes(_next(parts)[1])
        fields = [
            names[i : i + length].partition(b"\0")[0].decode("latin-1")
            for i in range(0, len(names), length)
        ]
        each = [{f: self._value(parts) for f in fields} for _ in range(count if fields else 0)]
        return _together([{f: x for f, x in fields.items() if x is not None} for fields in each])

    def _text(self, element: _Element, shape: list[int]) -> NDArray[Any]:
        kind, data = element
        self._claim(_WIDEST * len(data))
        size = np.dtype(_NUMBERS[kind]).itemsize
        end = "le" if self._order == "<" else "be"
        of_size = {1: "latin-1", 2: f"utf-16-{end}", 4: f"utf-32-{end}"}
        text = bytes(data).decode("utf-8" if kind == _UTF8 else of_size[size], "replace")
        return _rows_of(text, shape[0])

    def _numbers(self, element: _Element) -> NDArray[Any]:
        kind, data = element
        return np.frombuffer(data, self._order + _NUMBERS[kind])


def _version_4(data: memoryview) -> Iterator[tuple[str, Any]]:
    at = 0
    while at < len(data):
        (kind,) = unpack_from("<i", data, at)
        order = "<" if 0 <= kind < 1000 else ">"
        kind, rows, columns, has_imaginary, length = unpack_from(f"{order}5i", data, at)
        number, content = kind % 100 // 10, kind % 10
        is_known = kind // 100 == (0 if order == "<" else 10) and has_imaginary in (0, 1)
        if not is_known or min(rows, columns) < 0 or length < 1:
            raise ValueError(f"no matrix at byte {at}")
        at += 20
        name = bytes(data[at : at + length]).partition(b"\0")[0].decode("latin-1")
        at += length
        dtype = np.dtype(order + _NUMBERS_4[number])
        parts = []
        for _ in range(1 + has_imaginary):
            parts.append(np.frombuffer(data, dtype, rows * columns, at))
            at += parts[-1].nbytes
        if content == _TEXT_4:
            yield name, _rows_of(parts[0].astype("u1").tobytes().decode("latin-1"), rows)
        elif content == _FULL_4:
            values = parts[0] + 1j * parts[1] if has_imaginary else parts[0]
            yield name, values.reshape((rows, columns), order="F")


def _next(parts: Iterator[_Element]) -> _Element:
    found = next(parts, None)
    if found is None:
        raise ValueError("an array ends early")
    return found


def _rows_of(text: str, rows: int) -> NDArray[Any]:
    """A matrix of characters, which is kept by columns, as its rows."""
    if rows > max(len(text), 1):
        raise ValueError("a text of fewer characters than lines")
    return np.array([text[i::rows] for i in range(rows)], dtype=np.str_)


def _together(values: list[Any]) -> Any:
    """Structures as they are if there is one, as a list if there are more; else objects."""
    if values and all(isinstance(x, Mapping | list) for x in values):
        each = list(chain.from_iterable(x if isinstance(x, list) else [x] for x in values))
        return each[0] if len(each) == 1 else each
    return np.fromiter(values, object, len(values))


# What writes an object of a class so that it is read.
_TYPES_WRITTEN = {
    "table": "writetable({0}, 'results.csv')",
    "timetable": "writetimetable({0}, 'results.csv')",
    "timeseries": "results = [{0}.Time {0}.Data]; save results.mat results",
}
_SAVED = "save results.mat with its times and values as arrays"


def read(file: ResultFile) -> list[ReadTable]:
    """The tables in the variables; those of version 7.3 are in HDF5.

    Raises
    ------
    InputError
        Kept in other files, or not columns of real numbers.
    """
    request = file.request
    if is_hdf5_of_matlab(file.head):
        with request.damage("HDF5"):
            found = hdf5.read(file, is_turned=True)
    else:
        found = matlab_variables(file.stream().read(), request.most_bytes)
    objects = [(name, x.name) for name, x in found.items() if isinstance(x, OfClass)]
    found = _trajectory(found, request) or found
    try:
        return tables(_plain(found, request), request)
    except InputError:
        if not objects:
            raise
        name, kind = objects[0]
        raise request.error(
            f"found {quoted(name)}, a {kind}, which MATLAB saves in a form of its own, expected "
            f"arrays; in MATLAB: {_TYPES_WRITTEN.get(kind, _SAVED).format(name)}"
        ) from None


def _trajectory(members: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """The variables of a trajectory of Dymola or OpenModelica by name; none of another file.

    ``name`` has the names, a row or a column of characters each, ``dataInfo`` the table of each and
    its row or column there, negative for the negative, and ``Aclass`` says which of both.
    """
    if not {"Aclass", "name", "dataInfo"} <= members.keys():
        return {}
    kinds = [str(x).strip() for x in np.ravel(members["Aclass"])]
    if not kinds or not kinds[0].endswith("trajectory"):
        return {}
    letters = [str(x) for x in np.ravel(members["name"])]
    info, values = np.asarray(members["dataInfo"]), members.get("data_2")
    if kinds[-1] == "binTrans":
        # Names and values of a variable are in a column.
        width = max(map(len, letters))
        letters = list(map("".join, zip(*(x.ljust(width) for x in letters), strict=True)))
        info = info.T
    elif values is not None:
        values = np.asarray(values).T
    if len(info) != len(letters) or values is None:
        raise request.error("found a trajectory without its names and values, expected both")
    found: list[tuple[str, Any]] = []
    for name, (table, at, *_) in zip(letters, info.astype(int).tolist(), strict=True):
        # Parameters are in the first table; the time, of table 0, is in each.
        if table in (0, 2) and 0 < abs(at) <= len(values):
            found.append((name.strip("\0 "), values[abs(at) - 1] * np.sign(at)))
    return request.by_name(found)


def _plain(members: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """Variables with cells, solutions of ode45 and what Simulink logs as columns and their time."""
    found: dict[str, Any] = {}
    for name, x in _without_cells(members).items():
        if isinstance(x, list):
            each = [y for y in x if isinstance(y, Mapping)]
            x = {f"maneuver_{i}": y for i, y in enumerate(each, 1)}
        if isinstance(x, Mapping):
            found[name] = _structure(name, x, request)
        elif not isinstance(x, OfClass):
            found[name] = x
    # The time of the simulation is that of what was logged without one.
    logged = [x for x in found.values() if isinstance(x, dict)]
    if len(logged) == 1 and "tout" in found and "time" not in logged[0]:
        logged[0]["time"] = found["tout"]
    return found


def _structure(name: str, x: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """A structure, of which some programs have their own kinds, as its columns."""
    if "signals" in x:
        signals = x["signals"] if isinstance(x["signals"], list) else [x["signals"]]
        columns = _columns([s for s in signals if isinstance(s, Mapping)], request)
        has_time = "time" in x and prod(x["time"].shape)
        return {"time": x["time"], **columns} if has_time else columns
    if not x.keys() >= {"solver", "x", "y"}:
        return _plain(x, request)
    if request.names is None and 1 + x["y"].shape[0] not in request.widths:
        raise request.error(
            f"found {quoted(name)}, a solution of {_word(x['solver']) or 'ode45'} with "
            f"{x['y'].shape[0]} states, and not which they are; {request.how_to_tell}"
        )
    return {"time": x["x"], "y": x["y"]}


def _without_cells(members: Mapping[str, Any]) -> dict[str, Any]:
    """Cell arrays as what is in them: one thing, columns below their names, or maneuvers."""
    found = {n: x for n, x in members.items() if not _is_cell(x)}
    for name, x in members.items():
        if not _is_cell(x):
            continue
        if x.size == 1:
            found[name] = x.item()
        elif x.ndim == 2 and len(x) > 1 and all(map(_word, x[0])):
            found[name] = {_word(y[0]): np.array([*map(np.ravel, y[1:])]).ravel() for y in x.T}
        elif not all(hasattr(y, "shape") and prod(y.shape) > 1 for y in x.flat):
            found[name] = x
        else:
            for i, y in enumerate(x.ravel(order="F"), 1):
                found.setdefault(f"maneuver_{i}", {})[name] = y
    return found


def _is_cell(x: Any) -> bool:
    return isinstance(x, np.ndarray) and x.dtype.kind == "O" and x.size > 0


def _columns(signals: list[Mapping[str, Any]], request: Request) -> dict[str, Any]:
    values = {
        i: np.squeeze(read_array(s["values"], request.within("signals")))
        for i, s in enumerate(signals)
        if "values" in s
    }
    labels = {i: _word(signals[i].get("label")) for i in values}
    if all(map(is_known, labels.values())) or len(values) == 1:
        return {labels[i] or "values": x for i, x in values.items()}
    # Blocks in the order of the benchmark, or a matrix of each.
    rows = max((max(x.shape, default=0) for x in values.values()), default=0)
    upright = [x if x.shape[:1] == (rows,) else x.T for x in values.values()]
    if any(x.shape[:1] != (rows,) for x in upright):
        return {}
    return {"values": np.column_stack(upright)}


def _word(x: Any) -> str:
    """A text of MATLAB, empty if it is none."""
    if not isinstance(x, np.ndarray) or not x.size or x.dtype.kind not in "US":
        return ""
    return str(x.ravel()[0]).strip()
