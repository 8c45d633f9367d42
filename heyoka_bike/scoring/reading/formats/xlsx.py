"""Read Excel workbooks: the values in the cells, one table per sheet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.evidence.as_read import NotCompared, Reason
from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.cells import before_comment, read_cells
from heyoka_bike.scoring.reading.formats.text_files import read_table
from heyoka_bike.scoring.reading.layout import layout_of
from heyoka_bike.scoring.reading.names.heading import group_number
from heyoka_bike.scoring.reading.names.suggestions import listed
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.text.dialects import DIALECTS_OF_CELLS
from heyoka_bike.scoring.reading.text_cells import read_words

# Maximum number of rows in an Excel sheet, and maximum number of columns of a table of results.
_ROWS_OF_A_SHEET, _COLUMNS_OF_A_TABLE = 2**20, 1000


def read(file: ResultFile) -> list[ReadTable]:
    """Return the table in the only sheet with results, or the tables in the sheets ``maneuver_N``.

    Raises
    ------
    InputError
        No sheet contains rows of numbers.
    ImportError
        openpyxl is not installed.
    """
    from openpyxl import load_workbook

    book = load_workbook(file.stream(), read_only=True, data_only=True)
    sheets = {sheet.title: _rows(sheet, file.request) for sheet in book.worksheets}
    numbers = {title: number for title in sheets if (number := group_number(title)) is not None}
    found: dict[str, list[ReadTable]] = {}
    errors: list[InputError] = []
    for title in numbers or sheets:
        part = f"sheet {quoted(title)}"
        request = file.request.within(part) if len(sheets) > 1 else file.request
        try:
            found[title] = _tables(sheets[title], request)
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
    seen = _with_results(sheets.keys() - found.keys(), sheets, file.request) if numbers else ()
    return [
        replace(table, maneuver=numbers.get(title, table.maneuver), seen=(*table.seen, *seen))
        for title, of_sheet in found.items()
        for table in of_sheet
    ]


def _with_results(
    titles: Iterable[str], sheets: Mapping[str, list[list[Any]]], request: Request
) -> tuple[NotCompared, ...]:
    """Return evidence of sheets that contain results but are not named as maneuvers."""
    lost = []
    for title in sorted(titles):
        # Skip a sheet without columns of results: it contains notes, parameters or figures.
        with suppress(InputError):
            for table in _tables(sheets[title], request):
                layout_of(table, request)
            lost.append(LostColumn(title))
    return (NotCompared(Reason.BESIDE_A_TABLE, tuple(lost), request.columns_hint),) if lost else ()


def _rows(sheet: Any, request: Request) -> list[list[Any]]:
    """Return the values in the cells of a sheet, without its empty columns."""
    # The size that a sheet states may be wrong.
    sheet.reset_dimensions()
    rows: list[dict[int, Any]] = []
    for row in sheet.iter_rows(values_only=True):
        rows.append({j: x for j, x in enumerate(row) if x not in (None, "")})
        if len(rows) > _ROWS_OF_A_SHEET or max(rows[-1], default=0) >= _COLUMNS_OF_A_TABLE:
            raise request.error(
                f"found cells beyond row {_ROWS_OF_A_SHEET} or column {_COLUMNS_OF_A_TABLE} in the "
                f"sheet {quoted(sheet.title)}, expected none beyond"
            )
    used = sorted({j for row in rows for j in row})
    return [[row.get(j) for j in used] for row in rows]


def _tables(rows: list[list[Any]], request: Request) -> list[ReadTable]:
    """Return the tables of a sheet: rows of numbers, rows with words, or a row for each column."""
    if not rows or not rows[0]:
        raise request.error("found an empty sheet, expected rows of numbers")
    if len(rows[0]) == 1:
        # Each row contains one line of a text that was pasted into a single column.
        text = "".join(f"{'' if row[0] is None else row[0]}\n" for row in rows)
        return read_table((text.encode(),), "utf-8", request)
    try:
        return [read_cells(rows, request)]
    except InputError as error:
        plain = [before_comment(row) for row in rows]
        held = [[x for x in row if x not in (None, "")] for row in plain]
        lines = [a if len(a) == 1 else b for a, b in zip(held, plain, strict=True) if a]
        for dialect in DIALECTS_OF_CELLS:
            with suppress(InputError):
                if found := read_words(lines, request, dialect):
                    return found
        with suppress(InputError, TypeError):
            if len(rows) in request.widths and all(a < b for a, b in pairwise(rows[0])):
                return tables(np.array(rows, object), request)
        raise error from None
