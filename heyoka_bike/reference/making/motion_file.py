"""motion.h5: its bytes."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import h5py

from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.reference.layout import content_sha256
from heyoka_bike.reference.making.hdf5_groups import content_parts, write_dense, write_rows
from heyoka_bike.reference.making.tabulate import Table

TITLE = "The whole motion of the reference solution: configuration and forces"

COMMENT = (
    "Each value is the correctly rounded exact one, or zero where an enclosure as narrow as its "
    "bound holds zero; <name>_lo is the exact value minus it, so <name> + <name>_lo has 32 digits. "
    "Ground frame: x along the initial heading, y right, z down, origin where the rear wheel "
    "touches the floor at t = 0. Wheel angles are zero at t = 0."
)


def render(tables: Sequence[Table], inputs: Mapping[str, Any]) -> bytes:
    """Bytes of motion.h5; `inputs` as in the manifest."""
    dense = [c for c in MOTION_COLUMNS if c.is_dense]
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        f.attrs["title"] = TITLE
        f.attrs["Conventions"] = "CF-1.8"
        f.attrs["content_sha256"] = content_sha256(
            {
                f"maneuver_{i}": content_parts((t.time, t.time_lo), t.motion_rows, t.motion_dense)
                for i, t in enumerate(tables, start=1)
            }
        )
        f.attrs["bicycle"] = inputs["bicycle"]["name"]
        f.attrs["parameters"] = json.dumps(inputs["bicycle"]["parameters"])
        f.attrs["comment"] = COMMENT
        for i, table in enumerate(tables, start=1):
            group = f.create_group(f"maneuver_{i}", track_order=True)
            for key, text in inputs["maneuvers"][i - 1].items():
                group.attrs[key] = text
            write_rows(group, (table.time, table.time_lo), table.motion_rows, MOTION_COLUMNS)
            write_dense(group.create_group("dense", track_order=True), table.motion_dense, dense)
    return buffer.getvalue()
