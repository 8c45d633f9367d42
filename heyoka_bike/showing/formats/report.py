"""What a report says, as a document for every medium."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from heyoka_bike.errors import printable
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.report import ManeuverScore, Report, Requirement, Series
from heyoka_bike.showing.charts.definitions import definitions
from heyoka_bike.showing.charts.maneuver import all_errors, every_column, explained
from heyoka_bike.showing.document import (
    HTML,
    TEXT,
    Block,
    Cell,
    Chapter,
    Chart,
    Document,
    Facts,
    Item,
    Listing,
    Paragraph,
    TableBlock,
    TableColumn,
    Words,
)
from heyoka_bike.showing.document.html import capital
from heyoka_bike.showing.formats import matrix
from heyoka_bike.showing.grades import SIGNS, file_grade, style_of
from heyoka_bike.showing.wording import (
    by_severity,
    caveats,
    contents,
    first_above,
    graded,
    heading,
    label,
    mark,
    mark_meanings,
    notes,
    number,
    one_decimal,
    percent,
    performance_remark,
    performance_words,
    plain,
    requirement_words,
    sentence,
    unit_text,
    verdict,
    warnings_words,
    worst_error_words,
)

KIND = "Uncontrolled bicycle: score of"

_Measure = Callable[[ColumnScore], str | Cell]
_SCORES: tuple[tuple[TableColumn, _Measure], ...] = (
    (
        TableColumn("column", "the quantity, and its unit"),
        lambda c: Cell(Words(label(c.key), printable(c.key)), unit_text(c.unit)),
    ),
    (
        TableColumn("definition", "what the column was found to mean"),
        lambda c: _definition(c),
    ),
    (
        TableColumn(
            Words("max error", "max\nerror"),
            "largest absolute error over the rows, in the unit of the column",
        ),
        lambda c: _error(c.as_understood.measures.max_abs_error),
    ),
    (
        TableColumn("at [s]", "time of the largest error", only=HTML),
        lambda c: plain(c.as_understood.measures.time_of_max),
    ),
    (
        TableColumn(
            Words("rms error", "rms\nerror"), "root of the mean squared error of the rows",
            leave_out=2,
        ),
        lambda c: _error(c.as_understood.measures.rms_error),
    ),
    (
        TableColumn(
            Words("relative", "rel.\nerror"),
            "largest error / largest absolute value of the reference", leave_out=4,
        ),
        lambda c: number(c.as_understood.measures.max_rel_error),
    ),
    (
        TableColumn("scd", "significant correct digits: -log10 of the relative error"),
        lambda c: one_decimal(c.as_understood.measures.scd),
    ),
    (
        TableColumn("mescd", "the same, of the error / (1 + value)", leave_out=1),
        lambda c: one_decimal(c.as_understood.measures.mescd),
    ),
    (
        TableColumn(
            "floor",
            "largest error of correctly rounded values, as many digits as the file has",
            leave_out=3,
        ),
        lambda c: number(c.floor),
    ),
    (
        TableColumn(
            Words("above 1e-3 [s]", "above\n1e-3 [s]"),
            "first time at which the error exceeds 1e-3 of the scale",
        ),
        first_above,
    ),
    (
        TableColumn(
            "as written",
            "largest error if taken as the default definition, SI unit, sign and zero", only=HTML,
        ),
        lambda c: number(c.as_written.measures.max_abs_error),
    ),
    (
        TableColumn("values", "how many were compared", only=HTML),
        lambda c: f"{c.values}{f' ({c.missing} missing)' if c.missing else ''}",
    ),
)  # fmt: skip

_LEGEND = (
    "rel. error: largest error / scale, "
    "the largest absolute value of the reference; scd: correct digits, -log10 of it; mescd: the "
    "same of error / (1 + value); floor: largest error of correctly rounded values with as many "
    "digits; above 1e-3: first time at which the error exceeds 1e-3 of the scale"
)


def document(report: Report) -> Document:
    """The report of a file."""
    name = printable(Path(report.file.path).name or report.file.path)
    required = (requirements(report.requirements),)
    met = Chapter("Requirements", required, "requirements", "Requirements", only=HTML)
    e = report.explanation
    why = () if e is None else (
        Paragraph(f"{capital(sentence(e.says))}.", "said"), Chart(partial(explained, e)),
    )  # fmt: skip
    first = report.maneuvers[:1]
    return Document(
        name, name, KIND,
        (
            *verdict_of(report),
            Paragraph(verdict(report), f"verdict {style_of(report)}", only=TEXT),
            Paragraph(
                f"  {'; '.join(filter(None, (contents(report), warnings_words(report))))}",
                only=TEXT,
            ),
            matrix.of_report(report),
            remark(report),
            met,
            Chapter(titled("findings"), (findings(report.said),), "findings", "Findings"),
            Chapter("requirements", required, only=TEXT),
            Chapter("What explains it", why, "explanation", "What explains it", only=HTML),
            *(maneuver(m, is_explained=m in first) for m in report.maneuvers),
            Paragraph(_LEGEND if report.maneuvers else "", "facts", only=TEXT),
            Chapter(
                "eq. (1) of the benchmark, 100 (max E - min E) / E0 of the file's own energy",
                (_eq_1(report),),
                only=TEXT,
            ),
            Chapter("the file against itself", (_against_itself(report),), only=TEXT),
        ),
    )  # fmt: skip


def verdict_of(report: Report) -> list[Block]:
    """What the file is worth by its true error, then what it holds; for a page."""
    text = capital("; ".join([graded(report), *caveats(report)]))
    worst_error = worst_error_words(report)
    warnings = warnings_words(report)
    return [
        Paragraph(
            f"{text}.", f"verdict {style_of(report)}", sign=SIGNS.get(file_grade(report), ""),
            only=HTML,
        ),
        Paragraph(f"{capital(worst_error)}." if worst_error else "", "worst", only=HTML),
        asked(report),
        Paragraph(
            contents(report), "facts", link=(warnings, "findings") if warnings else None,
            note=printable(report.file.path), only=HTML,
        ),
    ]  # fmt: skip


def asked(scored: Report | Series) -> Paragraph:
    """Whether the requirements are met, for a page."""
    said = requirement_words(scored)
    style, sign = ("right", "✓") if scored.passed else ("wrong", "✗")
    text = f"{capital(said)}." if said else ""
    return Paragraph(text, f"asked {style}", sign=sign, only=HTML)


def remark(report: Report) -> Paragraph:
    """What eq. (1) says, and what it sees."""
    said = performance_remark(report)
    return Paragraph(f"{said}." if said else "", "remark", lead="remark")


def titled(name: str) -> Words:
    """A heading that has a large first letter on a page."""
    return Words(capital(name), name)


def findings(found: Sequence[Finding]) -> Listing:
    """Each finding with its severity, warnings first."""
    items = []
    for f in by_severity(tuple(found)):
        said = sentence(f.message)
        level = "WARNING" if f.severity == Severity.WARNING else "info"
        items.append(Item(Words(capital(said), said), f.severity, Words(f.severity, level)))
    return Listing(tuple(items))


def requirements(found: Sequence[Requirement]) -> Listing:
    """Each requirement with what came of it."""
    return Listing(
        tuple(
            Item(
                f"found {sentence(r.message)}",
                "passed" if r.met else "failed",
                Words("✓ met", "ok") if r.met else Words("✗ FAILED", "FAILED"),
                printable(r.text),
            )
            for r in found
        )
    )


def maneuver(m: ManeuverScore, *, is_explained: bool = False, is_within: bool = False) -> Chapter:
    """All that is known of a maneuver: scores, charts, definitions.

    Parameters
    ----------
    is_explained
        Whether the columns of its scores are.
    is_within
        Whether it is a part of a notebook's piece: without what is better looked at on a page.
    """
    facts = f"{m.rows} rows, {plain(m.t_start)} to {plain(m.t_end)} s"
    if m.step is not None:
        facts += f", every {plain(m.step)} s"
    covered = f"{facts}, {percent(m.coverage)} of the reference"
    title = heading(m)
    blocks: tuple[Block, ...] = (
        Paragraph("" if is_within else f"{covered}.", "facts", only=HTML),
        *scores(m, is_explained),
    )
    if is_within:
        blocks += (Chart(partial(all_errors, m)),)
    else:
        blocks += (
            Facts(_consistency(m), HTML),
            Chapter("Error over time", (Chart(partial(all_errors, m)),)),
            Chapter("Which definition", (Chart(partial(definitions, m)),)),
            Chapter("Column by column", _column_by_column(m), only=HTML),
        )
    return Chapter(
        Words(capital(title), f"{title}: {covered if m.coverage < 1 else facts}"), blocks,
        f"maneuver-{m.maneuver}", f"Maneuver {m.maneuver}", is_folded=True,
    )  # fmt: skip


def scores(m: ManeuverScore, is_explained: bool = False) -> tuple[Block, ...]:
    """Scores of a maneuver's columns, and what their marks mean."""
    if not m.columns:
        return (Paragraph("  no column could be compared", only=TEXT),)
    marks = "; ".join(mark_meanings(m.columns))
    rows = [[cell(c) for _, cell in _SCORES] for c in m.columns]
    about = f"Scores of maneuver {m.maneuver}"
    note = Words(f"{marks}.", marks) if marks else ""
    columns = [column for column, _ in _SCORES]
    return (TableBlock(columns, rows, about, left=2, is_explained=is_explained, note=note),)


def _definition(c: ColumnScore) -> Words:
    """The definition, and what else is not the default."""
    name = printable(c.as_understood.definition) + mark(c)
    full = c.as_understood.definition.replace("_", " ") + mark(c)
    return Words(", ".join((full, *notes(c))), "\n  ".join((name, *notes(c))))


def _error(x: float | None) -> Words:
    return Words(number(x, 3), number(x))


def _column_by_column(m: ManeuverScore) -> tuple[Block, ...]:
    if not m.columns:
        return ()
    return (
        Paragraph(
            "Above, the result on top of the reference; below, their distance on a logarithmic "
            "scale, where each thin line is a factor of ten. The dotted line is the floor: so far "
            "off exact values may be, once rounded to the digits of the file.",
            "said",
        ),
        Chart(partial(every_column, m)),
    )


def _rounding(m: ManeuverScore) -> str:
    """The distance of the energies from their sum, and what of it is rounding."""
    c = m.consistency
    said = f"{number(c.energy_sum)} J"
    if c.energy_sum_floor is not None:
        said += f" (rounding explains {number(c.energy_sum_floor)} J)"
    return said


def _rates(m: ManeuverScore) -> list[tuple[str, str]]:
    found = (("roll", m.consistency.roll_rate), ("steer", m.consistency.steer_rate))
    return [(name, f"{number(x)} rad/s") for name, x in found if x is not None]


def _consistency(m: ManeuverScore) -> tuple[tuple[str, str, str], ...]:
    """What the file says about itself, each with its explanation."""
    found = [
        (
            "eq. (1), 100 (max E − min E) / E₀", performance_words(m),
            "drift of the file's own mechanical energy, the only thing the benchmark judges",
        ),
    ]  # fmt: skip
    if m.consistency.energy_sum is not None:
        found.append(("energies", _rounding(m), "potential + kinetic against mechanical energy"))
    said = "against the derivative of the file's own angle"
    found += [(f"{name} rate", text, said) for name, text in _rates(m)]
    return tuple(found)


def _eq_1(report: Report) -> Facts:
    return Facts(
        tuple((f"maneuver {m.maneuver}", performance_words(m), "") for m in report.maneuvers)
    )


def _against_itself(report: Report) -> Facts:
    found = []
    for m in report.maneuvers:
        parts = []
        if m.consistency.energy_sum is not None:
            parts.append(f"potential + kinetic - mechanical energy {_rounding(m)}")
        parts += [f"{name} rate - derivative of the angle {text}" for name, text in _rates(m)]
        if parts:
            found.append((f"maneuver {m.maneuver}", "; ".join(parts), ""))
    return Facts(tuple(found))
