"""Read rows of numbers in the cells of a sheet by the rules for the lines of a text.

Each row is a line that is already split into fields. So headings, lines of units, rows of column
numbers, comments, numbers written as words, and an incomplete last row mean the same as in a text.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.evidence.as_read import LastRowIncomplete
from heyoka_bike.scoring.reading.arrays.array_columns import read_column
from heyoka_bike.scoring.reading.digits import evened
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.text.dialects import DIALECTS_OF_CELLS, is_number, without_comment
from heyoka_bike.scoring.reading.text.headings import headings_of_cells
from heyoka_bike.scoring.reading.text.opening import MOST_ABOVE, Notation, opened
from heyoka_bike.scoring.reading.text.rows import decimals_of

_EXPECTED = "expected a number (a formula has a value once a spreadsheet program has saved it)"


def read_cells(rows: Sequence[Sequence[Any]], request: Request) -> ReadTable:
    """Return the rows of numbers in a sheet as a table, by the rules for the lines of a text.

    Parameters
    ----------
    rows
        Cells of each row: numbers, words, and None for empty cells.
    request
        The request to read them.

    Raises
    ------
    InputError
        There are no rows of numbers, their lengths differ, or there is something else among them.
    """
    lines = [_trimmed(row) for row in rows]
    width = max(map(len, lines), default=0)
    first = next((i for i, row in enumerate(lines) if any(map(is_number, row))), 0)
    # The row of names or units may be shorter than the rows of numbers, if the last columns lack a
    # name or a unit.
    for row in lines[max(0, first - MOST_ABOVE) : first]:
        row += [None] * (width - len(row)) if row else []
    try:
        opening = opened(lines, _CELLS, request)
    except InputError as error:
        raise _without_value(lines, request) or error from None
    first = opening.line
    found, cut = decimals_of(lines[first:], opening, first + 1, request)
    held = [(i, row) for i, row in enumerate(found, first + 1) if row]
    values = zip(*(row for _, row in held), strict=True)
    columns = [
        read_column(np.array(x, dtype=object), None, j == opening.time, request)
        for j, x in enumerate(values)
    ]
    return ReadTable(
        evened(columns, opening.time),
        opening.names,
        np.array([i for i, _ in held], dtype=np.int64),
        opening.heading,
        seen=(
            *opening.skipped.evidence(),
            *(() if cut is None else (LastRowIncomplete(cut.line),)),
        ),
    )


def _without_value(lines: Sequence[Sequence[Any]], request: Request) -> InputError | None:
    """Return the error for the first row of numbers with an empty cell; None without such a row."""
    for i, row in enumerate(lines, 1):
        empty = [j for j, x in enumerate(row, 1) if x is None]
        if empty and len(row) > len(empty) + 1 and all(is_number(x) for x in row if x is not None):
            return request.error(f"found no value in column {empty[0]}, {_EXPECTED}", i, empty[0])
    return None


def _trimmed(row: Sequence[Any]) -> list[Any]:
    """Return the row without the empty cells at its end."""
    cells = list(row)
    while cells and (cells[-1] is None or cells[-1] == ""):
        cells.pop()
    return cells


def before_comment(row: Sequence[Any]) -> list[Any]:
    """Return the cells of a row that precede a comment."""
    for j, cell in enumerate(row):
        if isinstance(cell, str) and (rest := without_comment(cell)) != cell.strip():
            return _trimmed([*row[:j], rest])
    return list(row)


_CELLS = Notation(DIALECTS_OF_CELLS, before_comment, headings_of_cells, lambda row: not row)
