"""Several runs of one program, or programs side by side, as blocks of a document."""

from collections.abc import Callable, Iterator
from functools import partial

from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.report import Convergence, ManeuverScore, Series
from heyoka_bike.showing import document as doc
from heyoka_bike.showing import wording as words
from heyoka_bike.showing.charts import series as charts
from heyoka_bike.showing.document.html import capital
from heyoka_bike.showing.formats import matrix, report
from heyoka_bike.showing.grades import style_of


def blocks(series: Series) -> Iterator[doc.Block]:
    """All that is said about a series; a notebook has each run folded."""
    yield doc.Paragraph(words.series_verdict(series), "head", only=doc.TEXT)
    style = f" {style_of(words.chosen(series)[1].report)}" if series.is_one_program else ""
    text = f"{capital(words.series_verdict(series))}."
    yield doc.Paragraph(text, f"verdict{style}", only=doc.HTML)
    yield report.asked(series)
    yield matrix.of_series(series)
    if series.is_one_program:
        for run in series.runs:
            yield doc.Paragraph(f"  {words.verdict(run.report)}", only=doc.TEXT)
    found = report.findings(series.findings)
    yield report.folded("Findings", found, only=doc.HTML)
    for n in sorted({c.maneuver for c in series.convergence}):
        yield _maneuver(series, n)
    yield report.folded("Findings", found, is_open=True, only=doc.TEXT)
    yield from _each_run(series)


def _maneuver(series: Series, n: int) -> doc.Chapter:
    """Errors of all runs in a maneuver that they have in common."""
    title, errors = f"Maneuver {n}", _convergence(series, n)
    content: tuple[doc.Block, ...]
    if series.is_one_program:
        has_steps = any(run.step is not None for run in series.runs)
        between = ", and observed orders between them" if _has_orders(series, n) else ""
        brief = f"maneuver {n}: largest errors{between}"
        title = f"{'Convergence' if has_steps else 'Errors of the runs'}, maneuver {n}"
        drawn = (charts.convergence, charts.work_precision)
        content = (*(doc.Chart(partial(f, series, n)) for f in drawn), errors)
    else:
        brief = f"maneuver {n}: correct digits"
        over_time = doc.Chart(partial(charts.side_by_side, series, n))
        content = (
            matrix.side_by_side(series, n),
            doc.Chapter("Error over time", (over_time,)),
            doc.Chapter("Largest errors", (errors,), only=doc.HTML),
        )
    return doc.Chapter(doc.Words(title, brief), content, f"all-{n}", title, True, is_open=True)


def _each_run(series: Series) -> Iterator[doc.Block]:
    """A chapter for each run; of one program a page shows the chosen one in full."""
    kind, best = words.chosen(series)
    for i, run in enumerate(series.runs):
        is_best = run is best
        name, held = words.run_name(series, run), run.report
        called = words.run_words(run) + (f" ({kind})" if is_best else "")
        asked = report.requirements(held.requirements)
        scored: Callable[[ManeuverScore, bool], doc.Chapter] = _scores
        if is_best and series.is_one_program:
            scored = report.maneuver
        content: tuple[doc.Block, ...] = (
            doc.Paragraph(called, "facts"),
            doc.Paragraph(f"{capital(words.graded(held))}.", "said"),
            asked,
            report.findings(held.findings),
            *(scored(m, i == j == 0) for j, m in enumerate(held.maneuvers)),
        )
        yield doc.Chapter(name, content, f"run-{i + 1}", name, only=doc.PAGE)
        found = held.findings
        if series.is_one_program and not is_best:
            # What is found about one run is mostly found about all of them.
            known = {f.message for f in best.report.findings}
            new = (f for f in found if f.message not in known)
            found = tuple(f for f in new if f.severity == Severity.WARNING)
        yield doc.Chapter(called, (report.findings(found), asked), only=doc.TEXT)
        yield doc.Chapter(name, tuple(report.blocks(held)), is_folded=True, only=doc.NOTEBOOK)


def _scores(m: ManeuverScore, is_explained: bool) -> doc.Chapter:
    return doc.Chapter(capital(words.heading(m)), report.scores(m, is_explained))


def _convergence(series: Series, maneuver: int) -> doc.TableBlock:
    """Errors of a maneuver for each run, the observed order between neighbours."""
    columns = [c for c in series.convergence if c.maneuver == maneuver]
    has_cpu = any(run.cpu is not None for run in series.runs)
    has_orders = _has_orders(series, maneuver)
    size = words.size_heading(series)
    what = doc.Words(size.removesuffix(" [s]") or "run", size)
    blank = [""] * has_cpu
    rows: list[list[str | doc.Cell]] = []
    for i, run in enumerate(series.runs):
        if i and has_orders:
            orders = (doc.Cell(words.one_decimal(c.orders[i - 1]), style="aside") for c in columns)
            name = doc.Cell(doc.Words("observed order", "  order"), style="aside")
            rows.append([name, *blank, *orders])
        full = f"{words.plain(run.step)} s" if run.step is not None else words.run_name(series, run)
        step = doc.Words(full, words.size_text(run) or f"run {i + 1}")
        cpu = [words.plain(run.cpu, 3)] * has_cpu
        rows.append([step, *cpu, *(report.error(c.errors[i]) for c in columns)])
    said = "Largest errors."
    if has_orders:
        left = (words.number(c.richardson_error) for c in columns)
        rows.append([doc.Words("extrapolated", "extrapol."), *blank, *left])
        said = (
            "Largest errors, and the observed order between neighbouring runs. Extrapolated: the "
            "error that is left by Richardson's extrapolation of the two finest runs, which "
            "cancels the leading term."
        )
    if series.is_one_program:
        rows.append(["floor", *blank, *(words.number(c.floor) for c in columns)])
        said += " Floor: what the digits written allow."
    if has_cpu:
        said += " CPU: processor time of the whole run."
    return doc.TableBlock(
        [
            what if series.is_one_program else "program",
            *["CPU [s]"] * has_cpu,
            *map(_head, columns),
        ],
        rows,
        f"Convergence of maneuver {maneuver}",
        "numbers",
        left=1 + has_cpu,
        in_parts=True,
        note=doc.Words(said, ""),
    )


def _head(c: Convergence) -> doc.Cell:
    name = words.label(c.key)
    return doc.Cell(doc.Words(name, name.replace(" ", "\n", 1) + "\n"), words.unit_text(c.unit))


def _has_orders(series: Series, maneuver: int) -> bool:
    columns = (c for c in series.convergence if c.maneuver == maneuver)
    return any(p is not None for c in columns for p in c.orders)
