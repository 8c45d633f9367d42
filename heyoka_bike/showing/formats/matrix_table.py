"""Correct digits as HTML tables, each cell with the sign, the colour and the word of its grade."""

from collections.abc import Iterable, Sequence
from html import escape

from heyoka_bike.scoring.report import Report, Series
from heyoka_bike.showing.formats.grades import MEANINGS, SIGNS, WORDS, Grade
from heyoka_bike.showing.formats.markup import prose
from heyoka_bike.showing.formats.matrix import Cell, cell, matrix, worst_cell
from heyoka_bike.showing.formats.wording import label, number, run_name, worst_place

_Row = tuple[str, Sequence[Cell], str]
"""Heading as HTML, cells, and words as HTML."""


def of_report(report: Report) -> str:
    """Columns by maneuvers of a file, and how each column was taken."""
    found = matrix(report)
    if not found.rows:
        return ""
    rows = [(escape(label(row.key)), row.cells, prose(row.taken)) for row in found.rows]
    more = f" {found.left_out} more columns have no fewer digits." if found.left_out else ""
    return _table(
        "Correct digits",
        [f"maneuver {n}" for n in found.maneuvers],
        "taken as",
        rows,
        "Correct digits of the worst value of a column, <bdi>-log10</bdi> of its error relative to "
        f"the column's largest value.{more} Taken as: the definition, sign, unit and zero that the "
        "values follow; none of it is an error.",
    )


def of_series(series: Series) -> str:
    """The worst columns of runs or programs by maneuvers, with eq. (1) as a remark."""
    numbers = sorted({m.maneuver for run in series.runs for m in run.report.maneuvers})
    rows = []
    for run in series.runs:
        held = {m.maneuver: m for m in run.report.maneuvers}
        cells = [worst_cell(held[n].columns if n in held else ()) for n in numbers]
        words = worst_place(run.report)
        # Files without energies have nothing to say of it.
        if any(m.performance is not None for m in held.values()):
            drifts = (number(held[n].performance) for n in numbers if n in held)
            words += f"; eq. (1) {' / '.join(drifts)} %"
        rows.append((escape(run_name(series, run)), cells, prose(words)))
    return _table(
        "Run" if series.is_one_program else "Program",
        [f"maneuver {n}" for n in numbers],
        "worst column; energy",
        rows,
        "Correct digits of the worst value of the worst column. Eq. (1), the benchmark's own "
        "measure, sees only whether a program's own energy stays constant, and judges none of "
        "these digits.",
    )


def side_by_side(series: Series, maneuver: int) -> str:
    """Columns by programs in one maneuver."""
    keys = dict.fromkeys(c.key for c in series.convergence if c.maneuver == maneuver)
    scores = [
        {c.key: c for m in run.report.maneuvers if m.maneuver == maneuver for c in m.columns}
        for run in series.runs
    ]
    rows = [(escape(label(key)), [cell(found.get(key)) for found in scores], "") for key in keys]
    names = [run_name(series, run) for run in series.runs]
    return _table("Correct digits", names, "", rows, "")


def _table(first: str, heads: Sequence[str], last: str, rows: Sequence[_Row], about: str) -> str:
    top = "".join(f'<th scope="col">{escape(name)}</th>' for name in heads)
    end = f'<th scope="col" class="taken">{last}</th>' if last else ""
    body = "".join(
        f'<tr><th scope="row">{name}</th>{"".join(map(_cell, cells))}'
        + (f'<td class="taken">{words}</td>' if last else "")
        + "</tr>"
        for name, cells, words in rows
    )
    signs = _signs(c.grade for _, cells, _ in rows for c in cells)
    return (
        f'<div class="scroll" tabindex="0" role="group" aria-label="{first}"><table '
        f'class="matrix"><thead><tr><th scope="col">{first}</th>{top}{end}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>{signs}"
        + (f'<p class="facts">{about}</p>' if about else "")
    )


def _cell(found: Cell) -> str:
    if found.grade == Grade.UNKNOWN:
        return f'<td class="unknown">{found.digits}</td>'
    return (
        f'<td class="{found.grade.style}"><b aria-hidden="true">{SIGNS[found.grade]}</b> '
        f'{found.digits}<span class="spoken"> {WORDS[found.grade]}</span></td>'
    )


def _signs(grades: Iterable[Grade]) -> str:
    """What the signs of some cells mean."""
    items = "".join(
        f'<li><b class="{g.style}">{SIGNS[g]}</b> {escape(MEANINGS[g])}</li>'
        for g in sorted(set(grades) - {Grade.UNKNOWN})
    )
    return f'<ul class="signs">{items}</ul>' if items else ""
