"""A block of text lines as correctly rounded numbers, all at once.

A decimal is an integer times a power of ten. NumPy reads the integers ten times faster than
numbers with a point, and multiplies by the power in double-double arithmetic, about 32 digits: as
a rule that decides the rounding to binary64, and Python's `float` does the rest. Anything unusual
makes `parse_block` return None: another, slower reader then takes the block or names what is wrong.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cache
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, two_product, two_sum
from heyoka_bike.scoring.reading.quanta import significant

Ints = NDArray[np.int64]

_POINT, _E, _PLUS, _MINUS, _NEWLINE, _BLANK = b".e+-\n "
# Above this an integer may have been cut to int64's largest, 9.22e18, or its binary64 exceed that.
_LARGEST_INTEGER = 9 * 10**18
# Within this, products stay clear of overflow and their last digits of underflow.
_LARGEST_POWER = 250
NOTHING = -2
"""The digits after the point of what is not finite."""
# Powers of ten up to this are binary64 numbers, and remainders after dividing by them too.
_EXACT_POWER = 22
# The product has lost less than 2^-102 of itself.
_LOST = 2.0**-100
_DIGITS = 10 ** np.arange(19, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Block:
    """Numbers of consecutive lines.

    Attributes
    ----------
    values : ndarray, shape (columns, rows)
        Correctly rounded.
    lines : ndarray of int, shape (rows,)
        Index, in the block, of the line of each row.
    digits, places : ndarray of int, shape (columns, sampled rows)
        Significant digits written and digits after the point (-1 with an exponent, `NOTHING` if
        the value is not finite), of some of the rows.
    lo : mapping of int to ndarray, shape (rows,)
        By index of the column: the written decimal minus the value, correctly rounded.
    """

    values: Array
    lines: Ints
    digits: Ints
    places: Ints
    lo: dict[int, Array] = field(default_factory=dict)


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
    marks = _find_marks(text, columns, separator)
    if marks is None:
        return None
    numbers = _integers(text.replace(separator, b" ") if separator else text, marks)
    if numbers is None:
        return None
    mantissa, power = numbers
    value, odd = _product(mantissa, power)
    tokens = {int(i): _token(text, marks, int(i)) for i in odd}
    for i, token in tokens.items():
        value[i] = float(token)
    rows = len(mantissa) // columns
    values = np.ascontiguousarray(value.reshape(rows, columns).T)
    step = max(1, rows // samples)
    size = np.abs(np.clip(mantissa, -_LARGEST_INTEGER, _LARGEST_INTEGER))
    digits = np.searchsorted(_DIGITS, size, side="right")
    places = np.where(marks.exponent_at < 0, marks.places, -1)
    for i, token in tokens.items():
        digits[i] = len(significant(token))
        if not isfinite(value[i]):
            digits[i], places[i] = 0, NOTHING
    block = Block(
        values,
        marks.lines,
        digits.reshape(rows, columns)[::step].T.astype(np.int64),
        places.reshape(rows, columns)[::step].T.astype(np.int64),
    )
    certain = np.ones(len(mantissa), dtype=np.bool_)
    certain[odd] = False
    for j in exact:
        here = slice(j, None, columns)
        block.lo[j] = _remainder(mantissa[here], power[here], values[j], certain[here])
    for i, token in tokens.items():
        row, j = divmod(i, columns)
        if j in block.lo:
            block.lo[j][row] = rest(token, float(values[j, row]))
    return block


def rest(number: str, hi: float) -> float:
    """The decimal minus its binary64, correctly rounded; zero for zero and infinity."""
    if hi == 0.0 or not isfinite(hi):
        return 0.0
    Decimal, context = _decimal()
    return float(context.subtract(Decimal(number), Decimal(hi)))


@cache
def _decimal() -> tuple[Any, Any]:
    from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal

    # Enough digits for any binary64 without its leading ones; no exponent is too large.
    return Decimal, Context(prec=1200, Emax=MAX_EMAX, Emin=MIN_EMIN, traps=[])


@dataclass(frozen=True, slots=True)
class _Marks:
    """Where things are in the text: the ends of numbers, digits after the point, exponents."""

    ends: Ints
    places: Ints
    exponent_at: Ints
    """Position of the e of each number, -1 without."""
    lines: Ints


def _find_marks(text: bytes, columns: int, separator: bytes) -> _Marks | None:
    b = np.frombuffer(text, np.uint8)
    between = b <= _BLANK
    if separator:
        between |= b == separator[0]
    mark = (b == _POINT) | (b == _E)
    mark[1:] |= between[1:] > between[:-1]
    at = np.flatnonzero(mark)
    kind = b[at]
    is_end = between[at]
    end = np.flatnonzero(is_end)
    ends = at[end]
    newlines = np.flatnonzero(b == _NEWLINE)
    per_line = np.diff(np.searchsorted(ends, newlines, side="right"), prepend=0)
    lines = np.flatnonzero(per_line)
    if not (len(lines) and newlines[-1] == len(b) - 1 and (per_line[lines] == columns).all()):
        return None
    if separator and not _is_separated(b, ends, columns, separator[0]):
        return None
    # The marks of a number: a point or not, an e or not, its end.
    start = np.concatenate(([0], end[:-1] + 1))
    has_e = (kind[end - 1] == _E) & (end > start)
    point = end - 1 - has_e
    has_point = (point >= start) & (kind[point] == _POINT)
    if not (has_e.astype(np.int64) + has_point == end - start).all():
        return None
    exponent_at = np.where(has_e, at[end - 1], -1)
    places = np.where(has_point, np.where(has_e, exponent_at, ends) - at[point] - 1, 0)
    return _Marks(ends, places, exponent_at, lines)


def _is_separated(b: NDArray[np.uint8], ends: Ints, columns: int, separator: int) -> bool:
    """Whether there is one separator after each number, or each but the last of a row."""
    after = (b[ends] == separator).reshape(-1, columns)
    return bool(after[:, :-1].all() and after.sum() == np.count_nonzero(b == separator))


def _integers(text: bytes, marks: _Marks) -> tuple[Ints, Ints] | None:
    """Mantissa without its point, and power of ten, of each number."""
    has_e = marks.exponent_at >= 0
    exponents = np.count_nonzero(has_e)
    plain = text.replace(b".", b"")
    if exponents:
        plain = plain.replace(b"e", b" ")
    b = np.frombuffer(plain, np.uint8)
    sign = np.flatnonzero((b == _PLUS) | (b == _MINUS))
    # NumPy takes a lone sign for zero, or for that of the next number.
    if not (b[sign + 1] - 48 < 10).all():
        return None
    with warnings.catch_warnings():
        # Where it finds no integer NumPy stops, with an error or, in older versions, a warning.
        warnings.simplefilter("error", DeprecationWarning)
        try:
            found = np.fromstring(plain, dtype=np.int64, sep=" ")
        except (ValueError, DeprecationWarning):
            return None
    if len(found) != len(has_e) + exponents:
        return None
    if not exponents:
        return found, -marks.places
    at = np.arange(len(has_e)) + np.cumsum(has_e) - has_e
    power = -marks.places
    power[has_e] += np.clip(found[at[has_e] + 1], -(10**9), 10**9)
    return found[at], power


def _product(mantissa: Ints, power: Ints) -> tuple[Array, Ints]:
    """Mantissa 10^power rounded to binary64, and the indices where that is not certain."""
    # Some libraries cut at the least integer, which has no size in int64.
    odd = (mantissa > _LARGEST_INTEGER) | (mantissa < -_LARGEST_INTEGER)
    odd |= np.abs(power) > _LARGEST_POWER
    if odd.any():
        mantissa, power = np.where(odd, 0, mantissa), np.where(odd, 0, power)
    low, high = int(power.min()), int(power.max())
    table = np.array([_power_of_ten(q) for q in range(low, high + 1)])
    ten_hi, ten_lo = table[power - low].T
    hi = mantissa.astype(np.float64)
    lo = (mantissa - hi.astype(np.int64)).astype(np.float64)
    p, e = two_product(hi, ten_hi)
    value, left = two_sum(p, e + (hi * ten_lo + lo * ten_hi))
    lost = _LOST * np.abs(value)
    odd |= (value + (left + lost) != value) | (value + (left - lost) != value)
    return value, np.flatnonzero(odd)


@cache
def _power_of_ten(q: int) -> tuple[float, float]:
    if q >= 0:
        hi = float(10**q)
        return hi, float(10**q - int(hi))
    # A quotient of integers is correctly rounded.
    hi = 1 / 10**-q
    n, d = hi.as_integer_ratio()
    return hi, (d - n * 10**-q) / (d * 10**-q)


def _remainder(mantissa: Ints, power: Ints, value: Array, wanted: NDArray[np.bool_]) -> Array:
    """Mantissa 10^power minus its binary64, correctly rounded; zero where it is not wanted.

    With 10^s, s = -power up to 22, both m and v 10^s are multiples of ulp(v) 2^s, and differ by at
    most 5^22 / 2 < 2^53 of these: the difference is found without any rounding.
    """
    easy = wanted & (power <= 0) & (power >= -_EXACT_POWER)
    m = np.where(easy, mantissa, 0)
    ten = _TENS[np.where(easy, -power, 0)]
    hi = m.astype(np.float64)
    lo = (m - hi.astype(np.int64)).astype(np.float64)
    p, e = two_product(np.where(easy, value, 0.0), ten)
    left: Array = ((hi - p) + (lo - e)) / ten
    for i in np.flatnonzero(wanted & ~easy):
        left[i] = rest(f"{mantissa[i]}e{power[i]}", float(value[i]))
    return left


_TENS: Array = np.array([10.0**s for s in range(_EXACT_POWER + 1)])


def _token(text: bytes, marks: _Marks, i: int) -> str:
    start = int(marks.ends[i - 1]) if i else 0
    return text[start : int(marks.ends[i])].decode("ascii").strip(" \t\n,;")
