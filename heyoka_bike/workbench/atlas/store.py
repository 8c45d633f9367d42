"""An atlas on disk: a Zarr store, filled chunk by chunk, which xarray opens.

The store has format 2 of Zarr with consolidated metadata, which most readers know. Nothing in it
depends on when, where or in how many runs it was made. ``checksum`` contains a checksum of all
variables for each chunk of the grid, or 0 if the chunk is missing. The attributes contain those of
the grid and of the basin boundary, which is written last. Damaged parts count as missing.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle
from heyoka_bike.errors import DatasetError, InputError, required
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.atlas.data import FATES, UNDECIDED, VARIABLES, Atlas, Edge, GridAxis
from heyoka_bike.workbench.atlas.design import Chunk, Design

_CHECKSUM = "checksum"
_EDGE_ARRAYS = ("edge_at", "edge_stays", "edge_falls")
_KIND = "heyoka_bike atlas"
_AGAIN = "repeat the command that made the atlas"


class AtlasStore:
    """The Zarr store of an atlas, which is filled chunk by chunk.

    Parameters
    ----------
    folder
    design : Design
    force
        Replace another atlas in the folder.

    Raises
    ------
    InputError
        The folder contains something else, or cannot be written.
    MissingPackageError
        zarr is not installed.
    """

    def __init__(self, folder: Path, design: Design, *, force: bool = False) -> None:
        self.design = design
        provenance = design.provenance()
        if folder.exists() and any(folder.iterdir() if folder.is_dir() else (folder,)):
            self._open_or_refuse(folder, provenance, force)
        else:
            self._group = _make(folder, design, provenance)

    def missing(self) -> list[Chunk]:
        """Return the chunks that are missing or damaged."""
        slices, group = self.design.slices, self._group
        return [which for which in self.design.chunks() if not _chunk(group, which, slices(which))]

    def put(self, chunk: Chunk, values: Mapping[str, Array]) -> None:
        """Write a chunk, and its checksum last, so that an unfinished chunk is recognised."""
        part = self.design.slices(chunk)
        for name in VARIABLES:
            self._group[name][part] = values[name]
        self._group[_CHECKSUM][chunk] = _checksum({name: values[name] for name in VARIABLES})

    @property
    def has_edge(self) -> bool:
        """True if the store contains an undamaged basin boundary, which is written last."""
        return _checksum_matches(self._group, "edge")

    def row(self, i: int) -> Array:
        """Return the fates at point i of the first axis, along the second axis."""
        found: Array = self._group["fate"][i]
        return found

    def put_edge(self, edge: Edge) -> None:
        """Write the basin boundary, which completes the atlas."""
        for name, values in zip(_EDGE_ARRAYS, (edge.at, edge.stays, edge.falls), strict=True):
            array = self._group[name]
            array.resize(values.shape)
            if len(values):
                array[:] = values
        self._group.attrs["edge"] = "to neighbouring binary64 numbers"
        _store_checksum(self._group, "edge")
        _zarr().consolidate_metadata(self._group.store, zarr_format=2)

    def _open_or_refuse(self, folder: Path, provenance: Mapping[str, str], force: bool) -> None:
        try:
            group = _zarr().open_group(folder, mode="r+", zarr_format=2)
            found = dict(group.attrs)
        except (OSError, ValueError, KeyError, json.JSONDecodeError):
            found = {}
        if found.get("kind") != _KIND:
            raise InputError(
                "the folder contains something other than an atlas; use an empty or new folder",
                file=folder,
            )
        differing = [key for key, x in provenance.items() if found["provenance"].get(key) != x]
        if not differing and _checksum_matches(group, "grid"):
            self._group = group
            return
        if not force:
            what = f"differs in {', '.join(differing)}" if differing else "is damaged"
            raise InputError(
                f"the folder contains an atlas that {what}; use another folder, or --force to "
                "replace it",
                file=folder,
            )
        self._group = _make(folder, self.design, provenance)


def _make(folder: Path, design: Design, provenance: Mapping[str, str]) -> Any:
    """Create a Zarr store for an atlas, in which all chunks are missing."""
    zarr = _zarr()
    bicycle = {
        "name": design.bicycle.name,
        "parameters": {s: str(design.bicycle[s]) for s in PARAMETERS},
    }
    attributes = {
        "Conventions": "CF-1.11", "title": "Long-term behaviour of a bicycle", "kind": _KIND,
        "bicycle": bicycle, "start": dict(design.start), "provenance": dict(provenance),
        "axes": [a.name for a in design.axes], "side": design.side, "edge": "", "checksums": {},
    }  # fmt: skip
    try:
        group = zarr.open_group(folder, mode="w", zarr_format=2, attributes=attributes)
    except OSError as e:
        raise InputError(f"cannot be written: {e.strerror or e}", file=folder) from None
    names = [a.name for a in design.axes]
    for axis in design.axes:
        named = {"units": udunits(axis.unit), "long_name": axis.long_name}
        _array(group, axis.name, (axis.name,), axis.values.shape, "float64", named)[:] = axis.values
    for name, variable in VARIABLES.items():
        said: dict[str, Any] = {"units": variable.unit, "long_name": variable.long_name}
        if variable.flags:
            said["flag_values"] = list(range(len(variable.flags)))
            said["flag_meanings"] = " ".join(variable.flags)
        if name == "fate":
            said["comment"] = "; ".join(f"{fate}: {text}" for fate, text in FATES.items())
        chunks = (design.side, design.side)
        _array(group, name, names, design.shape, variable.dtype, said, chunks)
    first, second = design.axes
    for name, axis, text in zip(
        _EDGE_ARRAYS,
        (first, second, second),
        ("place of the basin boundary", "neighbour that does not fall", "neighbour that falls"),
        strict=True,
    ):
        said = {"units": udunits(axis.unit), "long_name": f"{text}: {axis.long_name}"}
        _array(group, name, ("edge",), (0,), "float64", said, (4096,))
    count = tuple(-(-n // design.side) for n in design.shape)
    said = {"long_name": "of the chunks of the grid, 0 of one that is missing"}
    _array(group, _CHECKSUM, ("chunk_0", "chunk_1"), count, "uint64", said, (1, 1))
    _store_checksum(group, "grid")
    zarr.consolidate_metadata(group.store, zarr_format=2)
    return group


def _array(
    group: Any, name: str, dimensions: Any, shape: tuple[int, ...], dtype: str,
    attributes: Mapping[str, Any], chunks: tuple[int, ...] | None = None,
) -> Any:  # fmt: skip
    return group.create_array(
        name, shape=shape, chunks=chunks or shape, dtype=dtype,
        # Arrays of integers have no fill value, because xarray would read it as missing, and turn
        # the integers into floats.
        fill_value=float("nan") if dtype == "float64" else None,
        attributes={"_ARRAY_DIMENSIONS": list(dimensions), **attributes},
    )  # fmt: skip


def load_atlas(folder: str | Path) -> Atlas:
    """Read an atlas.

    Parameters
    ----------
    folder
        Folder of the Zarr store.

    Returns
    -------
    Atlas
        Missing points of an unfinished atlas are undecided.

    Raises
    ------
    DatasetError
        The folder contains no atlas, or a damaged one.
    MissingPackageError
        zarr is not installed.
    """
    zarr = _zarr()
    try:
        group = zarr.open_group(Path(folder), mode="r", zarr_format=2)
        said = dict(group.attrs)
        if said.get("kind") != _KIND:
            raise ValueError("the store is not an atlas of heyoka_bike")
        if not _checksum_matches(group, "grid"):
            raise ValueError("the grid is damaged")
        if said["edge"] and not _checksum_matches(group, "edge"):
            raise ValueError(f"the basin boundary is damaged: {_AGAIN}")
        first, second = (GridAxis(name, group[name][:]) for name in said["axes"])
        return Atlas(
            bicycle=Bicycle.parse(said["bicycle"]["name"], said["bicycle"]["parameters"]),
            axes=(first, second),
            start={name: float(said["start"][name]) for name in START},
            variables=_undamaged(group, (len(first.values), len(second.values)), said["side"]),
            edge=Edge(*(group[name][:] for name in _EDGE_ARRAYS)) if said["edge"] else Edge(),
            provenance=said["provenance"],
        )
    except (OSError, ValueError, KeyError, TypeError) as e:
        what = " ".join(str(e).split()) or type(e).__name__
        raise DatasetError(f"{folder}: no atlas can be read: {what}") from None


def _undamaged(group: Any, shape: tuple[int, int], side: int) -> dict[str, Array]:
    """Return the arrays of all variables; points of missing chunks have missing values.

    Raises
    ------
    ValueError
        A chunk of a finished atlas is damaged.
    """
    found = {
        name: np.full(shape, UNDECIDED if v.dtype == "int8" else np.nan, dtype=v.dtype)
        for name, v in VARIABLES.items()
    }
    for i, j in np.ndindex(-(-shape[0] // side), -(-shape[1] // side)):
        part = (slice(i * side, (i + 1) * side), slice(j * side, (j + 1) * side))
        values = _chunk(group, (i, j), part)
        if values is None and group.attrs["edge"]:
            raise ValueError(f"chunk {i}.{j} is damaged: {_AGAIN}")
        for name, x in (values or {}).items():
            found[name][part] = x
    return found


def _chunk(group: Any, which: Chunk, part: tuple[slice, slice]) -> dict[str, Array] | None:
    """Return the variables of a chunk; None if it is missing or damaged."""
    values, kept = _read(group, VARIABLES, part), _read(group, [_CHECKSUM], which)
    return values if values and kept and kept[_CHECKSUM] == _checksum(values) else None


def _store_checksum(group: Any, what: str) -> None:
    """Store the checksum of the grid or of the basin boundary."""
    group.attrs["checksums"] = {**group.attrs["checksums"], what: _signature(group, what)}


def _checksum_matches(group: Any, what: str) -> bool:
    """True if the grid, or the basin boundary, still has the stored checksum."""
    return bool(group.attrs.get("checksums", {}).get(what, "") == _signature(group, what))


def _signature(group: Any, what: str) -> str | None:
    said = dict(group.attrs)
    names = _EDGE_ARRAYS if what == "edge" else said["axes"]
    keys = ("edge",) if what == "edge" else sorted(said.keys() - {"edge", "checksums"})
    values = _read(group, names)
    return f"{_checksum(values, json.dumps([said[key] for key in keys])):016x}" if values else None


def _read(group: Any, names: Iterable[str], part: Any = ...) -> dict[str, Array] | None:
    """Read arrays; return None if that fails (each codec raises exceptions of its own)."""
    try:
        return {name: group[name][part] for name in names}
    except Exception:
        return None


def _checksum(values: Mapping[str, Array], *texts: str) -> int:
    """Return a checksum of 64 bits over names, shapes, types and values."""
    found = hashlib.sha256(json.dumps(texts).encode())
    for name in sorted(values):
        x = np.ascontiguousarray(values[name])
        found.update(f"{name} {x.shape} {x.dtype.str} ".encode() + x.tobytes())
    # The hash is never 0, because 0 marks a missing chunk.
    return int.from_bytes(found.digest()[:8], "little") | 1


def udunits(unit: str) -> str:
    """Convert a unit of the inputs to UDUNITS spelling."""
    return {"m/s": "m s-1", "rad/s": "rad s-1", "kg m^2": "kg m2", "N/kg": "N kg-1"}.get(unit, unit)


def _zarr() -> Any:
    said = 'zarr is not installed; an atlas needs it (pip install "heyoka_bike[atlas]")'
    return required("zarr", said)
