"""The HTML report of several files: runs of one program, or programs side by side."""

from html import escape

from heyoka_bike.scoring.report import Run, Series
from heyoka_bike.showing.formats import matrix_table, series_charts, tables
from heyoka_bike.showing.formats.grades import style_of
from heyoka_bike.showing.formats.html_parts import (
    asked,
    capital,
    finding_list,
    links,
    maneuver,
    requirement_list,
    section,
)
from heyoka_bike.showing.formats.markup import prose
from heyoka_bike.showing.formats.wording import (
    chosen,
    graded,
    heading,
    run_name,
    run_words,
    series_verdict,
)


def series_body(series: Series) -> str:
    """Body of the page."""
    numbers = sorted({c.maneuver for c in series.convergence})
    parts = _runs(series, numbers) if series.is_one_program else _programs(series, numbers)
    return "\n".join(parts)


def _header(series: Series, title: str, places: list[tuple[str, str]]) -> list[str]:
    """Verdict, then digits by maneuver."""
    style = f" {style_of(chosen(series)[1].report)}" if series.is_one_program else ""
    return [
        f'<header><p class="kicker">Uncontrolled bicycle: score of</p><h1>{title}</h1>',
        f'<p class="verdict{style}">{prose(capital(series_verdict(series)))}.</p>',
        asked(series),
        matrix_table.of_series(series),
        links(places),
        "</header>",
        section("findings", "Findings", finding_list(series.findings)),
    ]


def _runs(series: Series, numbers: list[int]) -> list[str]:
    has_steps = any(run.step is not None for run in series.runs)
    compared = "Convergence" if has_steps else "Errors of the runs"
    name, shown_run = chosen(series)
    best = shown_run.report
    places = [(f"convergence-{n}", f"{compared}, maneuver {n}") for n in numbers]
    places += [("runs", "Runs"), ("in-full", f"{capital(name)} run")]
    parts = _header(series, f"{len(series.runs)} runs of one program", places)
    parts += [
        f'<section id="convergence-{n}"><h2>{compared}, maneuver {n}</h2>'
        f"{series_charts.convergence(series, n)}{series_charts.work_precision(series, n)}"
        f"{tables.convergence(series, n)}</section>"
        for n in numbers
    ]
    parts.append('<section id="runs"><h2>Runs</h2>')
    for run in series.runs:
        parts += [f"<h3>{escape(run_words(run))}</h3>", *_said(run)]
        if run is not shown_run:
            parts += _scores(run, "h4")
    parts.append("</section>")
    parts.append(
        f'<section id="in-full"><h2>{capital(name)} run: {escape(run_words(shown_run))}</h2>'
    )
    parts += [maneuver(m, 3, m is best.maneuvers[0]) for m in best.maneuvers]
    parts.append("</section>")
    return parts


def _programs(series: Series, numbers: list[int]) -> list[str]:
    places = [(f"maneuver-{n}", f"Maneuver {n}") for n in numbers]
    names = [run_name(series, run) for run in series.runs]
    places += [(f"program-{i}", name) for i, name in enumerate(names, start=1)]
    parts = _header(series, f"{len(series.runs)} programs side by side", places)
    parts += [
        f'<section id="maneuver-{n}"><h2>Maneuver {n}</h2>{matrix_table.side_by_side(series, n)}'
        f"<h3>Error over time</h3>{series_charts.side_by_side(series, n)}"
        f"<h3>Largest errors</h3>{tables.convergence(series, n)}</section>"
        for n in numbers
    ]
    for i, (name, run) in enumerate(zip(names, series.runs, strict=True), start=1):
        parts.append(f'<section id="program-{i}"><h2>{escape(name)}</h2>')
        parts.append(f'<p class="facts">{escape(run_words(run))}</p>')
        parts += [*_said(run), *_scores(run, "h3", i == 1)]
        parts.append("</section>")
    return parts


def _said(run: Run) -> list[str]:
    return [
        f'<p class="said">{prose(capital(graded(run.report)))}.</p>',
        requirement_list(run.report.requirements),
        finding_list(run.report.findings),
    ]


def _scores(run: Run, tag: str, explained: bool = False) -> list[str]:
    """Tables of all maneuvers; below the first what their headings mean, if that is asked."""
    shown = (
        (heading(m), tables.scores(m, explained and not i))
        for i, m in enumerate(run.report.maneuvers)
    )
    return [f"<{tag}>{escape(capital(name))}</{tag}>{table}" for name, table in shown]
