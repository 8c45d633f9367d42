"""The report as one HTML page that needs nothing else: tables, charts, and what they mean.

Readable without script and on paper; the script only reads values off the charts.
"""

from html import escape
from pathlib import Path

from heyoka_bike.errors import printable
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.measures import MOST_DIGITS
from heyoka_bike.scoring.report import Explanation, ManeuverScore, Report, Requirement, Series
from heyoka_bike.showing.formats import series_charts, tables
from heyoka_bike.showing.formats.charts import all_errors, explained, one_column
from heyoka_bike.showing.formats.definition_table import definitions
from heyoka_bike.showing.formats.markup import PAGE_STYLE, page, prose
from heyoka_bike.showing.formats.wording import (
    by_severity,
    chosen,
    coverage_words,
    digits_words,
    heading,
    is_judged,
    is_whole,
    label,
    limit_text,
    number,
    passes,
    percent,
    performance_words,
    plain,
    readable,
    reports,
    requirement_words,
    run_words,
    sentence,
    series_verdict,
    worst,
    worst_words,
)

_SCRIPT = Path(__file__).with_name("page.js")


def render(scored: Report | Series) -> str:
    """The report of a file or of a series as an HTML page."""
    if isinstance(scored, Report):
        title = printable(Path(scored.file.path).name or scored.file.path)
        body = _report(scored, title)
    else:
        title = f"{len(scored.runs)} runs: " + ", ".join(
            printable(Path(r.report.file.path).name) for r in scored.runs
        )
        body = _series(scored)
    first = reports(scored)[0]
    title = f"{title} – uncontrolled bicycle"
    source = printable(first.bicycle), printable(first.dataset_version)
    return page(title, body, source, styles=(PAGE_STYLE,), script=_SCRIPT)


def _report(report: Report, title: str) -> str:
    parts = [
        f'<header><p class="kicker">Uncontrolled bicycle: score of</p><h1>{escape(title)}</h1>',
        *_verdict(report),
        _contents(report),
        "</header>",
        _section("requirements", "Requirements", _requirement_list(report.requirements)),
        _section("findings", "Findings", _finding_list(report.said)),
        _section("explanation", "What explains it", _explanation(report.explanation)),
        *(_maneuver(m, 2, m is report.maneuvers[0]) for m in report.maneuvers),
    ]
    return "\n".join(parts)


def _series(series: Series) -> str:
    has_steps = any(run.step is not None for run in series.runs)
    compared = "Convergence" if has_steps else "Errors of the runs"
    numbers = sorted({c.maneuver for c in series.convergence})
    name, shown_run = chosen(series)
    best = shown_run.report
    links = [(f"convergence-{n}", f"{compared}, maneuver {n}") for n in numbers]
    links += [("runs", "Runs"), ("in-full", f"{_capital(name)} run")]
    parts = [
        '<header><p class="kicker">Uncontrolled bicycle: score of</p>'
        f"<h1>{len(series.runs)} runs of one program</h1>",
        f'<p class="verdict">{prose(_capital(series_verdict(series)))}.</p>',
        _tiles(best, _requirement_tile(series)),
        _links(links),
        "</header>",
        _section("findings", "Findings", _finding_list(series.findings)),
    ]
    parts += [
        f'<section id="convergence-{n}"><h2>{compared}, maneuver {n}</h2>'
        f"{series_charts.convergence(series, n)}{series_charts.work_precision(series, n)}"
        f"{tables.convergence(series, n)}</section>"
        for n in numbers
    ]
    parts.append('<section id="runs"><h2>Runs</h2>')
    for run in series.runs:
        parts.append(f"<h3>{escape(run_words(run))}</h3>")
        parts += [f'<p class="said">{prose(_capital(worst_words(run.report)))}.</p>']
        parts += [_requirement_list(run.report.requirements), _finding_list(run.report.findings)]
        if run is not shown_run:
            for m in run.report.maneuvers:
                parts.append(f"<h4>{escape(_capital(heading(m)))}</h4>{tables.scores(m, False)}")
    parts.append("</section>")
    title = escape(printable(best.file.path))
    parts.append(f'<section id="in-full"><h2>{_capital(name)} run: {title}</h2>')
    parts += [_maneuver(m, 3, m is best.maneuvers[0]) for m in best.maneuvers]
    parts.append("</section>")
    return "\n".join(parts)


def _verdict(report: Report) -> list[str]:
    f = report.file
    covered = coverage_words(report)
    facts = [
        f"{f.rows} rows",
        f"{plain(f.t_start)} to {plain(f.t_end)} s",
        digits_words(report),
        f"{printable(f.format)} file",
    ]
    text = _capital(worst_words(report)) + (f"; {covered}" if covered else "")
    return [
        f'<p class="verdict">{prose(text)}.</p>',
        f'<p class="facts">{escape(", ".join(facts))} <span>{escape(printable(f.path))}</span></p>',
        _tiles(report, _requirement_tile(report)),
    ]


def _requirement_tile(scored: Report | Series) -> str:
    said = requirement_words(scored)
    if not said:
        return ""
    return _tile("passed" if scored.passed else "failed", _capital(said), "what was asked for")


def _tiles(report: Report, first: str) -> str:
    """The answers to what everyone asks first."""
    tiles = [first]
    found = worst(report)
    if found is not None:
        m, c = found
        scd = c.as_understood.measures.scd
        assert scd is not None
        tiles.append(
            _tile(
                "",
                "No error at all" if scd >= MOST_DIGITS else f"{max(scd, 0.0):.1f} correct digits",
                f"worst column: {label(c.key)} of maneuver {m.maneuver}",
            )
        )
    for m in report.maneuvers:
        if is_judged(m):
            state = {True: "passed", False: "failed", None: ""}[passes(m)]
            words = {
                "passed": "Passes eq. (1)" if is_whole(m) else "Passes eq. (1) so far",
                "failed": "Fails eq. (1)",
                "": "No energy to judge",
            }
            drift = "" if m.performance is None else f" {readable(m.performance)} %,"
            about = f"energy drift of maneuver {m.maneuver}:{drift} allowed {limit_text(m)}"
            tiles.append(_tile(state, words[state], about))
    if report.maneuvers:
        least = min(m.coverage for m in report.maneuvers)
        count = len(report.maneuvers)
        said = f"of {'each of ' if count > 1 else ''}{count} maneuver{'s' if count > 1 else ''}"
        tiles.append(_tile("", f"{percent(least)} covered", said))
    return f'<ul class="tiles">{"".join(tiles)}</ul>'


def _tile(state: str, said: str, about: str) -> str:
    mark = {"passed": "✓ ", "failed": "✗ "}.get(state, "")
    return (
        f'<li class="{state}"><strong>{mark}{prose(said)}</strong><span>{prose(about)}</span></li>'
    )


def _contents(report: Report) -> str:
    links = [("requirements", "Requirements")] if report.requirements else []
    links += [("findings", "Findings")] if report.said else []
    links += [("explanation", "What explains it")] if report.explanation else []
    links += [(f"maneuver-{m.maneuver}", f"Maneuver {m.maneuver}") for m in report.maneuvers]
    return _links(links)


def _links(links: list[tuple[str, str]]) -> str:
    items = "".join(f'<li><a href="#{where}">{escape(said)}</a></li>' for where, said in links)
    return f'<nav aria-label="Contents"><ul>{items}</ul></nav>'


def _section(name: str, title: str, content: str) -> str:
    return f'<section id="{name}"><h2>{title}</h2>{content}</section>' if content else ""


def _requirement_list(requirements: tuple[Requirement, ...]) -> str:
    items = "".join(
        f'<li class="{"passed" if r.met else "failed"}"><b>{"✓ met" if r.met else "✗ FAILED"}</b> '
        f"<code>{escape(printable(r.text))}</code> <span>found {prose(sentence(r.message))}</span>"
        "</li>"
        for r in requirements
    )
    return f'<ul class="said">{items}</ul>' if items else ""


def _explanation(e: Explanation | None) -> str:
    if e is None:
        return ""
    return f'<p class="said">{prose(_capital(sentence(e.says)))}.</p>{explained(e)}'


def _finding_list(findings: tuple[Finding, ...]) -> str:
    items = "".join(
        f'<li class="{f.severity}"><b>{f.severity}</b> {prose(_capital(sentence(f.message)))}</li>'
        for f in by_severity(findings)
    )
    return f'<ul class="said">{items}</ul>' if items else ""


def _maneuver(m: ManeuverScore, level: int, explained: bool) -> str:
    h, sub = f"h{level}", f"h{level + 1}"
    every = "" if m.step is None else f", every {plain(m.step)} s"
    facts = f"{m.rows} rows, {plain(m.t_start)} to {plain(m.t_end)} s{every}"
    parts = [
        f'<section id="maneuver-{m.maneuver}"><{h}>{escape(_capital(heading(m)))}</{h}>'
        f'<p class="facts">{escape(facts)}, {percent(m.coverage)} of the reference.</p>',
        tables.scores(m, explained),
        _consistency(m),
        f"<{sub}>Error over time</{sub}>{all_errors(m)}",
    ]
    compared = definitions(m)
    if compared:
        parts.append(f"<{sub}>Which definition</{sub}>{compared}")
    if m.columns:
        parts.append(
            f'<{sub}>Column by column</{sub}><p class="said">Above, the result on top of the '
            "reference; below, their distance on a logarithmic scale, where each thin line is a "
            "factor of ten. The dotted line is the floor: so far off exact values may be, once "
            "rounded to the digits of the file.</p>"
        )
        parts.append(f'<div class="columns">{"".join(one_column(m, c) for c in m.columns)}</div>')
    parts.append("</section>")
    return "\n".join(parts)


def _consistency(m: ManeuverScore) -> str:
    """What the file says about itself, each with its explanation."""
    c = m.consistency
    rows = [
        ("eq. (1), 100 (max E − min E) / E₀", performance_words(m),
         "drift of the file's own mechanical energy, the only thing the benchmark judges"),
    ]  # fmt: skip
    if c.energy_sum is not None:
        said = f"{number(c.energy_sum)} J"
        if c.energy_sum_floor is not None:
            said += f" (rounding explains {number(c.energy_sum_floor)} J)"
        rows.append(("energies", said, "potential + kinetic against mechanical energy"))
    for name, value in (("roll rate", c.roll_rate), ("steer rate", c.steer_rate)):
        if value is not None:
            said = "against the derivative of the file's own angle"
            rows.append((name, f"{number(value)} rad/s", said))
    items = "".join(
        f"<dt>{escape(a)}</dt><dd><b>{prose(b)}</b> <span>{escape(said)}</span></dd>"
        for a, b, said in rows
    )
    return f'<dl class="facts">{items}</dl>'


def _capital(text: str) -> str:
    is_name = "_" in text.partition(" ")[0]
    return text if is_name else text[:1].upper() + text[1:]
