"""The report as text for a terminal or a pipe: readable without colours, letters of ASCII only."""

from collections.abc import Callable

from heyoka_bike.errors import printable
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.report import ManeuverScore, Report, Series
from heyoka_bike.showing.formats.grades import ASCII_SIGNS, file_grade, meanings, text_color
from heyoka_bike.showing.formats.matrix import matrix
from heyoka_bike.showing.formats.origin import UNKNOWN, Origin, origin_words
from heyoka_bike.showing.formats.series_table import digits, print_series
from heyoka_bike.showing.formats.text_lists import print_findings, print_requirements
from heyoka_bike.showing.formats.text_page import (
    PROSE,
    Styled,
    TextPage,
    TextTable,
    text_table,
    wrap,
)
from heyoka_bike.showing.formats.wording import (
    contents,
    first_above,
    heading,
    mark,
    mark_meanings,
    notes,
    number,
    one_decimal,
    percent,
    performance_remark,
    performance_words,
    plain,
    reports,
    unit_text,
    verdict,
    warnings_words,
)

_LEAST_WORDS = 16  # letters that a column of words needs, to be shown

_Measure = Callable[[ColumnScore], str]
# Name, cells, and how soon it is left out if there is no room; 0 never.
_SCORES: tuple[tuple[str, _Measure, int], ...] = (
    ("column", lambda c: f"{printable(c.key)} [{unit_text(c.unit)}]", 0),
    ("definition", lambda c: _definition(c), 0),
    ("max\nerror", lambda c: number(c.as_understood.measures.max_abs_error), 0),
    ("rms\nerror", lambda c: number(c.as_understood.measures.rms_error), 2),
    ("rel.\nerror", lambda c: number(c.as_understood.measures.max_rel_error), 4),
    ("scd", lambda c: one_decimal(c.as_understood.measures.scd), 0),
    ("mescd", lambda c: one_decimal(c.as_understood.measures.mescd), 1),
    ("floor", lambda c: number(c.floor), 3),
    ("above\n1e-3 [s]", first_above, 0),
)

_LEGEND = (
    "rel. error: largest error / scale, "
    "the largest absolute value of the reference; scd: correct digits, -log10 of it; mescd: the "
    "same of error / (1 + value); floor: largest error of correctly rounded values with as many "
    "digits; above 1e-3: first time at which the error exceeds 1e-3 of the scale"
)


def render(scored: Report | Series, width: int | None, color: bool, made: Origin = UNKNOWN) -> str:
    """The report of a file or of a series as text.

    Parameters
    ----------
    width
        Columns of text; None for those of the terminal. Tables leave out what does not fit, but
        never cut a number.
    color
        Whether to use the colours of a terminal.
    made
        When and how.
    """
    page = TextPage(width, color)
    if isinstance(scored, Report):
        _print_report(page, scored)
    else:
        print_series(page, scored)
    page.say("")
    first = reports(scored)[0]
    for name, text in origin_words(first, made):
        page.say(f"{name + ':':<11}{text}", "dim", " " * 11)
    return page.text()


def render_maneuver(m: ManeuverScore, width: int | None) -> str:
    """What the report says of a maneuver, without colours."""
    page = TextPage(width, color=False)
    _print_maneuver(page, m)
    return page.text()


def _print_report(page: TextPage, report: Report) -> None:
    page.say(verdict(report), f"bold {text_color(file_grade(report))}", "  ")
    page.say(f"  {'; '.join(filter(None, (contents(report), warnings_words(report))))}")
    _print_matrix(page, report)
    if remark := performance_remark(report):
        page.say("")
        page.say(f"remark: {remark}.", indent="  ")
    if report.said:
        page.head("findings")
        print_findings(page, report.said)
    if report.requirements:
        page.head("requirements")
        print_requirements(page, report.requirements)
    for m in report.maneuvers:
        _print_maneuver(page, m)
    if report.maneuvers:
        page.say("")
        page.say(_LEGEND, "dim")
        page.head("eq. (1) of the benchmark, 100 (max E - min E) / E0 of the file's own energy")
        for m in report.maneuvers:
            page.say(f"  maneuver {m.maneuver}: {performance_words(m)}")
        _print_consistency(page, report)


def _print_matrix(page: TextPage, report: Report) -> None:
    """Correct digits of every column in every maneuver, and what their signs mean."""
    found = matrix(report)
    if not found.rows:
        return
    rows: list[list[str | Styled]] = [
        [printable(row.key), *map(digits, row.cells)] for row in found.rows
    ]
    names = ["correct digits", *(f"maneuver\n{n}" for n in found.maneuvers)]
    view = text_table(names, rows, left=1)
    if not page.fits(view):
        names = ["correct digits\nin maneuver", *map(str, found.maneuvers)]
        view = text_table(names, rows, left=1)
    room = min(page.width, PROSE) - view.width - 2
    if room >= _LEAST_WORDS:
        names.append("taken as")
        for cells, row in zip(rows, found.rows, strict=True):
            cells.append("\n".join(wrap(row.taken, room)))
        view = text_table(names, rows, left=1, words=True)
    page.say("")
    page.show(view)
    if found.left_out:
        page.say(f"and {found.left_out} more columns, none with fewer digits", "dim")
    said = [text for _, text in meanings(found.grades, ASCII_SIGNS)]
    page.say("; ".join(said), "dim")


def _print_maneuver(page: TextPage, m: ManeuverScore) -> None:
    facts = f"{m.rows} rows, {plain(m.t_start)} to {plain(m.t_end)} s"
    if m.step is not None:
        facts += f", every {plain(m.step)} s"
    if m.coverage < 1:
        facts += f", {percent(m.coverage)} of the reference"
    page.head(f"{heading(m)}: {facts}", "  ")
    if not m.columns:
        page.say("  no column could be compared")
        return
    marks = mark_meanings(m.columns)
    dropped = sorted({order for _, _, order in _SCORES})
    view = _scores(m, 0)
    for order in dropped[1:]:
        if page.fits(view):
            break
        view = _scores(m, order)
    page.show(view)
    if marks:
        page.say("; ".join(marks), "dim")


def _scores(m: ManeuverScore, dropped: int) -> TextTable:
    """Table of scores without the columns that are dropped first, up to an order."""
    kept = [(name, cell) for name, cell, order in _SCORES if not 0 < order <= dropped]
    rows = [[cell(c) for _, cell in kept] for c in m.columns]
    return text_table([name for name, _ in kept], rows, left=2)


def _definition(c: ColumnScore) -> str:
    """The definition, and below it what else is not the default."""
    name = printable(c.as_understood.definition) + mark(c)
    return "\n".join([name, *(f"  {note}" for note in notes(c))])


def _print_consistency(page: TextPage, report: Report) -> None:
    lines = []
    for m in report.maneuvers:
        c, parts = m.consistency, []
        if c.energy_sum is not None:
            explained = "" if c.energy_sum_floor is None else (
                f" (rounding explains {number(c.energy_sum_floor)} J)"
            )  # fmt: skip
            parts.append(
                f"potential + kinetic - mechanical energy {number(c.energy_sum)} J{explained}"
            )
        for name, value in (("roll", c.roll_rate), ("steer", c.steer_rate)):
            if value is not None:
                parts.append(f"{name} rate - derivative of the angle {number(value)} rad/s")
        if parts:
            lines.append(f"  maneuver {m.maneuver}: {'; '.join(parts)}")
    if lines:
        page.head("the file against itself")
        for line in lines:
            page.say(line, indent="    ")
