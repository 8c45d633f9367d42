"""Groups of HDF5 files: declared, and by that written and read.

All files of a set have attributes of the whole file and a group for each maneuver, ``maneuver_1``
and so on. A column is one dataset or more: its values, ``<name>_lo`` and ``<name>_bound``.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import h5py
import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.layout import FILTERS

T = TypeVar("T")

INDEX = "<i4"
"""Kind of a dataset that counts along an axis: 0, 1, 2, ..."""

SCALE_ATTRIBUTES = frozenset(("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"))
"""Set by HDF5's dimension scales."""

LOW, BOUND = "_lo", "_bound"
"""Suffixes of the datasets of a column's low part and of its bounds."""

UNDECIDED = "_undecided"
"""Suffix of the numbers of the rows of a column whose rounding is not decided, if there are any."""

ROW_NUMBER = "<i8"
"""Kind of a dataset of such numbers."""

_NO_COLUMNS = frozenset(("time", "breaks", "piece", "order", "dense", "rows"))


@dataclass(frozen=True, slots=True)
class Dataset:
    """A dataset of a group.

    Attributes
    ----------
    name : str
    shape : tuple of int
    attributes : mapping of str to str
    scales : tuple of str
        The datasets of its group that are the dimension scales of its first axes.
    is_scale : bool
        True if it is one itself.
    is_column : bool
        True if it is one of several that differ in their numbers only.
    kind : str
        Its dtype.
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
    """A group, or a whole file; attributes and members are in the order of their creation.

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
        """Names of its datasets and groups."""
        return (*(dataset.name for dataset in self.datasets), *self.groups)


def by_maneuver(items: Iterable[T]) -> dict[str, T]:
    """Return items of the maneuvers by the names of their groups."""
    return {f"maneuver_{i}": item for i, item in enumerate(items, start=1)}


def of_maneuvers(f: Mapping[str, T], count: int) -> list[T]:
    """The groups of so many maneuvers."""
    return [f[name] for name in by_maneuver(range(count))]


def opened(raw: bytes) -> h5py.File:
    """A file in memory, which stays open for what of it is read when it is asked for."""
    # As an image: a Python object would be asked for at its closing, when Python has ended.
    return h5py.File(h5py.h5f.open_file_image(raw))


def columns_of(group: Iterable[str]) -> list[str]:
    """Names of the columns that a group has, in the order of their creation."""
    stems = (name.removesuffix(LOW).removesuffix(BOUND).removesuffix(UNDECIDED) for name in group)
    return [stem for stem in dict.fromkeys(stems) if stem not in _NO_COLUMNS]


def on_demand(group: Any, tags: Sequence[str] = ("", LOW, BOUND)) -> Iterator[Mapping[str, Array]]:
    """The columns that a group has: their values, low parts and bounds, read when asked for.

    Raises
    ------
    KeyError
        A part of a column is not there.
    """
    stored = dict.fromkeys(group)
    names = columns_of(stored)
    for tag in tags:
        missing = [name + tag for name in names if name + tag not in stored]
        if missing:
            raise KeyError(f"no dataset {group.name}/{missing[0]}")
        yield _OnDemand(group, {name: name + tag for name in names})


class _OnDemand(Mapping[str, Array]):
    """Datasets of a group by column, each read when first asked for."""

    def __init__(self, group: Any, dataset: Mapping[str, str]) -> None:
        self._group = group
        self._dataset = dataset
        self._read: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name not in self._read:
            self._read[name] = read_array(self._group, self._dataset[name])
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._dataset)

    def __len__(self) -> int:
        return len(self._dataset)

    def __contains__(self, name: object) -> bool:
        return name in self._dataset

    def __reduce__(self) -> tuple[type, tuple[dict[str, Array]]]:
        # An open file cannot be sent to another process; what is in it can.
        return dict, (dict(self),)


def read_array(group: Any, name: str) -> Array:
    """Numbers of a dataset, not to be changed.

    Scoring reads a hundred of them, which takes twice the time by h5py's interface of objects.
    """
    dataset = h5py.h5d.open(group.id, name.encode())
    array: Array = np.empty(dataset.shape, dataset.dtype)
    dataset.read(h5py.h5s.ALL, h5py.h5s.ALL, array)
    array.setflags(write=False)
    return array


def render(layout: Group, data: Mapping[str, Any]) -> bytes:
    """Bytes of a file: arrays by the names of its datasets, in mappings by those of its groups."""
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        _write_group(f, layout, data, {})
    return buffer.getvalue()


# HDF5 gives numbers their place in the file when their dataset is closed, and attributes when they
# are made. The published bytes come of this: a dataset of columns is closed when there is the next
# of its shape, an axis with the group that it is the scale of.


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
