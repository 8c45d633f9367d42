"""Read MATLAB's and Simulink's files: variables, structures and logged signals.

SciPy reads versions 4 to 7; files of version 7.3 are HDF5. Variables become Python objects: a text
an array of strings, a structure a mapping, an array or cell array of structures a list of mappings,
any other cell array an array of objects, and an object of a class its name. Sparse matrices and
functions are left out.
"""

import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from io import BytesIO
from itertools import chain
from math import prod
from struct import pack, unpack_from
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.arrays.array_columns import read_array
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.formats import hdf5, is_hdf5_of_matlab
from heyoka_bike.scoring.reading.formats.hdf5 import OfClass
from heyoka_bike.scoring.reading.names.heading import is_known
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.table import ReadTable

# Size of a number [bytes] by the type of the element, in versions 5 to 7 (*MAT-File Format*, The
# MathWorks).
_SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}
_MATRIX, _COMPRESSED = 14, 15
# Class numbers of arrays. `_NUMBERS` ranges from the class of text to that of 64-bit integers.
# `_COMPLEX` is the bit of the flags that marks a complex array.
_SPARSE, _OF_CLASS = 5, 17
_NUMBERS = range(4, 16)
_COMPLEX = 0x800
_BYTES_OF_FLAGS, _LEAST_BYTES_OF_SHAPE = 8, 8
_BYTES_OF_HEADER = 128
_ORDERS = {b"IM": "<", b"MI": ">"}
# Minimum memory of an array, and maximum memory of a single number or character [bytes].
_LEAST_BYTES, _WIDEST = 200, 8
_Element = tuple[int, memoryview]


def matlab_variables(data: bytes, request: Request) -> dict[str, Any]:
    """Return the variables of a file of version 4 to 7 by name.

    Raises
    ------
    InputError
        The file is larger after unpacking than the request allows.
    ImportError
        SciPy is not installed.
    ValueError
        The file is damaged. Damaged bytes may also raise other exceptions of Python.
    """
    from scipy.io import loadmat, whosmat

    order = _ORDERS.get(data[126:_BYTES_OF_HEADER])
    if order is None:
        names, options = [name for name, *_ in whosmat(BytesIO(data))], {}
    else:
        unpacker = _Unpacker(order, request)
        data = unpacker.unpacked(data)
        names, options = unpacker.names, {"uint16_codec": "utf-16"}
    if again := next((name for name, count in Counter(names).items() if count > 1), ""):
        raise ValueError(f"two variables {again}")
    values: dict[str, Any] = {}
    for name, x in loadmat(BytesIO(data), **options).items():
        value = None if name.startswith("__") else _value(x)
        if isinstance(value, OfClass):
            # SciPy gives every object of a class the name "None", so read the name from the object.
            values[_text(x["s0"].item())] = value
        elif value is not None:
            values[name] = value
    return values


class _Unpacker:
    """Unpacks the variables of a file of version 5 to 7, and checks what SciPy does not check.

    SciPy unpacks without a limit on memory. It crashes on elements of unknown types, and on arrays
    that are nested too deeply.

    Attributes
    ----------
    names : list of str
        Names of the variables.
    """

    def __init__(self, order: str, request: Request) -> None:
        self._order, self._request, self._room = order, request, request.most_bytes
        self.names: list[str] = []

    def unpacked(self, data: bytes) -> bytes:
        """Return the file without compression, as MATLAB's version 6 would write it."""
        found = [data[:_BYTES_OF_HEADER]]
        for kind, body in self._elements(memoryview(data)[_BYTES_OF_HEADER:]):
            if kind == _COMPRESSED:
                kind, body = self._decompressed(body)
            if name := self._checked(kind, body):
                self.names.append(name)
            found += [pack(f"{self._order}II", kind, len(body)), bytes(body)]
        return b"".join(found)

    def _decompressed(self, body: memoryview) -> _Element:
        unpacker = zlib.decompressobj()
        unpacked = unpacker.decompress(body, self._room + 1)
        self._claim(len(unpacked))
        elements = [*self._elements(memoryview(unpacked))]
        if not unpacker.eof or len(elements) != 1:
            raise ValueError("a compressed element has a wrong length")
        return elements[0]

    def _claim(self, size: int) -> None:
        """Subtract a size from the memory that the request allows."""
        self._room -= size
        if self._room < 0:
            raise self._request.too_long()

    def _elements(self, data: memoryview) -> Iterator[_Element]:
        at = 0
        while at < len(data):
            kind, size = unpack_from(f"{self._order}II", data, at)
            start, following = at + 8, at + 8 + size
            if kind >> 16:
                # A short element has four bytes for its type and length, and four bytes for its
                # content.
                kind, size, start, following = kind & 0xFFFF, kind >> 16, at + 4, at + 8
            elif kind != _COMPRESSED:
                following += -size % 8
            if start + size > min(following, len(data)):
                raise ValueError(
                    f"the element at byte {at} is shorter than its stated {size} bytes"
                )
            yield kind, data[start : start + size]
            at = following

    def _checked(self, kind: int, body: memoryview) -> str:
        """Check an element and its parts; return its name if the element is an array."""
        self._claim(_LEAST_BYTES)
        if kind in _SIZES:
            self._claim(len(body) // _SIZES[kind] * (_WIDEST - _SIZES[kind]))
            return ""
        if kind != _MATRIX:
            raise ValueError(f"an element has the unknown type {kind}")
        if not body:
            return ""
        parts = [*self._elements(body)]
        if len(parts) < 2:
            raise ValueError("an array without a shape")
        flags, shape = parts[0][1], parts[1][1]
        if len(flags) != _BYTES_OF_FLAGS:
            raise ValueError("an array without flags")
        (said,) = unpack_from(f"{self._order}I", flags)
        of = said & 0xFF
        if of != _OF_CLASS and (len(shape) < _LEAST_BYTES_OF_SHAPE or len(shape) % 4):
            raise ValueError("an array without a shape")
        if of in _NUMBERS:
            # Without this check, SciPy would continue to read into the next array.
            needed = (6 if of == _SPARSE else 4) + bool(said & _COMPLEX)
            if len(parts) < needed or any(kind == _MATRIX for kind, _ in parts):
                raise ValueError("an array without its numbers")
        for part in parts:
            self._checked(*part)
        # In an object of a class, the name is not preceded by a shape.
        place = 1 if of == _OF_CLASS else 2
        return _text(bytes(parts[place][1])) if len(parts) > place else ""


def _value(x: Any) -> Any:
    """Convert a variable that SciPy read to mappings and lists; None if it is left out."""
    if isinstance(x, str):
        # If SciPy cannot read a variable, it returns the text of the error in its place.
        raise ValueError(x)
    if not isinstance(x, np.ndarray) or type(x).__name__ == "MatlabFunction":
        return None
    if type(x).__name__ == "MatlabOpaque":
        return OfClass(_text(x["s2"].item()))
    if names := x.dtype.names:
        each = [{n: _value(y[n]) for n in names} for y in x.ravel("F")]
        return _together([{n: y for n, y in z.items() if y is not None} for z in each])
    if x.dtype != object:
        # MATLAB stores double-precision numbers as integers if this takes less space.
        return x.astype("f8") if x.dtype.kind in "iu" and x.itemsize < _WIDEST else x
    found = _together([_value(y) for y in x.ravel("F")])
    return found.reshape(x.shape, order="F") if isinstance(found, np.ndarray) else found


def _text(x: bytes | str) -> str:
    return x if isinstance(x, str) else x.decode("latin-1")


def _together(values: list[Any]) -> Any:
    """Return a single structure unchanged, several as a list, and other values as an array."""
    if values and all(isinstance(x, Mapping | list) for x in values):
        each = list(chain.from_iterable(x if isinstance(x, list) else [x] for x in values))
        return each[0] if len(each) == 1 else each
    return np.fromiter(values, object, len(values))


# For objects of these classes: MATLAB code that writes the object to a file that can be read here.
_TYPES_WRITTEN = {
    "table": "writetable({0}, 'results.csv')",
    "timetable": "writetimetable({0}, 'results.csv')",
    "timeseries": "results = [{0}.Time {0}.Data]; save results.mat results",
}
_SAVED = "save results.mat with its times and values as arrays"


def read(file: ResultFile) -> list[ReadTable]:
    """Return the tables in the variables of a file; files of version 7.3 are read as HDF5.

    Raises
    ------
    InputError
        The arrays are stored in other files, or are not columns of real numbers.
    """
    request = file.request
    if is_hdf5_of_matlab(file.head):
        with request.damage("HDF5"):
            found = hdf5.read(file, is_turned=True)
    else:
        found = matlab_variables(file.stream().read(), request)
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
    """Return the variables of a Dymola or OpenModelica trajectory; empty for other files.

    ``name`` contains the names. ``dataInfo`` contains the table of each variable, and its row or
    column in that table, with a minus sign if the values are to be negated. ``Aclass`` shows
    whether each name is in a row or a column.
    """
    if not {"Aclass", "name", "dataInfo"} <= members.keys():
        return {}
    kinds = [str(x).strip() for x in np.ravel(members["Aclass"])]
    if not kinds or not kinds[0].endswith("trajectory"):
        return {}
    letters = [str(x) for x in np.ravel(members["name"])]
    info, values = np.asarray(members["dataInfo"]), members.get("data_2")
    if kinds[-1] == "binTrans":
        # The name and the values of each variable are in a column, not in a row.
        width = max(map(len, letters))
        letters = list(map("".join, zip(*(x.ljust(width) for x in letters), strict=True)))
        info = info.T
    elif values is not None:
        values = np.asarray(values).T
    if len(info) != len(letters) or values is None:
        raise request.error("found a trajectory without its names and values, expected both")
    found: list[tuple[str, Any]] = []
    for name, (table, at, *_) in zip(letters, info.astype(int).tolist(), strict=True):
        # Parameters are in the first table and are left out. The time has the table number 0,
        # because each table contains it.
        if table in (0, 2) and 0 < abs(at) <= len(values):
            found.append((name.strip("\0 "), values[abs(at) - 1] * np.sign(at)))
    return request.by_name(found)


def _plain(members: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """Convert cell arrays, solutions of ode45 and signals of Simulink to columns with times."""
    found: dict[str, Any] = {}
    for name, x in _without_cells(members).items():
        if isinstance(x, list):
            each = [y for y in x if isinstance(y, Mapping)]
            x = {f"maneuver_{i}": y for i, y in enumerate(each, 1)}
        if isinstance(x, Mapping):
            found[name] = _structure(name, x, request)
        elif not isinstance(x, OfClass):
            found[name] = x
    # `tout` contains the times of signals that were logged without times of their own.
    logged = [x for x in found.values() if isinstance(x, dict)]
    if len(logged) == 1 and "tout" in found and "time" not in logged[0]:
        logged[0]["time"] = found["tout"]
    return found


def _structure(name: str, x: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """Return the columns of a structure, which may be of Simulink, of ode45 or of the user."""
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
            f"{x['y'].shape[0]} states without names; {request.columns_hint}"
        )
    return {"time": x["x"], "y": x["y"]}


def _without_cells(members: Mapping[str, Any]) -> dict[str, Any]:
    """Replace each cell array with what it contains: one value, named columns, or maneuvers."""
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
    # Together, the signals must contain the columns of the benchmark in its order. Each signal is a
    # vector, or a matrix of several columns.
    rows = max((max(x.shape, default=0) for x in values.values()), default=0)
    upright = [x if x.shape[:1] == (rows,) else x.T for x in values.values()]
    if any(x.shape[:1] != (rows,) for x in upright):
        return {}
    return {"values": np.column_stack(upright)}


def _word(x: Any) -> str:
    """Return the first text in a MATLAB array; an empty string if the array contains no text."""
    if not isinstance(x, np.ndarray) or not x.size or x.dtype.kind not in "US":
        return ""
    return str(x.ravel()[0]).strip()
