"""Grades of columns and files, by their true error alone, in words, signs and colours.

A grade is shown by a sign and a colour beside the digits; tables that show the signs say what they
mean.
"""

from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.verdict import CLOSE_DIGITS, RIGHT_DIGITS
from heyoka_bike.scoring.verdict import Grade as Grade

WORDS = {
    Grade.RIGHT: "right",
    Grade.UNTOLD: "cannot be told at the digits written",
    Grade.CLOSE: "close",
    Grade.WRONG: "wrong",
}
SIGNS = {Grade.RIGHT: "✓", Grade.UNTOLD: "?", Grade.CLOSE: "≈", Grade.WRONG: "✗"}
ASCII_SIGNS = {Grade.RIGHT: "+", Grade.UNTOLD: "?", Grade.CLOSE: "o", Grade.WRONG: "x"}
_TEXT_COLORS = {Grade.RIGHT: "green", Grade.WRONG: "red", Grade.UNKNOWN: ""}
MEANINGS = {
    Grade.RIGHT: f"right: {RIGHT_DIGITS:g} correct digits or more",
    Grade.UNTOLD: "cannot be told at the digits written: they allow no more",
    Grade.CLOSE: f"close: {CLOSE_DIGITS:g} to {RIGHT_DIGITS:g} digits",
    Grade.WRONG: f"wrong: fewer than {CLOSE_DIGITS:g} digits, off by more than a thousandth of the "
    "column's largest value",
}
PHRASES = {
    "nothing": "nothing could be compared",
    "in_part": ", as far as it goes",
    "worst": "worst column",
    "no_digit": "worst column without a correct digit",
    "correct_digits": "correct digits",
    "maneuver": "maneuver",
}
"""Of the verdict, beside `WORDS`; the checker in C has both, see `checker.header`."""


def text_color(found: Grade) -> str:
    """Colour of a grade on a terminal."""
    return _TEXT_COLORS.get(found, "yellow")


def file_grade(report: Report) -> Grade:
    """Grade of a file: that of its worst column."""
    return max(report.grades, default=Grade.UNKNOWN)


def judgement(report: Report) -> str:
    """Return the grade of a file in a word or a few; empty if nothing was compared."""
    found = file_grade(report)
    word = WORDS.get(found, "")
    if not word or found == Grade.WRONG or report.is_whole:
        return word
    if not any(m.part.time.any() for m in report.maneuvers):
        return f"only the start is there, which the benchmark gives: {word}"
    if report.not_compared:
        return f"not all of it was compared, the rest is {word}"
    return f"{word}{PHRASES['in_part']}"


def style_of(report: Report) -> str:
    """The grade for style sheets: what is right in part only is not shown as right."""
    found = file_grade(report)
    return (Grade.CLOSE if found == Grade.RIGHT and not report.is_right else found).style
