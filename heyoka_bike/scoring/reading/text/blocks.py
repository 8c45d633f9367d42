"""Read blocks of lines as correctly rounded numbers, all lines of a block at once.

NumPy parses the numbers, in C. If anything in a block is unusual, `parse_block` returns None. Then
a slower reader reads the block, or reports the error.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array

Ints = NDArray[np.int64]
_OF_NUMBERS = b"0123456789.e+- \t\n"
# Decimal arithmetic with enough digits for the difference between any written decimal and its
# binary64 number, and without limits on the exponent.
_EXACT = Context(prec=1200, Emax=MAX_EMAX, Emin=MIN_EMIN, traps=[])


@dataclass(frozen=True, slots=True)
class Block:
    """The numbers of consecutive lines.

    Attributes
    ----------
    values : list of ndarray, shape (rows,)
        The numbers of each column, correctly rounded to binary64.
    lines : ndarray of int, shape (rows,)
        Index of the line of each row in the block.
    written : list of tuple of str
        For each column, the numbers of some of the rows as they are written.
    lo : mapping of int to ndarray, shape (rows,)
        For some columns, by index: the written decimals minus the values, correctly rounded.
    """

    values: list[Array]
    lines: Ints
    written: list[tuple[str, ...]]
    lo: dict[int, Array]


def parse_block(
    text: bytes, columns: int, separator: bytes, exact: Collection[int], samples: int
) -> Block | None:
    """Read the lines of a block of plain decimals; None if anything in it is unusual.

    Parameters
    ----------
    text
        Lines, each ending in a line feed, with decimal points and the exponent letter e.
    columns
        Numbers in each line that is not blank.
    separator
        Sign between the numbers, besides blanks; empty if only blanks separate them.
    exact
        Columns whose digits beyond binary64 are needed.
    samples
        Approximate number of rows whose written numbers are returned.

    Returns
    -------
    Block or None
        None if anything in the text is not as described.
    """
    if not text.endswith(b"\n") or text.translate(None, _OF_NUMBERS + separator):
        return None
    try:
        return read_lines(text.decode().split("\n"), columns, separator.decode(), exact, samples)
    except ValueError:
        return None


def read_lines(
    lines: Sequence[str], columns: int, separator: str, exact: Collection[int], samples: int
) -> Block | None:
    """Read lines of plain decimals as `parse_block` does; None if all of them are blank.

    Raises
    ------
    ValueError
        A row has another number of columns, or contains something that is not a number.
    """
    rows = [line.rstrip().removesuffix(separator) for line in lines]
    at = np.flatnonzero([bool(row) for row in rows])
    rows = [row for row in rows if row]
    if not rows:
        return None
    mark = separator or None
    table = np.loadtxt(rows, comments=None, delimiter=mark, ndmin=2)
    if table.shape != (len(rows), columns):
        raise ValueError("rows with a wrong number of columns")
    values = [np.ascontiguousarray(column) for column in table.T]
    sampled = rows[:: max(1, len(rows) // samples)]
    written = [*zip(*([x.strip() for x in row.split(mark)] for row in sampled), strict=True)]
    lo = {j: rests((row.split(mark, j + 1)[j] for row in rows), values[j]) for j in exact}
    return Block(values, at, written, lo)


def rests(numbers: Iterable[str], values: Array) -> Array:
    """Return the `rest` of each decimal: the decimal minus its binary64 value."""
    return np.array([rest(x, hi) for x, hi in zip(numbers, values.tolist(), strict=True)])


def rest(number: str, hi: float) -> float:
    """Return a decimal minus its binary64 value, correctly rounded; 0 for zero and infinity."""
    if hi == 0.0 or not isfinite(hi):
        return 0.0
    return float(_EXACT.subtract(Decimal(number), Decimal.from_float(hi)))
