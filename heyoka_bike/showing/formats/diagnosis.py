"""A diagnosis as text: the verdict, the conventions, and why the results differ."""

import textwrap

from heyoka_bike.scoring.conventions import DEFAULT
from heyoka_bike.scoring.report import Report
from heyoka_bike.showing.formats.wording import verdict

_WIDTH = 96
# Findings of the score that are said before the diagnosis, which leaves these columns out.
_BESIDE = ("definition_unknown", "never_filled")


def render(report: Report) -> str:
    """Paragraphs, the likeliest cause first."""
    said = {f.code: f.message for f in report.findings}
    paragraphs = [verdict(report), said.get("conventions", DEFAULT)]
    paragraphs += [f.message for f in report.findings if f.code in _BESIDE]
    paragraphs += [f.message for f in report.diagnosis]
    return "\n\n".join(textwrap.fill(p, _WIDTH, break_long_words=False) for p in paragraphs)
