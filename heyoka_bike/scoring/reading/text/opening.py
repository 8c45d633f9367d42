"""The opening of a text: the dialect of its first lines, its heading, and where its rows begin."""

from __future__ import annotations

import logging
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import chain, dropwhile, islice

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.digits import are_beyond_binary64
from heyoka_bike.scoring.reading.names.columns import are_names, time_among
from heyoka_bike.scoring.reading.names.words import names_found
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.text.dialects import (
    DIALECTS,
    Dialect,
    best_dialect,
    without_comment,
)
from heyoka_bike.scoring.reading.text.headings import (
    are_units,
    heading_above,
    headings_in,
    of_width,
)

_log = logging.getLogger(__name__)
# Enough to tell the dialect by the majority, and quickly.
_SAMPLE_LINES = 300
# Of these the digits beyond binary64 are looked at.
_SAMPLE_ROWS = 40
# A heading stands near the top.
HEADING_LINES = 100
_FEWEST_COUNTED = 9
Line = tuple[int, str]
"""Index and content of a line."""


@dataclass(frozen=True, slots=True)
class Opening:
    """How rows of numbers are written, and where they begin.

    Attributes
    ----------
    dialect : Dialect
    width
        Numbers in a row.
    line
        Number of lines before the first row.
    names : list of str or None
        Column names, if a heading has them.
    heading
        Number of its line.
    time
        Index of the column of times.
    exact : tuple of int
        Columns with more digits than binary64 has.
    """

    dialect: Dialect
    width: int
    line: int
    names: list[str] | None
    heading: int | None
    time: int
    exact: tuple[int, ...]


def open_text(text: str, request: Request) -> Opening:
    """Find out how rows of numbers are written, and where they begin.

    Parameters
    ----------
    text
        The first lines.
    request
        The request to read it.

    Raises
    ------
    InputError
        No rows, rows of another number of columns, or a damaged first row.
    """
    lines = text.split("\n")
    written = dropwhile(lambda line: not line.strip(), lines)
    headings = chain.from_iterable(map(headings_in, islice(written, HEADING_LINES)))
    widths = {len(names) for names in headings if are_names(names, request)} | {*request.widths}
    if not widths:
        raise request.not_columns("no line of column names that are known")
    sample, dialect, width, rows = _first_rows(lines, widths)
    if not rows and not text.strip():
        raise request.error("found an empty file, expected rows of numbers")
    if not rows:
        raise request.not_columns("no row of numbers")
    first = rows[0][0]
    if width not in widths:
        above = [[*headings_in(line)] for line in lines[:first]]
        raise wrong_width(above, width, len(rows), first + 1, request)
    _refuse_damaged_row(sample, first, dialect, width, request)
    names, heading = heading_above(lines[:first], width, request)
    if request.names:
        names, heading = [*request.names], None
    time = time_among(names or ())
    _log.debug(
        "%s: rows of %d numbers from line %d, separator %r, decimal %r; names %s", request.path,
        width, first + 1, dialect.separator, dialect.decimal,
        f"in line {heading}" if heading else "told" if names else "none",
    )  # fmt: skip
    spread = (dialect.split(content) for _, content in rows[:: max(1, len(rows) // _SAMPLE_ROWS)])
    numbers = [[dialect.number(field) or "" for field in fields] for fields in spread]
    exact = tuple(
        j for j in range(width) if are_beyond_binary64([row[j] for row in numbers], j == time)
    )
    return Opening(dialect, width, first, names, heading, time, exact)


def _first_rows(
    lines: Sequence[str], widths: Collection[int]
) -> tuple[list[Line], Dialect, int, list[Line]]:
    """The first lines that have rows, their dialect, numbers in a row, and those that are rows."""
    contents = ((i, x) for i, line in enumerate(lines) if (x := without_comment(line)))
    while sample := list(islice(contents, _SAMPLE_LINES)):
        if found := best_dialect([content for _, content in sample], widths):
            dialect, width, at = found
            is_count = counts_columns(sample[at[0]][1], dialect, width)
            return sample, dialect, width, [sample[i] for i in at[is_count:]]
    return [], DIALECTS[0], 0, []


def row_error(
    fields: Sequence[str], row: Sequence[str | None], width: int, request: Request, line: int
) -> InputError:
    """Return the error of the first bad field of a row; the column counts the fields from 1."""
    if None in row[:width]:
        at = row.index(None)
        found = quoted(fields[at]) if fields[at] else "no value between two separators"
        message = f"found {found} as value {at + 1}, expected a number"
    else:
        at = min(len(fields), width)
        message = f"found {len(fields)} values, expected {width}"
    return request.error(message, line, at + 1)


def wrong_width(
    above: Sequence[Sequence[list[str]]], width: int, rows: int, line: int, request: Request
) -> InputError:
    """Return the error for rows of so many columns, with the heading above them if there is one.

    Parameters
    ----------
    above
        Of each line above the rows, all names that it may have.
    width, rows
        Numbers in a row, and how many rows there are.
    line
        Number of the first of them.
    request
        The request to read them.
    """
    for i, names in of_width(above, width):
        if request.names is None and not are_units(names):
            return request.not_columns(names_found(names), i + 1)
    return request.wrong_width(width, rows, line)


def counts_columns(content: str, dialect: Dialect, width: int) -> bool:
    """True if the row is 1 2 3 ... or 0 1 2 ..., which counts the columns."""
    # 0 1 may well be the first of rows that have names.
    if width < _FEWEST_COUNTED:
        return False
    fields = dialect.split(content)
    return fields in ([str(i + start) for i in range(width)] for start in (0, 1))


def _refuse_damaged_row(
    sample: Sequence[Line], first: int, dialect: Dialect, width: int, request: Request
) -> None:
    """Raise an error if what stands before the rows looks like a row and not like a heading."""
    for i, content in sample:
        if i >= first:
            return
        fields = dialect.split(content)
        row = dialect.numbers(fields)
        numbers = len(row) - row.count(None)
        is_row = bool(row) and row[0] is not None and numbers >= 3 and 2 * numbers > len(row)
        if is_row and not counts_columns(content, dialect, width):
            raise row_error(fields, row, width, request, i + 1)
