"""NetCDF-4 with CF and ACDD attributes: the rows, each column over maneuver and row.

The time is no dimension: CF has a time coordinate count from a date, and ours counts from the
start of each maneuver. It is an auxiliary coordinate of the rows.
"""

import io
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike

from heyoka_bike.bicycle.columns import Column
from heyoka_bike.reference.description.facts import CONVENTIONS, TITLE, shared_attributes
from heyoka_bike.reference.exports.selection import Selection, about, sharing_times
from heyoka_bike.version import __version__

SUFFIXES = (".nc",)

_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}

# What ACDD-1.3 calls the kinds of variables.
_COORDINATE, _VALUE, _REST = "coordinate", "modelResult", "auxiliaryInformation"


def render(selection: Selection, stem: str) -> dict[str, bytes]:
    """A file of all maneuvers, or one for each if their times differ."""
    return {f"{tag}.nc": _file(part) for tag, part in sharing_times(selection).items()}


def _file(selection: Selection) -> bytes:
    buffer = io.BytesIO()
    # The netCDF library keeps variables and attributes in the order of their creation.
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        f.attrs.update(_about_file(selection))
        first = selection.reference[selection.numbers[0]]
        numbers = np.array(selection.numbers, dtype="<i4")
        maneuver = _dataset(f, "maneuver", numbers, "1", "number of the maneuver", _COORDINATE)
        maneuver.make_scale("maneuver")
        row = f.create_dataset("row", shape=first.time.shape, dtype=">f4", track_order=True)
        row.make_scale(f"This is a netCDF dimension but not a netCDF variable.{len(row):10d}")
        about_time = "time since the start of the maneuver"
        for name, data, said, kind in (
            ("time", first.time, about_time, _COORDINATE),
            ("time_lo", first.time_lo, f"{about_time}, exact value minus time", _REST),
        ):
            _dataset(f, name, data, "s", said, kind).dims[0].attach_scale(row)
        for column in selection.columns:
            _write_column(f, selection, column, (maneuver, row))
    return buffer.getvalue()


def _about_file(selection: Selection) -> dict[str, str]:
    reference = selection.reference
    use = (
        "The value is <name> + <name>_lo at the time time + time_lo; <name> alone is the double "
        "nearest to the exact value."
    )
    shared = shared_attributes(reference.dataset_version)
    history = f"{shared['history']}; by heyoka-bike export {__version__}"
    return {
        "_NCProperties": f"version=2,h5py={h5py.__version__}",
        "title": TITLE,
        "summary": "Rows of " + ", ".join(c.long_name for c in selection.columns),
        **shared,
        "Conventions": CONVENTIONS,
        "history": history,
        "dataset_version": reference.dataset_version,
        "content_sha256": reference.content_sha256,
        "comment": "\n".join(about(selection, "the rows", use)),
    }


def _write_column(
    f: h5py.File, selection: Selection, column: Column, scales: tuple[h5py.Dataset, h5py.Dataset]
) -> None:
    rows = [m.rows for _, m in selection.maneuvers]
    name, about_lo = column.name, f"{column.long_name}, exact value minus {column.name}"
    hi = np.stack([values.hi[name] for values in rows])
    lo = np.stack([values.lo[name] for values in rows])
    whole = _dataset(f, name, hi, column.unit, column.long_name, _VALUE)
    whole.attrs["definition"] = column.meaning
    whole.attrs["definition_name"] = column.definition
    if column.positive:
        whole.attrs["positive"] = column.positive
    rest = _dataset(f, f"{name}_lo", lo, column.unit, about_lo, _REST)
    for dataset in (whole, rest):
        dataset.attrs["coordinates"] = "time"
        for axis, scale in zip(dataset.dims, scales, strict=True):
            axis.attach_scale(scale)


def _dataset(
    f: h5py.File, name: str, data: ArrayLike, unit: str, long_name: str, kind: str
) -> h5py.Dataset:
    dataset = f.create_dataset(name, data=data, track_order=True, **_FILTERS)
    about = {"units": unit, "long_name": long_name, "coverage_content_type": kind}
    dataset.attrs.update(about)
    return dataset
