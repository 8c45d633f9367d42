"""Files of arrays: NumPy's, netCDF and HDF5."""

from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError, printable
from heyoka_bike.scoring.reading.array_columns import MOST_BYTES
from heyoka_bike.scoring.reading.array_tables import DEEPEST, tables
from heyoka_bike.scoring.reading.damage import any_damage, damage, missing
from heyoka_bike.scoring.reading.expected import Expected
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
            is_matlab = f.userblock_size > 0
            if is_matlab:
                from heyoka_bike.scoring.reading.matlab_files import variables, without_signals

                members = without_signals(variables(f, partial(_Dataset, path=path)), path)
            else:
                members = _datasets(f, path)
        found = tables(members, path, expected, is_ordered=False, is_transposed=is_matlab)
        return found, "mat" if is_matlab else "hdf5"


class _Dataset:
    """An array in an HDF5 file, read when it is wanted."""

    def __init__(self, dataset: Any, path: str) -> None:
        if dataset.is_virtual or dataset.external:
            # Whose name the file chooses: that of a stranger must not open ours.
            raise InputError(
                f"found {printable(dataset.name)} kept in another file, expected it in this one",
                file=path,
            )
        self.dtype = dataset.dtype
        self.shape = dataset.shape
        self._dataset = dataset
        self._path = path

    def __getitem__(self, index: tuple[()]) -> Any:
        with damage("HDF5", self._path):
            try:
                return self._dataset[index]
            except OSError:
                self._check_filters()
                raise

    def _check_filters(self) -> None:
        """Say it if the array was compressed by what is not here."""
        import h5py

        made = self._dataset.id.get_create_plist()
        for i in range(made.get_nfilters()):
            code, _, _, name = made.get_filter(i)
            if not h5py.h5z.filter_avail(code):
                raise InputError(
                    f"found {printable(self._dataset.name)} compressed by "
                    f"{printable(name.decode(errors='replace')) or f'filter {code}'}, which is not "
                    "installed here, expected gzip or none (h5repack -f GZIP=6 changes it)",
                    file=self._path,
                )


def _datasets(group: Any, path: str, depth: int = 0) -> dict[str, Any]:
    """The arrays of a group and of those in it; links to other files are not followed."""
    import h5py

    found: dict[str, Any] = {}
    for name in group:
        if isinstance(group.get(name, getlink=True), h5py.ExternalLink):
            continue
        x = group.get(name)
        if isinstance(x, h5py.Group) and x.keys() == {"type", "value"}:
            # As Octave writes a variable.
            x = x["value"]
        if isinstance(x, h5py.Dataset) and x.shape is not None and not _is_a_length(x):
            found[name] = _Dataset(x, path)
        elif isinstance(x, h5py.Group) and depth < DEEPEST:
            found[name] = _datasets(x, path, depth + 1)
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
