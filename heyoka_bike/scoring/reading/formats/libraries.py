"""Formats that a library reads in a few lines: of NumPy, netCDF 3, Parquet, Arrow and Excel."""

from dataclasses import replace
from typing import Any
from zipfile import ZipFile

import numpy as np

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.arrays import MOST_BYTES, unpacked
from heyoka_bike.scoring.reading.formats.text_files import read_table
from heyoka_bike.scoring.reading.headings import group_number, listed
from heyoka_bike.scoring.reading.request import Request, ResultFile
from heyoka_bike.scoring.reading.results import Vectors


def read_npy(file: ResultFile) -> Any:
    """Read the NumPy array in the file."""
    return np.lib.format.read_array(file.stream(), allow_pickle=False)


def read_npz(file: ResultFile) -> dict[str, Any] | None:
    """Read an archive of NumPy arrays; None if it is a workbook.

    Raises
    ------
    InputError
        Too large, or without arrays.
    """
    request, arrays = file.request, {}
    with ZipFile(file.stream()) as archive:
        names = archive.namelist()
        if sum(member.file_size for member in archive.infolist()) > MOST_BYTES:
            raise request.error(f"found more than {MOST_BYTES} bytes, expected fewer")
        if "mimetype" in names:
            raise request.error("is a spreadsheet or document; save it as xlsx or CSV")
        for name in names:
            if name.endswith(".npy"):
                with archive.open(name) as member:
                    array = np.lib.format.read_array(member, allow_pickle=False)
                    arrays[name.removesuffix(".npy")] = array
    if not arrays and not any(name.startswith(("xl/", "[Content")) for name in names):
        raise request.error("found an archive without NumPy arrays, expected .npz or .xlsx")
    return arrays or None


def read_netcdf(file: ResultFile) -> dict[str, Any]:
    """Read the variables of netCDF 3; files of version 4 are HDF5.

    Raises
    ------
    ImportError
        SciPy is not installed.
    """
    from scipy.io import netcdf_file

    with netcdf_file(file.stream(), mmap=False) as f:
        return {name: unpacked(np.array(x[()]), x._attributes) for name, x in f.variables.items()}


def read_parquet(file: ResultFile) -> dict[str, Any]:
    """Read the columns of the table in the file.

    Raises
    ------
    InputError
        Too large.
    ImportError
        pyarrow is not installed.
    """
    from pyarrow import parquet

    content = parquet.ParquetFile(file.stream())
    size = 8 * content.metadata.num_rows * content.metadata.num_columns
    if size > MOST_BYTES:
        raise file.request.error(f"found {size} bytes, expected at most {MOST_BYTES}")
    return _columns(content.read())


def read_arrow(file: ResultFile) -> dict[str, Any]:
    """Read the columns of the table in a file of Arrow or Feather.

    Raises
    ------
    ImportError
        pyarrow is not installed.
    """
    from pyarrow import ipc

    return _columns(ipc.open_file(file.stream()).read_all())


def _columns(table: Any) -> dict[str, Any]:
    return {name: table[name].to_numpy() for name in table.column_names}


# Rows that a sheet of Excel may have, and more columns than a table of results has.
_MOST_ROWS, _MOST_COLUMNS = 2**20, 1000
_BREAKS = str.maketrans({"\t": " ", "\n": " ", "\r": " "})


def read_xlsx(file: ResultFile) -> list[Vectors]:
    """The tables in the sheets: one, or one in each ``maneuver_N``.

    Raises
    ------
    InputError
        No sheet with rows of numbers.
    ImportError
        openpyxl is not installed.
    """
    from openpyxl import load_workbook

    book = load_workbook(file.stream(), read_only=True, data_only=True)
    texts = {sheet.title: _as_text(sheet, file.request) for sheet in book.worksheets}
    numbers = {title: number for title in texts if (number := group_number(title)) is not None}
    found: dict[str, list[Vectors]] = {}
    errors: list[InputError] = []
    for title in numbers or texts:
        part = f"sheet {quoted(title)}"
        request = file.request.within(part) if len(texts) > 1 else file.request
        try:
            found[title] = read_table((texts[title],), "utf-8", request)
        except InputError as e:
            if numbers:
                raise
            errors.append(e)
    if not found:
        raise errors[0]
    if not numbers and len(found) > 1:
        raise file.request.error(
            f"found results in the sheets {listed(list(found))}, expected them in one sheet, or in "
            "sheets named maneuver_1 and so on"
        )
    return [
        replace(table, maneuver=numbers.get(title, table.maneuver))
        for title, tables in found.items()
        for table in tables
    ]


def _as_text(sheet: Any, request: Request) -> bytes:
    """The cells of a sheet with tabs between them, a row in each line; no column is empty."""
    # What a sheet says of its size may be wrong.
    sheet.reset_dimensions()
    rows: list[dict[int, str]] = []
    for row in sheet.iter_rows(values_only=True):
        rows.append({j: _cell(x) for j, x in enumerate(row) if x is not None})
        if len(rows) > _MOST_ROWS or max(rows[-1], default=0) >= _MOST_COLUMNS:
            raise request.error(
                f"found cells beyond row {_MOST_ROWS} or column {_MOST_COLUMNS} in the sheet "
                f"{quoted(sheet.title)}, expected no more"
            )
    used = sorted({j for row in rows for j, text in row.items() if text})
    return "\n".join("\t".join(row.get(j, "") for j in used).rstrip() for row in rows).encode()


def _cell(x: Any) -> str:
    """A value as it is written in a text."""
    return str(x).translate(_BREAKS).strip()
