"""Texts: rows of numbers, and other tables.

Labels, names and units may stand in the rows of a table, and its columns may be in lines.
"""

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.arrays import long_columns, tables
from heyoka_bike.scoring.reading.headings import TIME, are_names, group_number, recognise
from heyoka_bike.scoring.reading.request import Request, ResultFile, whole_lines
from heyoka_bike.scoring.reading.results import Vectors
from heyoka_bike.scoring.reading.text import (
    DIALECTS,
    Dialect,
    best_dialect,
    read_text,
    without_comment,
)

# One matrix alone is rows of numbers, and these begin early.
_OCTAVE, _VARIABLE, _SHORT = b"# Created by Octave", b"\n# name:", 400
_MANEUVER = "maneuver"
# A duration of MATLAB, of less than a minute.
_DURATION = re.compile(r"(?:0+:0+:)?([0-9.]+(?:[eE][-+]?[0-9]+)?)(?: ?(?:s|sec|secs|seconds))?")


def read(file: ResultFile) -> list[Vectors]:
    """The rows of a text; see `read_table`.

    Raises
    ------
    InputError
        No rows of numbers, or the variables that Octave writes with ``save -text``.
    """
    is_column = any(mark in file.head[:_SHORT] for mark in (b"_range\n", b"# columns: 1\n"))
    if file.head.startswith(_OCTAVE) and (is_column or file.head.count(_VARIABLE) > 1):
        raise file.request.error(
            "found variables of Octave's save -text, expected rows of numbers; save -v7 writes "
            "variables that are read"
        )
    return read_table(file.text(), file.encoding, file.request)


def read_table(chunks: Iterable[bytes], encoding: str, request: Request) -> list[Vectors]:
    """The tables in a text: rows of numbers, the same on its side, or with words in its rows.

    Parameters
    ----------
    chunks, encoding, request
        As in `text.read_text`.

    Raises
    ------
    InputError
        None of that: what `text.read_text` says.
    """
    rest = iter(chunks)
    pulled: list[bytes] = []

    def first() -> Iterator[bytes]:
        for chunk in rest:
            # No more is kept of a long text; words begin in its first lines.
            pulled[:] = [chunk] if not pulled else [b"", b""]
            yield chunk

    try:
        return [read_text(first(), encoding, request)]
    except InputError as error:
        if len(pulled) == 1:
            text = "".join(whole_lines(chain(pulled, rest), encoding, request))
            lines = [x for line in text.split("\n") if (x := without_comment(line))]
            for read in (_read_words, _read_upright):
                with suppress(InputError):
                    if found := read(lines, request):
                        return found
        raise error from None


def _read_words(lines: list[str], request: Request) -> list[Vectors] | None:
    """The tables in columns of words and numbers below a line of their names; None without one."""
    for dialect in DIALECTS:
        if columns := _columns(lines, dialect, request):
            return tables(columns, request)
    return None


def _columns(
    lines: list[str], dialect: Dialect, request: Request
) -> dict[str, NDArray[np.object_]] | None:
    """Cells by the names of their columns; None if lines have not all as many."""
    names, number = [TIME, *BENCHMARK_COLUMNS], None
    rows: list[list[Any]] = []
    for line in lines:
        fields = [field.strip("\"'") for field in dialect.split(line)]
        if not rows and (are_names(fields, request) or long_columns(fields)):
            names = fields
        elif (label := group_number(line.strip("[]():;,=-\"' "))) is not None:
            number = label
        elif fields == names:
            continue
        elif len(fields) == len(names):
            rows.append(
                [*(_plain(*cell, dialect) for cell in zip(names, fields, strict=True)), number]
            )
        else:
            return None
    columns = zip([*names, _MANEUVER], zip(*rows, strict=True), strict=False)
    found = {name: np.array(x, object) for name, x in columns if name != _MANEUVER or x[0]}
    return found if len({*names}) == len(names) else None


def _plain(name: str, cell: str, dialect: Dialect) -> str:
    """A number as `float` reads it, a time without its unit; a word as it is."""
    found = recognise(name)
    match = _DURATION.fullmatch(cell) if found and found[0] == TIME else None
    return dialect.number(match[1] if match else cell) or cell


def _read_upright(lines: list[str], request: Request) -> list[Vectors] | None:
    """The table of a text that is on its side; None if it is not.

    It is if it has as many lines as there may be columns, all of them numbers, as many in each, and
    those of the first one ascend.
    """
    found = best_dialect(lines, ()) if len(lines) in request.widths else None
    if found is None or len(found[2]) != len(lines):
        return None
    dialect = found[0]
    columns = [[dialect.number(field) or "" for field in dialect.split(line)] for line in lines]
    if not all(float(a) < float(b) for a, b in pairwise(columns[0])):
        return None
    return tables(np.array(columns, object), request)
