"""What is rough in an error: noise, the traces of steps, and interpolation between them.

Fourth differences of the rows leave nothing of a smooth error and all of what jumps. Their
correlation with themselves, shifted by some rows, tells the kinds apart.
"""

from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.report import ManeuverScore

# Fourth differences of white noise are so many times as large as the noise: sqrt(1+16+36+16+1).
_GAIN = 70**0.5
_FEWEST = 100
# Noise of so many floors is not that of the digits written.
_SHOWN = 10.0
# Of even rows, steps differ by no more than this part.
_EVEN = 1e-6
_LONGEST = 25
# Interpolation repeats itself with every step, and a smooth error resembles itself after one row.
# The law of interpolation has the last word.
_REPEATED = 0.4
_ALIKE = 0.05
SMOOTH = 0.5
# The part of the fourth differences that the law of interpolation must explain.
_EXPLAINED = 0.8


@dataclass(frozen=True, slots=True)
class Roughness:
    """What of a column jumps from row to row, medians of the fifths of the run.

    A start that settles, or an event, is not in them.

    Attributes
    ----------
    part
        Size of what jumps, of that of the error.
    at_one, at_two
        Correlation of the fourth differences with themselves one and two rows on: near 1 of a
        smooth error, -0.8 and 0.4 of white noise, -1 and 1 of one that alternates.
    """

    part: float
    at_one: float
    at_two: float


@dataclass(frozen=True, slots=True)
class Interpolation:
    """Rows between steps that are interpolated.

    Attributes
    ----------
    rows
        From step to step.
    first
        Row of the first step, from 0.
    degree
        Of the interpolation, 1 or 3.
    """

    rows: int
    first: int
    degree: int


def roughness(c: ColumnScore) -> Roughness | None:
    """What jumps in the error of a column; None if it is not above the digits written."""
    if c.values < _FEWEST:
        return None
    fifths = np.array_split(np.diff(c.trace.error, 4) / _GAIN, 5)
    size = float(np.median([np.std(x) for x in fifths]))
    if size <= _SHOWN * (c.floor or 0.0):
        return None
    at_one, at_two = (float(np.median([_correlation(x, k) for x in fifths])) for k in (1, 2))
    return Roughness(size / float(np.std(c.trace.error)), at_one, at_two)


def interpolation(m: ManeuverScore) -> Interpolation | None:
    """How the rows between steps are interpolated, by the angles and rates; None if not."""
    columns = [c for c in m.columns if c.key in LATERAL and roughness(c) is not None]
    if not columns or any(not _is_even(c.trace.time) for c in columns):
        return None
    differences = [np.diff(c.trace.error, 4) for c in columns]
    rows = _period(differences)
    if rows is None:
        return None
    best, found = _EXPLAINED, None
    for degree in (1, 3):
        for first in range(rows):
            laws = [_law(c.trace.reference, rows, first, degree) for c in columns]
            part = float(np.median([_part(x, y) for x, y in zip(differences, laws, strict=True)]))
            if part > best:
                best, found = part, Interpolation(rows, first, degree)
    return found


def _period(differences: list[Array]) -> int | None:
    """After how many rows the fourth differences repeat themselves, 2 or more."""
    most = min(_LONGEST, len(differences[0]) // 4)
    by_lag = [float(np.median([_correlation(x, k) for x in differences])) for k in range(1, most)]
    if not by_lag[1:] or max(by_lag[1:]) < _REPEATED:
        return None
    best = 2 + int(np.argmax(by_lag[1:]))
    # Multiples of the period are as good, but for the motion's change in the meantime.
    rows = next(
        k for k in range(2, best + 1) if best % k == 0 and by_lag[k - 1] > by_lag[best - 1] - _ALIKE
    )
    return rows if min(by_lag[: rows - 1]) < SMOOTH else None


def _law(values: Array, rows: int, first: int, degree: int) -> Array:
    """Fourth differences of the error of interpolation in every so many rows.

    Between two steps it is the derivative of order degree + 1 times s (1 - s) for lines and
    s^2 (1 - s)^2 for cubics that keep values and rates, s the place between the steps.
    """
    s = (np.arange(len(values)) - first) % rows / rows
    bulge = s * (1 - s) if degree == 1 else (s * (1 - s)) ** 2
    margin = (degree + 1) // 2
    derivative = np.pad(np.diff(values, degree + 1), margin, mode="edge")
    return np.diff(bulge * derivative, 4)


def _part(x: Array, law: Array) -> float:
    """Part of the squares of x that a multiple of the law explains."""
    both = float(np.dot(x, x) * np.dot(law, law))
    return float(np.dot(x, law)) ** 2 / both if both else 0.0


def _correlation(x: Array, rows: int) -> float:
    a, b = x[:-rows], x[rows:]
    both = float(np.dot(a, a) * np.dot(b, b)) ** 0.5
    return float(np.dot(a, b)) / both if both else 0.0


def _is_even(time: Array) -> bool:
    steps = np.diff(time)
    return bool(np.ptp(steps) < _EVEN * np.max(steps))
