"""The report as one HTML page that needs nothing else: tables, charts, and what they mean.

Readable without script and on paper; the script only reads values off the charts.
"""

from html import escape
from pathlib import Path

from heyoka_bike.errors import printable
from heyoka_bike.scoring.report import Explanation, Report, Series
from heyoka_bike.showing.formats import matrix_table
from heyoka_bike.showing.formats.charts import explained
from heyoka_bike.showing.formats.grades import SIGNS, file_grade, style_of
from heyoka_bike.showing.formats.html_parts import (
    asked,
    capital,
    finding_list,
    links,
    maneuver,
    remark,
    requirement_list,
    section,
)
from heyoka_bike.showing.formats.markup import PAGE_STYLE, page, prose
from heyoka_bike.showing.formats.origin import UNKNOWN, Origin, origin_words
from heyoka_bike.showing.formats.series_page import series_body
from heyoka_bike.showing.formats.wording import (
    caveats,
    contents,
    graded,
    reports,
    run_name,
    sentence,
    warnings_words,
    worst_error_words,
)

SCRIPT = Path(__file__).with_name("page.js").read_text(encoding="utf-8")
"""Of every report."""


def render(scored: Report | Series, made: Origin = UNKNOWN) -> str:
    """The report of a file or of a series as an HTML page.

    Parameters
    ----------
    made
        When and how, for the foot of the page.
    """
    if isinstance(scored, Report):
        title = printable(Path(scored.file.path).name or scored.file.path)
        body = _report(scored, title)
    else:
        what = "runs" if scored.is_one_program else "programs"
        names = ", ".join(run_name(scored, run) for run in scored.runs)
        title = f"{len(scored.runs)} {what}: {names}"
        body = series_body(scored)
    first = reports(scored)[0]
    return page(
        f"{title} – uncontrolled bicycle", body, origin_words(first, made),
        styles=(PAGE_STYLE,), script=SCRIPT,
    )  # fmt: skip


def _report(report: Report, title: str) -> str:
    parts = [
        f'<header><p class="kicker">Uncontrolled bicycle: score of</p><h1>{escape(title)}</h1>',
        *verdict_parts(report),
        matrix_table.of_report(report),
        remark(report),
        _contents(report),
        "</header>",
        section("requirements", "Requirements", requirement_list(report.requirements)),
        section("findings", "Findings", finding_list(report.said)),
        section("explanation", "What explains it", _explanation(report.explanation)),
        *(maneuver(m, 2, m is report.maneuvers[0]) for m in report.maneuvers),
    ]
    return "\n".join(parts)


def verdict_parts(report: Report) -> list[str]:
    """What the file is worth by its true error, then what it holds."""
    grade = file_grade(report)
    text = capital("; ".join([graded(report), *caveats(report)]))
    sign = SIGNS.get(grade, "")
    parts = [
        f'<p class="verdict {style_of(report)}">'
        + (f'<span aria-hidden="true">{sign}</span> ' if sign else "")
        + f"{prose(text)}.</p>"
    ]
    if worst_error := worst_error_words(report):
        parts.append(f'<p class="worst">{prose(capital(worst_error))}.</p>')
    parts.append(asked(report))
    warnings = warnings_words(report)
    noted = f'; <a href="#findings">{warnings}</a>' if warnings else ""
    path = escape(printable(report.file.path))
    parts.append(f'<p class="facts">{escape(contents(report))}{noted} <span>{path}</span></p>')
    return parts


def _contents(report: Report) -> str:
    places = [("requirements", "Requirements")] if report.requirements else []
    places += [("findings", "Findings")] if report.said else []
    places += [("explanation", "What explains it")] if report.explanation else []
    places += [(f"maneuver-{m.maneuver}", f"Maneuver {m.maneuver}") for m in report.maneuvers]
    return links(places)


def _explanation(e: Explanation | None) -> str:
    if e is None:
        return ""
    return f'<p class="said">{prose(capital(sentence(e.says)))}.</p>{explained(e)}'
