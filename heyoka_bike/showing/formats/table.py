"""The report as text for a terminal or a pipe: readable without colours, letters of ASCII only."""

import io
import re
import shutil
import textwrap
from collections.abc import Callable, Sequence
from typing import Literal

from rich.box import Box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from heyoka_bike.errors import printable
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.report import (
    ColumnScore,
    Convergence,
    ManeuverScore,
    Report,
    Requirement,
    Series,
)
from heyoka_bike.showing.formats.wording import (
    by_severity,
    chosen,
    first_above,
    heading,
    label,
    mark,
    notes,
    number,
    one_decimal,
    percent,
    performance_words,
    plain,
    run_words,
    sentence,
    series_verdict,
    unit_text,
    verdict,
)

_KEPT = "\N{NO-BREAK SPACE}"
_PROSE = 100  # the longest line of text, and what a table of scores fits into
_RULE = Box("    \n    \n -- \n    \n    \n    \n    \n    \n", ascii=True)

_Cell = Callable[[ColumnScore], str]
# Name, cells, and how soon it is left out if there is no room; 0 never.
_SCORES: tuple[tuple[str, _Cell, int], ...] = (
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
    "* is not the default definition, ~ others fit as well. rel. error: largest error / scale, "
    "the largest absolute value of the reference; scd: correct digits, -log10 of it; mescd: the "
    "same of error / (1 + value); floor: largest error of correctly rounded values with as many "
    "digits; above 1e-3: first time at which the error exceeds 1e-3 of the scale"
)


def render(scored: Report | Series, width: int | None, color: bool) -> str:
    """The report of a file or of a series as text.

    Parameters
    ----------
    width
        Columns of text; None for those of the terminal. Tables leave out what does not fit, but
        never cut a number.
    color
        Whether to use the colours of a terminal.
    """
    page = _Page(shutil.get_terminal_size((_PROSE, 24)).columns if width is None else width, color)
    if isinstance(scored, Report):
        _print_report(page, scored)
    else:
        _print_series(page, scored)
    return page.text()


class _Page:
    """Lines of text of a certain width."""

    def __init__(self, width: int, color: bool) -> None:
        self._file = io.StringIO()
        # The width of the console is no limit: rich would cut numbers to keep it.
        self._console = Console(
            file=self._file, width=1000, force_terminal=color, no_color=not color,
            color_system="standard" if color else None, markup=False, highlight=False,
            emoji=False, legacy_windows=False, _environ={},
        )  # fmt: skip
        self.width = max(width, 40)

    def say(self, text: str, style: str = "", indent: str = "") -> None:
        """Text, wrapped; all lines but the first are indented."""
        for i, line in enumerate(_wrap(text, min(self.width, _PROSE) - len(indent))):
            self._console.print(Text((indent if i else "") + line, style))

    def head(self, text: str, indent: str = "") -> None:
        """A heading, after an empty line."""
        self.say("")
        self.say(text, "bold", indent)

    def listed(self, mark: str, style: str, text: str) -> None:
        """An entry of a list, with its mark in front."""
        for i, line in enumerate(_wrap(text, min(self.width, _PROSE) - 10)):
            self._console.print(Text.assemble((f"  {mark if not i else '':<8}", style), line))

    def fits(self, table: Table) -> bool:
        return self._console.measure(table).maximum <= self.width

    def show(self, table: Table) -> None:
        self._console.print(table)

    def text(self) -> str:
        lines = self._file.getvalue().split("\n")
        return "\n".join(line.rstrip() for line in lines)


def _wrap(text: str, width: int) -> list[str]:
    """Lines of at most so many letters; a unit stays with its number."""
    kept = re.sub(r"(?<=[0-9]) (?=(?:%|s|J|rad(?:/s)?|m/s)(?![a-z]))", _KEPT, text)
    lines = textwrap.wrap(kept, width, break_on_hyphens=False) or [""]
    return [line.replace(_KEPT, " ") for line in lines]


def _print_report(page: _Page, report: Report) -> None:
    page.say(verdict(report), "bold", "  ")
    for m in report.maneuvers:
        _print_maneuver(page, m)
    if report.maneuvers:
        page.say("")
        page.say(_LEGEND, "dim")
        page.head("eq. (1) of the benchmark, 100 (max E - min E) / E0 of the file's own energy")
        for m in report.maneuvers:
            page.say(f"  maneuver {m.maneuver}: {performance_words(m)}")
        _print_consistency(page, report)
    if report.said:
        page.head("findings")
        _print_findings(page, report.said)
    if report.requirements:
        page.head("requirements")
        _print_requirements(page, report.requirements)


def _print_maneuver(page: _Page, m: ManeuverScore) -> None:
    facts = f"{m.rows} rows, {plain(m.t_start)} to {plain(m.t_end)} s"
    if m.step is not None:
        facts += f", every {plain(m.step)} s"
    if m.coverage < 1:
        facts += f", {percent(m.coverage)} of the reference"
    page.head(f"{heading(m)}: {facts}", "  ")
    if not m.columns:
        page.say("  no column could be compared")
        return
    dropped = sorted({order for _, _, order in _SCORES})
    view = _scores(m, 0)
    for order in dropped[1:]:
        if page.fits(view):
            break
        view = _scores(m, order)
    page.show(view)


def _scores(m: ManeuverScore, dropped: int) -> Table:
    """Table of scores without the columns that are dropped first, up to an order."""
    kept = [(name, cell) for name, cell, order in _SCORES if not 0 < order <= dropped]
    rows = [[cell(c) for _, cell in kept] for c in m.columns]
    return _table([name for name, _ in kept], rows, left=2)


def _table(names: Sequence[str], rows: Sequence[Sequence[str]], left: int) -> Table:
    """A table with a rule below its headings; so many columns flush left."""
    view = Table(box=_RULE, padding=0, pad_edge=False, show_edge=False, header_style="bold")
    height = max(name.count("\n") for name in names)
    for i, name in enumerate(names):
        justify: Literal["left", "right"] = "left" if i < left else "right"
        # Two spaces in front of each number but the first, which follows words of many lengths.
        lines = [""] * (height - name.count("\n")) + name.split("\n")
        text = "\n".join(" " * (i > left) + line for line in lines)
        # As text: a heading alone would be read as markup, and its [s] taken for a style.
        view.add_column(Text(text), justify=justify, no_wrap=True)
    for row in rows:
        view.add_row(*(Text(" " * (i > left) + cell) for i, cell in enumerate(row)))
    return view


def _definition(c: ColumnScore) -> str:
    """The definition, and below it what else is not the default."""
    name = printable(c.as_understood.definition) + mark(c)
    return "\n".join([name, *(f"  {note}" for note in notes(c))])


def _print_consistency(page: _Page, report: Report) -> None:
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


def _print_findings(page: _Page, findings: Sequence[Finding]) -> None:
    for f in by_severity(tuple(findings)):
        is_warning = f.severity == Severity.WARNING
        mark, style = ("WARNING", "bold yellow") if is_warning else ("info", "dim")
        page.listed(mark, style, sentence(f.message))


def _print_requirements(page: _Page, requirements: Sequence[Requirement]) -> None:
    for r in requirements:
        mark, style = ("ok", "green") if r.met else ("FAILED", "bold red")
        page.listed(mark, style, f"{printable(r.text)}: found {sentence(r.message)}")


def _print_series(page: _Page, series: Series) -> None:
    page.say(series_verdict(series), "bold", "  ")
    for run in series.runs:
        page.say(f"  {verdict(run.report)}", indent="    ")
    for number_ in sorted({c.maneuver for c in series.convergence}):
        _print_convergence(page, series, number_)
    if series.findings:
        page.head("findings")
        _print_findings(page, series.findings)
    name, best = chosen(series)
    said = {f.message for f in best.report.findings}
    for run in series.runs:
        # What is found about one run is mostly found about all of them.
        findings = [f for f in run.report.findings if run is best or f.message not in said]
        findings = [f for f in findings if run is best or f.severity == Severity.WARNING]
        if findings or run.report.requirements:
            page.head(f"{run_words(run)}{f' ({name})' if run is best else ''}", "  ")
            _print_findings(page, findings)
            _print_requirements(page, run.report.requirements)


def _print_convergence(page: _Page, series: Series, maneuver: int) -> None:
    columns = [c for c in series.convergence if c.maneuver == maneuver]
    page.say("")
    has_orders = any(p is not None for c in columns for p in c.orders)
    between = ", and observed orders between them" if has_orders else ""
    page.say(f"maneuver {maneuver}: largest errors{between}", "bold")
    # As many columns side by side as there is room for.
    while columns:
        count = len(columns)
        while count > 1 and not page.fits(_convergence(series, columns[:count])):
            count -= 1
        page.show(_convergence(series, columns[:count]))
        columns = columns[count:]
        if columns:
            page.say("")


def _convergence(series: Series, columns: Sequence[Convergence]) -> Table:
    has_cpu = any(run.cpu is not None for run in series.runs)
    has_steps = any(run.step is not None for run in series.runs)
    names = ["step [s]" if has_steps else "", *(["CPU [s]"] if has_cpu else [])]
    heads = [f"{label(c.key).replace(' ', chr(10), 1)}\n[{unit_text(c.unit)}]" for c in columns]
    has_orders = any(p is not None for c in series.convergence for p in c.orders)
    rows = []
    for i, run in enumerate(series.runs):
        cpu = [plain(run.cpu, 3)] if has_cpu else []
        if i and has_orders:
            orders = (one_decimal(c.orders[i - 1]) for c in columns)
            rows.append(["  order", *(["" for _ in cpu]), *orders])
        step = f"run {i + 1}" if run.step is None else plain(run.step)
        rows.append([step, *cpu, *(number(c.errors[i]) for c in columns)])
    blank = [""] if has_cpu else []
    if has_orders:
        rows.append(["extrapol.", *blank, *(number(c.richardson_error) for c in columns)])
    rows.append(["floor", *blank, *(number(c.floor) for c in columns)])
    return _table([*names, *heads], rows, left=1)
