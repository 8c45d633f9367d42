"""Times of a result file: exact decimals where the file means these, in ascending order."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array, divide, two_product
from heyoka_bike.scoring.findings import Finding, info, warning
from heyoka_bike.scoring.reading.quanta import as_single

# Picoseconds; finer decimals are hardly meant.
_MOST_PLACES = 12
_FEWEST_ROWS = 3
# Digits that single precision numbers are written with; fewer do not show them.
_SINGLE_DIGITS = (8, 9)
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
    findings : tuple of Finding
    """

    hi: Array
    lo: Array
    order: NDArray[np.intp] | None
    findings: tuple[Finding, ...]


def settle(
    hi: Array, lo: Array | None, digits: int | None,
    lines: Sequence[int] | NDArray[np.int64] | None, unit: str = "s",
) -> Times:  # fmt: skip
    """Make times exact, and sort them.

    Parameters
    ----------
    hi, lo : ndarray, shape (n,)
        Times as read, finite.
    digits
        Significant digits if they were written as decimals; 0 for binary numbers; None for hi + lo
        that is exact already.
    lines
        Number of each row's line in the file; None if it is its place, from 1.
    unit
        In which they were read: ``s`` or ``ms``.
    """
    findings = []
    rest = np.zeros(len(hi)) if lo is None else lo
    multiples = None if digits is None else as_multiples(hi, digits)
    if multiples is not None:
        places, exact_hi, exact_lo = multiples
        changed = np.flatnonzero((exact_hi != hi) | (exact_lo != rest))
        hi, rest = exact_hi, exact_lo
        if len(changed):
            said = (
                f"the times are binary numbers next to multiples of 1e-{places} {unit}, and are "
                f"read as these decimals ({hi[changed[0]]:.{places}f} {unit} is exactly that)"
            )
            found = info("times_read_as_multiples", said, places=places, changed=len(changed))
            findings.append(found)
    if unit == "ms":
        hi, rest = divide((hi, rest), np.full(len(hi), 1000.0))
    order = None
    back = np.flatnonzero((hi[1:] < hi[:-1]) | ((hi[1:] == hi[:-1]) & (rest[1:] < rest[:-1])))
    if len(back):
        where = int(back[0]) + 1
        line = where + 1 if lines is None else int(lines[where])
        place = f"{'row' if lines is None else 'line'} {line}"
        said = f"Times go back (first in {place}); the rows are sorted by time."
        findings.append(warning("times_unsorted", said, line=line, count=len(back)))
        order = np.lexsort((rest, hi))
        hi, rest = hi[order], rest[order]
    repeated = int(np.count_nonzero((hi[1:] == hi[:-1]) & (rest[1:] == rest[:-1])))
    if repeated:
        said = f"{repeated} rows have the time of another one."
        findings.append(info("times_repeated", said, count=repeated))
    return Times(hi, rest, order, tuple(findings))


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
    if (single == hi).all() or (digits in _SINGLE_DIGITS and _are_written(single, hi, digits)):
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
