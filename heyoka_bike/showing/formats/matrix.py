"""The first thing a report shows: correct digits of every column in every maneuver."""

from collections.abc import Iterable, Sequence

from heyoka_bike.errors import printable
from heyoka_bike.scoring.report import ColumnScore, Report, Series, open_words
from heyoka_bike.showing import wording as words
from heyoka_bike.showing.document import HTML, Cell, Row, TableBlock, TableColumn, Words
from heyoka_bike.showing.grades import Grade

_MOST_ROWS = 12  # the benchmark has eight columns, a file of the whole motion up to a hundred


def of_report(report: Report) -> TableBlock:
    """Columns by maneuvers of a file, and how each column was taken.

    Of a file with very many columns those with the fewest digits.
    """
    columns = by_key(report)
    worst = sorted(columns, key=lambda key: _fewest(columns[key]))[:_MOST_ROWS]
    rows: list[Row] = []
    for key, found in columns.items():
        if key in worst:
            cells = (_cell(m.get(key)) for m in report.maneuvers)
            rows.append([Words(words.label(key), printable(key)), *cells, taken(found)])
    left_out = len(columns) - len(rows)
    more = f" {left_out} more columns have no fewer digits." if left_out else ""
    return TableBlock(
        [
            Words("Correct digits", "correct digits"),
            *_maneuvers(report),
            TableColumn("taken as", is_prose=True, leave_out=1, style="taken"),
        ],
        rows,
        about="Correct digits",
        style="matrix",
        note=Words(
            "Correct digits of the worst value of a column, -log10 of its error relative to the "
            f"column's largest value.{more} Taken as: the definition, sign, unit and zero that the "
            "values follow; none of it is an error.",
            f"and {left_out} more columns, none with fewer digits" if left_out else "",
        ),
    )


def of_series(series: Series) -> TableBlock:
    """The worst columns of runs or programs by maneuvers, with eq. (1) as a remark."""
    numbers = sorted({n for run in series.runs for n in run.report})
    rows: list[Row] = []
    for run in series.runs:
        held = run.report
        cells = (_worst_cell(held[n].columns if n in held else ()) for n in numbers)
        name, said = words.run_name(series, run), words.worst_place(run.report)
        drifts = (words.number(held[n].performance) if n in held else "-" for n in numbers)
        rows.append([Words(name, words.short_name(name)), *cells, *drifts, said])
    what = "Run" if series.is_one_program else "Program"
    return TableBlock(
        [
            Words(what, "digits of\nworst column"),
            *_maneuvers(numbers),
            *(TableColumn(f"eq. (1) [%]\n{n}", leave_out=1) for n in numbers),
            TableColumn("worst column", is_prose=True, style="taken", only=HTML),
        ],
        rows,
        about=what,
        style="matrix",
        only=HTML if series.is_one_program else "",
        note=Words(
            "Correct digits of the worst value of the worst column. Eq. (1), the benchmark's own "
            "measure, sees only whether a program's own energy stays constant, and judges none of "
            "these digits.",
            "eq. (1) sees the energy only: it judges no digits.",
        ),
    )


def side_by_side(series: Series, maneuver: int) -> TableBlock:
    """Columns by programs in one maneuver."""
    keys = dict.fromkeys(c.key for c in series.convergence if c.maneuver == maneuver)
    held = (run.report.get(maneuver) for run in series.runs)
    scores = [dict(m) if m else {} for m in held]
    names = (words.run_name(series, run) for run in series.runs)
    return TableBlock(
        [Words("Correct digits", ""), *(Words(name, words.short_name(name)) for name in names)],
        [[words.label(key), *(_cell(found.get(key)) for found in scores)] for key in keys],
        about="Correct digits",
        style="matrix",
        in_parts=True,
    )


def _maneuvers(numbers: Iterable[int]) -> list[Words]:
    return [Words(f"maneuver {n}", f"maneuver\n{n}") for n in numbers]


def _cell(column: ColumnScore | None) -> Cell:
    """Return the digits and the grade of a column, ``-`` without one."""
    if column is None:
        return Cell("-", grade=Grade.UNKNOWN)
    return Cell(words.one_decimal(column.scd), grade=column.grade)


def _worst_cell(columns: Sequence[ColumnScore]) -> Cell:
    """The fewest digits of some columns, and the worst grade."""
    known = [c for c in columns if c.scd is not None]
    if not known:
        return _cell(None)
    return Cell(words.one_decimal(_fewest(known)), grade=max(c.grade for c in known))


def _fewest(columns: Sequence[ColumnScore]) -> float:
    return min((c.scd for c in columns if c.scd is not None), default=0.0)


def taken(columns: Sequence[ColumnScore]) -> str:
    """Return the definition of a column where there is a choice, and `unusual`."""
    c = _compared(columns)[0]
    said = [printable(c.as_understood.definition)] if c.alternatives else []
    return ", ".join([*said, *unusual(columns)])


def unusual(columns: Sequence[ColumnScore]) -> list[str]:
    """In what a column, over all maneuvers, is not taken as by default, and what is left open."""
    found = _compared(columns)
    c = found[0]
    r = c.as_understood
    said = []
    others, default = printable(open_words(found)), printable(c.as_written.definition)
    if not c.is_known:
        said.append("the nearest, but its definition is unknown")
    elif not words.is_default(c) and default not in others.split():
        said.append(f"not the default {default}")
    if others:
        said.append(others)
    if r.sign != c.as_written.sign:
        said.append("other sign")
    if r.unit != c.as_written.unit:
        said.append(f"in {words.unit_text(r.unit)}")
    if r.offset != c.as_written.offset:
        said.append(f"zero at {words.plain(r.offset, 5)} {words.unit_text(c.unit)}")
    return said


def conventions(report: Report) -> str:
    """Return the conventions of a file that are not the default, in one line; none is an error."""
    said = [
        f"{printable(key)} {taken(columns)}"
        for key, columns in by_key(report).items()
        if unusual(columns)
    ]
    return "; ".join(said) or "all columns as by default"


def by_key(report: Report) -> dict[str, list[ColumnScore]]:
    """Each column of a file, in all maneuvers."""
    found: dict[str, list[ColumnScore]] = {}
    for m in report.maneuvers:
        for c in m.columns:
            found.setdefault(c.key, []).append(c)
    return found


def _compared(columns: Sequence[ColumnScore]) -> Sequence[ColumnScore]:
    return [c for c in columns if c.values] or columns
