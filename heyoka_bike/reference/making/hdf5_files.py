"""From tables to the bytes of the HDF5 files, which netCDF readers open too."""

from collections.abc import Mapping, Sequence
from typing import Any

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.reference import structure
from heyoka_bike.reference.hdf5 import BOUND, LOW, Group, by_maneuver, render, whole_file
from heyoka_bike.reference.layout import HDF5, MOTION, SENSITIVITIES, content_sha256
from heyoka_bike.reference.making.tabulate import Table
from heyoka_bike.reference.sensitivities import Sensitivity
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
        structure.sensitivity(m, COLUMNS, len(t.breaks) - 1, t.orders, len(t.time))
        for m, t in zip(inputs["maneuvers"], (t.sensitivity for t in tables), strict=True)
    ]
    return {
        name: render(whole_file(about, groups), by_maneuver(data))
        for name, about, groups, data in (
            (
                HDF5,
                structure.about_reference(inputs, version, content),
                _groups(inputs, COLUMNS, core),
                core,
            ),
            (
                SENSITIVITIES,
                structure.about_sensitivities(inputs, version, of_varied),
                derivatives,
                varied,
            ),
            (
                MOTION,
                structure.about_motion(inputs, version, of_motion),
                _groups(inputs, MOTION_COLUMNS, motion),
                motion,
            ),
        )
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
    parts = (("", values.hi), (LOW, values.lo), (BOUND, values.bound))
    return {name + tag: x for tag, part in parts for name, x in part.items()}
