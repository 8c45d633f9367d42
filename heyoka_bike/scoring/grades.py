"""The grade of a column: right, undecided, close or wrong.

A column is *right* if every error is at most 1e-6 of the column's largest value (six correct
digits), and if its values are written with enough digits to show that. A column is *undecided* if
its errors may come from rounding to the digits written: a right column could be written alike.
Otherwise the column is close or wrong, depending on the part of its error that rounding does not
explain. A time means the decimal that is written, so rounded times explain no error. Signs that
contradict each other are wrong whatever the digits are.
"""

from enum import IntEnum
from math import floor, isfinite, log10

MOST_DIGITS = 32.0
"""Largest number of correct digits that is reported."""

RIGHT_DIGITS = 6.0
"""Fewest correct digits of a right column; the examples of ``--require`` demand as many."""

RIGHT = 10.0**-RIGHT_DIGITS
"""Largest error of a right column, in scales."""

TOLERANCE = 1e-3
"""Error, in scales, that is visible in a plot; `time_to_tolerance` is the first time at which it is
exceeded."""

MAX_ROUNDING_FLOORS = 4.0
"""Errors of up to this many resolution limits count as rounding. Rounding itself makes one; sums
and unit conversions add a few."""

MIN_ROWS_FOR_SHAPE = 10
"""Fewest rows that show the shape of an error. With fewer rows, a definition is recognised only if
it fits to the digits written."""

CLOSE_DIGITS = -log10(TOLERANCE)
"""Fewest correct digits of a column that is not wrong."""

LIMITS = (CLOSE_DIGITS, RIGHT_DIGITS)
"""Fewest correct digits of a close and of a right column."""


class Grade(IntEnum):
    """Grades from the best to the worst; a file has the worst grade of its columns."""

    UNKNOWN = 0
    RIGHT = 1
    UNTOLD = 2
    CLOSE = 3
    WRONG = 4

    @property
    def style(self) -> str:
        """Name of the grade in style sheets and JSON."""
        return self.name.lower()


def digits_text(found: float) -> str:
    """Return correct digits to one decimal, never rounded up to the limit of a better grade."""
    # Adding 0.0 turns -0.0 into 0.0.
    rounded = round(found, 1) + 0.0
    if any(found < limit <= rounded for limit in LIMITS):
        rounded = floor(10.0 * found) / 10.0
    return f"{rounded:.1f}"


def digits(relative: float | None) -> float | None:
    """Return the correct digits of a relative error, -log10, at most 32; None for None."""
    if relative is None:
        return None
    if relative == 0.0:
        return MOST_DIGITS
    return min(MOST_DIGITS, 0.0 - log10(relative)) if isfinite(relative) else None


def digits_of(error: float, scale: float) -> float:
    """Return the correct digits of an error relative to a scale; the maximum if the scale is 0."""
    return digits(error / scale if scale else 0.0) or 0.0


def has_right_digits(error: float) -> bool:
    """True if an error, in scales, is small enough for a right column."""
    return digits_of(error, 1.0) >= RIGHT_DIGITS


def grade(
    error: float | None,
    *,
    unexplained: float,
    resolution: float,
    scale: float,
    is_contradicted: bool = False,
) -> Grade:
    """Return the grade of a column.

    Parameters
    ----------
    error
        The largest error [SI unit]; None if nothing was compared.
    unexplained
        The largest part of an error that rounding to the digits of its row does not explain
        [SI unit].
    resolution
        The largest error of a value that is rounded to the digits of its row [SI unit].
    scale
        Largest absolute value of the reference [SI unit].
    is_contradicted
        True if the sign contradicts another column's.
    """
    if error is None or not (scale or error == 0.0):
        return Grade.UNKNOWN
    found, at_most, shown = (digits_of(x, scale) for x in (error, unexplained, resolution))
    if is_contradicted or at_most < CLOSE_DIGITS:
        return Grade.WRONG
    if min(found, shown) >= RIGHT_DIGITS:
        return Grade.RIGHT
    if at_most >= RIGHT_DIGITS or found < CLOSE_DIGITS:
        return Grade.UNTOLD
    return Grade.CLOSE
