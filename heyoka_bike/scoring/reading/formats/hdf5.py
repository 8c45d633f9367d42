"""Read HDF5 files, including netCDF 4, but only arrays that are stored in the file itself.

A file may name other files: by external links, arrays whose bytes are stored elsewhere, and virtual
arrays. None of these is opened, wherever it is and whatever leads to it. All arrays that are read
together unpack to the bytes that the request allows.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import prod
from pickletools import genops
from typing import Any

import h5py
import numpy as np

from heyoka_bike.errors import DatasetError, printable
from heyoka_bike.reference.hdf5 import bytes_of, refuse_many_texts, why_unsafe
from heyoka_bike.scoring.reading.arrays.array_columns import MOST_BYTES, refuse_too_large
from heyoka_bike.scoring.reading.arrays.groups import DEEPEST, MOST_MEMBERS
from heyoka_bike.scoring.reading.arrays.packed import StoredArray, unpacked
from heyoka_bike.scoring.reading.names.heading import TIME, is_time, with_unit
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile

# Beginning of the name of a block, in which pandas stores all columns of one type of a data frame.
_BLOCK = "values_"
_KIND_OF_PANDAS = re.compile(r"(datetime|timedelta)64(?:\[(s|ms|us|ns)\])?")
_BYTES_OF_TIMES = 8
_BYTES_OF_LETTER = 4
# A text may be as long as the file. A row of texts of this length may exceed the memory limit by at
# most this factor; otherwise the row is refused. The true lengths are known only after reading.
_MOST_TIMES = 10


@dataclass(frozen=True, slots=True)
class OfClass:
    """An object of a MATLAB class, such as a table, whose content is stored in another format."""

    name: str


def read(file: ResultFile, is_turned: bool = False) -> dict[str, Any]:
    """Read the arrays and groups of the file; convert those that MATLAB and Octave wrote.

    MATLAB's variables are converted as `matlab.matlab_variables` does for older files.

    Parameters
    ----------
    file
    is_turned
        True if the axes of arrays are stored in reverse order, as in MATLAB's files.

    Raises
    ------
    InputError
        An array is stored in another file, or there are too many arrays.
    """
    opened = file.stack.enter_context(h5py.File(file.path_or_stream(), "r"))
    return _OwnFile(opened, file.request, is_turned).variables(opened)


class _OwnFile:
    """Reads the groups and arrays that are stored in an HDF5 file itself."""

    def __init__(self, file: Any, request: Request, is_turned: bool) -> None:
        self._file = file
        self._request = request
        self._is_turned = is_turned
        self._count = 0
        self._left = request.most_bytes
        self._unpacked: set[int] = set()

    def variables(self, group: Any, depth: int = 0) -> dict[str, Any]:
        """Return the arrays and groups in a group by name."""
        if columns := self._of_pandas(group):
            return columns
        found: dict[str, Any] = {}
        for name, x in self._members(group):
            if isinstance(x, h5py.Group) and x.keys() == {"type", "value"}:
                # Octave writes a variable as a group with its type and its value.
                x = dict(self._members(x)).get("value")
            if isinstance(x, h5py.Group) and depth < DEEPEST and not name.startswith("#"):
                fields = {n: y for n, y in self._members(x) if isinstance(y, h5py.Dataset)}
                if fields and all(map(_has_references, fields.values())):
                    each = {n: self._array(y)[()].ravel("F") for n, y in fields.items()}
                    found[name] = [
                        {n: self._referred(y[i]) for n, y in each.items()}
                        for i in range(min(map(len, each.values())))
                    ]
                else:
                    found[name] = self.variables(x, depth + 1)
            elif isinstance(x, h5py.Dataset) and (value := self._value(x)) is not None:
                found[with_unit(name, x.attrs)] = value
        return found

    def _of_pandas(self, group: Any) -> dict[str, Any]:
        """Return the columns of a data frame that pandas wrote; an empty dict for other groups.

        Columns of one type form a matrix, the block. The names of its columns are stored
        separately: in the layout ``table`` as a pickle, from which only the texts are read, so that
        no code runs.
        """
        kind = group.attrs.get("pandas_type", b"")
        members = dict(self._members(group)) if kind else {}
        found: list[tuple[str, Any]] = []
        index = None
        if kind == b"frame_table" and isinstance(members.get("table"), h5py.Dataset):
            table = members["table"]
            rows = self._array(table)[()]
            if "index" in (rows.dtype.names or ()):
                index = _of_kind(rows["index"], table.attrs.get("index_kind"))
            fields = [name for name in rows.dtype.names or () if name != "index"]
            # Columns that pandas can search are not in the blocks. Each such column is stored
            # separately under its name.
            alone = [name for name in fields if not name.startswith(_BLOCK)]
            found += ((name, _of_kind(rows[name], table.attrs.get(f"{name}_dtype")))
                      for name in alone if rows[name].ndim == 1)  # fmt: skip
            for block in [name for name in fields if name.startswith(_BLOCK)]:
                names = texts_of_pickle(bytes(table.attrs.get(f"{block}_kind", b"")))
                if len(names) == rows[block][0:1].size:
                    values = _of_kind(rows[block], table.attrs.get(f"{block}_dtype"))
                    found += zip(names, np.atleast_2d(values.T), strict=True)
        elif kind == b"frame" and isinstance(members.get("axis1"), h5py.Dataset):
            index = _of_kind(self._array(members["axis1"])[()], members["axis1"].attrs.get("kind"))
            for i in range(len(members)):
                items, values = (members.get(f"block{i}_{x}") for x in ("items", "values"))
                if isinstance(items, h5py.Dataset) and isinstance(values, h5py.Dataset):
                    names = [_text(x) for x in self._array(items)[()].ravel()]
                    kind = values.attrs.get("value_type")
                    found += zip(names, _of_kind(self._array(values)[()], kind).T, strict=True)
        # The index of the rows may contain the times, but an index of integers only counts the
        # rows.
        if index is not None and index.dtype.kind in "fm" and not any(is_time(n) for n, _ in found):
            found.insert(0, (TIME, index))
        return self._request.by_name(found)

    def _value(self, dataset: Any) -> Any:
        """Return the array or the text in a dataset; None if the dataset is empty."""
        if dataset.shape is None or "MATLAB_empty" in dataset.attrs or _is_a_length(dataset):
            return None
        if "MATLAB_object_decode" in dataset.attrs:
            return OfClass(dataset.attrs["MATLAB_class"].decode("latin-1"))
        array = self._array(dataset)
        if _has_references(dataset):
            cells = array[()]
            inner = [self._referred(x) for x in cells.ravel(order="F")]
            return np.fromiter(inner, object, len(inner)).reshape(cells.shape, order="F")
        if dataset.attrs.get("MATLAB_class") == b"char":
            # The text remains in memory, and any number of references may lead to it, so count its
            # memory each time.
            self._spend(prod(dataset.shape) * _BYTES_OF_LETTER)
            return np.array("".join(map(chr, array[()].ravel())))
        return unpacked(array, dataset.attrs)

    def _referred(self, reference: Any) -> Any:
        x = self._file[reference] if reference else None
        if isinstance(x, h5py.Group):
            return self.variables(x, DEEPEST)
        return self._value(x) if isinstance(x, h5py.Dataset) else None

    def _members(self, group: Any) -> Iterator[tuple[str, Any]]:
        """Yield the names and objects in a group.

        Soft and external links are left out: a soft link could lead, by way of other links, to
        another file.
        """
        for name in group:
            # HDF5 looks up a name that contains a slash as a path, and follows any link on this
            # path.
            if "/" not in name and isinstance(group.get(name, getlink=True), h5py.HardLink):
                self._claim()
                item = group[name]
                try:
                    refuse_many_texts(item.id, name.encode() + b"/")
                except DatasetError as e:
                    raise self._request.error(f"found {e}") from None
                yield name, item

    def _array(self, dataset: Any) -> StoredArray:
        """Return an array that is read from the file only when it is used."""
        self._claim()
        if dataset.is_virtual or dataset.external:
            raise self._request.error(
                f"found {printable(dataset.name)} stored in another file, expected it in this one"
            )
        shape = dataset.shape[::-1] if self._is_turned else dataset.shape
        return StoredArray(dataset.dtype, shape, lambda: self._read(dataset))

    def _claim(self) -> None:
        self._count += 1
        if self._count > MOST_MEMBERS:
            raise self._request.error(
                f"found more than {MOST_MEMBERS} arrays and groups, expected fewer"
            )

    def _read(self, dataset: Any) -> Any:
        with self._request.damage("HDF5"):
            refuse_too_large(dataset, self._request)
            if reason := why_unsafe(dataset.id, MOST_BYTES):
                raise self._request.error(f"found {printable(dataset.name)[:100]}: it {reason}")
            self._claim_unpacked(dataset)
            try:
                found = self._texts(dataset) if dataset.dtype.hasobject else dataset[()]
            except OSError:
                self._check_filters(dataset)
                raise
            return found.T if self._is_turned else found

    def _claim_unpacked(self, dataset: Any) -> None:
        """Count the memory that unpacking an array adds, once for each array, against the limit."""
        place = h5py.h5o.get_info(dataset.id).addr
        if place not in self._unpacked:
            self._unpacked.add(place)
            chunk = prod(dataset.chunks or ()) * dataset.dtype.itemsize
            self._spend(max(bytes_of(dataset.id), chunk) - dataset.id.get_storage_size())

    def _spend(self, size: int) -> None:
        self._left -= max(size, 0)
        if self._left < 0:
            raise self._request.too_long()

    def _texts(self, dataset: Any) -> Any:
        """Read an array of texts in steps, because each text may be as long as the file."""
        if _has_references(dataset) or dataset.ndim == 0:
            return dataset[()]
        longest = self._file.id.get_filesize()
        row = prod(dataset.shape[1:])
        if row * longest > _MOST_TIMES * self._request.most_bytes:
            raise self._request.too_long()
        step = max(1, self._request.most_bytes // max(row * longest, 1))
        parts = []
        for i in range(0, len(dataset), step):
            parts.append(dataset[i : i + step])
            self._spend(_length(parts[-1]))
        return np.concatenate(parts) if parts else dataset[()]

    def _check_filters(self, dataset: Any) -> None:
        """Raise an error that names the filter if the array needs one that is not installed."""
        made = dataset.id.get_create_plist()
        for i in range(made.get_nfilters()):
            code, _, _, name = made.get_filter(i)
            if not h5py.h5z.filter_avail(code):
                raise self._request.error(
                    f"found {printable(dataset.name)} compressed by "
                    f"{printable(name.decode(errors='replace')) or f'filter {code}'}, which is not "
                    "installed here, expected gzip or none (h5repack -f GZIP=6 changes it)"
                )


def _length(x: Any) -> int:
    """Return the total length of all texts and sequences in an array, and in its fields."""
    if x.dtype.names:
        return sum(_length(x[name]) for name in x.dtype.names)
    if x.dtype.kind != "O":
        return 0
    return sum(getattr(item, "nbytes", len(item)) for item in x.ravel() if item is not None)


def texts_of_pickle(pickled: bytes) -> list[str]:
    """Return the texts in a pickle, in order, without running any of its code."""
    with suppress(ValueError):
        operations = genops(pickled.rstrip(b"\0"))
        return [str(x) for operation, x, _ in operations if "UNICODE" in operation.name]
    return []


def _of_kind(values: Any, kind: Any) -> Any:
    """Convert integers that pandas wrote for dates or time differences to these types."""
    match = _KIND_OF_PANDAS.fullmatch(_text(kind))
    is_whole = values.dtype.kind == "i" and values.dtype.itemsize == _BYTES_OF_TIMES
    if match is None or not is_whole:
        return values
    return values.view(f"{'M8' if match[1] == 'datetime' else 'm8'}[{match[2] or 'ns'}]")


def _text(x: Any) -> str:
    return x.decode("utf-8", "replace") if isinstance(x, bytes) else str(x)


def _has_references(dataset: Any) -> bool:
    return bool(h5py.check_ref_dtype(dataset.dtype) is h5py.Reference)


def _is_a_length(dataset: Any) -> bool:
    """True if netCDF stores a dataset only for the length of an axis without coordinates."""
    what = dataset.attrs.get("NAME", b"")
    return isinstance(what, bytes) and what.startswith(b"This is a netCDF dimension but not")
