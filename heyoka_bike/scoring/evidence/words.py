"""Phrases shared by the sentences of evidence."""

import math
import re
from collections.abc import Sequence

from heyoka_bike.errors import printable
from heyoka_bike.scoring.evidence.base import MAX_LOG10_ODDS, Errors, Odds

KEYS_NAMED = 6
"""Maximum number of columns that a sentence on conventions or on constant errors lists."""

# Maximum number of alternatives to a definition that a sentence names.
_MOST_OPEN = 3

# Names of units that are spelled out, so their plural needs an s.
_SPELLED_OUT = re.compile(r"\b(degree|revolution)\b")
# The unit of a forward speed that is written as the rate of a wheel, such as ``0.3 m rad s-1``.
_RATE_OF_WHEEL = re.compile(r"^([0-9]\S* m) (rad s-1)$")
# A unit divided by another unit, such as ``m s-1``.
_ONE_PER = re.compile(r"^(\S+) ([a-z]+)-1$")


def unit_text(unit: str) -> str:
    """Format a unit as people write it: ``rad s-1`` becomes rad/s, ``degree`` degrees."""
    if wheel := _RATE_OF_WHEEL.fullmatch(unit):
        return f"{unit_text(wheel[2])} (wheel radius {wheel[1]})"
    return printable(_SPELLED_OUT.sub(r"\1s", _ONE_PER.sub(r"\1/\2", unit)))


def number_in_unit(x: float, unit: str) -> str:
    """Format a number to six digits with its unit, as "0.3 rad/s"; without the unit 1."""
    return f"{x:.6g}" + ("" if unit == "1" else " " + unit_text(unit))


def odds_words(odds: Odds) -> str:
    """Format the odds of a definition, as "300 times as likely as wheel_spin"."""
    other = odds.against or "an unknown definition"
    first, _, second = ratio_words(odds.log10).partition(" to ")
    if second == "1":
        times = "" if first == "1" else f"{first} times "
        return f"{times}as likely as {other}"
    return f"{second} times less likely than {other}"


def ratio_words(power: float) -> str:
    """Format odds, given by their decimal logarithm, as "300 to 1"."""
    if power > MAX_LOG10_ODDS:
        return f"over 10^{MAX_LOG10_ODDS} to 1"
    if power < 0.0:
        return (
            f"1 to {10**-power:.2g}"
            if power > -MAX_LOG10_ODDS
            else f"1 to over 10^{MAX_LOG10_ODDS}"
        )
    return f"10^{math.floor(power)} to 1" if power >= 3 else f"{10**power:.0f} to 1"


def either(names: Sequence[str]) -> str:
    """List alternatives, as "a", "a or b" or "a, b or c"."""
    *first, last = names
    return f"{', '.join(first)} or {last}" if first else last


def open_words(names: Sequence[str]) -> str:
    """Name the other definitions that fit as well, at most three; empty if there is none."""
    if not names:
        return ""
    shown = names if len(names) <= _MOST_OPEN else names[: _MOST_OPEN - 1]
    more = len(names) - len(shown)
    others = [f"one of {more} others (see score --details)"] if more else []
    return f"may also be {either([*shown, *others])}"


def short_number(x: float, digits: int = 2) -> str:
    """Format a number with few significant digits, as "100", "0.019" or "3e+10"."""
    return f"{float(f'{x:.{digits}g}'):g}"


def scale_words(error: float, column: str = "") -> str:
    """Return an error relative to the scale of a column, which sentences call its largest value.

    Without `column`, it is the column that the sentence has named.
    """
    size = f"{short_number(100 * error)} % of" if error < 2.0 else f"{short_number(error)} times"
    return f"{size} the largest value of {column}" if column else f"{size} its largest value"


def errors_words(errors: Errors) -> str:
    """Format the largest errors, one for each maneuver, as "0.17 / 1.3e-08"."""
    return " / ".join("-" if x is None else short_number(x) for x in errors)


def its_errors(errors: Errors) -> str:
    """Begin a sentence on the largest errors of a column, as "Its largest error is 0.17"."""
    which = "error is" if len(errors) == 1 else "errors in the maneuvers are"
    return f"Its largest {which} {errors_words(errors)}"


def counted(count: int, one: str, several: str = "") -> str:
    """Format a count with its noun (``1 row``, ``2 rows``), or with a verb too (``1 value is``).

    Parameters
    ----------
    count
    one, several
        The words after 1, and the words after any other number; the default is `one` with an s.
    """
    return f"{count} {one if count == 1 else several or one + 's'}"


def time_beside(t: float, end: float) -> str:
    """Format a time to six digits, or to 15 if six would make it look like the end of the run."""
    return f"{t:.6g}" if t == end or f"{t:.6g}" != f"{end:.6g}" else f"{t:.15g}"
