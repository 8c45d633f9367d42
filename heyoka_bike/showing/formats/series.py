"""What is said of several runs of one program, or of programs side by side, as a document."""

from collections.abc import Iterator
from functools import partial

from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.report import Convergence, Run, Series
from heyoka_bike.showing.charts import series as charts
from heyoka_bike.showing.document import (
    HTML,
    TEXT,
    Block,
    Cell,
    Chapter,
    Chart,
    Document,
    Paragraph,
    TableBlock,
    Words,
)
from heyoka_bike.showing.document.html import capital
from heyoka_bike.showing.formats import matrix
from heyoka_bike.showing.formats.report import (
    KIND,
    asked,
    findings,
    maneuver,
    requirements,
    scores,
    titled,
)
from heyoka_bike.showing.grades import style_of
from heyoka_bike.showing.wording import (
    chosen,
    graded,
    heading,
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


def document(series: Series) -> Document:
    """All that is said about a series, and about its runs."""
    what = "runs" if series.is_one_program else "programs"
    names = ", ".join(run_name(series, run) for run in series.runs)
    count = f"{len(series.runs)} {what}"
    if series.is_one_program:
        of_what, parts = "of one program", _runs(series)
    else:
        of_what, parts = "side by side", _programs(series)
    return Document(
        f"{count}: {names}", f"{count} {of_what}", KIND,
        (
            Paragraph(series_verdict(series), "head", only=TEXT),
            *verdict_of(series),
            *(
                Paragraph(f"  {verdict(run.report)}", only=TEXT)
                for run in series.runs if series.is_one_program
            ),
            Chapter(titled("findings"), (findings(series.findings),), "findings", only=HTML),
            *parts,
            Chapter("findings", (findings(series.findings),), only=TEXT),
            *_said_of_runs(series),
        ),
    )  # fmt: skip


def verdict_of(series: Series) -> list[Block]:
    """Verdict, then digits by maneuver."""
    style = f" {style_of(chosen(series)[1].report)}" if series.is_one_program else ""
    return [
        Paragraph(f"{capital(series_verdict(series))}.", f"verdict{style}", only=HTML),
        asked(series),
        matrix.of_series(series),
    ]


def maneuvers_of(series: Series) -> list[int]:
    """Numbers of the maneuvers that runs have in common."""
    return sorted({c.maneuver for c in series.convergence})


def _runs(series: Series) -> Iterator[Block]:
    has_steps = any(run.step is not None for run in series.runs)
    compared = "Convergence" if has_steps else "Errors of the runs"
    name, shown = chosen(series)
    for n in maneuvers_of(series):
        between = ", and observed orders between them" if _has_orders(series, n) else ""
        title = f"{compared}, maneuver {n}"
        yield Chapter(
            Words(title, f"maneuver {n}: largest errors{between}"),
            (
                Chart(partial(charts.convergence, series, n)),
                Chart(partial(charts.work_precision, series, n)),
                *convergence(series, n),
            ),
            f"convergence-{n}",
            title,
        )
    runs: list[Block] = []
    for run in series.runs:
        others = () if run is shown else _scores(run)
        runs.append(Chapter(run_words(run), (*_said(run), *others)))
    yield Chapter("Runs", tuple(runs), "runs", "Runs", only=HTML)
    best = shown.report.maneuvers
    yield Chapter(
        f"{capital(name)} run: {run_words(shown)}",
        tuple(maneuver(m, is_explained=m is best[0]) for m in best),
        "in-full",
        f"{capital(name)} run",
        only=HTML,
    )


def _programs(series: Series) -> Iterator[Block]:
    for n in maneuvers_of(series):
        yield Chapter(
            Words(f"Maneuver {n}", f"maneuver {n}: correct digits"),
            (
                matrix.side_by_side(series, n),
                Chapter("Error over time", (Chart(partial(charts.side_by_side, series, n)),)),
                Chapter("Largest errors", convergence(series, n), only=HTML),
            ),
            f"maneuver-{n}",
            f"Maneuver {n}",
        )
    for i, run in enumerate(series.runs, start=1):
        name = run_name(series, run)
        blocks = (Paragraph(run_words(run), "facts"), *_said(run), *_scores(run, i == 1))
        yield Chapter(name, blocks, f"program-{i}", name, only=HTML)


def _said(run: Run) -> tuple[Block, ...]:
    """What is said of a run on a page."""
    return (
        Paragraph(f"{capital(graded(run.report))}.", "said"),
        requirements(run.report.requirements),
        findings(run.report.findings),
    )


def _said_of_runs(series: Series) -> Iterator[Block]:
    """What is said of the runs in text: where they differ from the one that is shown in full."""
    name, best = chosen(series)
    said = {f.message for f in best.report.findings} if series.is_one_program else set()
    for run in series.runs:
        found = run.report.findings
        if run is not best and series.is_one_program:
            # What is found about one run is mostly found about all of them.
            new = (f for f in found if f.message not in said)
            found = tuple(f for f in new if f.severity == Severity.WARNING)
        yield Chapter(
            f"{run_words(run)}{f' ({name})' if run is best else ''}",
            (findings(found), requirements(run.report.requirements)),
            only=TEXT,
        )


def _scores(run: Run, is_explained: bool = False) -> tuple[Block, ...]:
    """Tables of all maneuvers; below the first what their headings mean, if that is asked."""
    return tuple(
        Chapter(capital(heading(m)), scores(m, is_explained and not i))
        for i, m in enumerate(run.report.maneuvers)
    )


def convergence(series: Series, maneuver: int) -> tuple[Block, ...]:
    """Errors of a maneuver for each run, the observed order between neighbours."""
    columns = [c for c in series.convergence if c.maneuver == maneuver]
    has_cpu = any(run.cpu is not None for run in series.runs)
    has_orders = _has_orders(series, maneuver)
    size = size_heading(series)
    what = Words(size.removesuffix(" [s]") or "run", size) if series.is_one_program else "program"
    names = (label(c.key) for c in columns)
    heads = (
        Cell(Words(name, f"{name.replace(' ', chr(10), 1)}\n"), unit_text(c.unit))
        for name, c in zip(names, columns, strict=True)
    )
    blank = [""] * has_cpu
    rows: list[list[str | Cell]] = []
    for i, run in enumerate(series.runs):
        if i and has_orders:
            orders = (Cell(one_decimal(_at(c, i - 1)), style="aside") for c in columns)
            rows.append([Cell(Words("observed order", "  order"), style="aside"), *blank, *orders])
        full = f"{plain(run.step)} s" if run.step is not None else run_name(series, run)
        name = Words(full, size_text(run) or f"run {i + 1}")
        cpu = [plain(run.cpu, 3)] * has_cpu
        rows.append([name, *cpu, *(_error(c.errors[i]) for c in columns)])
    said = ["Largest errors."]
    if has_orders:
        left = (number(c.richardson_error) for c in columns)
        rows.append([Words("extrapolated", "extrapol."), *blank, *left])
        said = [
            "Largest errors, and the observed order between neighbouring runs. Extrapolated: the "
            "error that is left by Richardson's extrapolation of the two finest runs, which "
            "cancels the leading term."
        ]
    if series.is_one_program:
        rows.append(["floor", *blank, *(number(c.floor) for c in columns)])
        said.append("Floor: what the digits written allow.")
    if has_cpu:
        said.append("CPU: processor time of the whole run.")
    return (
        TableBlock(
            [what, *["CPU [s]"] * has_cpu, *heads], rows,
            f"Convergence of maneuver {maneuver}", "numbers", left=1 + has_cpu, in_parts=True,
            note=Words(" ".join(said), ""),
        ),
    )  # fmt: skip


def _has_orders(series: Series, maneuver: int) -> bool:
    columns = (c for c in series.convergence if c.maneuver == maneuver)
    return any(p is not None for c in columns for p in c.orders)


def _error(x: float | None) -> Words:
    return Words(number(x, 3), number(x))


def _at(c: Convergence, pair: int) -> float | None:
    return c.orders[pair] if pair < len(c.orders) else None
