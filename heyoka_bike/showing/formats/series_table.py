"""Several runs or programs as text."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.report import Convergence, Series
from heyoka_bike.showing.formats.grades import ASCII_SIGNS, grade, meanings, text_color
from heyoka_bike.showing.formats.matrix import Cell, cell, worst_cell
from heyoka_bike.showing.formats.text_lists import print_findings, print_requirements
from heyoka_bike.showing.formats.text_page import Styled, TextPage, TextTable, text_table
from heyoka_bike.showing.formats.wording import (
    chosen,
    label,
    number,
    one_decimal,
    plain,
    run_name,
    run_words,
    series_verdict,
    size_heading,
    size_text,
    unit_text,
    verdict,
)

_LONGEST_NAME = 30
_T = TypeVar("_T")


def print_series(page: TextPage, series: Series) -> None:
    """All that is said about a series, and about its runs where they differ."""
    page.say(series_verdict(series), "bold", "  ")
    if not series.is_one_program:
        _print_programs(page, series)
    else:
        for run in series.runs:
            page.say(f"  {verdict(run.report)}", indent="    ")
        for number_ in sorted({c.maneuver for c in series.convergence}):
            _print_convergence(page, series, number_)
    if series.findings:
        page.head("findings")
        print_findings(page, series.findings)
    name, best = chosen(series)
    said = {f.message for f in best.report.findings} if series.is_one_program else set()
    for run in series.runs:
        findings = run.report.findings
        if run is not best and series.is_one_program:
            # What is found about one run is mostly found about all of them.
            new = (f for f in findings if f.message not in said)
            findings = tuple(f for f in new if f.severity == Severity.WARNING)
        if findings or run.report.requirements:
            page.head(f"{run_words(run)}{f' ({name})' if run is best else ''}", "  ")
            print_findings(page, findings)
            print_requirements(page, run.report.requirements)


def _print_programs(page: TextPage, series: Series) -> None:
    """Correct digits of each program: the worst of each maneuver, then all of them."""
    numbers = sorted({m.maneuver for run in series.runs for m in run.report.maneuvers})
    rows: list[list[str | Styled]] = []
    drifts: list[list[str | Styled]] = []
    for run in series.runs:
        held = {m.maneuver: m for m in run.report.maneuvers}
        cells = (digits(worst_cell(held[n].columns if n in held else ())) for n in numbers)
        rows.append([_short(run_name(series, run)), *cells])
        drifts.append([number(held[n].performance) if n in held else "-" for n in numbers])
    names = ["digits of\nworst column", *(f"maneuver\n{n}" for n in numbers)]
    view = text_table(names, rows, left=1)
    with_energy = text_table(
        [*names, *(f"eq. (1) [%]\n{n}" for n in numbers)],
        [a + b for a, b in zip(rows, drifts, strict=True)],
        left=1,
    )
    page.say("")
    page.show(with_energy if page.fits(with_energy) else view)
    signs = {grade(c) for run in series.runs for m in run.report.maneuvers for c in m.columns}
    page.say("; ".join(text for _, text in meanings(signs, ASCII_SIGNS)), "dim")
    page.say("eq. (1) sees the energy only: it judges no digits.", "dim")
    for n in numbers:
        keys = list(dict.fromkeys(c.key for c in series.convergence if c.maneuver == n))
        if keys:
            page.head(f"maneuver {n}: correct digits")
            _print_side_by_side(page, series, n, keys)


def _print_side_by_side(page: TextPage, series: Series, n: int, keys: Sequence[str]) -> None:
    def view(keys: Sequence[str]) -> TextTable:
        rows: list[list[str | Styled]] = []
        for run in series.runs:
            found = {c.key: c for m in run.report.maneuvers if m.maneuver == n for c in m.columns}
            cells = (digits(cell(found.get(key))) for key in keys)
            rows.append([_short(run_name(series, run)), *cells])
        return text_table(["", *(_in_lines(label(key)) for key in keys)], rows, left=1)

    _print_in_parts(page, keys, view)


def digits(cell: Cell) -> Styled:
    """Correct digits with the sign of their grade."""
    return Styled(f"{cell.digits} {ASCII_SIGNS.get(cell.grade, ' ')}", text_color(cell.grade))


def _short(name: str) -> str:
    """A name that leaves room for numbers: the end of a path tells more than its start."""
    return name if len(name) <= _LONGEST_NAME else f"...{name[3 - _LONGEST_NAME :]}"


def _in_lines(words: str) -> str:
    return words.replace(" ", "\n", 1)


def _print_in_parts(
    page: TextPage, columns: Sequence[_T], view: Callable[[Sequence[_T]], TextTable]
) -> None:
    """A table of as many columns side by side as there is room for, and so on."""
    while columns:
        count = len(columns)
        while count > 1 and not page.fits(view(columns[:count])):
            count -= 1
        page.show(view(columns[:count]))
        columns = columns[count:]
        if columns:
            page.say("")


def _print_convergence(page: TextPage, series: Series, maneuver: int) -> None:
    columns = [c for c in series.convergence if c.maneuver == maneuver]
    page.say("")
    has_orders = any(p is not None for c in columns for p in c.orders)
    between = ", and observed orders between them" if has_orders else ""
    page.say(f"maneuver {maneuver}: largest errors{between}", "bold")
    _print_in_parts(page, columns, lambda part: _convergence(series, part))


def _convergence(series: Series, columns: Sequence[Convergence]) -> TextTable:
    has_cpu = any(run.cpu is not None for run in series.runs)
    names = [size_heading(series), *(["CPU [s]"] if has_cpu else [])]
    heads = [f"{_in_lines(label(c.key))}\n[{unit_text(c.unit)}]" for c in columns]
    has_orders = any(p is not None for c in series.convergence for p in c.orders)
    rows = []
    for i, run in enumerate(series.runs):
        cpu = [plain(run.cpu, 3)] if has_cpu else []
        if i and has_orders:
            orders = (one_decimal(c.orders[i - 1]) for c in columns)
            rows.append(["  order", *(["" for _ in cpu]), *orders])
        step = size_text(run) or f"run {i + 1}"
        rows.append([step, *cpu, *(number(c.errors[i]) for c in columns)])
    blank = [""] if has_cpu else []
    if has_orders:
        rows.append(["extrapol.", *blank, *(number(c.richardson_error) for c in columns)])
    rows.append(["floor", *blank, *(number(c.floor) for c in columns)])
    return text_table([*names, *heads], rows, left=1)
