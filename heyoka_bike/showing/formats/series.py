"""What is said of several runs of one program, or of programs side by side, as a document."""

from collections.abc import Iterator
from functools import partial

from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.report import Convergence, Run, Series
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
    yield from _runs(series) if series.is_one_program else _programs(series)
    yield report.folded("Findings", found, is_open=True, only=doc.TEXT)
    yield from _said_of_runs(series)
    for run in series.runs:
        name, content = words.run_name(series, run), tuple(report.blocks(run.report))
        yield doc.Chapter(name, content, is_folded=True, only=doc.NOTEBOOK)


def _maneuvers(series: Series) -> list[int]:
    """Numbers of the maneuvers that runs have in common."""
    return sorted({c.maneuver for c in series.convergence})


def _runs(series: Series) -> Iterator[doc.Block]:
    has_steps = any(run.step is not None for run in series.runs)
    compared = "Convergence" if has_steps else "Errors of the runs"
    name, shown = words.chosen(series)
    for n in _maneuvers(series):
        between = ", and observed orders between them" if _has_orders(series, n) else ""
        title = f"{compared}, maneuver {n}"
        heading = doc.Words(title, f"maneuver {n}: largest errors{between}")
        drawn = (charts.convergence, charts.work_precision)
        found: list[doc.Block] = [doc.Chart(partial(f, series, n)) for f in drawn]
        found.append(_convergence(series, n))
        yield doc.Chapter(heading, found, f"convergence-{n}", title, is_folded=True, is_open=True)
    runs: list[doc.Block] = []
    for run in series.runs:
        others = () if run is shown else _scores(run)
        runs.append(doc.Chapter(words.run_words(run), (*_said(run), *others)))
    yield doc.Chapter("Runs", tuple(runs), "runs", "Runs", only=doc.PAGE)
    best, title = shown.report.maneuvers, f"{capital(name)} run"
    every = tuple(report.maneuver(m, is_explained=m is best[0]) for m in best)
    whole = f"{title}: {words.run_words(shown)}"
    yield doc.Chapter(whole, every, "in-full", title, only=doc.PAGE)


def _programs(series: Series) -> Iterator[doc.Block]:
    for n in _maneuvers(series):
        heading = doc.Words(f"Maneuver {n}", f"maneuver {n}: correct digits")
        drawn = doc.Chart(partial(charts.side_by_side, series, n))
        found = (
            matrix.side_by_side(series, n),
            doc.Chapter("Error over time", (drawn,)),
            doc.Chapter("Largest errors", (_convergence(series, n),), only=doc.PAGE),
        )
        yield doc.Chapter(
            heading, found, f"maneuver-{n}", f"Maneuver {n}", is_folded=True, is_open=True
        )
    for i, run in enumerate(series.runs, start=1):
        name = words.run_name(series, run)
        blocks = (doc.Paragraph(words.run_words(run), "facts"), *_said(run), *_scores(run, i == 1))
        yield doc.Chapter(name, blocks, f"program-{i}", name, only=doc.PAGE)


def _said(run: Run) -> tuple[doc.Block, ...]:
    """What is said of a run on a page."""
    return (
        doc.Paragraph(f"{capital(words.graded(run.report))}.", "said"),
        report.requirements(run.report.requirements),
        report.findings(run.report.findings),
    )


def _said_of_runs(series: Series) -> Iterator[doc.Block]:
    """What is said of the runs in text: where they differ from the one that is shown in full."""
    name, best = words.chosen(series)
    said = {f.message for f in best.report.findings} if series.is_one_program else set()
    for run in series.runs:
        found = run.report.findings
        if run is not best and series.is_one_program:
            # What is found about one run is mostly found about all of them.
            new = (f for f in found if f.message not in said)
            found = tuple(f for f in new if f.severity == Severity.WARNING)
        yield doc.Chapter(
            f"{words.run_words(run)}{f' ({name})' if run is best else ''}",
            (report.findings(found), report.requirements(run.report.requirements)),
            only=doc.TEXT,
        )


def _scores(run: Run, is_explained: bool = False) -> tuple[doc.Block, ...]:
    """Tables of all maneuvers; below the first what their headings mean, if that is asked."""
    return tuple(
        doc.Chapter(capital(words.heading(m)), report.scores(m, is_explained and not i))
        for i, m in enumerate(run.report.maneuvers)
    )


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
