"""A diagnosis as text: the verdict, the conventions, and why the results differ."""

import textwrap

from heyoka_bike.scoring.judge.columns import DEFAULT, ODD_SIGNS, UNITS_BESIDE
from heyoka_bike.scoring.report import Report
from heyoka_bike.showing.wording import verdict

_WIDTH = 96
# Findings of the score that are said before the diagnosis, which leaves these columns out.
_BESIDE = ("definition_unknown", "never_filled", *ODD_SIGNS)


def render(report: Report) -> str:
    """Paragraphs, the likeliest cause first."""
    said = {f.code: f.message for f in report.findings}
    is_usual = not any(code in said for code in ODD_SIGNS)
    is_usual &= not any(f.code == UNITS_BESIDE for f in report.diagnosis)
    default = DEFAULT if is_usual else ""
    paragraphs = [p for p in (verdict(report), said.get("conventions", default)) if p]
    paragraphs += [f.message for f in report.findings if f.code in _BESIDE]
    paragraphs += [f.message for f in report.diagnosis]
    return "\n\n".join(textwrap.fill(p, _WIDTH, break_long_words=False) for p in paragraphs)
