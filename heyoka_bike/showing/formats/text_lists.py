"""Findings and requirements as lists of text."""

from collections.abc import Sequence

from heyoka_bike.errors import printable
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.report import Requirement
from heyoka_bike.showing.formats.text_page import TextPage
from heyoka_bike.showing.formats.wording import by_severity, sentence


def print_findings(page: TextPage, findings: Sequence[Finding]) -> None:
    """Each with its severity, warnings first."""
    for f in by_severity(tuple(findings)):
        is_warning = f.severity == Severity.WARNING
        mark, style = ("WARNING", "bold yellow") if is_warning else ("info", "dim")
        page.listed(mark, style, sentence(f.message))


def print_requirements(page: TextPage, requirements: Sequence[Requirement]) -> None:
    """Each with what came of it."""
    for r in requirements:
        mark, style = ("ok", "green") if r.met else ("FAILED", "bold red")
        page.listed(mark, style, f"{printable(r.text)}: found {sentence(r.message)}")
