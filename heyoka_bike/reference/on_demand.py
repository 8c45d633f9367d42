"""Columns of a group of an HDF5 file, of which those are read that are asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import h5py
import numpy as np

from heyoka_bike.numbers.double import Array


def on_demand(group: Any, known: Sequence[str]) -> Iterator[_OnDemand]:
    """hi, lo and bounds of the known columns, and of others that a newer set may have."""
    stored = set(group)
    others = sorted(n for n in stored - {"time", *known} if f"{n}_lo" in stored)
    return (_OnDemand(group, stored, [*known, *others], tag) for tag in ("", "_lo", "_bound"))


class _OnDemand(Mapping[str, Array]):
    """Datasets of a group by column, each read when first asked for."""

    def __init__(self, group: Any, stored: set[str], names: Sequence[str], tag: str) -> None:
        missing = [n + tag for n in names if n + tag not in stored]
        if missing:
            raise KeyError(f"no dataset {group.name}/{missing[0]}")
        self._group = group
        self._dataset = {n: n + tag for n in names}
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
