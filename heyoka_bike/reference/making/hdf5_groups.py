"""Rows and dense output of a maneuver as HDF5 groups that netCDF readers open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.reference.layout import FILTERS
from heyoka_bike.reference.values import Dense, Values


def write_rows(
    group: h5py.Group, times: tuple[Any, Any], rows: Values, columns: Sequence[Column]
) -> None:
    """Write times (hi, lo) and the rows of some columns."""
    time = group.create_dataset("time", data=times[0], **FILTERS)
    _describe(time, "s", "time", "standard time of the rows, a multiple of the spacing")
    time.attrs["axis"] = "T"
    time.make_scale("time")
    lo = group.create_dataset("time_lo", data=times[1], **FILTERS)
    _describe(lo, "s", "time, low part", "exact time minus time")
    lo.dims[0].attach_scale(time)
    for column in columns:
        for suffix, values in (
            ("", rows.hi),
            ("_lo", rows.lo),
            ("_bound", rows.bound),
        ):
            dataset = group.create_dataset(
                column.name + suffix, data=values[column.name], **FILTERS
            )
            dataset.dims[0].attach_scale(time)
            if suffix == "_lo":
                meaning = f"exact value minus {column.name}, rounded"
                _describe(dataset, column.unit, f"{column.long_name}, low part", meaning)
            elif suffix == "_bound":
                meaning = f"certified: abs(exact value - {column.name} - {column.name}_lo) <= this"
                _describe(dataset, column.unit, f"{column.long_name}, certified bound", meaning)
            else:
                _describe(dataset, column.unit, column.long_name, column.meaning)
                if column in COLUMNS:
                    dataset.attrs["definition_name"] = column.definition
                if column.positive:
                    dataset.attrs["positive"] = column.positive


def write_dense(group: h5py.Group, dense: Dense, columns: Sequence[Column]) -> None:
    """Write the dense output of some columns."""
    group.attrs["comment"] = (
        "Piecewise Chebyshev: on the piece [a, b] of breaks the column is sum_k c_k T_k(x), "
        "c_0 not halved, x = 2 (t - a) / (b - a) - 1, c = <name> + <name>_lo; "
        "a break belongs to the piece on its right, the end to the last."
    )
    pieces, nodes = dense.hi[columns[0].name].shape
    breaks = group.create_dataset("breaks", data=dense.breaks, **FILTERS)
    _describe(breaks, "s", "ends of the pieces", "exact")
    breaks.make_scale("breaks")
    piece = group.create_dataset("piece", data=np.arange(pieces, dtype="<i4"))
    piece.make_scale("piece")
    order = group.create_dataset("order", data=np.arange(nodes, dtype="<i4"))
    order.make_scale("order")
    for column in columns:
        for suffix, values in (("", dense.hi), ("_lo", dense.lo)):
            dataset = group.create_dataset(
                column.name + suffix, data=values[column.name], **FILTERS
            )
            dataset.dims[0].attach_scale(piece)
            dataset.dims[1].attach_scale(order)
            what = "Chebyshev coefficients" + (", low part" if suffix else "")
            _describe(dataset, column.unit, f"{column.long_name}, {what}", column.meaning)
        bound = group.create_dataset(
            column.name + "_bound", data=dense.bound[column.name], **FILTERS
        )
        bound.dims[0].attach_scale(piece)
        meaning = "certified: largest distance of the piece from the exact column"
        _describe(bound, column.unit, f"{column.long_name}, certified bound", meaning)


def _describe(dataset: h5py.Dataset, unit: str, long_name: str, definition: str) -> None:
    dataset.attrs["units"] = unit
    dataset.attrs["long_name"] = long_name
    dataset.attrs["definition"] = definition


def content_parts(times: tuple[Any, Any], rows: Values, dense: Dense) -> dict[str, Any]:
    """The published numbers of a maneuver by dataset, for `proof.content_sha256`."""
    arrays = {"time": times[0], "time_lo": times[1], **_with_lo(rows.hi, rows.lo)}
    arrays["dense/breaks"] = dense.breaks
    return arrays | {f"dense/{n}": x for n, x in _with_lo(dense.hi, dense.lo).items()}


def _with_lo(hi: Mapping[str, Any], lo: Mapping[str, Any]) -> dict[str, Any]:
    return dict(hi) | {f"{name}_lo": x for name, x in lo.items()}
