"""Digits: the resolution of the numbers in a column.

The resolution is the distance of neighbouring numbers that can be written. Decimals have a fixed
number of places, or of significant digits. Binary numbers have 53 bits, or 24 if all of them are
single precision numbers. 17 significant digits distinguish any two binary64 numbers, 9 any two
single precision numbers (IEEE 754-2019, section 5.12.2).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import floor, isfinite, log10

import numpy as np

from heyoka_bike.numbers.double import Array, divide, multiply
from heyoka_bike.scoring.reading.results import Quantum
from heyoka_bike.scoring.reading.table import ReadColumn

BINARY64_DIGITS = 17
"""Decimal digits that distinguish any two binary64 numbers."""

# Number of decimal digits, rounded to an integer, by the number of significant bits of the usual
# binary formats.
_DIGITS_OF_BITS = {11: 3, 24: 7, 53: 16, 64: 19, 113: 34}
# Minimum number of decimal digits that distinguish any two single-precision numbers.
_SINGLE_DIGITS = 9
# Minimum number of different decimals that show whether a column contains rounded single-precision
# numbers.
_ENOUGH_SINGLE = 20
# A column is read as written with d digits if the probability that all its numbers have at most d
# digits by chance is below 10^-_LOG_OF_CHANCE. At most _ENOUGH_SHORT numbers are examined.
_LOG_OF_CHANCE, _ENOUGH_SHORT = 6.0, 1000


def significant(number: str) -> str:
    """Return the significant digits of a written decimal, including zeros at the end."""
    mantissa = number.replace("E", "e").partition("e")[0]
    return mantissa.lstrip("+-0.").replace(".", "")


def places_of(number: str) -> int:
    """Return the number of digits after the decimal point; -1 for a number with an exponent."""
    return -1 if "e" in number else len(number.partition(".")[2])


def are_beyond_binary64(numbers: Sequence[str], is_time: bool) -> bool:
    """True if numbers contain more digits than binary64, and not only digits without meaning.

    A program may print a binary64 number with more digits than it has. With 18 digits, one decimal
    in ten equals a printed binary64 number by chance. So numbers count as printed binary64 only if
    at least five have such digits, and all of these equal a binary64 number. One time suffices,
    because a file may have few times.
    """
    long = [x for x in numbers if len(significant(x)) > BINARY64_DIGITS]
    # The savetxt of NumPy writes 0.1 as 1.000000000000000056e-01, which contains no more
    # information than binary64.
    are_written_out = len(long) >= (1 if is_time else 5) and all(
        significant(f"{float(x):.{len(significant(x)) - 1}e}") == significant(x) for x in long
    )
    return bool(long) and not are_written_out


def written_column(
    values: Array, lo: Array | None, written: Iterable[str], is_time: bool
) -> ReadColumn:
    """Return a column of decimals, with the resolution inferred from its written numbers."""
    finite = [x for x in written if isfinite(float(x))]
    digits = max((len(significant(x)) for x in finite), default=0)
    places = {places_of(x) for x in finite} or {-1}
    fewest, most = min(places), max(places)
    largest = _largest(values)
    varies = _tells_digits(values, lo, digits)
    # Times such as 0.07 and 10 are written to the same number of decimal places, because programs
    # omit zeros at the end.
    is_fixed_time = is_time and fewest >= 0 and digits < BINARY64_DIGITS
    if (is_fixed_time or fewest == most >= 0) and varies and 10.0**-most >= np.spacing(largest):
        count = max(1, floor(log10(largest)) + 1 + most)
        return ReadColumn(values, lo, Quantum(10, places=most), count, digits)
    if _SINGLE_DIGITS <= digits < BINARY64_DIGITS and _are_single_written(values, digits):
        # These are single-precision numbers, printed with more digits than single precision has.
        return ReadColumn(values, lo, Quantum(2, digits=24), _DIGITS_OF_BITS[24], digits)
    # Times always have the low part `lo`, so `lo` alone does not indicate more digits than
    # binary64.
    if 0 < digits < BINARY64_DIGITS or (lo is not None and digits > BINARY64_DIGITS):
        quantum, known = Quantum(10, digits=digits), digits
    else:
        bits = binary_digits(values) if varies else 53
        quantum = Quantum(2, digits=bits)
        known = BINARY64_DIGITS if bits == 53 else _DIGITS_OF_BITS[bits]
    return ReadColumn(values, lo, quantum, known if varies else None, digits)


def times_power_of_ten(column: ReadColumn, power: int) -> ReadColumn:
    """Return the column multiplied by 10^power, with the same number of written digits."""
    values, lo, ten = column.values, column.lo, np.full(len(column.values), 10.0 ** abs(power))
    both = values, np.zeros_like(values) if lo is None else lo
    hi, rest = multiply(both, (ten, np.zeros_like(ten))) if power > 0 else divide(both, ten)
    quantum = column.quantum
    if quantum.base == 10 and quantum.places is not None:
        quantum = replace(quantum, places=quantum.places - power)
    return replace(column, values=hi, lo=None if lo is None else rest, quantum=quantum)


def _tells_digits(values: Array, lo: Array | None, digits: int) -> bool:
    """True if the numbers show how many digits are written; False for a constant column.

    A few numbers with nearly as many digits as binary64 needs may be short by chance: for each
    missing digit, the probability is one in ten.
    """
    if not len(values) or _is_constant(values, lo):
        return False
    some = np.array([x for x in {*values[:_ENOUGH_SHORT].tolist()} if x and np.isfinite(x)])
    if digits >= BINARY64_DIGITS or not some.size:
        return True
    last = np.floor(np.log10(np.abs(some))) + 1 - digits
    missing = last - np.log10(np.spacing(np.abs(some)))
    return float(np.maximum(missing, 0.0).sum()) > _LOG_OF_CHANCE


def evened(columns: list[ReadColumn], time: int) -> list[ReadColumn]:
    """Give the constant columns of a table the finest resolution of its other columns."""
    varying = [w for j, w in enumerate(columns) if j != time and w.digits is not None]
    if not varying:
        return columns
    finest = max(varying, key=lambda w: w.digits or 0).quantum
    return [w if w.digits is not None else replace(w, quantum=finest) for w in columns]


def binary_column(values: Array, lo: Array | None, bits: int) -> ReadColumn:
    """Return a column of binary numbers with this many significant bits."""
    if bits == 53:
        bits = binary_digits(values)
    varies = bool(len(values)) and not _is_constant(values, lo)
    digits = _DIGITS_OF_BITS.get(bits, floor(bits * log10(2)))
    return ReadColumn(values, lo, Quantum(2, digits=bits), digits if varies else None)


def column_of_steps(values: Array, step: float) -> ReadColumn:
    """Return a column whose values are multiples of a step."""
    quantum = Quantum(2, places=0, step=abs(step))
    digits = floor(log10(max(_largest(values) / quantum.step, 1.0))) + 1
    return ReadColumn(values, None, quantum, None if _is_constant(values, None) else digits)


def binary_digits(values: Array) -> int:
    """Return 24 if all values are single-precision numbers and not all are integers; else 53."""
    finite = values[np.isfinite(values)]
    return 24 if are_single(values) and (finite != np.rint(finite)).any() else 53


def are_single(values: Array) -> bool:
    """True if all finite values are single-precision numbers."""
    return bool(((as_single(values) == values) | ~np.isfinite(values)).all())


def _are_single_written(values: Array, digits: int) -> bool:
    """True if decimals are single-precision numbers, rounded to this many digits.

    With nine digits, one decimal in ten is near a single-precision number by chance. So many
    different decimals have to be near one.
    """
    some = np.sort(values[np.isfinite(values) & (values != np.rint(values))])
    if np.count_nonzero(np.diff(some)) + 1 < _ENOUGH_SINGLE:
        return False
    # A decimal differs from the number that it stands for by at most half a unit of its last digit,
    # plus the error of reading it into binary64.
    nearest = 0.501 * Quantum(10, digits=digits).at(some)
    return bool((np.abs(some - as_single(some)) <= nearest).all())


def as_single(values: Array) -> Array:
    """Return the values rounded to single precision."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return values.astype(np.float32).astype(np.float64)


def _is_constant(values: Array, lo: Array | None) -> bool:
    known = np.isfinite(values)
    first = int(np.argmax(known))
    same = values == values[first]
    if lo is not None:
        same &= lo == lo[first]
    return bool((same | ~known).all())


def _largest(values: Array) -> float:
    known = np.isfinite(values)
    return max(np.max(values, where=known, initial=0.0), -np.min(values, where=known, initial=0.0))
