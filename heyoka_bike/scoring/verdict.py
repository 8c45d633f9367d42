"""The one decision of what is right: every word about a result follows these functions.

A column is *right* if each of its values is within 1e-6 of the column's largest value of the exact
one, six correct digits, and is written finely enough to show that. What the digits written leave
open *cannot be told*: some right value would be written so. All else is close or wrong, by what
rounding does not explain. A time means the decimal that is written, so rounded times explain
nothing, and signs that contradict each other are wrong whatever the digits are.

A file is right if every column is, of every maneuver, over the whole run, and nothing that it holds
under a known name was left out. Eq. (1) is met by an energy that is the file's own potential plus
kinetic energy within rounding, or the true one where one of these is not there, and that is written
finely enough to show the limit. It is a part of the true energy, whatever the first value is.
"""

from collections.abc import Iterable
from enum import IntEnum
from math import inf, isfinite, log10

MOST_DIGITS = 32.0
"""Correct digits are not counted beyond this."""

RIGHT_DIGITS = 6.0
"""Correct digits of what is called right: what the examples of ``--require`` ask for."""

TOLERANCE = 1e-3
"""Of the column's scale: the error that `time_to_tolerance` waits for; it is seen in a plot."""

CLOSE_DIGITS = -log10(TOLERANCE)
"""Correct digits of what is not wrong."""

WHOLE = 0.99
"""Of the duration: a run without its first row is whole enough to be judged."""

SUM_ROUNDING = 4.0
"""Rounding of written values explains up to this many times its bound: sums are rounded, too."""


ARITHMETIC = 1e-12
"""Of an energy: what thousands of operations in binary64 may leave, with more digits, too."""


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


def is_right(grades: Iterable[Grade], *, is_whole: bool) -> bool:
    """True if a file is right: all that could be compared, and that is the whole of it."""
    return is_whole and max(grades, default=Grade.UNKNOWN) == Grade.RIGHT


def performance(
    change: float | None,
    limit: float,
    *,
    resolution: float,
    sum_error: float | None,
    true_error: float,
    start: float = 1.0,
) -> tuple[float, str]:
    """Eq. (1) as it may be claimed, and why that is not what was measured; all in percent.

    Parameters
    ----------
    change
        Eq. (1) as it was measured; None without an energy.
    limit
        What is asked for.
    resolution
        The smallest change that the digits written can show.
    sum_error
        How far the energy is from potential plus kinetic energy, beyond rounding; None if one of
        these is not there, or written so coarsely that this says nothing about the limit.
    true_error
        How far it is from the exact one.
    start
        The first value of the energy, in exact ones (1, not percent).
    """
    if change is None:
        return inf, "there is no mechanical energy to judge"
    if sum_error:
        return inf, "its energy is not its own potential plus kinetic energy"
    if sum_error is None and change < limit <= true_error:
        return true_error, "its energy is not the true one, and its parts do not show otherwise"
    if change < limit <= change * start:
        return change * start, "its energy does not begin with the true one"
    if change < limit < resolution:
        return resolution, "it cannot be told at the digits written"
    return change, ""
