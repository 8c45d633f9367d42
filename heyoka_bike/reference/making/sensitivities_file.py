"""sensitivities.h5: its bytes."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import h5py

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.reference.layout import FILTERS, content_sha256
from heyoka_bike.reference.sensitivities import UNKNOWNS, Sensitivity


def render(sensitivities: Sequence[Sensitivity], inputs: Mapping[str, Any]) -> bytes:
    """Bytes of sensitivities.h5; `inputs` as in the manifest."""
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        f.attrs["title"] = "Sensitivities of the reference solution: d column / d unknown"
        f.attrs["comment"] = (
            "On the piece [a, b] of breaks the derivative of a column with respect to unknown u is "
            "sum_k c[piece, k, u] T_k(x), c_0 not halved, x = 2 (t - a) / (b - a) - 1; a break "
            "belongs to the piece on its right. The pitch at the start follows from roll and "
            "steer. Computed in binary128 by first variations; not certified, see the docs for "
            "how many digits agree with differences of runs at 70 digits."
        )
        f.attrs["content_sha256"] = content_sha256(
            {
                f"maneuver_{i}": {"breaks": s.breaks, **s.coefficients}
                for i, s in enumerate(sensitivities, start=1)
            }
        )
        f.attrs["bicycle"] = inputs["bicycle"]["name"]
        f.attrs["parameters"] = json.dumps(inputs["bicycle"]["parameters"])
        f.attrs["unknowns"] = json.dumps(list(UNKNOWNS))
        f.attrs["unknown_units"] = json.dumps(list(UNKNOWNS.values()))
        for i, s in enumerate(sensitivities, start=1):
            group = f.create_group(f"maneuver_{i}", track_order=True)
            for key, text in inputs["maneuvers"][i - 1].items():
                group.attrs[key] = text
            breaks = group.create_dataset("breaks", data=s.breaks, **FILTERS)
            breaks.attrs["units"] = "s"
            for column in COLUMNS:
                data = s.coefficients[column.name]
                dataset = group.create_dataset(column.name, data=data, **FILTERS)
                dataset.attrs["units"] = f"{column.unit} per unit of the unknown"
                dataset.attrs["long_name"] = f"{column.long_name}, derivatives"
                dataset.attrs["definition"] = column.meaning
    return buffer.getvalue()
