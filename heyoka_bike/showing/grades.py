"""How good a result is, by its true error alone: the grade of a column and of a file.

A grade is shown by a sign and a colour beside the digits; each place that shows the signs says what
they mean, by `meanings`.
"""

from collections.abc import Iterable
from enum import IntEnum
from math import log10

from heyoka_bike.scoring.column_score import RIGHT_DIGITS, ColumnScore
from heyoka_bike.scoring.measures import TOLERANCE
from heyoka_bike.scoring.report import WHOLE, Report

_CLOSE = -log10(TOLERANCE)


class Grade(IntEnum):
    """From the best to the worst; a file has the worst of its columns."""

    UNKNOWN = 0
    RIGHT = 1
    ROUNDED = 2
    CLOSE = 3
    WRONG = 4

    @property
    def style(self) -> str:
        """Name for style sheets."""
        return self.name.lower()


WORDS = {
    Grade.RIGHT: "right",
    Grade.ROUNDED: "right to the digits written",
    Grade.CLOSE: "close",
    Grade.WRONG: "wrong",
}
SIGNS = {Grade.RIGHT: "✓", Grade.ROUNDED: "=", Grade.CLOSE: "≈", Grade.WRONG: "✗"}
ASCII_SIGNS = {Grade.RIGHT: "+", Grade.ROUNDED: "=", Grade.CLOSE: "o", Grade.WRONG: "x"}
_TEXT_COLORS = {Grade.CLOSE: "yellow", Grade.WRONG: "red", Grade.UNKNOWN: ""}
MEANINGS = {
    Grade.RIGHT: f"right: {RIGHT_DIGITS:g} correct digits or more",
    Grade.ROUNDED: "right to the digits written: they allow no more",
    Grade.CLOSE: f"close: {_CLOSE:g} to {RIGHT_DIGITS:g} digits",
    Grade.WRONG: f"wrong: fewer than {_CLOSE:g} digits, off by more than a thousandth of the "
    "column's largest value",
}


def text_color(found: Grade) -> str:
    """Colour of a grade on a terminal."""
    return _TEXT_COLORS.get(found, "green")


def grade(column: ColumnScore) -> Grade:
    """Grade of a column, by the digits as they are shown."""
    scd = column.as_understood.measures.scd
    if scd is None:
        return Grade.UNKNOWN
    digits = round(scd, 1)
    if column.is_right:
        return Grade.RIGHT if digits >= RIGHT_DIGITS else Grade.ROUNDED
    return Grade.CLOSE if digits >= _CLOSE else Grade.WRONG


def file_grade(report: Report) -> Grade:
    """Grade of a file: that of its worst column."""
    return max((grade(c) for m in report.maneuvers for c in m.columns), default=Grade.UNKNOWN)


def is_part(report: Report) -> bool:
    """Whether rows of a maneuver leave out a part of the run that matters."""
    return any(m.coverage < WHOLE for m in report.maneuvers)


def is_start(report: Report) -> bool:
    """Whether all rows are at time 0."""
    return not any(m.part.time.any() for m in report.maneuvers)


def judgement(report: Report) -> str:
    """What a file is, in a word or a few; empty if nothing was compared."""
    found = file_grade(report)
    word = WORDS.get(found, "")
    if not word or found == Grade.WRONG or not is_part(report):
        return word
    if is_start(report):
        return f"only the start is there, which the benchmark gives: {word}"
    return f"{word}, as far as it goes"


def style_of(report: Report) -> str:
    """The grade for style sheets: what is right in part only is not shown as right."""
    found = file_grade(report)
    is_right = found in (Grade.RIGHT, Grade.ROUNDED)
    return (Grade.CLOSE if is_right and is_part(report) else found).style


def meanings(grades: Iterable[Grade], signs: dict[Grade, str]) -> list[tuple[Grade, str]]:
    """What the signs among some grades mean, the best first."""
    return [(g, f"{signs[g]} {MEANINGS[g]}") for g in sorted(set(grades)) if g in MEANINGS]
