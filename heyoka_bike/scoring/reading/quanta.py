"""How finely columns are written, and the exact decimals that their times mean."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import floor, isfinite, log10

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, divide, two_product
from heyoka_bike.scoring.evidence import Evidence, TimesAsDecimals, TimesRepeated, TimesUnsorted
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.results import Quantum, Vector, Vectors

BINARY64_DIGITS = 17
"""Decimal digits that tell any two binary64 numbers apart."""
# Decimal digits of the usual binary formats, to the nearest.
_DIGITS_OF_BITS = {11: 3, 24: 7, 53: 16, 64: 19, 113: 34}

# With fewer decimal digits single precision numbers are no longer told apart.
_SINGLE_DIGITS = 9
_ENOUGH_SINGLE = 20
# Numbers are not all as short by chance once in 10 to this power; so many are looked at.
_BY_CHANCE, _ENOUGH_SHORT = 6.0, 1000


def significant(number: str) -> str:
    """Significant digits written in a decimal, zeros at the end included."""
    mantissa = number.replace("E", "e").partition("e")[0]
    return mantissa.lstrip("+-0.").replace(".", "")


def places_of(number: str) -> int:
    """Digits written after the point of a decimal; -1 with an exponent."""
    return -1 if "e" in number else len(number.partition(".")[2])


def are_beyond_binary64(numbers: Sequence[str], is_time: bool) -> bool:
    """True if numbers have more digits than binary64, and not just more than it needs.

    Of 18 digits, one in ten agrees by chance with what the nearest binary64 would give: so many
    must agree. Of times one is enough: three rows in a row are no accident, and there may be no
    more.
    """
    long = [x for x in numbers if len(significant(x)) > BINARY64_DIGITS]
    # So NumPy's savetxt writes 0.1 as 1.000000000000000056e-01: there is nothing beyond binary64.
    are_written_out = len(long) >= (1 if is_time else 5) and all(
        significant(f"{float(x):.{len(significant(x)) - 1}e}") == significant(x) for x in long
    )
    return bool(long) and not are_written_out


def written_column(
    values: Array, lo: Array | None, written: Iterable[str], is_time: bool
) -> Vector:
    """A column of a text; some of its numbers, as they are written, tell how finely it is."""
    finite = [x for x in written if isfinite(float(x))]
    digits = max((len(significant(x)) for x in finite), default=0)
    places = {places_of(x) for x in finite} or {-1}
    fewest, most = min(places), max(places)
    largest = _largest(values)
    varies = _tells_digits(values, lo, digits)
    # The times 0.07 and 10 are written to the same places, without the zeros.
    is_fixed_time = is_time and fewest >= 0 and digits < BINARY64_DIGITS
    if (is_fixed_time or fewest == most >= 0) and varies and 10.0**-most >= np.spacing(largest):
        count = max(1, floor(log10(largest)) + 1 + most)
        return Vector(values, lo, Quantum(10, places=most), count, digits)
    if _SINGLE_DIGITS <= digits < BINARY64_DIGITS and _are_single_written(values, digits):
        # Printed longer than they are.
        return Vector(values, lo, Quantum(2, digits=24), _DIGITS_OF_BITS[24], digits)
    # The times always have their rest.
    if 0 < digits < BINARY64_DIGITS or (lo is not None and digits > BINARY64_DIGITS):
        quantum, known = Quantum(10, digits=digits), digits
    else:
        bits = binary_digits(values) if varies else 53
        quantum = Quantum(2, digits=bits)
        known = BINARY64_DIGITS if bits == 53 else _DIGITS_OF_BITS[bits]
    return Vector(values, lo, quantum, known if varies else None, digits)


def _tells_digits(values: Array, lo: Array | None, digits: int) -> bool:
    """True if numbers tell how many digits are written: a constant does not.

    A few numbers of nearly as many digits as binary64 needs may be short by chance, one in ten of
    each digit that is not there.
    """
    if not len(values) or _is_constant(values, lo):
        return False
    some = np.array([x for x in {*values[:_ENOUGH_SHORT].tolist()} if x and np.isfinite(x)])
    if digits >= BINARY64_DIGITS or not some.size:
        return True
    last = np.floor(np.log10(np.abs(some))) + 1 - digits
    missing = last - np.log10(np.spacing(np.abs(some)))
    return float(np.maximum(missing, 0.0).sum()) > _BY_CHANCE


def evened(columns: list[Vector], time: int) -> list[Vector]:
    """The columns of a table, a constant one as finely written as the finest of the others."""
    varying = [w for j, w in enumerate(columns) if j != time and w.digits is not None]
    if not varying:
        return columns
    finest = max(varying, key=lambda w: w.digits or 0).quantum
    return [w if w.digits is not None else replace(w, quantum=finest) for w in columns]


def binary_column(values: Array, lo: Array | None, bits: int) -> Vector:
    """A column of binary numbers of so many bits."""
    if bits == 53:
        bits = binary_digits(values)
    varies = bool(len(values)) and not _is_constant(values, lo)
    digits = _DIGITS_OF_BITS.get(bits, floor(bits * log10(2)))
    return Vector(values, lo, Quantum(2, digits=bits), digits if varies else None)


def column_of_steps(values: Array, step: float) -> Vector:
    """A column of multiples of a step."""
    quantum = Quantum(2, places=0, step=abs(step))
    digits = floor(log10(max(_largest(values) / quantum.step, 1.0))) + 1
    return Vector(values, None, quantum, None if _is_constant(values, None) else digits)


def binary_digits(values: Array) -> int:
    """24 if all values are single precision numbers, and not only integers; else 53."""
    finite = values[np.isfinite(values)]
    return 24 if are_single(values) and (finite != np.rint(finite)).any() else 53


def are_single(values: Array) -> bool:
    """True if all finite values are single precision numbers."""
    return bool(((as_single(values) == values) | ~np.isfinite(values)).all())


def _are_single_written(values: Array, digits: int) -> bool:
    """True if decimals are single precision numbers, rounded to so many digits.

    One number in ten is near one by chance if nine digits are written: it takes many.
    """
    some = values[np.isfinite(values) & (values != np.rint(values))]
    if len(some) < _ENOUGH_SINGLE:
        return False
    # Half a digit, and the rounding of its reading.
    nearest = 0.501 * Quantum(10, digits=digits).at(some)
    return bool((np.abs(some - as_single(some)) <= nearest).all())


def as_single(values: Array) -> Array:
    """Values rounded to single precision."""
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


# Picoseconds; finer decimals are hardly meant.
_MOST_PLACES = 12
_FEWEST_ROWS = 3
# Digits that single precision numbers are written with; fewer do not show them.
_DIGITS_OF_SINGLE = (8, 9)
# Times that only happen to be close to multiples pass with this probability, its logarithm.
_CHANCE = -6.0
# Enough rows to see at once that times are no multiples.
_FIRST_ROWS = 64
# So many at once: of what is computed on the way a long file needs little memory.
_ROWS = 1 << 16


@dataclass(frozen=True, slots=True)
class Times:
    """Times made exact and put in order.

    Attributes
    ----------
    hi, lo : ndarray, shape (n,)
        Ascending [s].
    order : ndarray of int, shape (n,), or None
        Index of each time's row in the file; None if they were in order.
    seen : tuple of Evidence
    """

    hi: Array
    lo: Array
    order: NDArray[np.intp] | None
    seen: tuple[Evidence, ...]


def settle(table: Vectors, at: int, request: Request, unit: str = "s") -> Times:
    """Make times exact, and sort them.

    Parameters
    ----------
    table
        The columns as read.
    at
        Place of the times among them.
    request
        The request to read them.
    unit
        In which they were read: ``s`` or ``ms``.

    Raises
    ------
    InputError
        A time that is not finite.
    """
    column = table.columns[at]
    seen: list[Evidence] = []
    hi, digits = column.values, column.significant
    if not (is_finite := np.isfinite(hi)).all():
        said = "found a time that is not finite, expected seconds"
        raise table.error(request, int(np.argmin(is_finite)), said, at + 1)
    rest = np.zeros(len(hi)) if column.lo is None else column.lo
    multiples = None if digits is None else as_multiples(hi, digits)
    if multiples is not None:
        places, exact_hi, exact_lo = multiples
        changed = np.flatnonzero((exact_hi != hi) | (exact_lo != rest))
        hi, rest = exact_hi, exact_lo
        if len(changed):
            seen.append(TimesAsDecimals(places, unit, len(changed), float(hi[changed[0]])))
    if unit == "ms":
        hi, rest = divide((hi, rest), np.full(len(hi), 1000.0))
    order = None
    back = np.flatnonzero((hi[1:] < hi[:-1]) | ((hi[1:] == hi[:-1]) & (rest[1:] < rest[:-1])))
    if len(back):
        counted_by, line = table.place(int(back[0]) + 1)
        seen.append(TimesUnsorted(counted_by, line, len(back)))
        order = np.lexsort((rest, hi))
        hi, rest = hi[order], rest[order]
    repeated = int(np.count_nonzero((hi[1:] == hi[:-1]) & (rest[1:] == rest[:-1])))
    if repeated:
        seen.append(TimesRepeated(repeated))
    return Times(hi, rest, order, tuple(seen))


def as_multiples(hi: Array, digits: int = 0) -> tuple[int, Array, Array] | None:
    """Decimal multiples of which all times are the nearest binary64, or single precision, numbers.

    Parameters
    ----------
    hi : ndarray, shape (n,)
        Times [s].
    digits
        Significant digits if the times were written as decimals, else 0.

    Returns
    -------
    (int, ndarray, ndarray) or None
        The smallest d such that all times mean k 10^-d, and k 10^-d as hi + lo, correctly rounded;
        None if there is no such d up to 12, or three rows, or it could be chance.
    """
    # A larger number is no nearer to one multiple than to another.
    if len(hi) < _FEWEST_ROWS or not (np.abs(hi) < 2.0**53).all():
        return None
    single = as_single(hi)
    candidates: list[tuple[Array, type[np.floating]]] = [(hi, np.float64)]
    if (single == hi).all() or (digits in _DIGITS_OF_SINGLE and _are_written(single, hi, digits)):
        candidates.append((single, np.float32))
    # As decimals, 0.0700000003 and the like are multiples too, of a smaller step.
    each = ((d, x, kind) for d in range(_MOST_PLACES + 1) for x, kind in candidates)
    found = next(((d, x) for d, x, kind in each if _are_multiples(x, d, kind)), None)
    if found is None:
        return None
    places, hi = found
    ten = 10.0**places
    exact, lo = np.empty_like(hi), np.empty_like(hi)
    for piece in _pieces(len(hi)):
        k = np.rint(hi[piece] * ten)
        exact[piece] = k / ten
        # Every term is exact: what is left has at most 28 bits.
        p, e = two_product(exact[piece], np.full(len(k), ten))
        lo[piece] = ((k - p) - e) / ten
    return places, exact, lo


def _are_multiples(hi: Array, places: int, kind: type[np.floating]) -> bool:
    """True if all times are the nearest numbers to multiples of 10^-places."""
    ten, chance, last = 10.0**places, 0.0, 0.0
    for piece in _pieces(len(hi)):
        times = hi[piece]
        k = np.rint(times * ten)
        # With more bits no quotient would be correctly rounded, nor mean anything.
        if not (np.abs(k) < 2.0**53).all():
            return False
        if not ((k / ten).astype(kind).astype(np.float64) == times).all():
            return False
        # Of numbers this close together one in so many is the nearest to some multiple.
        different = times[np.diff(times, prepend=last) != 0]
        last = times[-1]
        with np.errstate(divide="ignore"):
            spacing = np.spacing(np.abs(different).astype(kind)).astype(np.float64)
            chance += float(np.minimum(np.log10(spacing * ten), 0.0).sum())
    return chance < _CHANCE


def _pieces(count: int) -> Iterator[slice]:
    """The rows in pieces, the first of which shows at once what times are no multiples."""
    at, size = 0, _FIRST_ROWS
    while at < count:
        yield slice(at, at + size)
        at, size = at + size, _ROWS


def _are_written(single: Array, hi: Array, digits: int) -> bool:
    """True if the single precision numbers, written with so many digits, give these times."""
    both = zip(single.tolist(), hi.tolist(), strict=True)
    return all(float(f"{x:.{digits - 1}e}") == time for x, time in both)
