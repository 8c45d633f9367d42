"""Compare rates with the slopes of their angles, which they equal in any motion."""

from collections.abc import Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import ANGLE_OF
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE
from heyoka_bike.scoring.ratios import MOST_ROWS

Columns = Mapping[str, tuple[Array, Array]]
"""Times and values of the columns of a maneuver, by key."""


def opposite_pairs(maneuvers: Sequence[Columns], *, is_begun: bool) -> list[tuple[str, str]]:
    """Return angles, each with its rate, if the rate is the opposite of the angle's slope.

    Parameters
    ----------
    maneuvers
    is_begun
        True if the first rows contain the given initial conditions. If the motion does not continue
        from these, and every rate is the opposite of a slope, the rows may be in reversed order.
        Then no pair is returned.
    """
    signs = {(angle, rate): slope_sign(angle, rate, maneuvers) for rate, angle in ANGLE_OF.items()}
    found = [pair for pair, x in signs.items() if x < 0]
    if 1 in signs.values() or (is_begun and all(_continues(found, m) for m in maneuvers)):
        return found
    return []


def _continues(pairs: Sequence[tuple[str, str]], columns: Columns) -> bool:
    """True if from the first row to the second no angle changes more than its rates explain."""

    def is_small(angle: str, rate: str) -> bool:
        (time, values), (_, rates) = columns[angle], columns[rate]
        largest = np.max(np.abs(rates[:2])) * np.ptp(time[:2])
        return bool(np.ptp(values[:2]) <= 3 / 2 * largest)

    return all(is_small(*pair) for pair in pairs if columns.keys() >= {*pair})


def slope_sign(angle: str, rate: str, maneuvers: Sequence[Columns]) -> int:
    """Return 1 if a rate is the slope of its angle, -1 if the opposite, 0 if the rows show neither.

    Most of a maneuver must show the sign. No maneuver may show the other sign in more than a tenth:
    a sign that is flipped by mistake is flipped in all rows. But the roll angle of a bicycle that
    has fallen turns back at 90 degrees, although its rate continues.
    """
    shares = [_shares(*m[angle], *m[rate]) for m in maneuvers if angle in m and rate in m]
    same, opposite = np.max(shares, axis=0, initial=0.0) if shares else (0.0, 0.0)
    if min(same, opposite) > 1.0 - MOST_ROWS or max(same, opposite) <= 1 / 2:
        return 0
    return 1 if same > opposite else -1


def _shares(time: Array, angle: Array, rate_time: Array, rate: Array) -> tuple[float, float]:
    """Return which parts of a maneuver show that a rate is the slope of its angle, or the opposite.

    Two neighbouring rows show it if the change of the angle differs by less than half from the
    change that the rate of either row predicts. If the rows are too far apart or have too few
    digits, they show neither. Rows are weighted by the predicted change: in other definitions of
    the rate, the tail of a decaying motion may have another sign.
    """
    if len(time) < MIN_ROWS_FOR_SHAPE or not np.array_equal(time, rate_time):
        return 0.0, 0.0
    predicted = np.array([rate[1:], rate[:-1]]) * np.diff(time)
    sizes = np.abs(predicted)
    weight = np.sum(sizes, axis=0)
    total = float(np.sum(weight)) or 1.0

    def share(expected: Array) -> float:
        is_shown = np.all(np.abs(np.diff(angle) - expected) < sizes / 2, axis=0)
        return float(np.sum(weight[is_shown])) / total

    return share(predicted), share(-predicted)
