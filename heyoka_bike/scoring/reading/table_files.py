"""Spreadsheets, Parquet and Arrow files, through the libraries that read them."""

from dataclasses import replace
from typing import Any, BinaryIO

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.array_columns import MOST_BYTES
from heyoka_bike.scoring.reading.array_tables import tables
from heyoka_bike.scoring.reading.column_names import group_number, listed
from heyoka_bike.scoring.reading.damage import any_damage, missing
from heyoka_bike.scoring.reading.expected import Expected
from heyoka_bike.scoring.reading.text_table import read_text
from heyoka_bike.scoring.reading.written import WrittenTable

_BREAKS = str.maketrans({"\t": " ", "\n": " ", "\r": " "})


def read_columns(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The table in a Parquet file, or in an Arrow file (Feather).

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
    MissingPackageError
        pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise missing(path, "pyarrow", "Parquet and Arrow files") from None
    is_parquet = stream.read(4) == b"PAR1"
    stream.seek(0)
    with any_damage("a Parquet file" if is_parquet else "an Arrow file", path):
        if is_parquet:
            file = parquet.ParquetFile(stream)
            size = 8 * file.metadata.num_rows * file.metadata.num_columns
            if size > MOST_BYTES:
                raise InputError(f"found {size} bytes, expected at most {MOST_BYTES}", file=path)
            table = file.read()
        else:
            table = pyarrow.ipc.open_file(stream).read_all()
        columns = {name: table[name].to_numpy() for name in table.column_names}
    return tables(columns, path, expected)


def read_spreadsheet(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The tables in the sheets of an Excel workbook: one, or one in each ``maneuver_N``.

    Raises
    ------
    InputError
        Not such a file, or no sheet with rows of numbers.
    MissingPackageError
        openpyxl is not installed.
    """
    try:
        from openpyxl import load_workbook
    except ImportError:
        raise missing(path, "openpyxl", "spreadsheets (or save it as CSV)") from None
    with any_damage("a spreadsheet", path):
        book = load_workbook(stream, read_only=True, data_only=True)
        texts = {sheet.title: _as_text(sheet) for sheet in book.worksheets}
    found: dict[str, WrittenTable] = {}
    errors: dict[str, InputError] = {}
    for title, text in texts.items():
        try:
            found[title] = read_text((text,), "utf-8", path, expected)
        except InputError as e:
            where = f"sheet {quoted(title)}: " if len(texts) > 1 else ""
            message = f"{where}{e.message}"
            errors[title] = InputError(message, file=path, line=e.line, column=e.column)
    numbers = {title: number for title in texts if (number := group_number(title)) is not None}
    if not numbers and len(found) > 1:
        raise InputError(
            f"found results in the sheets {listed(list(found))}, expected them in one sheet, or in "
            "sheets named maneuver_1 and so on",
            file=path,
        )
    for title in numbers if numbers else () if found else errors:
        if title in errors:
            raise errors[title]
    if not numbers:
        return list(found.values())
    return [replace(found[title], maneuver=number) for title, number in numbers.items()]


def _as_text(sheet: Any) -> bytes:
    """The cells of a sheet with tabs between them, a row in each line; no column is empty."""
    rows = [[_cell(x) for x in row] for row in sheet.iter_rows(values_only=True)]
    used = sorted({j for row in rows for j, text in enumerate(row) if text})
    lines = ["\t".join(row[j] if j < len(row) else "" for j in used).rstrip() for row in rows]
    return "\n".join(lines).encode()


def _cell(x: Any) -> str:
    """A value as it is written in a text."""
    return "" if x is None else str(x).translate(_BREAKS).strip()
