"""The grade of a column: right, close, wrong, or not to be told at the digits written.

A column is *right* if each of its values is within 1e-6 of the column's largest value of the exact
one, six correct digits, and is written finely enough to show that. What the digits written leave
open *cannot be told*: some right value would be written so. All else is close or wrong, by what
rounding does not explain. A time means the decimal that is written, so rounded times explain
nothing, and signs that contradict each other are wrong whatever the digits are.
"""

from enum import IntEnum
from math import isfinite, log10

MOST_DIGITS = 32.0
"""Correct digits are not counted beyond this."""

RIGHT_DIGITS = 6.0
"""Correct digits of what is called right: what the examples of ``--require`` ask for."""

RIGHT = 10.0**-RIGHT_DIGITS
"""The same as a part of what is right."""

TOLERANCE = 1e-3
"""Of the column's scale: the error that `time_to_tolerance` waits for; it is seen in a plot."""

MAX_ROUNDING_FLOORS = 4.0
"""An error of up to so many resolution limits is rounding: a correct file's is one, and sums and
conversions make it a few."""

MIN_ROWS_FOR_SHAPE = 10
"""Fewer rows show no shape of an error, and no definition but by meeting the digits written."""

CLOSE_DIGITS = -log10(TOLERANCE)
"""Correct digits of what is not wrong."""


class Grade(IntEnum):
    """From the best to the worst; a file has the worst of its columns."""

    UNKNOWN = 0
    RIGHT = 1
    UNTOLD = 2
    CLOSE = 3
    WRONG = 4

    @property
    def style(self) -> str:
        """Name in style sheets and JSON."""
        return self.name.lower()


def digits(relative: float | None) -> float | None:
    """Correct digits of a relative error, -log10, at most 32; None of None."""
    if relative is None:
        return None
    if relative == 0.0:
        return MOST_DIGITS
    return min(MOST_DIGITS, 0.0 - log10(relative)) if isfinite(relative) else None


def digits_of(error: float, scale: float) -> float:
    """Correct digits of an error; all that are counted of a column that vanishes."""
    return digits(error / scale if scale else 0.0) or 0.0


def has_right_digits(error: float) -> bool:
    """True if an error in scales is that of a column which is called right."""
    return digits_of(error, 1.0) >= RIGHT_DIGITS


def grade(
    error: float | None,
    *,
    unexplained: float,
    resolution: float,
    scale: float,
    is_contradicted: bool = False,
) -> Grade:
    """Decide what a column is.

    Parameters
    ----------
    error
        The largest [SI unit]; None if nothing was compared.
    unexplained
        The largest that rounding to the digits of its own row does not explain [SI unit].
    resolution
        The largest error of a value that is rounded to the digits of its own row [SI unit].
    scale
        Largest value of the reference [SI unit].
    is_contradicted
        Whether the sign contradicts another column's.
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
