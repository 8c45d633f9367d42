"""Words, signs and meanings of the grades.

A grade depends on the true error alone. Reports show it as a sign and a colour next to the digits.
"""

from heyoka_bike.scoring.grades import CLOSE_DIGITS, RIGHT_DIGITS, Grade
from heyoka_bike.scoring.report import Report

WORDS = {
    Grade.RIGHT: "right",
    Grade.UNTOLD: "undecided because of rounding",
    Grade.CLOSE: "close",
    Grade.WRONG: "wrong",
}

SIGNS = {Grade.RIGHT: "✓", Grade.UNTOLD: "?", Grade.CLOSE: "≈", Grade.WRONG: "✗"}

ASCII_SIGNS = {Grade.RIGHT: "+", Grade.UNTOLD: "?", Grade.CLOSE: "o", Grade.WRONG: "x"}

MEANINGS = {
    Grade.RIGHT: f"right: {RIGHT_DIGITS:g} correct digits or more",
    Grade.UNTOLD: "undecided because of rounding: the file has too few digits to decide",
    Grade.CLOSE: f"close: {CLOSE_DIGITS:g} to {RIGHT_DIGITS:g} digits",
    Grade.WRONG: f"wrong: fewer than {CLOSE_DIGITS:g} digits, that is, off by more than a "
    "thousandth of the column's largest value",
}


def file_grade(report: Report) -> Grade:
    """Return the grade of a file, which is the grade of its worst column."""
    return max(report.grades, default=Grade.UNKNOWN)


def style_of(report: Report) -> str:
    """Return the CSS class of a file's grade; a file that is right in part is shown as close."""
    found = file_grade(report)
    return (Grade.CLOSE if found == Grade.RIGHT and not report.is_right else found).style
