"""Tables with words in some columns, or with names of maneuvers between their rows.

The rows are lines of a text, already split into cells, or rows of a sheet.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.reading.arrays.long_tables import long_columns
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.names.heading import TIME, group_number, is_time
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.scoring.reading.text.dialects import Dialect, is_number
from heyoka_bike.scoring.reading.text.headings import COMMENT_SIGNS, heading_among
from heyoka_bike.scoring.reading.text.opening import MOST_ABOVE, MOST_COLUMNS

_MANEUVER = "maneuver"
# Maximum number of lines above the rows that are kept: a title, several lines of names, and units.
_MOST_ABOVE = 20
_AROUND_LABELS = "[]():;,=-\"' "
# A duration of less than a minute in the form that MATLAB or pandas writes.
_PATTERN_OF_DURATION = re.compile(
    r"(?:0+ days? \+?)?(?:0+:0+:)?([0-9.]+(?:[eE][-+]?[0-9]+)?)(?: ?(?:s|sec|secs|seconds))?"
)


def read_words(
    rows: Iterable[Sequence[Any]], request: Request, dialect: Dialect
) -> list[ReadTable] | None:
    """Return tables of words and numbers below a line of column names; None if there are none.

    Parameters
    ----------
    rows
        Cells of each row: numbers, words, and None for empty cells. A row with one cell may name
        the maneuver of the rows below it.
    request
        The request to read them.
    dialect
        How words are converted to numbers.
    """
    columns = _columns(rows, request, dialect)
    return tables(columns, request) if columns else None


def _columns(
    rows: Iterable[Sequence[Any]], request: Request, dialect: Dialect
) -> dict[str, NDArray[np.object_]] | None:
    """Return the cells of each column by name; None if the rows do not form a table."""
    names: list[str] = []
    maneuver = None
    found: list[list[Any]] = []
    above: list[list[str]] = []
    for i, row in enumerate(rows):
        if len(row) > MOST_COLUMNS or (i > MOST_ABOVE and not found):
            return None
        words = [_word(x) for x in row]
        cells = zip(row, words, strict=True)
        has_number = any(is_number(x) or dialect.number(word) for x, word in cells)
        if not found and len(row) > 1 and not has_number:
            # This line above the rows contains names, parts of names, or units.
            above = [*above[1 - _MOST_ABOVE :], words]
        elif (label := group_number(" ".join(words).strip(_AROUND_LABELS))) is not None:
            maneuver = label
        elif words in above:
            continue
        elif len(words) == len(names := names or _names(above, len(words), request)):
            named = zip(names, row, words, strict=True)
            found.append([*(_plain(*cell, dialect) for cell in named), maneuver])
        else:
            return None
    columns = zip([*names, _MANEUVER], zip(*found, strict=True), strict=False)
    held = {name: np.array(x, object) for name, x in columns if name != _MANEUVER or x[0]}
    return held if len({*names}) == len(names) else None


def _names(above: Sequence[list[str]], width: int, request: Request) -> list[str]:
    """Return the names above rows with this many cells, or else the names of the benchmark."""
    names, _ = heading_among({i: [words] for i, words in enumerate(above)}, width, request)
    long = (words for words in reversed(above) if len(words) == width and long_columns(words))
    return names or next(long, [TIME, *BENCHMARK_COLUMNS])


def _plain(name: str, cell: Any, word: str, dialect: Dialect) -> Any:
    """Return a number unchanged, a number in words as a decimal without unit, or else the word."""
    if is_number(cell):
        return cell
    match = _PATTERN_OF_DURATION.fullmatch(word) if is_time(name) else None
    return dialect.number(match[1] if match else word) or word


def _word(cell: Any) -> str:
    text = "" if cell is None else " ".join(str(cell).split())
    return COMMENT_SIGNS.sub("", text, count=1).strip("\"'") if text[:1] in "#%\"'" else text
