"""An atlas on the disk: a Zarr store, filled chunk by chunk, which xarray opens.

Format 2 of Zarr with consolidated metadata, which most readers know. Nothing in it depends on when,
where or in how many runs it was made. ``complete`` has a 1 for each chunk that is there; the edge
comes last.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle
from heyoka_bike.errors import DatasetError, InputError, required
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.atlas.data import FATES, VARIABLES, Atlas, Edge, GridAxis
from heyoka_bike.workbench.atlas.design import Chunk, Design

_COMPLETE = "complete"
_EDGE = ("edge_at", "edge_stays", "edge_falls")
_KIND = "heyoka_bike atlas"


class AtlasStore:
    """A store that is being filled.

    Parameters
    ----------
    folder
    design : Design
    force
        Replace what is in the folder, if that is another atlas.

    Raises
    ------
    InputError
        The folder holds something else, or cannot be written.
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
        self._complete = self._group[_COMPLETE][:]

    def missing(self) -> list[Chunk]:
        """Chunks that are not there yet."""
        return [chunk for chunk in self.design.chunks() if not self._complete[chunk]]

    def put(self, chunk: Chunk, values: Mapping[str, Array]) -> None:
        """Keep a chunk; its mark is written when all else is on the disk."""
        part = self.design.slices(chunk)
        for name in VARIABLES:
            self._group[name][part] = values[name]
        self._complete[chunk] = 1
        self._group[_COMPLETE][chunk] = 1

    @property
    def has_edge(self) -> bool:
        """Whether the edge, which comes last, is there."""
        return bool(self._group.attrs["edge"])

    def row(self, i: int) -> Array:
        """The fates along the second axis."""
        found: Array = self._group["fate"][i]
        return found

    def put_edge(self, edge: Edge) -> None:
        """Keep the edge; then the atlas is whole."""
        for name, values in zip(_EDGE, (edge.at, edge.stays, edge.falls), strict=True):
            array = self._group[name]
            array.resize(values.shape)
            if len(values):
                array[:] = values
        self._group.attrs["edge"] = "to neighbouring binary64 numbers"
        _zarr().consolidate_metadata(self._group.store, zarr_format=2)

    def _open_or_refuse(self, folder: Path, provenance: Mapping[str, str], force: bool) -> None:
        try:
            group = _zarr().open_group(folder, mode="r+", zarr_format=2)
            found = dict(group.attrs)
        except (OSError, ValueError, KeyError, json.JSONDecodeError):
            found = {}
        if found.get("kind") != _KIND:
            raise InputError(
                "found a folder that is no atlas, expected one, or a new or empty folder",
                file=folder,
            )
        differing = [key for key, x in provenance.items() if found["provenance"].get(key) != x]
        if not differing:
            self._group = group
            return
        if not force:
            raise InputError(
                f"found an atlas that differs in {', '.join(differing)}, expected this one: "
                "another folder, or --force to replace it",
                file=folder,
            )
        self._group = _make(folder, self.design, provenance)


def _make(folder: Path, design: Design, provenance: Mapping[str, str]) -> Any:
    """An empty store."""
    zarr = _zarr()
    bicycle = {
        "name": design.bicycle.name,
        "parameters": {s: str(design.bicycle[s]) for s in PARAMETERS},
    }
    attributes = {
        "Conventions": "CF-1.11", "title": "What becomes of a bicycle", "kind": _KIND,
        "bicycle": bicycle, "start": dict(design.start), "provenance": dict(provenance),
        "axes": [a.name for a in design.axes], "edge": "",
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
        _EDGE,
        (first, second, second),
        ("where the edge of falling is", "neighbour that does not fall", "neighbour that falls"),
        strict=True,
    ):
        said = {"units": udunits(axis.unit), "long_name": f"{text}: {axis.long_name}"}
        _array(group, name, ("edge",), (0,), "float64", said, (4096,))
    marks = tuple(-(-n // design.side) for n in design.shape)
    said = {"long_name": "chunks of the grid that are there"}
    _array(group, _COMPLETE, ("chunk_0", "chunk_1"), marks, "int8", said, (1, 1))
    zarr.consolidate_metadata(group.store, zarr_format=2)
    return group


def _array(
    group: Any, name: str, dimensions: Any, shape: tuple[int, ...], dtype: str,
    attributes: Mapping[str, Any], chunks: tuple[int, ...] | None = None,
) -> Any:  # fmt: skip
    return group.create_array(
        name, shape=shape, chunks=chunks or shape, dtype=dtype,
        # A filling of integers would be read as missing, and as floating-point numbers.
        fill_value=None if dtype == "int8" else float("nan"),
        attributes={"_ARRAY_DIMENSIONS": list(dimensions), **attributes},
    )  # fmt: skip


def load_atlas(folder: str | Path) -> Atlas:
    """Read an atlas.

    Parameters
    ----------
    folder
        Of the Zarr store.

    Returns
    -------
    Atlas
        Of one that is not whole yet the points that are missing are undecided.

    Raises
    ------
    DatasetError
        No atlas is there, or one that is damaged.
    MissingPackageError
        zarr is not installed.
    """
    zarr = _zarr()
    try:
        group = zarr.open_group(Path(folder), mode="r", zarr_format=2)
        said = dict(group.attrs)
        if said.get("kind") != _KIND:
            raise ValueError("it is something else")
        first, second = (GridAxis(name, group[name][:]) for name in said["axes"])
        return Atlas(
            bicycle=Bicycle.parse(said["bicycle"]["name"], said["bicycle"]["parameters"]),
            axes=(first, second),
            start={name: float(said["start"][name]) for name in START},
            variables={name: group[name][:] for name in VARIABLES},
            edge=Edge(*(group[name][:] for name in _EDGE)),
            provenance=said["provenance"],
        )
    except (OSError, ValueError, KeyError, TypeError) as e:
        what = " ".join(str(e).split()) or type(e).__name__
        raise DatasetError(f"{folder}: no atlas can be read: {what}") from None


def udunits(unit: str) -> str:
    """A unit of the inputs as UDUNITS has it."""
    return {"m/s": "m s-1", "rad/s": "rad s-1", "kg m^2": "kg m2", "N/kg": "N kg-1"}.get(unit, unit)


def _zarr() -> Any:
    said = 'zarr is not installed; an atlas needs it (pip install "heyoka_bike[atlas]")'
    return required("zarr", said)
