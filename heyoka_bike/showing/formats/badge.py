"""The verdict as a badge for a README: JSON for a shields.io endpoint.

https://shields.io/badges/endpoint-badge explains its keys. The content does not depend on the time
or place of writing.
"""

import json

from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.showing.wording.grade_text import WORDS, file_grade, style_of
from heyoka_bike.showing.wording.number_text import correct_digits
from heyoka_bike.showing.wording.run_text import chosen
from heyoka_bike.showing.wording.verdict_text import PHRASES

LABEL = "uncontrolled bicycle"
COLORS = {
    Grade.UNKNOWN: "lightgrey",
    Grade.RIGHT: "brightgreen",
    Grade.UNTOLD: "yellow",
    Grade.CLOSE: "yellow",
    Grade.WRONG: "red",
}
"""Colour names of shields.io."""


def render(scored: Report | Series) -> str:
    """Render the badge of a file, or of the run of a series that its report shows in full."""
    report = scored if isinstance(scored, Report) else chosen(scored)[1].report
    document = {
        "schemaVersion": 1,
        "label": LABEL,
        "message": _message(report),
        "color": COLORS[Grade[style_of(report).upper()]],
    }
    return json.dumps(document, indent=2) + "\n"


def _message(report: Report) -> str:
    """Return the grade in words, and the correct digits of the worst column."""
    found = report.worst
    if found is None:
        return PHRASES["nothing"]
    part = "" if report.is_whole else PHRASES["in_part"]
    digits = correct_digits(max(found.scd, 0.0))
    return f"{WORDS[file_grade(report)]}{part}, {digits} {PHRASES['correct_digits']}"
