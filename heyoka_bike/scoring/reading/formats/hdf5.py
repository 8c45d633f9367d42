"""HDF5, and netCDF 4 with it."""

from typing import Any

from heyoka_bike.scoring.reading.arrays.packed import unpacked
from heyoka_bike.scoring.reading.arrays.tables import DEEPEST, tables
from heyoka_bike.scoring.reading.formats.own_arrays import OwnFile
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors


def read(file: ResultFile) -> list[Vectors]:
    """The tables in groups and arrays.

    Raises
    ------
    InputError
        Damaged, kept in other files, or not columns of real numbers.
    """
    with OwnFile.opened(file) as own:
        with file.request.damage("HDF5"):
            members = _datasets(own.file, own)
        return tables(members, file.request, is_ordered=False)


def _datasets(group: Any, own: OwnFile, depth: int = 0) -> dict[str, Any]:
    """The arrays of a group and of those in it."""
    import h5py

    found: dict[str, Any] = {}
    for name, x in own.members(group):
        if isinstance(x, h5py.Group) and x.keys() == {"type", "value"}:
            # As Octave writes a variable.
            x = dict(own.members(x)).get("value")
        if isinstance(x, h5py.Dataset) and x.shape is not None and not _is_a_length(x):
            found[name] = unpacked(own.array(x), x.attrs)
        elif isinstance(x, h5py.Group) and depth < DEEPEST:
            found[name] = _datasets(x, own, depth + 1)
    return found


def _is_a_length(dataset: Any) -> bool:
    """Whether a dataset stands for an axis of which no values were given, as netCDF puts it."""
    what = dataset.attrs.get("NAME", b"")
    return isinstance(what, bytes) and what.startswith(b"This is a netCDF dimension but not")
