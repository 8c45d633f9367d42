"""Files of single-precision numbers: written as such, or computed with them on the way."""

from collections.abc import Iterator

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, warning
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.reading.quanta import are_single
from heyoka_bike.scoring.report import Report

_BITS = 24
_FEW_ROWS = 50
# Rows that are looked at.
_MOST_ROWS = 4000
# Rounding to 24 bits leaves 1.7e-8 to 3.4e-8 of a value, root mean square; a value that is computed
# from some rounded ones, a few times that.
_NOISE = (1.2e-8, 3e-7)
# Root mean square of third over second differences: 1.83 for white noise, far less for a smooth
# error. With a thousand rows it scatters by 0.03.
_WHITE = (1.6, 2.0)
# Times the floor: what few digits leave of a right value.
_OF_DIGITS = 4.0
# The noise is said of a file if that many of its columns have it.
_MOSTLY = 2 / 3


def single_precision(report: Report) -> Iterator[Finding]:
    """Say that a file was written or computed in single precision, though with more digits."""
    every = [(m.part, c) for m in report.maneuvers for c in m.columns]
    # A constant is a number of any precision.
    telling = [(p, c) for p, c in every if c.values >= _FEW_ROWS and np.ptp(c.trace.value)]
    single = {c.key for part, c in telling if _is_single(part, c)}
    others = {c.key for _, c in telling} - single
    noisy = [c.key for _, c in telling if _has_its_noise(c)]
    if telling and len(single) >= len(others):
        yield warning(
            "single_precision",
            f"{'Most' if others else 'All'} values are single-precision numbers, good to seven "
            "digits, however many are written: an error of 1e-7 of a value, or one that grows from "
            "that, is the arithmetic and not the model; compute and store in double precision",
            columns=sorted(single if others else {c.key for _, c in every}),
        )
    elif telling and len(noisy) >= _MOSTLY * len(telling):
        yield warning(
            "single_precision",
            "The values jump from row to row by some 1e-7 of their size, as numbers of single "
            "precision on the way leave them: this is the arithmetic and not the model; compute "
            "in double precision throughout",
            columns=sorted(set(noisy)),
        )


def _is_single(part: Part, c: ColumnScore) -> bool:
    """True if a column holds numbers of single precision, and more digits than these have."""
    quantum = part.quantum.get(c.key)
    if quantum is None or quantum.base != 2:
        return False
    return quantum.digits == _BITS or are_single(part.values[c.key])


def _has_its_noise(c: ColumnScore) -> bool:
    """True if the error is noise of the size that rounding to 24 bits leaves.

    Where so few digits are written that their rounding is as large, it says nothing.
    """
    if c.as_understood.measures.max_abs_error in (None, 0.0) or c.is_at_floor(_OF_DIGITS):
        return False
    error: Array = c.trace.error[:_MOST_ROWS]
    size = rms(c.trace.value[:_MOST_ROWS])
    second, third = (rms(np.diff(error, n)) for n in (2, 3))
    if not second or not size:
        return False
    noise = second / 6**0.5 / size
    return _NOISE[0] < noise < _NOISE[1] and _WHITE[0] < third / second < _WHITE[1]
