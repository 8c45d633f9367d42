"""Read the rows of a text from blocks of lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence.as_read import CommonFactor, LastRowIncomplete
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.reading.digits import evened, times_power_of_ten, written_column
from heyoka_bike.scoring.reading.encodings import whole_lines
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.text.blocks import Block, parse_block, read_lines
from heyoka_bike.scoring.reading.text.opening import (
    MOST_COLUMNS,
    TEXT,
    Opening,
    looks_like_row,
    opened,
    row_error,
)

# Number of rows whose digits are counted: first in the first block, then in each later block. The
# second number also applies to a block that is read line by line.
_ROWS_COUNTED, _ROWS_COUNTED_LATER = 2000, 200
# Maximum number of fields in a line. It exceeds the maximum number of columns, because quotes and
# blanks at the ends may add fields.
_MOST_FIELDS = 4 * MOST_COLUMNS
# Translation of numbers to the form that `parse_block` reads, by the decimal sign. With a decimal
# comma, a point is not part of a number.
_PLAIN_LETTERS = {
    ".": bytes.maketrans(b"EDdQq", b"eeeee"),
    ",": bytes.maketrans(b".,EDdQq", b"?.eeeee"),
}


def read_text(chunks: Iterable[bytes], encoding: str, request: Request) -> ReadTable:
    """Read rows of numbers.

    Parameters
    ----------
    chunks
        The parts of the text, which may end anywhere in a line.
    encoding
        See `encodings.encoding_of`.
    request
        The request to read it.

    Raises
    ------
    InputError
        The text does not consist of rows of numbers.
    """
    blocks = whole_lines(chunks, encoding, request)
    return read_rows(first_block(blocks, request), blocks, request)


def first_block(blocks: Iterator[str], request: Request) -> str:
    """Return the first blocks of whole lines, up to the first block that is not blank.

    Raises
    ------
    InputError
        A line has far more fields than a table may have columns.
    """
    read = []
    for block in blocks:
        read.append(block)
        if block.strip():
            break
    first = "".join(read)
    for i, line in enumerate(first.split("\n")):
        if len(line) > _MOST_FIELDS and (count := _fields_at_most(line)) > _MOST_FIELDS:
            said = f"found {count} columns, expected at most {MOST_COLUMNS}"
            raise request.error(said, i + 1)
    return first


def _fields_at_most(line: str) -> int:
    """Return the largest number of fields that any separator or quote makes of a line."""
    return max(len(line.split()), *(line.count(sign) + 1 for sign in ",;\t\"'"))


def read_rows(first: str, blocks: Iterable[str], request: Request) -> ReadTable:
    """Read rows of numbers from blocks of whole lines; the first block shows their form.

    Raises
    ------
    InputError
        As in `read_text`.
    """
    opening = opened(first.split("\n"), TEXT, request)
    reader = RowReader(request, opening, opening.line)
    for block in chain([first.split("\n", opening.line)[-1]], blocks):
        reader.read(block)
    return reader.finish()


@dataclass(eq=False, slots=True)
class RowReader:
    """Reads rows from blocks of lines; the first lines determine the form of the rows.

    Attributes
    ----------
    request : Request
    opening : Opening
    line : int
        Number of lines before the next block.
    blocks : list of Block
        The blocks that have been read.
    cut : InputError or None
        The error of an incomplete row, which is accepted only at the end of the text.
    """

    request: Request
    opening: Opening
    line: int
    blocks: list[Block] = field(default_factory=list)
    cut: InputError | None = None

    def read(self, text: str) -> None:
        """Read the rows in the next block of lines."""
        opening = self.opening
        samples = _ROWS_COUNTED_LATER if self.blocks else _ROWS_COUNTED
        letters, separator = _PLAIN_LETTERS[opening.dialect.decimal], opening.dialect.separator
        plain = _unquoted(text.rstrip("\n"), separator).encode().translate(letters) + b"\n"
        exact, block = {opening.time, *opening.exact}, None
        if self.cut is None:
            block = parse_block(plain, opening.width, separator.encode(), exact, samples)
        if block is None:
            block = read_lines(self._line_by_line(text), opening.width, "", exact, samples)
        if block is not None:
            self.blocks.append(replace(block, lines=block.lines + self.line + 1))
        self.line += text.count("\n")

    def finish(self) -> ReadTable:
        """Return the table of all blocks that were read."""
        opening = self.opening
        seen: tuple[Evidence, ...] = opening.skipped.evidence()
        if self.cut is not None:
            seen += (LastRowIncomplete(self.cut.line),)
        blocks, columns = self.blocks, []
        for j in range(opening.width):
            has_rest = j in blocks[0].lo
            lo = np.concatenate([block.lo.pop(j) for block in blocks]) if has_rest else None
            values = _together([block.values for block in blocks], j)
            written = chain.from_iterable(block.written[j] for block in blocks)
            columns.append(written_column(values, lo, written, j == opening.time))
        columns = evened(columns, opening.time)
        if opening.time in opening.exact:
            columns[opening.time] = replace(columns[opening.time], significant=None)
        if opening.power:
            seen += (CommonFactor(opening.power),)
            columns = [times_power_of_ten(column, opening.power) for column in columns]
        lines = np.concatenate([block.lines for block in blocks])
        return ReadTable(
            columns,
            opening.names,
            lines,
            opening.heading,
            commented=opening.maneuver,
            seen=seen,
        )

    def _line_by_line(self, text: str) -> list[str]:
        """Return lines as plain decimals, or blank; a value that is not finite becomes 8e888."""
        lines, number = text.split("\n"), self.line + 1
        rows, self.cut = decimals_of(lines, self.opening, number, self.request, self.cut)
        # The last row is not reported as skipped if it is incomplete, because there is a separate
        # message for this.
        last = None if self.cut is None else self.cut.line
        for i, (row, line) in enumerate(zip(rows, lines, strict=True), number):
            if not row and i != last and looks_like_row(line, self.opening):
                self.opening.skipped.add(i, line)
        return [" ".join(row).lower().replace("nan", "8e888") for row in rows]


def decimals_of(
    lines: Sequence[Any], opening: Opening, number: int, request: Request,
    cut: InputError | None = None,
) -> tuple[list[list[str]], InputError | None]:  # fmt: skip
    """Return the numbers in each line, none for a blank line; only the last row may be incomplete.

    Parameters
    ----------
    lines
        Lines after the heading.
    opening
        How the rows are written.
    number
        Number of the first of these lines, from 1.
    request
        The request to read them.
    cut
        The error of an incomplete row before these lines.

    Returns
    -------
    (list of list of str, InputError or None)
        The numbers, and the error of an incomplete last row, which may be the end of the text.

    Raises
    ------
    InputError
        A line is not a row.
    """
    dialect, width = opening.dialect, opening.width
    found: list[list[str]] = []
    for i, line in enumerate(lines):
        content = opening.notation.without_comment(line)
        fields = dialect.split(content)
        found.append([])
        if fields.count("") == len(fields):
            continue
        if cut is not None:
            raise cut
        row = dialect.numbers(fields)
        numbers = [x for x in row if x is not None]
        if len(numbers) == len(fields) == width:
            found[-1] = numbers
            continue
        cut = row_error(content, dialect, width, request, number + i)
        if not dialect.is_cut(fields, width, at_end=i == len(lines) - 1):
            raise cut
    return found, cut


def _unquoted(text: str, separator: str) -> str:
    """Return the lines without quotes around their fields, if all fields are quoted."""
    for quote in "\"'":
        if separator and len(text) > 1 and text[0] == text[-1] == quote:
            plain = text.replace(f"{quote}\n{quote}", "\n")[1:-1]
            return plain.replace(f"{quote}{separator}{quote}", separator)
    return text


def _together(blocks: Sequence[list[Array]], j: int) -> Array:
    """Join a column of all blocks, and remove it from the blocks to save memory."""
    whole = np.concatenate([values[j] for values in blocks])
    for values in blocks:
        values[j] = whole[:0]
    return whole
