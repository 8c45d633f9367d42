"""Cells: tables whose numbers and words are told apart already, as those of a sheet.

Rows of numbers below a heading and perhaps a line of units, or without a heading; or a table with
words in some columns, with names of maneuvers between its rows. A text with words in its columns is
such a table, too, once its lines are split.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.arrays.columns import read_column
from heyoka_bike.scoring.reading.arrays.long_tables import long_columns
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.digits import evened
from heyoka_bike.scoring.reading.names.columns import (
    TIME,
    are_names,
    group_number,
    recognise,
    time_among,
)
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.text.headings import COMMENT_SIGNS, heading_among
from heyoka_bike.scoring.reading.text.opening import HEADING_LINES, row_error, wrong_width

# A row above the others that has so many numbers, more than half of its cells, is a damaged one.
_FEWEST_OF_A_ROW = 3
_MANEUVER = "maneuver"
_AROUND_LABELS = "[]():;,=-\"' "
# A duration of MATLAB, of less than a minute.
_PATTERN_OF_DURATION = re.compile(
    r"(?:0+:0+:)?([0-9.]+(?:[eE][-+]?[0-9]+)?)(?: ?(?:s|sec|secs|seconds))?"
)


def read_cells(rows: Sequence[Sequence[Any]], request: Request) -> ReadTable:
    """The rows of numbers in a table of cells.

    Parameters
    ----------
    rows
        Of the table: numbers, words, and None for what is empty.
    request
        The request to read it.

    Raises
    ------
    InputError
        No rows of numbers, rows of different lengths, or something else among them.
    """
    lines = [(i, _trimmed(row)) for i, row in enumerate(rows, 1)]
    lines = [(i, row) for i, row in lines if row]
    names = [[_word(x) for x in row] for _, row in lines[:HEADING_LINES]]
    widths = {len(x) for x in names if are_names(x, request)} | {*request.widths}
    if not widths:
        raise request.not_columns("no line of column names that are known")
    counts = [len(row) if len(row) > 1 and all(map(_is_number, row)) else None for _, row in lines]
    known = Counter(n for n in counts if n is not None)
    if not known:
        raise _nothing(lines, request)
    # Another width than those expected is taken if twice as many rows have it.
    width = max(known, key=lambda n: (known[n] * (1 + (n in widths)), n in widths))
    first = counts.index(width)
    if width not in widths:
        raise wrong_width(_headings(lines[:first]), width, known[width], lines[first][0], request)
    for i, row in lines[:first]:
        numbers = sum(map(_is_number, row))
        if _is_number(row[0]) and numbers >= _FEWEST_OF_A_ROW and 2 * numbers > len(row):
            raise _row_error(row, width, request, i)
    for i, row in lines[first:]:
        if len(row) != width or not all(map(_is_number, row)):
            raise _row_error(row, width, request, i)
    found, at = heading_among(_headings(lines[:first]), width, request)
    heading = None if at is None else lines[at][0]
    if request.names:
        found, heading = [*request.names], None
    time = time_among(found or ())
    values = zip(*(row for _, row in lines[first:]), strict=True)
    columns = [
        read_column(np.array(x, dtype=object), None, j == time, request)
        for j, x in enumerate(values)
    ]
    numbers_of_lines = np.array([i for i, _ in lines[first:]], dtype=np.int64)
    return ReadTable(evened(columns, time), found, numbers_of_lines, heading)


def read_words(
    rows: Iterable[Sequence[Any]], request: Request, number: Callable[[str], str | None]
) -> list[ReadTable] | None:
    """The tables in columns of words and numbers below a line of their names; None without one.

    Parameters
    ----------
    rows
        As of `read_cells`; a row of one cell may name the maneuver of those below it.
    request
        The request to read them.
    number
        The decimal that a word stands for; None if it is none.
    """
    columns = _columns(rows, request, number)
    return tables(columns, request) if columns else None


def _columns(
    rows: Iterable[Sequence[Any]], request: Request, number: Callable[[str], str | None]
) -> dict[str, NDArray[np.object_]] | None:
    """Cells by the names of their columns; None if rows have not all as many."""
    names, maneuver = [TIME, *BENCHMARK_COLUMNS], None
    found: list[list[Any]] = []
    for row in rows:
        words = [_word(x) for x in row]
        if not found and (are_names(words, request) or long_columns(words)):
            names = words
        elif (label := group_number(" ".join(words).strip(_AROUND_LABELS))) is not None:
            maneuver = label
        elif words == names:
            continue
        elif len(words) == len(names):
            cells = zip(names, row, words, strict=True)
            found.append([*(_plain(*cell, number) for cell in cells), maneuver])
        else:
            return None
    columns = zip([*names, _MANEUVER], zip(*found, strict=True), strict=False)
    held = {name: np.array(x, object) for name, x in columns if name != _MANEUVER or x[0]}
    return held if len({*names}) == len(names) else None


def _plain(name: str, cell: Any, word: str, number: Callable[[str], str | None]) -> Any:
    """A number as it is or as its decimal, a time without its unit; a word as it is."""
    if _is_number(cell):
        return cell
    found = recognise(name)
    match = _PATTERN_OF_DURATION.fullmatch(word) if found and found[0] == TIME else None
    return number(match[1] if match else word) or word


def _headings(lines: Sequence[tuple[int, Sequence[Any]]]) -> list[list[list[str]]]:
    """Of each line the names that it may have, see `heading_among`."""
    return [[[_word(x) for x in row]] for _, row in lines]


def _nothing(lines: Sequence[tuple[int, Sequence[Any]]], request: Request) -> InputError:
    """Return the error of a table without a row of numbers; a formula may have no value."""
    for i, row in lines:
        empty = [j for j, x in enumerate(row, 1) if x is None]
        if empty and len(row) > len(empty) + 1 and all(_is_number(x) for x in row if x is not None):
            said = (
                f"found no value in column {empty[0]}, expected a number (a formula has a value "
                "once a spreadsheet program has saved it)"
            )
            return request.error(said, i, empty[0])
    return request.not_columns("no row of numbers")


def _trimmed(row: Sequence[Any]) -> list[Any]:
    """The row without the empty cells at its end."""
    cells = list(row)
    while cells and (cells[-1] is None or cells[-1] == ""):
        cells.pop()
    return cells


def _word(cell: Any) -> str:
    text = "" if cell is None else " ".join(str(cell).split())
    return COMMENT_SIGNS.sub("", text, count=1).strip("\"'") if text[:1] in "#%\"'" else text


def _is_number(cell: Any) -> bool:
    return isinstance(cell, Real) and not isinstance(cell, bool)


def _row_error(row: Sequence[Any], width: int, request: Request, line: int) -> InputError:
    fields = ["" if x is None else str(x) for x in row]
    numbers = [str(x) if _is_number(x) else None for x in row]
    return row_error(fields, numbers, width, request, line)
