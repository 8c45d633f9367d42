"""Groups of HDF5 files: their declaration, used both to write and to read them.

All files of a dataset have attributes of the whole file and a group for each maneuver,
``maneuver_1`` and so on. A column is one dataset or more: its values, ``<name>_lo`` and
``<name>_bound``.

HDF5 allows links to other files, datasets stored in other files, and compressed numbers that unpack
to a thousand times their size. `opened` rejects all of these before anything is read, and
`why_unsafe` checks a single dataset of any file.
"""

from __future__ import annotations

import hashlib
import io
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from math import prod
from typing import Any, TypeVar

import h5py
import numpy as np

from heyoka_bike.errors import DatasetError, printable
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.layout import FILTERS

T = TypeVar("T")

DAMAGE = (
    OSError, ArithmeticError, AttributeError, LookupError, MemoryError, RuntimeError, TypeError,
    ValueError,
)  # fmt: skip
"""Errors that h5py, json and others raise on damaged bytes: nearly all exceptions."""

INDEX = "<i4"
"""Type of a dataset that counts along an axis: 0, 1, 2, ..."""

SCALE_ATTRIBUTES = frozenset(("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"))
"""Attributes set by HDF5's dimension scales."""

LOW, BOUND = "_lo", "_bound"
"""Suffixes of the datasets of a column's low part and of its bounds."""

UNDECIDED = "_undecided"
"""Suffix of the dataset with the row numbers whose rounding is not decided, if there are any."""

ROW_NUMBER = "<i8"
"""Type of a dataset of row numbers."""

_NO_COLUMNS = frozenset(("time", "breaks", "piece", "order", "dense", "rows"))


@dataclass(frozen=True, slots=True)
class Dataset:
    """Declaration of a dataset in a group.

    Attributes
    ----------
    name : str
    shape : tuple of int
    attributes : mapping of str to str
    scales : tuple of str
        Datasets of the group that are the dimension scales of the first axes.
    is_scale : bool
        True if the dataset is itself a dimension scale.
    is_column : bool
        True if the dataset is one of several that differ only in their numbers.
    kind : str
        NumPy dtype of the numbers.
    has_nan : bool
        True if NaN stands for a missing number.
    """

    name: str
    shape: tuple[int, ...]
    attributes: Mapping[str, str] = field(default_factory=dict)
    scales: tuple[str, ...] = ()
    is_scale: bool = False
    is_column: bool = False
    kind: str = "<f8"
    has_nan: bool = False


@dataclass(frozen=True, slots=True)
class Group:
    """Declaration of a group or of a whole file; attributes and members are in order of creation.

    Attributes
    ----------
    attributes : mapping
    datasets : tuple of Dataset
    groups : mapping of str to Group
    """

    attributes: Mapping[str, Any]
    datasets: tuple[Dataset, ...] = ()
    groups: Mapping[str, Group] = field(default_factory=dict)

    @property
    def members(self) -> tuple[str, ...]:
        """Names of the datasets and groups in this group."""
        return (*(dataset.name for dataset in self.datasets), *self.groups)


def by_maneuver(items: Iterable[T]) -> dict[str, T]:
    """Map the group name of each maneuver (maneuver_1, ...) to its item."""
    return {f"maneuver_{i}": item for i, item in enumerate(items, start=1)}


def of_maneuvers(f: Mapping[str, T], count: int) -> list[T]:
    """Return the groups of a file, one for each of its `count` maneuvers."""
    return [f[name] for name in by_maneuver(range(count))]


def opened(raw: bytes, *, is_known: bool = False) -> h5py.File:
    """Open an HDF5 file in memory; it stays open, and its arrays are read when needed.

    Parameters
    ----------
    raw
    is_known
        True if the package knows the hash of the bytes. Other bytes are checked first, once per
        process.

    Raises
    ------
    DatasetError
        An object is not stored in the file itself, or unpacks to more than a dataset may contain.
    """
    # Open an image of the file in memory. HDF5 would access a Python file object on closing, when
    # Python may have ended.
    f = h5py.File(h5py.h5f.open_file_image(raw))
    digest = b"" if is_known else hashlib.sha256(raw).digest()
    if not is_known and digest not in _looked_through:
        try:
            _look_through(f, _MOST_BYTES + _MOST_TIMES * len(raw))
        except BaseException:
            f.close()
            raise
        _looked_through.add(digest)
    return f


_looked_through: set[bytes] = set()

_MOST_BYTES, _MOST_TIMES = 50_000_000, 20
"""Limits on the unpacked size of a dataset's file: bytes, and multiples of the file's length. The
published files unpack to twice their length; columns of zeros take no space."""

_MOST_OBJECTS = 100_000
"""Maximum number of groups and datasets of a file; the published files have at most 1,500."""


def _look_through(f: h5py.File, most: int) -> None:
    """Reject a file with an object that is stored elsewhere, duplicated, or too large to unpack.

    All datasets together may unpack to at most `most` bytes.
    """
    root = h5py.h5g.open(f.id, b"/")
    groups, seen, count = [root], {h5py.h5o.get_info(root).addr}, 0
    while groups:
        group = groups.pop()
        inside = h5py.h5i.get_name(group).rstrip(b"/") + b"/"
        refuse_many_texts(group, inside)
        for name in group:
            where, count = _shown(inside + name), count + 1
            # HDF5 looks up a name that contains a slash as a path, and follows any link on this
            # path.
            if b"/" in name or group.links.get_info(name).type != h5py.h5l.TYPE_HARD:
                raise DatasetError(f"{where} is a link, expected numbers stored in this file")
            item = h5py.h5o.open(group, name)
            place = h5py.h5o.get_info(item).addr
            if place in seen:
                raise DatasetError(f"{where} is a second name of an object, expected one name")
            seen.add(place)
            if isinstance(item, h5py.h5g.GroupID):
                groups.append(item)
            elif isinstance(item, h5py.h5d.DatasetID):
                reason = why_unsafe(item, most, _FILTERS_OF_SETS)
                if not reason and item.get_type().get_class() not in _NUMBERS:
                    reason = "does not contain numbers, expected a dataset of numbers"
                if reason:
                    raise DatasetError(f"{where} {reason}")
                most -= bytes_of(item)
                refuse_many_texts(item, inside + name + b"/")
            else:
                raise DatasetError(f"{where} is a named type, which is not part of a dataset")
            if count > _MOST_OBJECTS:
                raise DatasetError(f"found more than {_MOST_OBJECTS} groups and datasets")


def refuse_many_texts(item: Any, inside: bytes) -> None:
    """Reject attributes with many texts: all could refer to the same long text of the file.

    Raises
    ------
    DatasetError
        An attribute of the object with this low-level identifier has many texts.
    """
    for i in range(h5py.h5a.get_num_attrs(item)):
        attribute = h5py.h5a.open(item, index=i)
        kind = attribute.get_type()
        has_texts = any(kind.detect_class(x) for x in (h5py.h5t.VLEN, h5py.h5t.STRING))
        if has_texts and prod(attribute.shape or ()) > _MOST_TEXTS:
            where = _shown(inside + attribute.name)
            raise DatasetError(f"attribute {where} has many strings, expected one string")


_NUMBERS = (h5py.h5t.INTEGER, h5py.h5t.FLOAT)
_MOST_TEXTS = 32
"""Maximum number of texts in an attribute. Attributes of dimension scales have an entry per axis,
and HDF5 allows 32 axes."""

_DEFLATE, _SHUFFLE, _FLETCHER32, _LZF = (
    h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32,
    h5py.h5z.FILTER_LZF,
)  # fmt: skip
_SIZED = (h5py.h5z.FILTER_NBIT, h5py.h5z.FILTER_SCALEOFFSET)
_FILTERS_OF_SETS = (_DEFLATE, _SHUFFLE, _FLETCHER32)

_TIMES_OF = {_DEFLATE: 1032, _LZF: 90}
"""Largest factor by which a packed chunk can unpack: deflate uses two bits for 258 bytes at best
(RFC 1951), LZF three bytes for 264."""

_USUAL_CHUNK = 1 << 26  # [bytes]
"""A chunk that cannot unpack to more than this is not checked further."""


def why_unsafe(
    dataset: h5py.h5d.DatasetID, most: int, filters: Collection[int] | None = None
) -> str:
    """Return why a dataset must not be read, as a predicate of its name; empty if it may be read.

    Parameters
    ----------
    dataset
    most
        Maximum unpacked size in bytes of the dataset and of each chunk.
    filters
        Codes of the filters that are allowed; by default any.
    """
    made = dataset.get_create_plist()
    layout = made.get_layout()
    if layout == h5py.h5d.VIRTUAL or made.get_external_count():
        return "is stored in another file, expected numbers stored in this one"
    if (size := bytes_of(dataset)) > most:
        return f"unpacks to {size} bytes, expected at most {most}"
    if layout != h5py.h5d.CHUNKED:
        return ""
    entries = prod(made.get_chunk())
    chunk = entries * dataset.get_type().get_size()
    if chunk > most:
        return f"has a chunk of {chunk} bytes, expected at most {most}"
    used = [made.get_filter(i) for i in range(made.get_nfilters())]
    codes = [code for code, *_ in used]
    if filters is not None and (others := sorted({*codes} - {*filters})):
        return f"is compressed by filter {others[0]} of HDF5, expected gzip"
    if len({*codes}) < len(codes):
        return "is compressed twice by the same filter"
    # These filters read the unpacked size from their own parameters, which may differ from the size
    # of the chunk.
    if any(code in _SIZED and values[2] != entries for code, _, values, _ in used):
        return "is compressed with a wrong chunk size, expected the size of its own chunks"
    if _unpacks_to_more(dataset, codes, max(chunk, _USUAL_CHUNK)):
        return f"has a chunk that unpacks to more than the declared {chunk} bytes"
    return ""


def _unpacks_to_more(dataset: h5py.h5d.DatasetID, codes: Sequence[int], most: int) -> bool:
    """True if a chunk unpacks to more than `most` bytes; HDF5 would unpack a chunk of any size."""
    times = prod(_TIMES_OF.get(code, 1) for code in codes)
    if dataset.get_storage_size() * times <= most:
        return False
    large: list[Any] = []
    dataset.chunk_iter(lambda x: large.append(x) if x.size * times > most else None)
    for stored in large:
        mask, raw = dataset.read_direct_chunk(stored.chunk_offset)
        # If bit i of the mask is set, filter i was not applied to this chunk.
        packers = [x for i, x in enumerate(codes) if x in _TIMES_OF and not mask >> i & 1]
        if packers == [_DEFLATE]:
            outer = [x for i, x in enumerate(codes) if not mask >> i & 1]
            if _SHUFFLE in outer[outer.index(_DEFLATE) :] or _inflates_to_more(raw, most):
                return True
        elif packers and len(raw) * times > max(most, _MOST_UNSEEN):
            return True
    return False


_MOST_UNSEEN = 500_000_000
"""Worst-case unpacked size of a chunk packed by another filter than deflate [bytes]."""


def _inflates_to_more(raw: bytes, most: int) -> bool:
    """True if a deflate stream unpacks to more than `most` bytes."""
    stream, left, step = zlib.decompressobj(), most, 1 << 20
    with suppress(zlib.error):
        while left >= 0 and not stream.eof:
            found = stream.decompress(raw, min(step, left + 1))
            raw, left = stream.unconsumed_tail, left - len(found)
            if not (found or raw):
                break
    return left < 0


def bytes_of(dataset: h5py.h5d.DatasetID) -> int:
    """Return the size of a dataset in memory [bytes]."""
    return prod(dataset.shape or ()) * int(dataset.get_type().get_size())


def _shown(name: bytes) -> str:
    return printable(name.decode("utf-8", "replace"))[:100]


def columns_of(group: Iterable[str]) -> list[str]:
    """Return the names of the columns of a group, in order of creation."""
    stems = (name.removesuffix(LOW).removesuffix(BOUND).removesuffix(UNDECIDED) for name in group)
    return [stem for stem in dict.fromkeys(stems) if stem not in _NO_COLUMNS]


def on_demand(
    group: Any, where: object, shapes: Mapping[str, tuple[int, ...]],
    may_be_nan: Collection[str] | None = None,
) -> Iterator[Mapping[str, Array]]:  # fmt: skip
    """Yield a mapping of columns, read when needed, for each part: values, low parts, bounds.

    Parameters
    ----------
    group
    where
        The file, for error messages: reading a damaged column raises `DatasetError`.
    shapes
        Shape of each part of a column, by the suffix of its dataset.
    may_be_nan
        Columns in which NaN stands for a missing number; by default all. Bounds are not checked.

    Raises
    ------
    KeyError
        A part of a column is missing.
    """
    stored = dict.fromkeys(group)
    names = columns_of(stored)
    for tag, shape in shapes.items():
        missing = [name + tag for name in names if name + tag not in stored]
        if missing:
            raise KeyError(f"no dataset {group.name}/{missing[0]}")
        may = None if tag == BOUND else may_be_nan
        yield _OnDemand(group, where, shape, {name: name + tag for name in names}, may)


class _OnDemand(Mapping[str, Array]):
    """A mapping from columns to their datasets in a group, each read on first use."""

    def __init__(
        self, group: Any, where: object, shape: tuple[int, ...], dataset: Mapping[str, str],
        may_be_nan: Collection[str] | None,
    ) -> None:  # fmt: skip
        self._group, self._where, self._shape = group, where, shape
        self._dataset, self._may_be_nan = dataset, may_be_nan
        self._read: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name not in self._read:
            dataset = self._dataset[name]
            try:
                found = read_array(self._group, dataset, self._shape)
                if self._may_be_nan is not None and name not in self._may_be_nan:
                    _refuse_infinite(found)
            except DAMAGE as e:
                raise DatasetError(f"{self._where}: {self._group.name}/{dataset}: {e}") from None
            self._read[name] = found
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._dataset)

    def __len__(self) -> int:
        return len(self._dataset)

    def __contains__(self, name: object) -> bool:
        return name in self._dataset

    def __reduce__(self) -> tuple[type, tuple[dict[str, Array]]]:
        # Send the contents to another process, because an open file cannot be sent.
        return dict, (dict(self),)


def _refuse_infinite(array: Array) -> None:
    if not np.isfinite(array).all():
        raise ValueError("found a number that is not finite")


def read_array(group: Any, name: str, shape: tuple[int, ...] | None = None) -> Array:
    """Read the binary64 numbers of a dataset as a read-only array.

    Scoring reads a hundred datasets, which would take twice as long with h5py's high-level
    interface.

    Raises
    ------
    ValueError
        The dataset has another type, or another shape than `shape`, which is any if it is None.
    """
    dataset = h5py.h5d.open(group.id, name.encode())
    if dataset.dtype != np.float64 or shape not in (None, dataset.shape):
        expected = "numbers" if shape is None else f"{shape}"
        raise ValueError(
            f"found {dataset.shape} of {dataset.dtype}, expected {expected} of float64"
        )
    array: Array = np.empty(dataset.shape, dataset.dtype)
    dataset.read(h5py.h5s.ALL, h5py.h5s.ALL, array)
    array.setflags(write=False)
    return array


def render(layout: Group, data: Mapping[str, Any]) -> bytes:
    """Return the bytes of an HDF5 file with `data`: arrays by dataset name, and groups by name."""
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        _write_group(f, layout, data, {})
    return buffer.getvalue()


# HDF5 places numbers in the file when their dataset is closed, and attributes when they are
# created, so the published bytes depend on the order of these operations. The dataset of a column
# is closed when the next dataset of its shape is created. An axis is closed together with the group
# whose scale it is.


def _write_group(
    group: h5py.Group, layout: Group, data: Mapping[str, Any], open_: dict[Any, h5py.Dataset]
) -> None:
    for name, value in layout.attributes.items():
        group.attrs[name] = value
    for item in layout.datasets:
        _write_dataset(group, item, data.get(item.name), open_)
    if any(item.is_scale for item in layout.datasets):
        open_.clear()
    for name, inner in layout.groups.items():
        _write_group(group.create_group(name, track_order=True), inner, data[name], open_)


def _write_dataset(
    group: h5py.Group, item: Dataset, values: Any, open_: dict[Any, h5py.Dataset]
) -> None:
    place = item.scales if item.is_column else item.name
    if item.kind == INDEX:
        open_[place] = group.create_dataset(item.name, data=np.arange(*item.shape, dtype=INDEX))
    else:
        open_[place] = group.create_dataset(item.name, data=values, **FILTERS)
    dataset = open_[place]
    if not item.is_column:
        dataset.attrs.update(item.attributes)
    for axis, scale in enumerate(item.scales):
        dataset.dims[axis].attach_scale(open_[scale])
    if item.is_column:
        dataset.attrs.update(item.attributes)
    if item.is_scale:
        dataset.make_scale(item.name)
