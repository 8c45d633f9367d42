"""The rows of a text, from blocks of lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence import Evidence, LastRowIncomplete
from heyoka_bike.scoring.reading.digits import evened, written_column
from heyoka_bike.scoring.reading.encodings import whole_lines
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.text.blocks import Block, parse_block, read_lines
from heyoka_bike.scoring.reading.text.dialects import without_comment
from heyoka_bike.scoring.reading.text.opening import Opening, open_text, row_error

# Rows of the first block of which digits are counted; of a later one, and by the slow reader.
_ROWS_COUNTED, _ROWS_COUNTED_LATER = 2000, 200
# Numbers as `parse_block` reads them; beside a decimal comma a point has no place.
_PLAIN_LETTERS = {
    ".": bytes.maketrans(b"EDdQq", b"eeeee"),
    ",": bytes.maketrans(b".,EDdQq", b"?.eeeee"),
}


def read_text(chunks: Iterable[bytes], encoding: str, request: Request) -> ReadTable:
    """Read rows of numbers.

    Parameters
    ----------
    chunks
        The text, cut anywhere.
    encoding
        See `encodings.encoding_of`.
    request
        The request to read it.

    Raises
    ------
    InputError
        Not rows of numbers: where, what was found, what was expected.
    """
    blocks = whole_lines(chunks, encoding, request)
    return read_rows(first_block(blocks), blocks, request)


def first_block(blocks: Iterator[str]) -> str:
    """The first block of whole lines in which there is anything."""
    first = next(blocks, "")
    while not first.strip() and (block := next(blocks, "")):
        first += block
    return first


def read_rows(first: str, blocks: Iterable[str], request: Request) -> ReadTable:
    """Read rows of numbers from blocks of whole lines, of which the first shows how they are.

    Raises
    ------
    InputError
        As of `read_text`.
    """
    opening = open_text(first, request)
    reader = RowReader(request, opening, opening.line)
    for block in chain([first.split("\n", opening.line)[-1]], blocks):
        reader.read(block)
    return reader.finish()


@dataclass(eq=False, slots=True)
class RowReader:
    """Reads rows from blocks of lines; the layout is that of the first lines.

    Attributes
    ----------
    request : Request
    opening : Opening
    line : int
        Number of lines before the next block; before the first row if there was none.
    blocks : list of Block
        What has been read.
    cut : InputError or None
        The error of a row that may be the last one, and incomplete.
    """

    request: Request
    opening: Opening
    line: int
    blocks: list[Block] = field(default_factory=list)
    cut: InputError | None = None

    def read(self, text: str) -> None:
        """Take the rows of the next block of lines."""
        samples = _ROWS_COUNTED_LATER if self.blocks else _ROWS_COUNTED
        plain = (
            text.rstrip("\n").encode().translate(_PLAIN_LETTERS[self.opening.dialect.decimal])
            + b"\n"
        )
        separator, exact = (
            self.opening.dialect.separator.encode(),
            {self.opening.time, *self.opening.exact},
        )
        block = (
            None if self.cut else parse_block(plain, self.opening.width, separator, exact, samples)
        )
        if block is None:
            block = read_lines(self._line_by_line(text), self.opening.width, "", exact, samples)
        if block is not None:
            self.blocks.append(replace(block, lines=block.lines + self.line + 1))
        self.line += text.count("\n")

    def finish(self) -> ReadTable:
        """The table, when all blocks have been read."""
        seen: tuple[Evidence, ...] = ()
        if self.cut is not None:
            seen = (LastRowIncomplete(self.cut.line),)
        blocks, columns = self.blocks, []
        for j in range(self.opening.width):
            has_rest = j in blocks[0].lo
            lo = np.concatenate([block.lo.pop(j) for block in blocks]) if has_rest else None
            values = _together([block.values for block in blocks], j)
            written = chain.from_iterable(block.written[j] for block in blocks)
            columns.append(written_column(values, lo, written, j == self.opening.time))
        columns = evened(columns, self.opening.time)
        if self.opening.time in self.opening.exact:
            columns[self.opening.time] = replace(columns[self.opening.time], significant=None)
        lines = np.concatenate([block.lines for block in blocks])
        return ReadTable(columns, self.opening.names, lines, self.opening.heading, seen=seen)

    def _line_by_line(self, text: str) -> list[str]:
        """The lines as plain decimals, or blank; only the last row may be incomplete.

        What is not finite is too large.
        """
        dialect, width = self.opening.dialect, self.opening.width
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
