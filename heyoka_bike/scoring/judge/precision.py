"""Precision: numbers of single precision, and errors that are those of the digits written.

Numbers may be of single precision: written as such, or computed with on the way. Rounding to 24
bits leaves noise of a known size, which jumps from row to row.
"""

from collections.abc import Iterator

import numpy as np

from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.contradictions import FewDigits, SinglePrecision
from heyoka_bike.scoring.grades import FLOORS_OF_ROUNDING
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.noise import FEWEST_ROWS, roughness
from heyoka_bike.scoring.reading.digits import are_single
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore

_BITS_OF_SINGLE = 24
# Rows that are looked at.
_ROWS_LOOKED_AT = 4000
# Rounding to 24 bits leaves 1.7e-8 to 3.4e-8 of a value, root mean square; a value that is computed
# from some rounded ones, a few times that.
_NOISE_OF_SINGLE = (1.2e-8, 3e-7)
# The noise is said of a file if that many of its columns have it.
_PART_OF_COLUMNS = 2 / 3


def single_precision(report: Report) -> Iterator[SinglePrecision]:
    """Say that a file was written or computed in single precision, though with more digits."""
    every = [(m.part, c) for m in report.maneuvers for c in m.columns]
    # A constant is a number of any precision.
    telling = [(p, c) for p, c in every if c.values >= FEWEST_ROWS and np.ptp(c.trace.value)]
    single = {c.key for part, c in telling if _is_single(part, c)}
    others = {c.key for _, c in telling} - single
    noisy = [c.key for _, c in telling if _has_its_noise(c)]
    if telling and len(single) >= len(others):
        keys = single if others else {c.key for _, c in every}
        yield SinglePrecision(tuple(sorted(keys)), is_written=True, are_all=not others)
    elif telling and len(noisy) >= _PART_OF_COLUMNS * len(telling):
        yield SinglePrecision(tuple(sorted(set(noisy))), is_written=False)


def _is_single(part: Part, c: ColumnScore) -> bool:
    """True if a column holds numbers of single precision, and more digits than these have."""
    quantum = part.quantum.get(c.key)
    if quantum is None or quantum.base != 2:
        return False
    return quantum.digits == _BITS_OF_SINGLE or are_single(part.values[c.key])


def _has_its_noise(c: ColumnScore) -> bool:
    """True if the error is noise of the size that rounding to 24 bits leaves.

    Where so few digits are written that their rounding is as large, it says nothing.
    """
    if c.as_understood.measures.max_abs_error in (None, 0.0) or c.is_at_floor(FLOORS_OF_ROUNDING):
        return False
    found = roughness(c.trace.error[:_ROWS_LOOKED_AT])
    size = rms(c.trace.value[:_ROWS_LOOKED_AT])
    # The largest rounding of the digits written: noise of that size may be theirs.
    if found.size <= (c.floor or 0.0) or not size:
        return False
    return found.is_white and _NOISE_OF_SINGLE[0] < found.size / size < _NOISE_OF_SINGLE[1]


# Fewer digits than binary64 holds are worth mentioning where they are what limits the score.
_DIGITS_OF_BINARY64 = 15


def digits_written(report: Report) -> Iterator[FewDigits]:
    """Where not the program but the digits it wrote limit the score, if not for their precision."""
    digits = report.file.significant_digits
    if digits is None or digits >= _DIGITS_OF_BINARY64:
        return
    single = [key for found in single_precision(report) for key in found.keys]
    limited = tuple(
        key
        for key, places in report.by_column().items()
        if key not in single and all(c.is_at_floor(FLOORS_OF_ROUNDING) for _, c in places)
    )
    if limited:
        yield FewDigits(limited, digits)
