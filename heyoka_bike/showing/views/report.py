"""A report, a diagnosis or a series: what its summary says, and in a notebook its tables."""

from collections.abc import Iterator

from heyoka_bike.scoring.report import Report, Series
from heyoka_bike.showing.document import Block, Chapter
from heyoka_bike.showing.formats import diagnosis, matrix, summary
from heyoka_bike.showing.formats import report as single
from heyoka_bike.showing.formats import series as several
from heyoka_bike.showing.formats.output import WIDTH
from heyoka_bike.showing.wording import run_name


def text(scored: Report | Series) -> str:
    """Ten lines at most; of a diagnosis what the command of that name prints."""
    if isinstance(scored, Report) and scored.diagnosis:
        return diagnosis.render(scored)
    return summary.render(scored, WIDTH, False, in_python=True).rstrip("\n")


def blocks(scored: Report | Series) -> tuple[Block, ...]:
    """Verdict and digits; what more there is is folded."""
    return tuple(_report(scored) if isinstance(scored, Report) else _series(scored))


def _report(report: Report) -> Iterator[Block]:
    said = [f for f in report.findings if f not in report.diagnosis]
    required = single.requirements(report.requirements)
    yield from single.verdict_of(report)
    yield _folded("Why it differs", single.findings(report.diagnosis), is_open=True)
    yield matrix.of_report(report)
    yield single.remark(report)
    yield _folded("Requirements", required, is_open=not report.passed)
    yield _folded(f"Findings ({len(said)})", single.findings(said))
    yield from (single.maneuver(m, is_within=True) for m in report.maneuvers)


def _series(series: Series) -> Iterator[Block]:
    yield from several.verdict_of(series)
    yield _folded(f"Findings ({len(series.findings)})", single.findings(series.findings))
    for n in several.maneuvers_of(series):
        yield _folded(f"Errors in maneuver {n}", several.convergence(series, n))
    for run in series.runs:
        yield _folded(run_name(series, run), *_report(run.report))


def _folded(title: str, *content: Block, is_open: bool = False) -> Chapter:
    return Chapter(title, content, is_folded=True, is_open=is_open)
