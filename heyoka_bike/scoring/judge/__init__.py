"""Findings: what the numbers of a report mean, in words. Each rule is a function of the report."""

from collections.abc import Callable, Iterable
from dataclasses import replace

from heyoka_bike.scoring.alignment import ANOTHER_ORDER
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.judge import columns, contradictions
from heyoka_bike.scoring.report import ManeuverScore, Report

RULES: tuple[Callable[[Report], Iterable[Finding]], ...] = (
    columns.conventions,
    columns.understood,
    columns.odd_signs,
    columns.unknown,
    contradictions.time_shifted,
    contradictions.coverage,
    contradictions.energy_hides_error,
    contradictions.against_itself,
    contradictions.digits_written,
    contradictions.single_precision,
)
"""In the order in which their findings are said."""


def judged(report: Report) -> Report:
    """A report with what is worth saying about it, by every rule."""
    # Of columns that are others than they are taken for nothing else can be said.
    is_moved = any(f.code == ANOTHER_ORDER for f in report.findings)
    found = tuple(finding for rule in (() if is_moved else RULES) for finding in rule(report))
    odd = (f.evidence["columns"] for f in found if f.code == columns.SIGNS_DISAGREE)
    contradicted = {key for keys in odd for key in keys}

    def marked(m: ManeuverScore) -> ManeuverScore:
        found = (replace(c, is_contradicted=c.key in contradicted) for c in m.columns)
        return replace(m, columns=tuple(found))

    maneuvers = tuple(map(marked, report.maneuvers)) if contradicted else report.maneuvers
    return replace(report, findings=report.findings + found, maneuvers=maneuvers)
