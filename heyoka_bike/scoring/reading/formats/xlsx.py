"""Excel workbooks, through openpyxl."""

from dataclasses import replace
from typing import Any

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.formats.text_files import read_table
from heyoka_bike.scoring.reading.names.headings import group_number, listed
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors

# Rows that a sheet of Excel may have, and more columns than a table of results has.
_MOST_ROWS, _MOST_COLUMNS = 2**20, 1000
_BREAKS = str.maketrans({"\t": " ", "\n": " ", "\r": " "})


def read(file: ResultFile) -> list[Vectors]:
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
