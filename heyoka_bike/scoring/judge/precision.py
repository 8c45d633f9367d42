"""Precision: single-precision numbers, and errors that come from few digits.

A program may write its numbers in single precision, or compute with them. Rounding to 24 bits
causes noise of a known size, which jumps from row to row.
"""

from collections.abc import Iterator

import numpy as np

from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.evidence.contradictions import FewDigits, SinglePrecision
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.noise import FEWEST_ROWS, roughness
from heyoka_bike.scoring.reading.digits import are_single
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore

_BITS_OF_SINGLE = 24
_ROWS_LOOKED_AT = 4000
# Smallest and largest relative noise of single precision. Rounding to 24 bits causes noise of
# 1.7e-8 to 3.4e-8 (root mean square). Computing a value from several rounded ones causes a few
# times as much.
_NOISE_OF_SINGLE = (1.2e-8, 3e-7)
# Minimum fraction of the columns with noise of this size for single precision to be reported.
_PART_OF_COLUMNS = 2 / 3


def single_precision(report: Report) -> Iterator[SinglePrecision]:
    """Yield evidence that a file was written or computed in single precision."""
    every = [(m.part, c) for m in report.maneuvers for c in m.columns]
    # Leave out constant columns, because they do not show the precision.
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
    """True if a column contains single-precision numbers, even if it has more digits."""
    quantum = part.quantum.get(c.key)
    if quantum is None or quantum.base != 2:
        return False
    return quantum.digits == _BITS_OF_SINGLE or are_single(part.values[c.key])


def _has_its_noise(c: ColumnScore) -> bool:
    """True if the error is noise of the size that rounding to 24 bits causes.

    False if the digits written are so few that their rounding is as large as the noise.
    """
    if not c.max_abs_error or c.is_hidden:
        return False
    found = roughness(c.trace.error[:_ROWS_LOOKED_AT])
    size = rms(c.trace.value[:_ROWS_LOOKED_AT])
    # Noise below the rounding floor may come from the digits written.
    if found.size <= (c.floor or 0.0) or not size:
        return False
    return found.is_white and _NOISE_OF_SINGLE[0] < found.size / size < _NOISE_OF_SINGLE[1]


# Significant digits of binary64. A file with fewer digits is reported if they limit its score.
_DIGITS_OF_BINARY64 = 15


def digits_written(report: Report) -> Iterator[FewDigits]:
    """Yield evidence of columns whose errors come from few decimal digits."""
    digits = report.file.significant_digits
    if digits is None or digits >= _DIGITS_OF_BINARY64:
        return
    single = [key for found in single_precision(report) for key in found.keys]
    limited = tuple(
        key
        for key, places in report.by_column().items()
        if key not in single and all(c.is_hidden for _, c in places)
    )
    if limited:
        yield FewDigits(limited, digits)
