"""NetCDF-4 with CF attributes: the rows, each column over maneuver and time."""

import io
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike

from heyoka_bike.bicycle.column import Column
from heyoka_bike.reference.exports.selection import LICENCE, TITLE, Selection, about, sharing_times
from heyoka_bike.version import __version__

SUFFIXES = (".nc",)

_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}


def render(selection: Selection, stem: str) -> dict[str, bytes]:
    """A file of all maneuvers, or one for each if their times differ."""
    return {f"{tag}.nc": _file(part) for tag, part in sharing_times(selection).items()}


def _file(selection: Selection) -> bytes:
    buffer = io.BytesIO()
    # The netCDF library keeps variables and attributes in the order of their creation.
    with h5py.File(buffer, "w", libver=("v110", "v110"), track_order=True) as f:
        _describe_file(f, selection)
        first = selection.reference[selection.numbers[0]]
        numbers = np.array(selection.numbers, dtype="<i4")
        maneuver = _dataset(f, "maneuver", numbers, long_name="number of the maneuver")
        maneuver.make_scale("maneuver")
        time = _dataset(f, "time", first.time, units="s", long_name="time", axis="T")
        time.make_scale("time")
        lo = _dataset(f, "time_lo", first.time_lo, units="s", long_name="exact time minus time")
        lo.dims[0].attach_scale(time)
        for column in selection.columns:
            _write_column(f, selection, column, (maneuver, time))
    return buffer.getvalue()


def _describe_file(f: h5py.File, selection: Selection) -> None:
    use = (
        "The value is <name> + <name>_lo at the time time + time_lo; <name> alone is the double "
        "nearest to the exact value."
    )
    f.attrs["_NCProperties"] = f"version=2,h5py={h5py.__version__}"
    f.attrs["Conventions"] = "CF-1.8"
    f.attrs["title"] = TITLE
    f.attrs["source"] = f"heyoka_bike {__version__}"
    f.attrs["license"] = LICENCE
    f.attrs["dataset_version"] = selection.reference.dataset_version
    f.attrs["content_sha256"] = selection.reference.content_sha256
    f.attrs["comment"] = "\n".join(about(selection, "the rows", use))


def _write_column(
    f: h5py.File, selection: Selection, column: Column, scales: tuple[h5py.Dataset, h5py.Dataset]
) -> None:
    rows = [m.rows for _, m in selection.maneuvers]
    name, about_lo = column.name, f"{column.long_name}, exact value minus {column.name}"
    hi = np.stack([values.hi[name] for values in rows])
    lo = np.stack([values.lo[name] for values in rows])
    whole = _dataset(f, name, hi, units=column.unit, long_name=column.long_name)
    whole.attrs["definition"] = column.meaning
    whole.attrs["definition_name"] = column.definition
    if column.positive:
        whole.attrs["positive"] = column.positive
    rest = _dataset(f, f"{name}_lo", lo, units=column.unit, long_name=about_lo)
    for dataset in (whole, rest):
        for axis, scale in zip(dataset.dims, scales, strict=True):
            axis.attach_scale(scale)


def _dataset(f: h5py.File, name: str, data: ArrayLike, **attributes: str) -> h5py.Dataset:
    dataset = f.create_dataset(name, data=data, track_order=True, **_FILTERS)
    for key, text in attributes.items():
        dataset.attrs[key] = text
    return dataset
