"""From tables to the bytes of the HDF5 files, which netCDF readers open too."""

import io
from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.reference import structure
from heyoka_bike.reference.layout import FILTERS, HDF5, MOTION, SENSITIVITIES, content_sha256
from heyoka_bike.reference.making.tabulate import Table
from heyoka_bike.reference.sensitivities import Sensitivity
from heyoka_bike.reference.structure import INDEX, Dataset, Group, by_maneuver
from heyoka_bike.reference.values import Dense, Values

Data = dict[str, Any]
"""Arrays by the names of their datasets, in groups by name."""


def render_hdf5(
    tables: Sequence[Table], inputs: Mapping[str, Any], version: str
) -> tuple[dict[str, bytes], str]:
    """The HDF5 files by name, and the hash of the numbers of the reference.

    Parameters
    ----------
    tables
    inputs
        As in the manifest.
    version
        The one that last changed these files.
    """
    core = [_table(t, t.rows, t.dense) for t in tables]
    motion = [_table(t, t.motion_rows, t.motion_dense) for t in tables]
    varied = [_sensitivity(t.sensitivity) for t in tables]
    content, of_motion, of_varied = (
        content_sha256(by_maneuver(data)) for data in (core, motion, varied)
    )
    derivatives = [
        structure.sensitivity(m, len(t.breaks) - 1, t.orders, len(t.time))
        for m, t in zip(inputs["maneuvers"], (t.sensitivity for t in tables), strict=True)
    ]
    about = structure.about_reference(inputs, version, content)
    return {
        HDF5: _file(about, _groups(inputs, COLUMNS, core), core),
        SENSITIVITIES: _file(
            structure.about_sensitivities(inputs, version, of_varied), derivatives, varied
        ),
        MOTION: _file(
            structure.about_motion(inputs, version, of_motion),
            _groups(inputs, MOTION_COLUMNS, motion),
            motion,
        ),
    }, content


def _groups(
    inputs: Mapping[str, Any], columns: Sequence[Column], tables: Sequence[Data]
) -> list[Group]:
    return [
        structure.table(m, columns, len(x["time"]), len(x["dense"]["breaks"]) - 1)
        for m, x in zip(inputs["maneuvers"], tables, strict=True)
    ]


def _table(table: Table, rows: Values, dense: Dense) -> Data:
    return {
        "time": table.time,
        "time_lo": table.time_lo,
        **_with_tags(rows),
        "dense": {"breaks": dense.breaks, **_with_tags(dense)},
    }


def _sensitivity(x: Sensitivity) -> Data:
    return {
        "breaks": x.breaks,
        **_with_tags(Values(x.coefficients, {}, x.bound)),
        "rows": {"time": x.time, **_with_tags(Values(x.values, {}, x.values_bound))},
    }


def _with_tags(values: Values) -> Data:
    parts = (("", values.hi), ("_lo", values.lo), ("_bound", values.bound))
    return {name + tag: x for tag, part in parts for name, x in part.items()}


def _file(about: Mapping[str, str], groups: Sequence[Group], data: Sequence[Data]) -> bytes:
    buffer = io.BytesIO()
    layout = Group(about, (), by_maneuver(groups))
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        _write_group(f, layout, by_maneuver(data), {})
    return buffer.getvalue()


# HDF5 gives numbers their place in the file when their dataset is closed, and attributes when they
# are made. The published bytes come of this: a dataset of columns is closed when there is the next
# of its shape, an axis with the group that it is the scale of.


def _write_group(
    group: h5py.Group, layout: Group, data: Mapping[str, Any], opened: dict[Any, h5py.Dataset]
) -> None:
    for name, value in layout.attributes.items():
        group.attrs[name] = value
    for item in layout.datasets:
        _write_dataset(group, item, data.get(item.name), opened)
    if any(item.is_scale for item in layout.datasets):
        opened.clear()
    for name, inner in layout.groups.items():
        _write_group(group.create_group(name, track_order=True), inner, data[name], opened)


def _write_dataset(
    group: h5py.Group, item: Dataset, values: Any, opened: dict[Any, h5py.Dataset]
) -> None:
    place = item.scales if item.is_column else item.name
    if item.kind == INDEX:
        opened[place] = group.create_dataset(item.name, data=np.arange(*item.shape, dtype=INDEX))
    else:
        opened[place] = group.create_dataset(item.name, data=values, **FILTERS)
    dataset = opened[place]
    if not item.is_column:
        dataset.attrs.update(item.attributes)
    for axis, scale in enumerate(item.scales):
        dataset.dims[axis].attach_scale(opened[scale])
    if item.is_column:
        dataset.attrs.update(item.attributes)
    if item.is_scale:
        dataset.make_scale(item.name)
