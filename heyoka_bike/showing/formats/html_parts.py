"""Pieces of the HTML report that pages of one file and of several have in common."""

from html import escape

from heyoka_bike.errors import printable
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.report import ManeuverScore, Report, Requirement, Series
from heyoka_bike.showing.formats import tables
from heyoka_bike.showing.formats.charts import all_errors, one_column
from heyoka_bike.showing.formats.definition_table import definitions
from heyoka_bike.showing.formats.markup import prose
from heyoka_bike.showing.formats.wording import (
    by_severity,
    heading,
    number,
    percent,
    performance_remark,
    performance_words,
    plain,
    requirement_words,
    sentence,
)


def asked(scored: Report | Series) -> str:
    """Whether the requirements are met; empty without any."""
    said = requirement_words(scored)
    if not said:
        return ""
    style, sign = ("right", "✓") if scored.passed else ("wrong", "✗")
    return (
        f'<p class="asked {style}"><span aria-hidden="true">{sign}</span> '
        f"{prose(capital(said))}.</p>"
    )


def remark(report: Report) -> str:
    """What eq. (1) says, and what it sees; empty if the benchmark judges none of the maneuvers."""
    said = performance_remark(report)
    return f'<p class="remark"><b>Remark.</b> {prose(capital(said))}.</p>' if said else ""


def links(links: list[tuple[str, str]]) -> str:
    """Places of the page, as a list of links."""
    items = "".join(f'<li><a href="#{where}">{escape(said)}</a></li>' for where, said in links)
    return f'<nav aria-label="Contents"><ul>{items}</ul></nav>'


def section(name: str, title: str, content: str) -> str:
    """A section with a heading; empty without content."""
    return f'<section id="{name}"><h2>{title}</h2>{content}</section>' if content else ""


def requirement_list(requirements: tuple[Requirement, ...]) -> str:
    """Each requirement with what came of it."""
    items = "".join(
        f'<li class="{"passed" if r.met else "failed"}"><b>{"✓ met" if r.met else "✗ FAILED"}</b> '
        f"<code>{escape(printable(r.text))}</code> <span>found {prose(sentence(r.message))}</span>"
        "</li>"
        for r in requirements
    )
    return f'<ul class="said">{items}</ul>' if items else ""


def finding_list(findings: tuple[Finding, ...]) -> str:
    """Each finding with its severity, warnings first."""
    items = "".join(
        f'<li class="{f.severity}"><b>{f.severity}</b> {prose(capital(sentence(f.message)))}</li>'
        for f in by_severity(findings)
    )
    return f'<ul class="said">{items}</ul>' if items else ""


def maneuver(m: ManeuverScore, level: int, explained: bool) -> str:
    """All that is known of a maneuver: scores, charts, definitions."""
    h, sub = f"h{level}", f"h{level + 1}"
    every = "" if m.step is None else f", every {plain(m.step)} s"
    facts = f"{m.rows} rows, {plain(m.t_start)} to {plain(m.t_end)} s{every}"
    parts = [
        f'<section id="maneuver-{m.maneuver}"><{h}>{escape(capital(heading(m)))}</{h}>'
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


def capital(text: str) -> str:
    """With a large first letter, unless that is of a name: of a column, or of a file."""
    first = text.partition(" ")[0].rstrip(".:")
    is_name = "_" in first or "." in first
    return text if is_name else text[:1].upper() + text[1:]


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
