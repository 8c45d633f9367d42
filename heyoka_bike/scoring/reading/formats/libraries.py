"""Formats that a library reads in a few lines: NumPy, netCDF 3, Parquet and Arrow."""

from collections.abc import Iterable
from typing import Any
from zipfile import ZipFile

import numpy as np

from heyoka_bike.scoring.reading.arrays.packed import unpacked
from heyoka_bike.scoring.reading.formats import STREAM_OF_ARROW
from heyoka_bike.scoring.reading.names.heading import with_unit
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile


def read_npy(file: ResultFile) -> Any:
    """Read the NumPy array in the file."""
    return np.lib.format.read_array(file.stream(), allow_pickle=False)


def read_npz(file: ResultFile) -> dict[str, Any] | None:
    """Read an archive of NumPy arrays; None if the archive is an Excel workbook.

    Raises
    ------
    InputError
        The archive is too large, or contains no arrays.
    """
    request = file.request
    with ZipFile(file.stream()) as archive:
        names = archive.namelist()
        size = sum(member.file_size for member in archive.infolist())
        if size > request.most_bytes:
            raise request.too_long(size)
        if "mimetype" in names:
            raise request.error("is a spreadsheet or document; save it as xlsx or CSV")
        arrays = request.by_name(
            (name.removesuffix(".npy"), _member(archive, name))
            for name in names
            if name.endswith(".npy")
        )
    if not arrays and not any(name.startswith(("xl/", "[Content")) for name in names):
        raise request.error("found an archive without NumPy arrays, expected .npz or .xlsx")
    return arrays or None


def _member(archive: ZipFile, name: str) -> Any:
    with archive.open(name) as member:
        return np.lib.format.read_array(member, allow_pickle=False)


def read_netcdf(file: ResultFile) -> dict[str, Any]:
    """Read the variables of a netCDF 3 file; netCDF 4 files are HDF5 files.

    Raises
    ------
    ImportError
        SciPy is not installed.
    """
    from scipy.io import netcdf_file

    with netcdf_file(file.stream(), mmap=False) as f:
        return {
            with_unit(name, x._attributes): unpacked(np.array(x[()]), x._attributes)
            for name, x in f.variables.items()
        }


def read_parquet(file: ResultFile) -> dict[str, Any]:
    """Read the columns of the table in the file.

    Raises
    ------
    InputError
        The table is too large.
    ImportError
        pyarrow is not installed.
    """
    from pyarrow import parquet

    content = parquet.ParquetFile(file.stream())
    size = 8 * content.metadata.num_rows * content.metadata.num_columns
    if size > file.request.most_bytes:
        raise file.request.too_long(size)
    return _columns(content.read(), file)


def read_arrow(file: ResultFile) -> dict[str, Any]:
    """Read the columns of the table in a file or a stream of Arrow, or in Feather.

    Raises
    ------
    ImportError
        pyarrow is not installed.
    """
    from pyarrow import ipc

    is_stream = file.signature.startswith(STREAM_OF_ARROW)
    opened = (ipc.open_stream if is_stream else ipc.open_file)(file.stream())
    return _columns(opened.read_all(), file)


def _columns(table: Any, file: ResultFile) -> dict[str, Any]:
    return _members(table.column_names, table.itercolumns(), file.request)


def _members(names: Iterable[str], columns: Iterable[Any], request: Request) -> dict[str, Any]:
    """Return columns by name; a column of structures becomes a group with a column per field."""

    def member(column: Any) -> Any:
        if not str(getattr(column, "type", "")).startswith("struct<"):
            return column.to_numpy()
        return _members([field.name for field in column.type], column.flatten(), request)

    return request.by_name((n, member(x)) for n, x in zip(names, columns, strict=True))
