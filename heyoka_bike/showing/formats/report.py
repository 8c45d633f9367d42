"""The report of a file as blocks of a document."""

from collections.abc import Iterator, Sequence
from functools import partial

from heyoka_bike.errors import printable
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.report import ColumnScore, ManeuverScore, Report, Requirement, Series
from heyoka_bike.showing import document as doc
from heyoka_bike.showing import wording as words
from heyoka_bike.showing.charts.definitions import definitions
from heyoka_bike.showing.charts.maneuver import all_errors, every_column, explained
from heyoka_bike.showing.document.html import capital
from heyoka_bike.showing.formats import matrix
from heyoka_bike.showing.grades import SIGNS, file_grade, style_of

_COLUMNS = (
    doc.TableColumn("column", "the quantity, and its unit"),
    doc.TableColumn("definition", "what the column was found to mean"),
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
        doc.Words("relative", "rel.\nerror"),
        "largest error / largest absolute value of the reference",
        leave_out=4,
    ),
    doc.TableColumn("scd", "significant correct digits: -log10 of the relative error"),
    doc.TableColumn("mescd", "the same, of the error / (1 + value)", leave_out=1),
    doc.TableColumn(
        "floor",
        "largest error of correctly rounded values, as many digits as the file has",
        leave_out=3,
    ),
    doc.TableColumn(
        doc.Words("above 1e-3 [s]", "above\n1e-3 [s]"),
        "first time at which the error exceeds 1e-3 of the scale",
    ),
    doc.TableColumn(
        "as written",
        "largest error if taken as the default definition, SI unit, sign and zero",
        only=doc.HTML,
    ),
    doc.TableColumn("values", "how many were compared", only=doc.HTML),
)

_LEGEND = "; ".join(f"{c.heading}: {c.meaning}" for c in _COLUMNS[2:] if not c.only)


def blocks(report: Report) -> Iterator[doc.Block]:
    """All that is said of a file; in a notebook what follows the digits is folded."""
    yield from verdict_of(report)
    yield doc.Paragraph(words.verdict(report), f"verdict {style_of(report)}", only=doc.TEXT)
    held = filter(None, (words.contents(report), words.warnings_words(report)))
    yield doc.Paragraph(f"  {'; '.join(held)}", only=doc.TEXT)
    yield folded("Why it differs", findings(report.diagnosis), is_open=True, only=doc.NOTEBOOK)
    yield matrix.of_report(report)
    yield remark(report)
    yield folded("Findings", findings(report.said), only=doc.HTML)
    for name, severity in (("Warnings", Severity.WARNING), ("Information", Severity.INFO)):
        some = findings([f for f in report.said if f.severity == severity])
        yield folded(name, some, is_open=severity == Severity.WARNING, only=doc.TEXT)
    yield folded("Requirements", requirements(report.requirements), is_open=True)
    if e := report.explanation:
        said = doc.Paragraph(f"{capital(words.sentence(e.says))}.", "said")
        title, charts = "What explains it", doc.Chart(partial(explained, e))
        yield doc.Chapter(title, (said, charts), "explanation", title, only=doc.PAGE)
    for m in report.maneuvers:
        yield maneuver(m, is_explained=m is report.maneuvers[0])
    legend = (doc.Paragraph(_LEGEND if report.maneuvers else "", "facts"),)
    yield doc.Chapter("columns of these tables", legend, is_folded=True, only=doc.TEXT)


def verdict_of(report: Report) -> Iterator[doc.Block]:
    """Yield the verdict by true error, then rows, times and digits; for a page."""
    text = capital("; ".join([words.graded(report), *words.caveats(report)]))
    sign = SIGNS.get(file_grade(report), "")
    yield doc.Paragraph(f"{text}.", f"verdict {style_of(report)}", sign=sign, only=doc.HTML)
    if worst_error := words.worst_error_words(report):
        yield doc.Paragraph(f"{capital(worst_error)}.", "worst", only=doc.HTML)
    yield asked(report)
    warnings = words.warnings_words(report)
    link = (warnings, "findings") if warnings else None
    path, held = printable(report.file.path), words.contents(report)
    yield doc.Paragraph(held, "facts", link=link, note=path, only=doc.HTML)


def asked(scored: Report | Series) -> doc.Paragraph:
    """Return the number of requirements that are met, for a page."""
    said = words.requirement_words(scored)
    style, sign = ("right", "✓") if scored.passed else ("wrong", "✗")
    text = f"{capital(said)}." if said else ""
    return doc.Paragraph(text, f"asked {style}", sign=sign, only=doc.HTML)


def remark(report: Report) -> doc.Paragraph:
    """Return the value of eq. (1), and what it sees."""
    said = words.performance_remark(report)
    return doc.Paragraph(f"{said}." if said else "", "remark", lead="remark")


def folded(name: str, content: doc.Block, *, is_open: bool = False, only: str = "") -> doc.Chapter:
    """A chapter that a notebook folds, and that the contents of a page name."""
    place = name.lower()
    return doc.Chapter(doc.Words(name, place), (content,), place, name, True, is_open, only)


def findings(found: Sequence[Finding]) -> doc.Listing:
    """Each finding with its severity, warnings first."""
    return doc.Listing(tuple(map(_finding, words.by_severity(tuple(found)))))


def _finding(f: Finding) -> doc.Item:
    said = words.sentence(f.message)
    mark = doc.Words(f.severity, "WARNING" if f.severity == Severity.WARNING else "info")
    return doc.Item(doc.Words(capital(said), said), f.severity, mark)


def requirements(found: Sequence[Requirement]) -> doc.Listing:
    """Each requirement with what came of it."""
    return doc.Listing(tuple(map(_requirement, found)))


def _requirement(r: Requirement) -> doc.Item:
    mark = doc.Words("✓ met", "ok") if r.met else doc.Words("✗ FAILED", "FAILED")
    style = "passed" if r.met else "failed"
    return doc.Item(f"found {words.sentence(r.message)}", style, mark, printable(r.text))


def maneuver(m: ManeuverScore, is_explained: bool = False) -> doc.Chapter:
    """All that is known of a maneuver: scores, charts, definitions.

    Parameters
    ----------
    is_explained
        True if a page says what the columns of its scores mean.
    """
    blocks = (
        doc.Paragraph(f"{_covered(m)}.", "facts", only=doc.HTML),
        *scores(m, is_explained),
        _consistency(m),
        doc.Chapter("Error over time", (over_time(m),)),
        doc.Chapter("Which definition", (doc.Chart(partial(definitions, m)),), only=doc.PAGE),
        doc.Chapter("Column by column", _column_by_column(m), only=doc.PAGE),
    )
    anchor, link = f"maneuver-{m.maneuver}", f"Maneuver {m.maneuver}"
    return doc.Chapter(title(m), blocks, anchor, link, is_folded=True)


def title(m: ManeuverScore) -> doc.Words:
    """The heading of a maneuver, in text with its rows."""
    name = words.heading(m)
    return doc.Words(capital(name), f"{name}: {_covered(m)}")


def _covered(m: ManeuverScore) -> str:
    """Rows, time and step, and how much of the reference they cover."""
    step = "" if m.step is None else f", every {words.plain(m.step)} s"
    times = f"{words.plain(m.t_start)} to {words.plain(m.t_end)} s"
    return f"{m.rows} rows, {times}{step}, {words.percent(m.coverage)} of the reference"


def over_time(m: ManeuverScore) -> doc.Chart:
    """Errors of all columns of a maneuver."""
    return doc.Chart(partial(all_errors, m))


def scores(m: ManeuverScore, is_explained: bool = False) -> tuple[doc.Block, ...]:
    """Scores of a maneuver's columns, and what their marks mean."""
    if not m.columns:
        return (doc.Paragraph("  no column could be compared", only=doc.TEXT),)
    marks = "; ".join(words.mark_meanings(m.columns))
    note = doc.Words(f"{marks}.", marks) if marks else ""
    rows, about = list(map(_score, m.columns)), f"Scores of maneuver {m.maneuver}"
    return (doc.TableBlock(_COLUMNS, rows, about, left=2, is_explained=is_explained, note=note),)


def _score(c: ColumnScore) -> list[str | doc.Cell]:
    """Cells of `_COLUMNS`."""
    r, notes, mark = c.as_understood.measures, words.notes(c), words.mark(c)
    name = printable(c.as_understood.definition)
    return [
        doc.Cell(doc.Words(words.label(c.key), printable(c.key)), words.unit_text(c.unit)),
        doc.Words(
            ", ".join((name.replace("_", " ") + mark, *notes)), "\n  ".join((name + mark, *notes))
        ),
        error(r.max_abs_error),
        words.plain(r.time_of_max),
        error(r.rms_error),
        words.number(r.max_rel_error),
        words.one_decimal(r.scd),
        words.one_decimal(r.mescd),
        words.number(c.floor),
        words.first_above(c),
        words.number(c.as_written.measures.max_abs_error),
        f"{c.values} ({c.missing} missing)" if c.missing else str(c.values),
    ]


def error(x: float | None) -> doc.Words:
    """An error, on a page with a digit more."""
    return doc.Words(words.number(x, 3), words.number(x))


def _column_by_column(m: ManeuverScore) -> tuple[doc.Block, ...]:
    if not m.columns:
        return ()
    said = (
        "Above, the result on top of the reference; below, their distance on a logarithmic scale, "
        "where each thin line is a factor of ten. The dotted line is the floor: so far off exact "
        "values may be, once rounded to the digits of the file."
    )
    return doc.Paragraph(said, "said"), doc.Chart(partial(every_column, m))


def _consistency(m: ManeuverScore) -> doc.Facts:
    """Return the contradictions within the file itself, each with its explanation."""
    c = m.consistency
    eq_1 = doc.Words("eq. (1), 100 (max E − min E) / E₀", "eq. (1), 100 (max E - min E) / E0")
    said = "drift of the file's own mechanical energy, the only thing the benchmark judges"
    found = [(eq_1, words.performance_words(m), said)]
    if c.energy_sum is not None:
        text = f"{words.number(c.energy_sum)} J"
        if c.energy_sum_floor is not None:
            text += f" (rounding explains {words.number(c.energy_sum_floor)} J)"
        name = doc.Words("energies", "potential + kinetic - mechanical energy")
        found.append((name, text, "potential + kinetic against mechanical energy"))
    for which, x in (("roll", c.roll_rate), ("steer", c.steer_rate)):
        if x is not None:
            name = doc.Words(f"{which} rate", f"{which} rate - derivative of the angle")
            said = "against the derivative of the file's own angle"
            found.append((name, f"{words.number(x)} rad/s", said))
    return doc.Facts(tuple(found))
