"""The opening of a text: its dialect, its heading, and where its rows begin."""

import logging
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, dropwhile, islice

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.names.headings import are_names, names_found, time_among
from heyoka_bike.scoring.reading.names.units import quantities
from heyoka_bike.scoring.reading.quanta import are_beyond_binary64
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.text import dialects

# Enough to tell the dialect by the majority, and quickly.
_SAMPLE_LINES = 300
# Of these the digits beyond binary64 are looked at.
_SAMPLE_ROWS = 40
# A heading stands near the top.
_HEADING_LINES = 100
_FEWEST_COUNTED = 9

_Line = tuple[int, str]
"""Index and content of a line."""

_log = logging.getLogger(__name__)

# Around a unit.
_MARKS = "[](){}<>\"' "
# What stands before a line of units, in the place of that of the time.
_CALLED_UNITS = ("unit", "units", "unit:", "units:")
_COMMENT_SIGNS = re.compile(r"[#%!/;*\s]+")
_TWO_BLANKS = re.compile(r"\s{2,}")
_BRACKETS = re.compile(r"[ \t]?(?:\[[^\[\]]*\]|\([^()]*\))")


@dataclass(frozen=True, slots=True)
class Opening:
    """The layout of a text, as its first lines tell it.

    Attributes
    ----------
    dialect : Dialect
    width : int
        Numbers in a row.
    skip : int
        Number of lines before the first row.
    names : list of str or None
        Column names, if a heading has them.
    heading : int or None
        Number of its line.
    time : int
        Index of the column of times.
    exact : tuple of int
        Columns with more digits than binary64 has.
    """

    dialect: dialects.Dialect
    width: int
    skip: int
    names: list[str] | None
    heading: int | None
    time: int
    exact: tuple[int, ...]


def find_opening(text: str, request: Request) -> Opening:
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
    headings = chain.from_iterable(map(_headings, islice(written, _HEADING_LINES)))
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
        raise _wrong_width(lines[:first], width, len(rows), request)
    _refuse_damaged_row(sample, first, dialect, width, request)
    names, heading = _heading(lines[:first], width, request)
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
) -> tuple[list[_Line], dialects.Dialect, int, list[_Line]]:
    """The first lines that have rows, their dialect, numbers in a row, and those that are rows."""
    contents = ((i, x) for i, line in enumerate(lines) if (x := dialects.without_comment(line)))
    while sample := list(islice(contents, _SAMPLE_LINES)):
        if found := dialects.best_dialect([content for _, content in sample], widths):
            dialect, width, at = found
            is_count = _counts_columns(sample[at[0]][1], dialect, width)
            return sample, dialect, width, [sample[i] for i in at[is_count:]]
    return [], dialects.DIALECTS[0], 0, []


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


def _headings(line: str) -> Iterator[list[str]]:
    """The names in a heading, for all ways to separate them."""
    if line.startswith("\t"):
        # pandas leaves the name of its index blank.
        yield dialects.DIALECTS[0].split(line)
    text = _COMMENT_SIGNS.sub("", line, count=1) if _COMMENT_SIGNS.match(line) else line
    text = text.strip()
    if not (text[:1].isalpha() or text[:1] in "\"',;[({<\u00b0"):
        return
    for dialect in dialects.DIALECTS[::2]:
        if dialect.separator in text:
            yield dialect.split(text)
    yield [part for part in _TWO_BLANKS.split(text) if part]
    yield _BRACKETS.sub("", text).split()


def _heading(
    lines: Sequence[str], width: int, request: Request
) -> tuple[list[str] | None, int | None]:
    """The last heading of so many names above the rows, and the number of its line.

    A line of units below it is put into the names.
    """
    below: list[str] = []
    for i, names in _headings_above(lines, width):
        if are_names(names, request) or are_names(_with_units(names, below), request):
            above = (x for _, x in _headings_above(lines[i - 1 : i], width) if _are_units(x))
            return _with_units(names, below or next(above, [])), i + 1
        if not below and _are_units(names):
            below = names
    return None, None


def _headings_above(lines: Sequence[str], width: int) -> Iterator[tuple[int, list[str]]]:
    """Index of each line, from the last to the first, and so many names that it may have."""
    for i in range(len(lines) - 1, -1, -1):
        yield from ((i, names) for names in _headings(lines[i]) if len(names) == width)


def _are_units(names: Sequence[str]) -> bool:
    units = [name.strip(_MARKS) for name in names]
    if units[0].lower() in _CALLED_UNITS:
        units[0] = ""
    return any(map(quantities, units)) and all(u in ("", "-", "1") or quantities(u) for u in units)


def _with_units(names: Sequence[str], units: Sequence[str]) -> list[str]:
    plain = [name.strip("\"'") for name in names]
    if not units:
        return plain
    return [
        f"{name} [{u}]" if quantities(u := unit.strip(_MARKS)) else name
        for name, unit in zip(plain, units, strict=True)
    ]


def _wrong_width(lines: Sequence[str], width: int, rows: int, request: Request) -> InputError:
    """Return the error for rows of so many columns, with the heading above them if there is one."""
    for i, names in _headings_above(lines, width):
        if request.names is None and not _are_units(names):
            return request.not_columns(names_found(names), i + 1)
    return request.wrong_width(width, rows, len(lines) + 1)


def _counts_columns(content: str, dialect: dialects.Dialect, width: int) -> bool:
    """True if the row is 1 2 3 ... or 0 1 2 ..., which counts the columns."""
    # 0 1 may well be the first of rows that have names.
    if width < _FEWEST_COUNTED:
        return False
    fields = dialect.split(content)
    return fields in ([str(i + start) for i in range(width)] for start in (0, 1))


def _refuse_damaged_row(
    sample: Sequence[_Line], first: int, dialect: dialects.Dialect, width: int, request: Request
) -> None:
    """Raise an error if what stands before the rows looks like a row and not like a heading."""
    for i, content in sample:
        if i >= first:
            return
        fields = dialect.split(content)
        row = dialect.numbers(fields)
        numbers = len(row) - row.count(None)
        is_row = bool(row) and row[0] is not None and numbers >= 3 and 2 * numbers > len(row)
        if is_row and not _counts_columns(content, dialect, width):
            raise row_error(fields, row, width, request, i + 1)
