"""A score with its diagnosis: what explains a file is among its findings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import Alignment, restricted
from heyoka_bike.scoring.diagnosis.answers import explanation, findings
from heyoka_bike.scoring.diagnosis.ranking import diagnose
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.report import Report

_NOTHING = Finding(
    "nothing_to_diagnose",
    "the diagnosis looks at the benchmark's columns, and none of them has a value: "
    + ", ".join(BENCHMARK_COLUMNS),
    Severity.WARNING,
)


def diagnosed(
    alignment: Alignment, report: Report, reference: Reference,
    progress: Callable[[float], None] = lambda _: None,
) -> Report:  # fmt: skip
    """The report of a file with the findings of its diagnosis first, and what the figure shows.

    Only the columns of the benchmark are diagnosed. Without them, or without heyoka, little or
    nothing can be said; the findings tell.
    """
    judged = restricted(alignment, BENCHMARK_COLUMNS)
    if not any(part.has_values() for part in judged.parts):
        return replace(report, findings=(_NOTHING, *report.findings))
    found = diagnose(judged, reference, progress=progress)
    said = findings(found, _of_benchmark(report), reference)
    return replace(report, findings=said + report.findings, explanation=explanation(found, said))


def _of_benchmark(report: Report) -> Report:
    maneuvers = tuple(
        replace(m, columns=tuple(c for c in m.columns if c.key in BENCHMARK_COLUMNS))
        for m in report.maneuvers
    )
    return replace(report, maneuvers=maneuvers)
