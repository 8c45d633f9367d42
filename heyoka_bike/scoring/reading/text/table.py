"""Rows of numbers in a text, in whatever way programs write them."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.findings import Finding, warning
from heyoka_bike.scoring.reading.quanta import evened, written_column
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.text.blocks import Block, parse_block, plain_row, read_rows
from heyoka_bike.scoring.reading.text.dialects import without_comment
from heyoka_bike.scoring.reading.text.lines import whole_lines
from heyoka_bike.scoring.reading.text.opening import Opening, find_opening, row_error
from heyoka_bike.scoring.reading.vectors import Vectors

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
        See `text.lines.encoding_of`.
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
    reader = _Reader(request, find_opening(first, request))
    for block in chain([first], blocks):
        reader.read(block)
    return reader.finish()


class _Reader:
    """Rows of one dialect, from blocks of lines."""

    def __init__(self, request: Request, opening: Opening) -> None:
        self.request = request
        self.opening = opening
        self.exact = sorted({opening.time, *opening.exact})
        self.blocks: list[Block] = []
        self.line = 0
        self.cut: InputError | None = None

    def read(self, text: str) -> None:
        """Take the rows of the next block of lines."""
        if self.line == 0:
            self.line = self.opening.skip
            text = text.split("\n", self.line)[-1]
        dialect, width = self.opening.dialect, self.opening.width
        samples = _COUNTED_LATER if self.blocks else _COUNTED
        plain = text.rstrip("\n").encode().translate(_PLAIN[dialect.decimal]) + b"\n"
        separator = dialect.separator.encode()
        block = None if self.cut else parse_block(plain, width, separator, self.exact, samples)
        if block is None:
            rows = self._line_by_line(text)
            lines = np.array(list(rows), dtype=np.int64)
            block = read_rows(list(rows.values()), lines, None, width, self.exact, samples)
        self.blocks.append(replace(block, lines=block.lines + self.line + 1))
        self.line += text.count("\n")

    def finish(self) -> Vectors:
        """The table, when all blocks have been read."""
        findings: tuple[Finding, ...] = ()
        if self.cut is not None:
            number = self.cut.line
            said = f"The last row (line {number}) is not complete and left out."
            findings = (warning("last_row_incomplete", said, line=number),)
        opening, blocks = self.opening, self.blocks
        columns = []
        for j in range(opening.width):
            lo = np.concatenate([block.lo.pop(j) for block in blocks]) if j in self.exact else None
            values = _together([block.values for block in blocks], j)
            written = chain.from_iterable(block.written[j] for block in blocks)
            columns.append(written_column(values, lo, written, j == opening.time))
        columns = evened(columns, opening.time)
        if opening.time in opening.exact:
            columns[opening.time] = columns[opening.time].with_exact_values()
        lines = np.concatenate([block.lines for block in blocks])
        return Vectors(columns, opening.names, lines, opening.heading, findings=findings)

    def _line_by_line(self, text: str) -> dict[int, str]:
        """Rows of plain decimals, by index of the line; only the last one may be incomplete."""
        dialect, width = self.opening.dialect, self.opening.width
        lines = text.split("\n")
        rows = {}
        for i, line in enumerate(lines):
            fields = dialect.split(without_comment(line))
            if not any(fields):
                continue
            if self.cut is not None:
                raise self.cut
            row = dialect.numbers(fields)
            numbers = [x for x in row if x is not None]
            if len(numbers) == len(fields) == width:
                rows[i] = plain_row(numbers)
                continue
            error = row_error(fields, row, width, self.request, self.line + i + 1)
            if not dialect.is_cut(fields, width, at_end=i == len(lines) - 1):
                raise error
            self.cut = error
        return rows


def _together(blocks: Sequence[list[Array]], j: int) -> Array:
    """A column of all blocks, which no longer hold it: a long file is in memory once."""
    whole = np.concatenate([values[j] for values in blocks])
    for values in blocks:
        values[j] = whole[:0]
    return whole
