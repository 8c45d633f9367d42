"""Noise: the part of an error that jumps from row to row.

Fourth differences leave nothing of a smooth error and all of what jumps. Those of white noise have
a correlation with themselves that is known, one and two rows on.
"""

from typing import NamedTuple

import numpy as np

from heyoka_bike.numbers.double import Array, median

FEWEST_ROWS = 50
"""Fewer rows tell no noise: the correlations of so many scatter by a tenth."""

# Of white noise fourth differences are so many times as large as the noise: their weights are
# 1, -4, 6, -4, 1. Correlations with themselves one and two rows on, which scatter by 0.1.
_GAIN = 70**0.5
_WHITE, _SCATTER = (-0.8, 0.4), 0.1


class Roughness(NamedTuple):
    """The part of an error that jumps from row to row.

    Attributes
    ----------
    size
        Root mean square of what jumps, in the unit of the error.
    at_one, at_two
        Correlation of the fourth differences with themselves one and two rows on: near 1 of a
        smooth error, -0.8 and 0.4 of white noise, -1 and 1 of one that alternates.
    """

    size: float
    at_one: float
    at_two: float

    @property
    def is_white(self) -> bool:
        """True of the correlations of white noise."""
        off = abs(self.at_one - _WHITE[0]), abs(self.at_two - _WHITE[1])
        return off[0] < _SCATTER and off[1] < 2 * _SCATTER


def roughness(error: Array, parts: int = 1) -> Roughness:
    """What jumps in an error: medians of so many parts of the run, one after the other.

    A start that settles, or an event, is not in the medians of several.
    """
    # Squares of the largest errors would overflow.
    largest = float(np.max(np.abs(error))) or 1.0
    each = np.array_split(np.diff(error / largest, 4) / _GAIN, parts)
    sizes, *at = np.array([(np.std(x), _correlation(x, 1), _correlation(x, 2)) for x in each]).T
    at_one, at_two = (float(median(x)) for x in at)
    return Roughness(largest * float(median(sizes)), at_one, at_two)


def _correlation(x: Array, rows: int) -> float:
    a, b = x[:-rows], x[rows:]
    both = float(np.dot(a, a) * np.dot(b, b)) ** 0.5
    return float(np.dot(a, b)) / both if both else 0.0
