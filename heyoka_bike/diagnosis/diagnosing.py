"""A score with its diagnosis: what explains a file is among its findings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from heyoka_bike.alignment import Alignment, restricted
from heyoka_bike.columns import BENCHMARK_COLUMNS
from heyoka_bike.diagnosis.ranking import diagnose
from heyoka_bike.diagnosis.words import explanation, findings
from heyoka_bike.errors import NothingScoredError
from heyoka_bike.reference import Reference
from heyoka_bike.report import Report


def diagnosed(
    alignment: Alignment, report: Report, reference: Reference,
    progress: Callable[[float], None] = lambda _: None,
) -> Report:  # fmt: skip
    """The report of a file with the findings of its diagnosis first, and what the figure shows.

    Only the columns of the benchmark are diagnosed. Without heyoka little can be simulated; the
    findings say so.

    Raises
    ------
    NothingScoredError
        The file has none of them.
    """
    judged = restricted(alignment, BENCHMARK_COLUMNS)
    if not any(part.values for part in judged.parts):
        raise NothingScoredError(
            f"{alignment.file.path}: found none of the benchmark's columns, expected some of "
            f"{', '.join(BENCHMARK_COLUMNS)} to diagnose"
        )
    found = diagnose(judged, reference, progress=progress)
    said = findings(found, report, reference)
    return replace(report, findings=said + report.findings, explanation=explanation(found, said))
