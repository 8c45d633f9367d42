"""Noise: the part of an error that jumps from row to row.

Fourth differences remove a smooth error and keep the noise. For white noise, their autocorrelation
at lags of one and two rows is known.
"""

from typing import NamedTuple

import numpy as np

from heyoka_bike.numbers.double import Array, median

FEWEST_ROWS = 50
"""Fewest rows that show whether an error is noise: their autocorrelations scatter by a tenth."""

# `_GAIN` is the factor by which fourth differences of white noise exceed the noise: their weights
# are 1, -4, 6, -4, 1. `_WHITE` contains their autocorrelations at lags of one and two rows, and
# `_SCATTER` is the scatter of these autocorrelations.
_GAIN = 70**0.5
_WHITE, _SCATTER = (-0.8, 0.4), 0.1


class Roughness(NamedTuple):
    """The part of an error that jumps from row to row.

    Attributes
    ----------
    size
        Root mean square of the noise, in the unit of the error.
    at_one, at_two
        Autocorrelation of the fourth differences at lags of one and two rows: near 1 for a smooth
        error, -0.8 and 0.4 for white noise, -1 and 1 for an error that alternates.
    """

    size: float
    at_one: float
    at_two: float

    @property
    def is_white(self) -> bool:
        """True if the autocorrelations are those of white noise."""
        off = abs(self.at_one - _WHITE[0]), abs(self.at_two - _WHITE[1])
        return off[0] < _SCATTER and off[1] < 2 * _SCATTER


def roughness(error: Array, parts: int = 1) -> Roughness:
    """Return the noise in an error, as medians over `parts` consecutive parts of the run.

    With several parts, the medians ignore a transient at the start or an event.
    """
    # Divide by the largest error, because the squares of large errors would overflow.
    largest = float(np.max(np.abs(error))) or 1.0
    each = np.array_split(np.diff(error / largest, 4) / _GAIN, parts)
    sizes, *at = np.array([(np.std(x), _correlation(x, 1), _correlation(x, 2)) for x in each]).T
    at_one, at_two = (float(median(x)) for x in at)
    return Roughness(largest * float(median(sizes)), at_one, at_two)


def _correlation(x: Array, rows: int) -> float:
    a, b = x[:-rows], x[rows:]
    both = float(np.dot(a, a) * np.dot(b, b)) ** 0.5
    return float(np.dot(a, b)) / both if both else 0.0
