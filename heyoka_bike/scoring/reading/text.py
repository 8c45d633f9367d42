"""Rows of numbers in a text, in whatever way programs write them.

The first lines tell its dialect (separators, decimal points or commas, comments), its heading, and
where its rows begin. A block of lines becomes correctly rounded numbers all at once: NumPy reads
them, in C. Anything unusual makes `parse_block` return None: another, slower reader then takes the
block or names what is wrong.
"""

import logging
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal
from itertools import chain, dropwhile, islice
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence import Evidence, LastRowIncomplete
from heyoka_bike.scoring.reading.headings import are_names, names_found, quantities, time_among
from heyoka_bike.scoring.reading.quanta import are_beyond_binary64, evened, written_column
from heyoka_bike.scoring.reading.request import Request, whole_lines
from heyoka_bike.scoring.reading.results import Vectors

_NUMBER = re.compile(
    r"([+-]?)([0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eEdDqQ]([+-]?[0-9]+)|([+-][0-9]{3}))?"
)
# What most rows are, at once: seven times as fast as one by one.
_PLAIN_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_MANY_NUMBERS = re.compile(rf"{_PLAIN_NUMBER}(?:\n{_PLAIN_NUMBER})*")
# Also as Microsoft's library used to write it.
_NOT_FINITE = re.compile(
    r"[+-]?(?:nan(?:\([a-z0-9_]*\))?|inf(?:inity)?|[0-9]+\.?#(?:ind|inf|qnan|snan)[0-9]*)",
    re.IGNORECASE,
)
# In 1.#IND the sign is part of the number.
_COMMENT = re.compile(r"(?:(?<![0-9]\.)#|#(?!IND|INF|QNAN|SNAN))|[%!]|//", re.IGNORECASE)
_CUT = re.compile(r"[+-]?[0-9]*[.,]?[0-9]*(?:[eEdDqQ][+-]?)?")
_QUOTED = re.compile(r"\"[^\"]*\"|'[^']*'")


@dataclass(frozen=True)
class Dialect:
    """A way to separate and to write numbers.

    Attributes
    ----------
    separator
        A comma, a semicolon or a tab, with any blanks around it; nothing if blanks separate.
    decimal
        The decimal point or comma.
    """

    separator: str
    decimal: str

    def split(self, line: str) -> list[str]:
        """Fields of a line, without blanks around them; a separator at the end adds none."""
        held = _QUOTED.findall(line) if '"' in line or "'" in line else []
        if held:
            # Separators in quotes are none.
            line = _QUOTED.sub("\0", line)
        if self.separator:
            fields = [field.strip(" \t") for field in line.split(self.separator)]
            if not fields[-1]:
                fields.pop()
        else:
            fields = [field for field in line.replace("\t", " ").split(" ") if field]
        if not held:
            return fields
        back = iter(held)
        return [re.sub("\0", lambda _: next(back, "\0"), field) for field in fields]

    def number(self, field: str) -> str | None:
        """The number in the form that `float` reads, ``nan`` if it is not finite; None if none."""
        if len(field) > 1 and field[0] == field[-1] and field[0] in "\"'":
            field = field[1:-1].strip(" \t")
        if self.decimal == ",":
            if "." in field:
                return None
            field = field.replace(",", ".")
        match = _NUMBER.fullmatch(field)
        if match is None:
            return "nan" if _NOT_FINITE.fullmatch(field) else None
        sign, mantissa, power, bare = match.groups()
        if power is None and bare is None:
            return field
        # Fortran leaves the letter out where three digits need its place.
        if bare is not None and "." not in mantissa:
            return None
        return f"{sign}{mantissa}e{power or bare}"

    def numbers(self, fields: Sequence[str]) -> list[str | None]:
        """`number` of each of the fields."""
        if self.decimal == "." and _MANY_NUMBERS.fullmatch("\n".join(fields)):
            return list(fields)
        return [self.number(field) for field in fields]

    def count(self, line: str) -> int | None:
        """Count the numbers in the line; None if it has anything else or nothing."""
        fields = self.split(line)
        return len(fields) if fields and None not in self.numbers(fields) else None

    def is_cut(self, fields: Sequence[str], columns: int, at_end: bool) -> bool:
        """True if a row may have been cut while it was being written.

        That is, numbers, then one that may be unfinished, fewer than the columns; as many if the
        text ends right there (`at_end`).
        """
        if not 0 < len(fields) < columns + at_end:
            return False
        complete = all(self.number(field) is not None for field in fields[:-1])
        return complete and bool(self.number(fields[-1]) or _CUT.fullmatch(fields[-1]))


DIALECTS = tuple(
    Dialect(separator, decimal) for separator in ("\t", ";", ",", "") for decimal in (".", ",")
)
"""All dialects; of two that read a text alike the first one is meant."""


def without_comment(line: str) -> str:
    """The line up to the first of ``# % ! //``."""
    may_have = "#" in line or "%" in line or "!" in line or "//" in line
    match = _COMMENT.search(line) if may_have else None
    return (line if match is None else line[: match.start()]).strip()


def best_dialect(
    lines: Sequence[str], fitting: Collection[int]
) -> tuple[Dialect, int, list[int]] | None:
    """The dialect under which most lines are rows of numbers.

    Parameters
    ----------
    lines
        Without comments, none of them empty.
    fitting
        Numbers of columns that are expected; another one is taken if twice as many rows have it.

    Returns
    -------
    (Dialect, int, list of int) or None
        With the numbers in a row, and the indices of the lines that are rows; None if no line is
        a row of at least two numbers.
    """
    text = "".join(lines)
    best: tuple[int, bool] = (0, False)
    found = None
    for dialect in DIALECTS:
        if dialect.separator not in text or (dialect.decimal == "," and "," not in text):
            continue
        counts = [dialect.count(line) for line in lines]
        for count, times in Counter(counts).items():
            if count is None or count < 2:
                continue
            # A few rows that happen to fit among many that do not are no rows.
            fits = count in fitting
            if (times * (1 + fits), fits) > best:
                best = (times * (1 + fits), fits)
                found = dialect, count, [i for i, n in enumerate(counts) if n == count]
    return found


Ints = NDArray[np.int64]

_OF_NUMBERS = b"0123456789.e+- \t\n"
# Enough digits for any binary64 without its leading ones; no exponent is too large.
_EXACT = Context(prec=1200, Emax=MAX_EMAX, Emin=MIN_EMIN, traps=[])


@dataclass(frozen=True, slots=True)
class Block:
    """Numbers of consecutive lines.

    Attributes
    ----------
    values : list of ndarray, shape (rows,)
        By column, correctly rounded.
    lines : ndarray of int, shape (rows,)
        Index, in the block, of the line of each row.
    written : list of tuple of str
        By column, the numbers of some of the rows.
    lo : mapping of int to ndarray, shape (rows,)
        By index of the column: the written decimal minus the value, correctly rounded.
    """

    values: list[Array]
    lines: Ints
    written: list[tuple[str, ...]]
    lo: dict[int, Array]


def parse_block(
    text: bytes, columns: int, separator: bytes, exact: Collection[int], samples: int
) -> Block | None:
    """Read whole lines of plain decimals.

    Parameters
    ----------
    text
        Lines, each ending in a line feed, with decimal points and the exponent letter e.
    columns
        Numbers in each line that is not blank.
    separator
        What separates numbers besides blanks; nothing for blanks alone.
    exact
        Columns of which the rest beyond binary64 is wanted.
    samples
        Number of rows, roughly, of which to tell how many digits were written.

    Returns
    -------
    Block or None
        None if anything in the text is not as described.
    """
    if not text.endswith(b"\n") or text.translate(None, _OF_NUMBERS + separator):
        return None
    try:
        return _read_lines(text.decode().split("\n"), columns, separator.decode(), exact, samples)
    except ValueError:
        return None


def _read_lines(
    lines: Sequence[str], columns: int, separator: str, exact: Collection[int], samples: int
) -> Block | None:
    """Read lines of plain decimals as `parse_block` does; None if all of them are blank.

    Raises
    ------
    ValueError
        A row has another number of columns, or what is no number.
    """
    rows = [line.rstrip().removesuffix(separator) for line in lines]
    at = np.flatnonzero([bool(row) for row in rows])
    rows = [row for row in rows if row]
    if not rows:
        return None
    mark = separator or None
    table = np.loadtxt(rows, comments=None, delimiter=mark, ndmin=2)
    if table.shape != (len(rows), columns):
        raise ValueError("rows of another number of columns")
    values = [np.ascontiguousarray(column) for column in table.T]
    sampled = rows[:: max(1, len(rows) // samples)]
    written = [*zip(*([x.strip() for x in row.split(mark)] for row in sampled), strict=True)]
    lo = {j: rests((row.split(mark, j + 1)[j] for row in rows), values[j]) for j in exact}
    return Block(values, at, written, lo)


def rests(numbers: Iterable[str], values: Array) -> Array:
    """The `rest` of each decimal beyond its value."""
    return np.array([rest(x, hi) for x, hi in zip(numbers, values.tolist(), strict=True)])


def rest(number: str, hi: float) -> float:
    """The decimal minus its binary64, correctly rounded; zero for zero and infinity."""
    if hi == 0.0 or not isfinite(hi):
        return 0.0
    return float(_EXACT.subtract(Decimal(number), Decimal(hi)))


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


def _opened(text: str, request: Request) -> "_Reader":
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
    return _Reader(request, dialect, width, first, names, heading, time, exact)


def _first_rows(
    lines: Sequence[str], widths: Collection[int]
) -> tuple[list[_Line], Dialect, int, list[_Line]]:
    """The first lines that have rows, their dialect, numbers in a row, and those that are rows."""
    contents = ((i, x) for i, line in enumerate(lines) if (x := without_comment(line)))
    while sample := list(islice(contents, _SAMPLE_LINES)):
        if found := best_dialect([content for _, content in sample], widths):
            dialect, width, at = found
            is_count = _counts_columns(sample[at[0]][1], dialect, width)
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


def _headings(line: str) -> Iterator[list[str]]:
    """The names in a heading, for all ways to separate them."""
    if line.startswith("\t"):
        # pandas leaves the name of its index blank.
        yield DIALECTS[0].split(line)
    text = _COMMENT_SIGNS.sub("", line, count=1) if _COMMENT_SIGNS.match(line) else line
    text = text.strip()
    if not (text[:1].isalpha() or text[:1] in "\"',;[({<\u00b0"):
        return
    for dialect in DIALECTS[::2]:
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


def _counts_columns(content: str, dialect: Dialect, width: int) -> bool:
    """True if the row is 1 2 3 ... or 0 1 2 ..., which counts the columns."""
    # 0 1 may well be the first of rows that have names.
    if width < _FEWEST_COUNTED:
        return False
    fields = dialect.split(content)
    return fields in ([str(i + start) for i in range(width)] for start in (0, 1))


def _refuse_damaged_row(
    sample: Sequence[_Line], first: int, dialect: Dialect, width: int, request: Request
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


# Rows of the first block of which digits are counted; of a later one, and by the slow reader.
_COUNTED, _COUNTED_LATER = 2000, 200
# Numbers as `parse_block` reads them; beside a decimal comma a point has no place.
_PLAIN = {
    ".": bytes.maketrans(b"EDdQq", b"eeeee"),
    ",": bytes.maketrans(b".,EDdQq", b"?.eeeee"),
}


def read_text(chunks: Iterable[bytes], encoding: str, request: Request) -> Vectors:
    """Read rows of numbers.

    Parameters
    ----------
    chunks
        The text, cut anywhere.
    encoding
        See `request.encoding_of`.
    request
        The request to read it.

    Raises
    ------
    InputError
        Not rows of numbers: where, what was found, what was expected.
    """
    blocks = whole_lines(chunks, encoding, request)
    first = next(blocks, "")
    while not first.strip() and (block := next(blocks, "")):
        first += block
    reader = _opened(first, request)
    for block in chain([first.split("\n", reader.line)[-1]], blocks):
        reader.read(block)
    return reader.finish()


@dataclass(eq=False, slots=True)
class _Reader:
    """Reads rows from blocks of lines; the layout is that of the first lines.

    Attributes
    ----------
    request : Request
    dialect : Dialect
    width : int
        Numbers in a row.
    line : int
        Number of lines before the next block; before the first row if there was none.
    names : list of str or None
        Column names, if a heading has them.
    heading : int or None
        Number of its line.
    time : int
        Index of the column of times.
    exact : tuple of int
        Columns with more digits than binary64 has.
    blocks : list of Block
        What has been read.
    cut : InputError or None
        The error of a row that may be the last one, and incomplete.
    """

    request: Request
    dialect: Dialect
    width: int
    line: int
    names: list[str] | None
    heading: int | None
    time: int
    exact: tuple[int, ...]
    blocks: list[Block] = field(default_factory=list)
    cut: InputError | None = None

    def read(self, text: str) -> None:
        """Take the rows of the next block of lines."""
        samples = _COUNTED_LATER if self.blocks else _COUNTED
        plain = text.rstrip("\n").encode().translate(_PLAIN[self.dialect.decimal]) + b"\n"
        separator, exact = self.dialect.separator.encode(), {self.time, *self.exact}
        block = None if self.cut else parse_block(plain, self.width, separator, exact, samples)
        if block is None:
            block = _read_lines(self._line_by_line(text), self.width, "", exact, samples)
        if block is not None:
            self.blocks.append(replace(block, lines=block.lines + self.line + 1))
        self.line += text.count("\n")

    def finish(self) -> Vectors:
        """The table, when all blocks have been read."""
        seen: tuple[Evidence, ...] = ()
        if self.cut is not None:
            seen = (LastRowIncomplete(self.cut.line),)
        blocks, columns = self.blocks, []
        for j in range(self.width):
            has_rest = j in blocks[0].lo
            lo = np.concatenate([block.lo.pop(j) for block in blocks]) if has_rest else None
            values = _together([block.values for block in blocks], j)
            written = chain.from_iterable(block.written[j] for block in blocks)
            columns.append(written_column(values, lo, written, j == self.time))
        columns = evened(columns, self.time)
        if self.time in self.exact:
            columns[self.time] = replace(columns[self.time], significant=None)
        lines = np.concatenate([block.lines for block in blocks])
        return Vectors(columns, self.names, lines, self.heading, seen=seen)

    def _line_by_line(self, text: str) -> list[str]:
        """The lines as plain decimals, or blank; only the last row may be incomplete.

        What is not finite is too large.
        """
        dialect, width = self.dialect, self.width
        lines = text.split("\n")
        for i, line in enumerate(lines):
            fields = dialect.split(without_comment(line))
            lines[i] = ""
            if not any(fields):
                continue
            if self.cut is not None:
                raise self.cut
            row = dialect.numbers(fields)
            numbers = [x for x in row if x is not None]
            if len(numbers) == len(fields) == width:
                lines[i] = " ".join(numbers).lower().replace("nan", "8e888")
                continue
            error = row_error(fields, row, width, self.request, self.line + i + 1)
            if not dialect.is_cut(fields, width, at_end=i == len(lines) - 1):
                raise error
            self.cut = error
        return lines


def _together(blocks: Sequence[list[Array]], j: int) -> Array:
    """A column of all blocks, which no longer hold it: a long file is in memory once."""
    whole = np.concatenate([values[j] for values in blocks])
    for values in blocks:
        values[j] = whole[:0]
    return whole
