"""A report, a diagnosis or a series: what its summary says, and in a notebook its tables."""

from heyoka_bike.scoring.report import Report, Series
from heyoka_bike.showing.formats import diagnosis, matrix_table, summary, tables
from heyoka_bike.showing.formats.html import verdict_parts
from heyoka_bike.showing.formats.html_parts import (
    asked,
    capital,
    finding_list,
    remark,
    requirement_list,
)
from heyoka_bike.showing.formats.markup import prose
from heyoka_bike.showing.formats.output import WIDTH
from heyoka_bike.showing.formats.wording import heading, run_name, series_verdict
from heyoka_bike.showing.views import maneuver
from heyoka_bike.showing.views.card import card, folded


def text(scored: Report | Series) -> str:
    """Ten lines at most; of a diagnosis what the command of that name prints."""
    if isinstance(scored, Report) and scored.diagnosis:
        return diagnosis.render(scored)
    return summary.render(scored, WIDTH, False, in_python=True).rstrip("\n")


def html(scored: Report | Series) -> str:
    """Verdict and digits; what more there is is folded."""
    return card(*(_report(scored) if isinstance(scored, Report) else _series(scored)))


def _report(report: Report) -> list[str]:
    said = [f for f in report.findings if f not in report.diagnosis]
    return [
        *verdict_parts(report),
        folded("Why it differs", finding_list(report.diagnosis), is_open=True),
        matrix_table.of_report(report),
        remark(report),
        folded("Requirements", requirement_list(report.requirements), is_open=not report.passed),
        folded(f"Findings ({len(said)})", finding_list(tuple(said))),
        *(folded(capital(heading(m)), maneuver.parts(m)) for m in report.maneuvers),
    ]


def _series(series: Series) -> list[str]:
    numbers = sorted({c.maneuver for c in series.convergence})
    return [
        f'<p class="verdict">{prose(capital(series_verdict(series)))}.</p>',
        asked(series),
        matrix_table.of_series(series),
        folded(f"Findings ({len(series.findings)})", finding_list(series.findings)),
        *(folded(f"Errors in maneuver {n}", tables.convergence(series, n)) for n in numbers),
        *(folded(run_name(series, r), "".join(_report(r.report))) for r in series.runs),
    ]
