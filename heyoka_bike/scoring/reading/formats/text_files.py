"""Read text files: rows of numbers, and other tables.

The rows of a table may contain labels, names and units, and each column may be a line.
"""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise, takewhile

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.evidence.as_read import Transposed
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.encodings import whole_lines
from heyoka_bike.scoring.reading.names.heading import are_names
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.text.dialects import DIALECTS, best_dialect, without_comment
from heyoka_bike.scoring.reading.text.displayed import has_blocks, side_by_side
from heyoka_bike.scoring.reading.text.headings import (
    COMMENT_SIGNS,
    headings_in,
    is_heading,
    with_units,
)
from heyoka_bike.scoring.reading.text.opening import MOST_ABOVE, MOST_COLUMNS
from heyoka_bike.scoring.reading.text.rows import first_block, read_rows
from heyoka_bike.scoring.reading.text_cells import read_words

# Marks of a text file that Octave wrote, and the number of bytes in which they are searched for. A
# file with only one matrix is read as rows of numbers, which begin within these bytes.
_OCTAVE, _VARIABLE_OF_OCTAVE, _BYTES_OF_BEGINNING = b"# Created by Octave", b"\n# name:", 400


def read(file: ResultFile) -> list[ReadTable]:
    """Return the tables in a text file; see `read_table`.

    Raises
    ------
    InputError
        There are no rows of numbers, or Octave wrote several variables with ``save -text``.
    """
    is_column = any(
        mark in file.head[:_BYTES_OF_BEGINNING] for mark in (b"_range\n", b"# columns: 1\n")
    )
    if file.head.startswith(_OCTAVE) and (is_column or file.head.count(_VARIABLE_OF_OCTAVE) > 1):
        raise file.request.error(
            "found variables of Octave's save -text, expected rows of numbers; save them with "
            "save -v7"
        )
    return read_table(file.text(), file.encoding, file.request)


def read_table(chunks: Iterable[bytes], encoding: str, request: Request) -> list[ReadTable]:
    """Return the tables in a text: rows of numbers, rows with words, or a line for each column.

    Parameters
    ----------
    chunks, encoding, request
        As in `text.rows.read_text`.

    Raises
    ------
    InputError
        The text contains no table; the error is that of `text.rows.read_rows`.
    """
    blocks = whole_lines(chunks, encoding, request)
    first, is_beyond_it = first_block(blocks, request), False
    if has_blocks(first):
        first, blocks = side_by_side("".join((first, *blocks)), request), iter(())

    def rest() -> Iterator[str]:
        nonlocal is_beyond_it
        for block in blocks:
            is_beyond_it = True
            yield block

    try:
        return [read_rows(first, rest(), request)]
    except InputError as error:
        # If the file contains words, they are in the first lines. The rest is not kept in memory,
        # because the file may be a long text of numbers.
        if is_beyond_it or not first.strip():
            raise
        lines = _contents("".join((first, *blocks)).split("\n"), request)
        for dialect in (x for x in DIALECTS if x.may_read(lines)):
            with suppress(InputError):
                if found := read_words(map(dialect.split, lines), request, dialect):
                    return found
        with suppress(InputError):
            if found := _read_upright(lines, request):
                return found
        raise error from None


def _contents(lines: list[str], request: Request) -> list[str]:
    """Return the lines without comments, but keep the last comment above them that is a heading."""
    found = [x for line in lines if (x := without_comment(line))]
    above = takewhile(lambda line: not without_comment(line), lines)
    for line in [line for line in above if line.strip()][: -MOST_ABOVE - 1 : -1]:
        plain = COMMENT_SIGNS.sub("", line, count=1)
        if any(is_heading(names, request) for names in headings_in(line)):
            return [plain, *found]
    return found


def _read_upright(lines: list[str], request: Request) -> list[ReadTable] | None:
    """Return the table of a text in which each line is a column; None for other texts.

    The lines begin with known names, or there are as many lines as a table may have columns and the
    numbers of the first line ascend. All other fields are numbers, and every line has equally many.
    """
    if named := _named_lines(lines, request):
        found = tables(named, request)
        seen = Transposed(len(named), len(next(iter(named.values()))))
        return [replace(found[0], seen=(*found[0].seen, seen)), *found[1:]]
    found_dialect = best_dialect(lines, ()) if len(lines) in request.widths else None
    if found_dialect is None or len(found_dialect[2]) != len(lines):
        return None
    dialect = found_dialect[0]
    columns = [[dialect.number(field) or "" for field in dialect.split(line)] for line in lines]
    if not all(float(a) < float(b) for a, b in pairwise(columns[0])):
        return None
    return tables(np.array(columns, object), request)


def _named_lines(lines: list[str], request: Request) -> dict[str, NDArray[np.object_]]:
    """Return the numbers of each line by the name before them; an empty dict without names."""
    if request.names or not 1 < len(lines) <= MOST_COLUMNS:
        return {}
    for dialect in DIALECTS:
        if not dialect.may_read(lines):
            continue
        rows = [dialect.split(line) for line in lines]
        if len({*map(len, rows)}) > 1:
            continue
        numbers = [dialect.numbers(row) for row in rows]
        # Number of words before the numbers: one if a line has only a name, two if it has a name
        # and a unit.
        words = next((i for i, x in enumerate(numbers[0]) if x is not None), 0)
        are_numbers = all(not any(row[:words]) and all(row[words:]) for row in numbers)
        if words not in (1, 2) or not are_numbers:
            continue
        names = [row[0].strip("\"'") for row in rows]
        if words == 2:
            names = with_units(names, [row[1] for row in rows])
        if are_names(names, request):
            columns = [np.array(row[words:], object) for row in numbers]
            return request.by_name(zip(names, columns, strict=True))
    return {}
