"""Numbers as text: errors, times, limits and percentages."""

import math

from heyoka_bike.errors import printable
from heyoka_bike.scoring.evidence.words import unit_text
from heyoka_bike.scoring.grades import digits_text


def sentence(text: str) -> str:
    """Return a message as one line: collapse white space, then apply `printable`."""
    return printable(" ".join(text.split()))


def number(x: float | None, digits: int = 2) -> str:
    """Return an error as text with a few significant digits; ``-`` if it is unknown."""
    if x is None or not math.isfinite(x):
        return "-"
    return "0" if x == 0 else f"{x:.{digits - 1}e}"


def readable(x: float | None) -> str:
    """Return a number as text for a sentence: a decimal if it is short; ``-`` if unknown."""
    if x is not None and 0.01 <= abs(x) < 1000:
        return f"{x:.2g}" if abs(x) < 100 else f"{x:.0f}"
    return number(x)


def plain(x: float | None, digits: int = 4) -> str:
    """Return a time or a step as text, without trailing zeros; ``-`` if it is unknown."""
    return "-" if x is None or not math.isfinite(x) else f"{x:.{digits}g}"


def correct_digits(x: float | None) -> str:
    """Return a number of correct digits as text, see `digits_text`; ``-`` if it is unknown."""
    return "-" if x is None or not math.isfinite(x) else digits_text(x)


def one_decimal(x: float | None) -> str:
    """Return an order of convergence, or mescd, with one decimal; ``-`` if it is unknown."""
    # Adding 0.0 turns -0.0 into 0.0.
    return "-" if x is None or not math.isfinite(x) else f"{round(x, 1) + 0.0:.1f}"


def in_unit(said: str, unit: str) -> str:
    """Return a number, followed by its unit if it has one."""
    return said if unit == "1" else f"{said} {unit_text(unit)}"


def percent(part: float) -> str:
    """Return a fraction in percent, rounded down, so that only 1 becomes 100 %."""
    return f"{math.floor(1000 * part) / 10:g} %"


def limit_words(limit: float) -> str:
    """Return the limit of eq. (1) as text with all its digits: "1e-3 %" or "2.5e-3 %"."""
    if limit >= 1:
        return f"{limit:.12g} %"
    # Twelve digits suffice for every limit in use. Without this maximum, a limit of 1/3 would be
    # written with sixteen digits.
    digits, exponent = f"{limit:.11e}".split("e")
    return f"{digits.rstrip('0').rstrip('.')}e{int(exponent)} %"
