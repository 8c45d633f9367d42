"""The report of a file, of runs of one program, or of several programs, as a document.

The correct digits of every column in every maneuver come first.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from heyoka_bike.errors import printable
from heyoka_bike.scoring.evidence.words import counted, open_words, unit_text
from heyoka_bike.scoring.findings import Finding, Severity, named
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore, also_open
from heyoka_bike.scoring.verdict import ALL_COLUMNS
from heyoka_bike.showing import document as doc
from heyoka_bike.showing.charts import results as charts
from heyoka_bike.showing.document.html import capital
from heyoka_bike.showing.wording import (
    column_text,
    number_text,
    origin_text,
    run_text,
    verdict_text,
)
from heyoka_bike.showing.wording.grade_text import SIGNS, WORDS, file_grade, style_of

_MOST_COLUMNS_SHOWN = (
    # Maximum number of columns in the table of digits. The benchmark has eight columns; a file with
    # the whole motion has up to a hundred.
    12
)

_NO_VALUE = "-"  # cell of a column without compared values

_COLUMNS_OF_SCORES = (
    doc.TableColumn("column", "the quantity, and its unit"),
    doc.TableColumn("definition", "the definition that the values follow"),
    doc.TableColumn(
        doc.Words("max error", "max\nerror"),
        "largest absolute error over the rows, in the unit of the column",
    ),
    doc.TableColumn("at [s]", "time of the largest error", only=doc.HTML),
    doc.TableColumn(
        doc.Words("rms error", "rms\nerror"),
        "root of the mean squared error of the rows",
        leave_out=2,
    ),
    doc.TableColumn(
        doc.Words("relative error", "rel.\nerror"),
        "largest error / largest absolute value of the reference",
        leave_out=4,
    ),
    doc.TableColumn("scd", "significant correct digits: -log10 of the relative error"),
    doc.TableColumn(
        "mescd", "-log10 of the largest abs(error) / (1 + abs(exact value))", leave_out=1
    ),
    doc.TableColumn(
        "floor",
        "largest error that rounding to the digits of the file causes",
        leave_out=3,
    ),
    doc.TableColumn(
        doc.Words("above 1e-3 [s]", "above\n1e-3 [s]"),
        "first time at which the error exceeds 1e-3 of the largest value",
    ),
    doc.TableColumn(
        "as written",
        "largest error if read with the default definition, SI unit, sign and zero",
        only=doc.HTML,
    ),
    doc.TableColumn("values", "number of values compared", only=doc.HTML),
)

_LEGEND = "; ".join(f"{c.heading}: {c.meaning}" for c in _COLUMNS_OF_SCORES[2:] if not c.only)


def document(
    scored: Report | Series, made: Sequence[tuple[str, str]] | None = None
) -> doc.Document:
    """Return the report of a file or of a series; for `made` see `origin_text`."""
    first = run_text.reports(scored)[0]
    if isinstance(scored, Report):
        title = heading = printable(Path(scored.file.path).name or scored.file.path)
        blocks = _of_file(scored)
    else:
        names = ", ".join(run_text.run_name(scored, run) for run in scored.runs)
        is_one, count = scored.is_one_program, len(scored.runs)
        heading = f"{count} {'runs of one program' if is_one else 'programs compared'}"
        title = f"{count} {'runs' if is_one else 'programs'}: {names}"
        blocks = _of_series(scored)
    made = origin_text.origin() if made is None else made
    by = origin_text.reference_words(first.bicycle, first.dataset_version, first.reference_sha256)
    window, kind = f"{title} – uncontrolled bicycle", "Uncontrolled bicycle: score of"
    return doc.Document(window, heading, kind, tuple(blocks), [*made, *by])


def _of_file(report: Report) -> Iterator[doc.Block]:
    """Yield the report of a file; in a notebook, everything after the table of digits is folded."""
    text = capital("; ".join([verdict_text.graded(report), *verdict_text.caveats(report)]))
    sign, style = SIGNS.get(file_grade(report), ""), f"verdict {style_of(report)}"
    yield doc.Paragraph(f"{text}.", style, sign=sign, only=doc.HTML)
    if worst_error := verdict_text.worst_error_words(report):
        yield doc.Paragraph(f"{capital(worst_error)}.", "worst", only=doc.HTML)
    yield _asked(report)
    warnings, held = verdict_text.warnings_words(report), verdict_text.contents(report)
    link, path = (warnings, "findings") if warnings else None, printable(report.file.path)
    yield doc.Paragraph(held, "facts", link=link, note=path, only=doc.HTML)
    yield doc.Paragraph(verdict_text.verdict(report), style, only=doc.TEXT)
    yield doc.Paragraph(f"  {'; '.join(filter(None, (held, warnings)))}", only=doc.TEXT)
    yield _folded("Why it differs", _findings(report.diagnosis), is_open=True, only=doc.NOTEBOOK)
    yield _digits_of_file(report)
    remark = verdict_text.performance_remark(report)
    yield doc.Paragraph(f"{remark}." if remark else "", "remark", lead="remark")
    yield _folded("Findings", _findings(report.said), only=doc.HTML)
    for name, severity in (("Warnings", Severity.WARNING), ("Information", Severity.INFO)):
        some = _findings([f for f in report.said if f.severity == severity])
        yield _folded(name, some, is_open=severity == Severity.WARNING, only=doc.TEXT)
    yield _folded("Requirements", _requirements(report), is_open=True)
    if e := report.explanation:
        said = doc.Paragraph(f"{capital(number_text.sentence(e.says))}.", "said")
        title, curves = "What explains it", doc.Chart(partial(charts.explained, e))
        yield doc.Chapter(title, (said, curves), "explanation", title, only=doc.PAGE)
    for m in report.maneuvers:
        yield _maneuver(m, is_explained=m is report.maneuvers[0])
    legend = (doc.Paragraph(_LEGEND if report.maneuvers else "", "facts"),)
    yield doc.Chapter("columns of these tables", legend, is_folded=True, only=doc.TEXT)


def _of_series(series: Series) -> Iterator[doc.Block]:
    """Yield the report of a series; in a notebook each run is folded."""
    verdict = verdict_text.series_verdict(series)
    yield doc.Paragraph(verdict, "head", only=doc.TEXT)
    style = f" {style_of(run_text.chosen(series)[1].report)}" if series.is_one_program else ""
    yield doc.Paragraph(f"{capital(verdict)}.", f"verdict{style}", only=doc.HTML)
    yield _asked(series)
    yield _digits_of_runs(series)
    if series.is_one_program:
        for run in series.runs:
            yield doc.Paragraph(f"  {verdict_text.verdict(run.report)}", only=doc.TEXT)
    found = _findings(series.findings)
    yield _folded("Findings", found, only=doc.HTML)
    for n in sorted({c.maneuver for c in series.convergence}):
        yield _all_runs(series, n)
    yield _folded("Findings", found, is_open=True, only=doc.TEXT)
    yield from _each_run(series)


def _asked(scored: Report | Series) -> doc.Paragraph:
    """Return a paragraph for a page: how many requirements are met."""
    said = verdict_text.requirement_words(scored)
    style, sign = ("right", "✓") if scored.passed else ("wrong", "✗")
    text = f"{capital(said)}." if said else ""
    return doc.Paragraph(text, f"asked {style}", sign=sign, only=doc.HTML)


def _folded(name: str, content: doc.Block, *, is_open: bool = False, only: str = "") -> doc.Chapter:
    """Return a chapter that folds in a notebook and is listed in the contents of a page."""
    place = name.lower()
    return doc.Chapter(doc.Words(name, place), (content,), place, name, True, is_open, only)


def _findings(found: Sequence[Finding]) -> doc.Listing:
    """Return a list of the findings, each with its severity; warnings first."""
    items = []
    for f in verdict_text.by_severity(found):
        said = number_text.sentence(f.message)
        mark = doc.Words(f.severity, "WARNING" if f.severity == Severity.WARNING else "info")
        items.append(doc.Item(doc.Words(capital(said), said), f.severity, mark))
    return doc.Listing(tuple(items))


def _requirements(report: Report) -> doc.Listing:
    """Return a list of the requirements, each with its result."""
    items = []
    for r in report.requirements:
        mark = doc.Words("✓ met", "ok") if r.met else doc.Words("✗ FAILED", "FAILED")
        said, style = f"found {number_text.sentence(r.message)}", "passed" if r.met else "failed"
        items.append(doc.Item(said, style, mark, printable(r.text)))
    return doc.Listing(tuple(items))


def _maneuver(m: ManeuverScore, is_explained: bool = False) -> doc.Chapter:
    """Return a chapter with the scores, charts and definitions of a maneuver.

    Parameters
    ----------
    is_explained
        True if a page explains the columns of its scores.
    """
    said = (
        "The upper chart shows the result on top of the reference. The lower one shows the error "
        "on a logarithmic scale; each thin line is a factor of ten. The dotted line is the floor: "
        "the largest error of exact values that are rounded to the digits of the file."
    )
    each = doc.Paragraph(said, "said"), *_each_column(m)
    blocks = (
        doc.Paragraph(f"{_covered(m)}.", "facts", only=doc.HTML),
        *scores(m, is_explained),
        _consistency(m),
        doc.Chapter("Error over time", (doc.Chart(partial(charts.all_errors, m)),)),
        doc.Chapter(
            "Definitions",
            (doc.Chart(partial(charts.definitions, m)),),
            only=doc.PAGE,
            folds=True,
        ),
        doc.Chapter("Column by column", each if m.columns else (), only=doc.PAGE),
    )
    anchor, link = f"maneuver-{m.maneuver}", f"Maneuver {m.maneuver}"
    return doc.Chapter(title(m), blocks, anchor, link, is_folded=True)


def _each_column(m: ManeuverScore) -> Iterator[doc.Block]:
    """Yield charts of all columns, worst first; only the wrong (or else the worst) are unfolded."""

    def goodness(c: ColumnScore) -> tuple[int, float]:
        return -c.grade, math.inf if c.scd is None else c.scd

    order = sorted(m.columns, key=goodness)
    shown = [c for c in order if c.grade == Grade.WRONG] or order[:1]
    yield doc.Chart(partial(charts.every_column, m, shown))
    for grade in sorted({c.grade for c in order}, reverse=True):
        some = [c for c in order if c.grade == grade and c not in shown]
        if some:
            names = ", ".join(column_text.label(c.key) for c in some)
            heading = f"{capital(WORDS.get(grade, 'not compared'))}: {names}"
            drawn = doc.Chart(partial(charts.every_column, m, some))
            yield doc.Chapter(heading, (drawn,), only=doc.PAGE, folds=True)


def title(m: ManeuverScore) -> doc.Words:
    """Return the heading of a maneuver; the text version adds row count, times and coverage."""
    name = column_text.heading(m)
    return doc.Words(capital(name), f"{name}: {_covered(m)}")


def _covered(m: ManeuverScore) -> str:
    """Return row count, times, step and coverage, and the column count if columns are missing."""
    step = "" if m.step is None else f", every {number_text.plain(m.step)} s"
    times = f"{number_text.plain(m.t_start)} to {number_text.plain(m.t_end)} s"
    covered = number_text.percent(m.coverage)
    few = "" if m.column_count >= ALL_COLUMNS else f", {m.column_count} of {ALL_COLUMNS} columns"
    return f"{counted(m.rows, 'row')}, {times}{step}, {covered} of the reference{few}"


def scores(m: ManeuverScore, is_explained: bool = False) -> tuple[doc.Block, ...]:
    """Return the table of the scores of a maneuver's columns, with the meanings of its marks."""
    if not m.columns:
        return (doc.Paragraph("  no column could be compared", only=doc.TEXT),)
    marks = "; ".join(column_text.mark_meanings(m.columns))
    note = doc.Words(f"{marks}.", marks) if marks else ""
    rows, about = list(map(_score, m.columns)), f"Scores of maneuver {m.maneuver}"
    return (
        doc.TableBlock(
            _COLUMNS_OF_SCORES, rows, about, left=2, is_explained=is_explained, note=note
        ),
    )


def _score(c: ColumnScore) -> list[str | doc.Cell]:
    """Return the row of a column in the table of scores: a cell for each `_COLUMNS_OF_SCORES`."""
    name, (mark, notes) = printable(c.definition), (column_text.mark(c), column_text.notes(c))
    return [
        doc.Cell(doc.Words(column_text.label(c.key), printable(c.key)), unit_text(c.unit)),
        doc.Words(
            ", ".join((name.replace("_", " ") + mark, *notes)), "\n  ".join((name + mark, *notes))
        ),
        _error(c.max_abs_error),
        number_text.plain(c.time_of_max),
        _error(c.rms_error),
        number_text.number(c.max_rel_error),
        number_text.correct_digits(c.scd),
        number_text.one_decimal(c.mescd),
        number_text.number(c.floor),
        column_text.first_above(c),
        number_text.number(c.as_written.measures.max_abs_error),
        f"{c.values} ({c.missing} missing)" if c.missing else str(c.values),
    ]


def _error(x: float | None) -> doc.Words:
    """Format an error with three digits for a page, and with two for text."""
    return doc.Words(number_text.number(x, 3), number_text.number(x))


def _consistency(m: ManeuverScore) -> doc.Facts:
    """Return how far a file contradicts itself: energy drift, energy sum, rates against angles."""
    c = m.consistency
    eq_1 = doc.Words("eq. (1), 100 (max E − min E) / E₀", "eq. (1), 100 (max E - min E) / E0")
    said = "drift of the file's own mechanical energy"
    if m.performance_limit is not None:
        said += ", the only quantity that the benchmark judges here"
    found = [(eq_1, verdict_text.performance_words(m), said)]
    if c.energy_sum is not None:
        text = f"{number_text.number(c.energy_sum)} J"
        if c.energy_sum_floor is not None:
            text += f" (rounding explains {number_text.number(c.energy_sum_floor)} J)"
        name = doc.Words("energies", "potential + kinetic - mechanical energy")
        found.append((name, text, "potential + kinetic against mechanical energy"))
    for which, x in (("roll", c.roll_rate), ("steer", c.steer_rate)):
        if x is not None:
            name = doc.Words(f"{which} rate", f"{which} rate - derivative of the angle")
            said = "against the derivative of the file's own angle"
            found.append((name, f"{number_text.number(x)} rad/s", said))
    return doc.Facts(tuple(found))


def _digits_of_file(report: Report) -> doc.TableBlock:
    """Return the table of correct digits: a row per column of the file, a column per maneuver.

    The last column of the table contains the interpretation of the file's column.

    If the file has very many columns, only those with the fewest digits are shown.
    """
    columns = _by_key(report)
    taken_as = {key: _taken(found) for key, found in columns.items()}
    has_taken = any(taken_as.values())
    fewest = {
        key: min((c.scd for c in found if c.scd is not None), default=0.0)
        for key, found in columns.items()
    }
    worst = sorted(columns, key=fewest.__getitem__)[:_MOST_COLUMNS_SHOWN]
    rows: list[doc.TableRow] = [
        [
            doc.Words(column_text.label(key), printable(key)),
            *(_digits(m.columns, key) for m in report.maneuvers),
            *([taken_as[key]] if has_taken else []),
        ]
        for key in columns
        if key in worst
    ]
    left_out = len(columns) - len(rows)
    more = f" {left_out} more columns have no fewer digits." if left_out else ""
    odd = [key for key, found in columns.items() if any(c.is_contradicted for c in found)]
    signs = f"{named(odd)}: wrong because of the signs, whatever the digits" if odd else ""
    has_dash = any(
        _digits(m.columns, key).text == _NO_VALUE for key in worst for m in report.maneuvers
    )
    about_dash = f" A dash ({_NO_VALUE}) means that there is no value to compare." * has_dash
    said = [
        f"and {left_out} more columns, none with fewer digits" if left_out else "",
        signs,
        f"{_NO_VALUE} no value to compare" if has_dash else "",
    ]
    taken = doc.TableColumn("taken as", is_prose=True, leave_out=1, style="taken")
    about_taken = (
        " Taken as: the definition, sign, unit and zero that the values follow, where these differ "
        "from the default or are ambiguous; none of it is an error."
    )
    return doc.TableBlock(
        [
            doc.Words("Correct digits", "correct digits"),
            *_maneuvers(report),
            *([taken] if has_taken else []),
        ],
        rows,
        about="Correct digits",
        style="matrix",
        beside=_worst_column(report),
        note=doc.Words(
            "Correct digits of the worst value of a column, -log10 of its error relative to the "
            f"column's largest value.{more}{about_taken if has_taken else ''}"
            f"{f' {signs}.' if signs else ''}{about_dash}",
            "; ".join(filter(None, said)),
        ),
    )


def _worst_column(report: Report) -> doc.Chapter | None:
    """Return the chart of the worst column for a page; None without an error or with one row."""
    place = verdict_text.worst_place(report)
    if place is None:
        return None
    m, c = place
    if not c.max_abs_error or len(c.trace.time) < 2:
        return None
    drawn = doc.Chart(partial(charts.every_column, m, [c]))
    heading = f"Maneuver {m.maneuver}, {column_text.label(c.key)}"
    return doc.Chapter(heading, (drawn,), "worst", only=doc.PAGE)


def _digits_of_runs(series: Series) -> doc.TableBlock:
    """Return a table with a row per run: digits of the worst column and eq. (1) per maneuver."""
    numbers = sorted({n for run in series.runs for n in run.report})
    rows: list[doc.TableRow] = []
    for run in series.runs:
        held, name, worst = run.report, run_text.run_name(series, run), run.report.worst
        cells = (_digits(held[n].columns if n in held else ()) for n in numbers)
        place = f"{column_text.label(worst.column)} in maneuver {worst.maneuver}" if worst else ""
        drifts = (number_text.number(held[n].performance) if n in held else "-" for n in numbers)
        short = doc.Words(name, run_text.short_name(name))
        rows.append([short, *cells, *drifts, place or "nothing compared"])
    what = "Run" if series.is_one_program else "Program"
    return doc.TableBlock(
        [
            doc.Words(what, "digits of\nworst column"),
            *_maneuvers(numbers),
            *(doc.TableColumn(f"eq. (1) [%]\n{n}", leave_out=1) for n in numbers),
            doc.TableColumn("worst column", is_prose=True, style="taken", only=doc.HTML),
        ],
        rows,
        about=what,
        style="matrix",
        only=doc.HTML if series.is_one_program else "",
        note=doc.Words(
            "Correct digits of the worst value of the worst column. Eq. (1), the benchmark's own "
            "measure, tests only whether a program's own energy is constant. It does not judge "
            "these digits.",
            "eq. (1) tests only the energy: it does not judge digits.",
        ),
    )


def _digits_side_by_side(series: Series, maneuver: int) -> doc.TableBlock:
    """Return a maneuver's table of correct digits, a row per column, a column per program.

    The errors over time are shown next to the table.
    """
    keys = dict.fromkeys(c.key for c in series.convergence if c.maneuver == maneuver)
    held = [[m for m in run.report.maneuvers if m.maneuver == maneuver] for run in series.runs]
    names = (run_text.run_name(series, run) for run in series.runs)
    return doc.TableBlock(
        [
            doc.Words("Correct digits", ""),
            *(doc.Words(name, run_text.short_name(name)) for name in names),
        ],
        [
            [
                column_text.label(key),
                *(_digits([c for m in ms for c in m.columns], key) for ms in held),
            ]
            for key in keys
        ],
        about="Correct digits",
        style="matrix",
        beside=doc.Chapter(
            "Error over time", (doc.Chart(partial(charts.side_by_side, series, maneuver)),)
        ),
        in_parts=True,
    )


def _maneuvers(numbers: Iterable[int]) -> list[doc.Words]:
    return [doc.Words(f"maneuver {n}", f"maneuver\n{n}") for n in numbers]


def _digits(columns: Sequence[ColumnScore], key: str = "") -> doc.Cell:
    """Return a cell with the fewest digits and the worst grade of the columns (of this key).

    `_NO_VALUE` if there are no such columns.
    """
    known = [c for c in columns if c.scd is not None and key in ("", c.key)]
    if not known:
        return doc.Cell(_NO_VALUE, grade=Grade.UNKNOWN)
    fewest = min(c.scd for c in known if c.scd is not None)
    return doc.Cell(number_text.correct_digits(fewest), grade=max(c.grade for c in known))


def _taken(columns: Sequence[ColumnScore]) -> str:
    """Return what is `_unusual` about a column, after its definition; empty if all is default."""
    unusual, c = _unusual(columns), _compared(columns)[0]
    definition = [printable(c.definition)] if c.alternatives and unusual else []
    return ", ".join([*definition, *unusual])


def _unusual(columns: Sequence[ColumnScore]) -> list[str]:
    """Return the conventions of a column that differ from the default, and open definitions.

    A definition is open if it fits as well as the chosen one.
    """
    found = _compared(columns)
    c = found[0]
    r = c.as_understood
    said = []
    others, default = (
        printable(open_words(also_open(found))),
        printable(c.as_written.definition),
    )
    if not c.is_known:
        said.append("the nearest one, but the definition is unknown")
    elif not column_text.is_default(c) and default not in others.split():
        said.append(f"not the default {default}")
    if others:
        said.append(others)
    if r.sign != c.as_written.sign:
        said.append("opposite sign")
    if r.unit != c.as_written.unit:
        said.append(f"in {unit_text(r.unit)}")
    if r.offset != c.as_written.offset:
        said.append(f"zero at {number_text.plain(r.offset, 5)} {unit_text(c.unit)}")
    return said


def conventions(report: Report) -> str:
    """List in one line the conventions of a file that are not the default."""
    taken = {key: _taken(columns) for key, columns in _by_key(report).items()}
    said = [f"{printable(key)} {how}" for key, how in taken.items() if how]
    return "; ".join(said) or "default in all columns"


def _by_key(report: Report) -> dict[str, list[ColumnScore]]:
    """Return the columns of a file by key: for each key, its columns in all maneuvers."""
    return grouped((c.key, c) for m in report.maneuvers for c in m.columns)


def _compared(columns: Sequence[ColumnScore]) -> Sequence[ColumnScore]:
    return [c for c in columns if c.values] or columns


def _all_runs(series: Series, n: int) -> doc.Chapter:
    """Return a chapter that compares the errors of all runs in one maneuver."""
    title, errors = f"Maneuver {n}", _convergence(series, n)
    content: tuple[doc.Block, ...]
    if series.is_one_program:
        has_steps = any(run.step is not None for run in series.runs)
        between = ", and observed orders between them" if _has_orders(series, n) else ""
        brief = f"maneuver {n}: largest errors{between}"
        title = f"{'Convergence' if has_steps else 'Errors of the runs'}, maneuver {n}"
        content = (doc.Chart(partial(charts.gains_and_costs, series, n)), errors)
    else:
        brief = f"maneuver {n}: correct digits"
        content = (
            _digits_side_by_side(series, n),
            doc.Chapter("Largest errors", (errors,), only=doc.HTML),
        )
    return doc.Chapter(doc.Words(title, brief), content, f"all-{n}", title, True, is_open=True)


def _each_run(series: Series) -> Iterator[doc.Block]:
    """Yield a chapter for each run; a page shows the chosen run of a single program in full."""
    kind, best = run_text.chosen(series)
    for i, run in enumerate(series.runs):
        is_best = run is best
        name, held = run_text.run_name(series, run), run.report
        called = run_text.run_words(run) + (f" ({kind})" if is_best else "")
        asked = _requirements(held)
        is_full = is_best and series.is_one_program
        scored: Callable[[ManeuverScore, bool], doc.Chapter] = _maneuver if is_full else _scores
        content: tuple[doc.Block, ...] = (
            doc.Paragraph(called, "facts"),
            doc.Paragraph(f"{capital(verdict_text.graded(held))}.", "said"),
            asked,
            _findings(held.findings),
            *(scored(m, i == j == 0) for j, m in enumerate(held.maneuvers)),
        )
        yield doc.Chapter(name, content, f"run-{i + 1}", name, only=doc.PAGE)
        found = held.findings
        if series.is_one_program and not is_best:
            # Most findings are the same for all runs of a program, so list only the warnings that
            # the report of the chosen run does not contain.
            known = {f.message for f in best.report.findings}
            new = (f for f in found if f.message not in known)
            found = tuple(f for f in new if f.severity == Severity.WARNING)
        yield doc.Chapter(called, (_findings(found), asked), only=doc.TEXT)
        yield doc.Chapter(name, tuple(_of_file(held)), is_folded=True, only=doc.NOTEBOOK)


def _scores(m: ManeuverScore, is_explained: bool) -> doc.Chapter:
    return doc.Chapter(capital(column_text.heading(m)), scores(m, is_explained))


def _convergence(series: Series, maneuver: int) -> doc.TableBlock:
    """Return a table with the errors of each run, and the observed orders between two runs."""
    columns = [c for c in series.convergence if c.maneuver == maneuver]
    has_cpu = any(run.cpu is not None for run in series.runs)
    has_orders = _has_orders(series, maneuver)
    size = run_text.size_heading(series)
    what = doc.Words(size.removesuffix(" [s]") or "run", size)
    blank = [""] * has_cpu
    rows: list[list[str | doc.Cell]] = []
    for i, run in enumerate(series.runs):
        if i and has_orders:
            orders = (
                doc.Cell(number_text.one_decimal(c.orders[i - 1]), style="aside") for c in columns
            )
            name = doc.Cell(doc.Words("observed order", "  order"), style="aside")
            rows.append([name, *blank, *orders])
        full = (
            f"{number_text.plain(run.step)} s"
            if run.step is not None
            else run_text.run_name(series, run)
        )
        step = doc.Words(full, run_text.size_text(run) or f"run {i + 1}")
        cpu = [number_text.plain(run.cpu, 3)] * has_cpu
        rows.append([step, *cpu, *(_error(c.errors[i]) for c in columns)])
    said = "Largest errors."
    if has_orders:
        left = (number_text.number(c.richardson_error) for c in columns)
        rows.append([doc.Words("extrapolated", "extrapol."), *blank, *left])
        said = (
            "Largest errors, and the observed order between neighbouring runs. Extrapolated: the "
            "error after Richardson extrapolation of the two finest runs, which cancels the "
            "leading term."
        )
    if series.is_one_program:
        rows.append(["floor", *blank, *(number_text.number(c.floor) for c in columns)])
        said += " Floor: the largest error that rounding to the digits of the file causes."
    if has_cpu:
        said += " CPU: processor time of the whole run."
    heads = []
    for c in columns:
        quantity = column_text.label(c.key)
        folded = doc.Words(quantity, quantity.replace(" ", "\n", 1) + "\n")
        heads.append(doc.Cell(folded, unit_text(c.unit)))
    first = what if series.is_one_program else "program"
    return doc.TableBlock(
        [first, *["CPU [s]"] * has_cpu, *heads],
        rows,
        f"Convergence of maneuver {maneuver}",
        "numbers",
        left=1 + has_cpu,
        in_parts=True,
        note=doc.Words(said, ""),
    )


def _has_orders(series: Series, maneuver: int) -> bool:
    columns = (c for c in series.convergence if c.maneuver == maneuver)
    return any(p is not None for c in columns for p in c.orders)
