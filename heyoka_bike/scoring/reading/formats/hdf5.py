"""HDF5, and netCDF 4 with it."""

from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.arrays.packed import unpacked
from heyoka_bike.scoring.reading.arrays.tables import DEEPEST, tables
from heyoka_bike.scoring.reading.formats.matlab_bytes import OfClass
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
        return tables(variables(own), file.request, is_ordered=False)


def variables(own: OwnFile) -> dict[str, Any]:
    """The arrays and groups of a file, and what the arrays of MATLAB and Octave stand for.

    MATLAB's are as `matlab_bytes.matlab_variables` has those of its older files.

    Raises
    ------
    InputError
        Damaged, kept in other files, or too many.
    """
    with own.request.damage("HDF5"):
        return _variables(own.file, own)


def _variables(group: Any, own: OwnFile, depth: int = 0) -> dict[str, Any]:
    import h5py

    found: dict[str, Any] = {}
    for name, x in own.members(group):
        if isinstance(x, h5py.Group) and x.keys() == {"type", "value"}:
            # As Octave writes a variable.
            x = dict(own.members(x)).get("value")
        if isinstance(x, h5py.Group) and depth < DEEPEST and not name.startswith("#"):
            fields = {n: y for n, y in own.members(x) if isinstance(y, h5py.Dataset)}
            if fields and all(map(_has_references, fields.values())):
                each = {n: own.array(y)[()].ravel("F") for n, y in fields.items()}
                found[name] = [
                    {n: _referred(x.file, y[i], own) for n, y in each.items()}
                    for i in range(min(map(len, each.values())))
                ]
            else:
                found[name] = _variables(x, own, depth + 1)
        elif isinstance(x, h5py.Dataset) and (value := _value(x, own)) is not None:
            found[name] = value
    return found


def _value(dataset: Any, own: OwnFile) -> Any:
    """An array or a text; None if it is empty."""
    if dataset.shape is None or "MATLAB_empty" in dataset.attrs or _is_a_length(dataset):
        return None
    if "MATLAB_object_decode" in dataset.attrs:
        return OfClass(dataset.attrs["MATLAB_class"].decode("latin-1"))
    if _has_references(dataset):
        cells = own.array(dataset)[()]
        inner = [_referred(dataset.file, x, own) for x in cells.ravel(order="F")]
        return np.fromiter(inner, object, len(inner)).reshape(cells.shape, order="F")
    array = own.array(dataset)
    if dataset.attrs.get("MATLAB_class") == b"char":
        return np.array("".join(map(chr, array[()].ravel())))
    return unpacked(array, dataset.attrs)


def _referred(file: Any, reference: Any, own: OwnFile) -> Any:
    import h5py

    x = file[reference] if reference else None
    if isinstance(x, h5py.Group):
        return _variables(x, own, DEEPEST)
    return _value(x, own) if isinstance(x, h5py.Dataset) else None


def _has_references(dataset: Any) -> bool:
    import h5py

    return bool(h5py.check_ref_dtype(dataset.dtype) is h5py.Reference)


def _is_a_length(dataset: Any) -> bool:
    """Whether a dataset stands for an axis of which no values were given, as netCDF puts it."""
    what = dataset.attrs.get("NAME", b"")
    return isinstance(what, bytes) and what.startswith(b"This is a netCDF dimension but not")
