"""Files of arrays: NumPy's, netCDF and HDF5."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.array_columns import MOST_BYTES
from heyoka_bike.scoring.reading.array_tables import DEEPEST, tables
from heyoka_bike.scoring.reading.damage import any_damage, damage, missing
from heyoka_bike.scoring.reading.expected import Expected
from heyoka_bike.scoring.reading.own_arrays import OwnFile
from heyoka_bike.scoring.reading.written import WrittenTable


def read_npy(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The table in a file of one NumPy array.

    Parameters
    ----------
    stream
        The file, which can seek.
    path
        Name of the file, for errors.
    expected
        What columns there may be.

    Raises
    ------
    InputError
        Not such a file, or not columns of real numbers.
    """
    with damage("a NumPy array", path):
        array = _npy(stream)
    return tables(array, path, expected)


def read_archive(stream: BinaryIO, path: str, expected: Expected) -> tuple[list[WrittenTable], str]:
    """The tables in an archive of NumPy arrays or in a spreadsheet, and which; see `read_npy`."""
    from zipfile import ZipFile

    with damage("NumPy arrays", path), ZipFile(stream) as archive:
        names = archive.namelist()
        if sum(member.file_size for member in archive.infolist()) > MOST_BYTES:
            raise InputError(f"found more than {MOST_BYTES} bytes, expected fewer", file=path)
        if "mimetype" in names:
            raise InputError("is a spreadsheet or document; save it as xlsx or CSV", file=path)
        arrays = {}
        for name in names:
            if name.endswith(".npy"):
                with archive.open(name) as member:
                    arrays[name.removesuffix(".npy")] = _npy(member)
    if arrays:
        return tables(arrays, path, expected), "npz"
    if any(name.startswith(("xl/", "[Content")) for name in names):
        from heyoka_bike.scoring.reading.table_files import read_spreadsheet

        stream.seek(0)
        return read_spreadsheet(stream, path, expected), "xlsx"
    raise InputError(
        "found an archive without NumPy arrays, expected text, JSON, .npy, .npz, .mat, netCDF, "
        "HDF5, Parquet or xlsx",
        file=path,
    )


def read_netcdf(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The tables in a netCDF 3 file; see `read_npy`. Those of version 4 are HDF5.

    Raises
    ------
    MissingPackageError
        SciPy is not installed.
    """
    try:
        from scipy.io import netcdf_file
    except ImportError:
        raise missing(path, "scipy", "netCDF 3 files") from None
    with any_damage("a netCDF file", path), netcdf_file(stream, mmap=False) as f:
        arrays = {name: np.array(x[()]) for name, x in f.variables.items()}
    return tables(arrays, path, expected)


def read_hdf5(
    source: BinaryIO | Path, path: str, expected: Expected
) -> tuple[list[WrittenTable], str]:
    """The tables in an HDF5 file (netCDF 4 too) or MATLAB's from version 7.3, and which it is."""
    import h5py

    with ExitStack() as stack:
        with damage("HDF5", path):
            f = stack.enter_context(h5py.File(source, "r"))
            # MATLAB's arrays have their axes the other way round.
            is_matlab, own = f.userblock_size > 0, OwnFile(path)
            if is_matlab:
                from heyoka_bike.scoring.reading.matlab_files import variables, without_signals

                members = without_signals(variables(f, own), path)
            else:
                members = _datasets(f, own)
        found = tables(members, path, expected, is_ordered=False, is_transposed=is_matlab)
        return found, "mat" if is_matlab else "hdf5"


def _datasets(group: Any, own: OwnFile, depth: int = 0) -> dict[str, Any]:
    """The arrays of a group and of those in it."""
    import h5py

    found: dict[str, Any] = {}
    for name, x in own.members(group):
        if isinstance(x, h5py.Group) and x.keys() == {"type", "value"}:
            # As Octave writes a variable.
            x = dict(own.members(x)).get("value")
        if isinstance(x, h5py.Dataset) and x.shape is not None and not _is_a_length(x):
            found[name] = own.array(x)
        elif isinstance(x, h5py.Group) and depth < DEEPEST:
            found[name] = _datasets(x, own, depth + 1)
    return found


def _is_a_length(dataset: Any) -> bool:
    """Whether a dataset stands for an axis of which no values were given, as netCDF puts it."""
    what = dataset.attrs.get("NAME", b"")
    return isinstance(what, bytes) and what.startswith(b"This is a netCDF dimension but not")


def _npy(stream: Any) -> NDArray[Any]:
    with catch_warnings():
        # About headers that Python 2 wrote.
        simplefilter("ignore")
        array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    return array
