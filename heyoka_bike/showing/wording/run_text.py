"""Names and sizes of the runs of a series."""

import math
from pathlib import Path

from heyoka_bike.errors import printable
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Run, Series
from heyoka_bike.showing.wording.number_text import plain

_LONGEST_NAME_SHOWN = 30


def reports(scored: Report | Series) -> tuple[Report, ...]:
    """Return the reports of all runs of a series, or the only report of a file."""
    return (scored,) if isinstance(scored, Report) else tuple(r.report for r in scored.runs)


def chosen(series: Series) -> tuple[str, Run]:
    """Return ``finest`` or ``best``, and the run of the series to which this word applies.

    A report shows this run in full.
    """
    if series.is_one_program and all(size_text(run) for run in series.runs):
        return "finest", series.runs[-1]

    def digits(run: Run) -> float:
        found = run.report.worst
        return -math.inf if found is None else found.scd

    return "best", max(series.runs, key=digits)


def order_words(series: Series) -> str:
    """Return the observed orders of convergence between the two finest runs with known orders."""
    for pair in reversed(range(len(series.runs) - 1)):
        orders = [c.orders[pair] for c in series.convergence if pair < len(c.orders)]
        known = [x for x in orders if x is not None]
        if known:
            low, high = f"{min(known):.1f}", f"{max(known):.1f}"
            between = low if low == high else f"{low} to {high}"
            return f"observed order {between}"
    return ""


def size_text(run: Run) -> str:
    """Return the step [s] of a run, or else its tolerance; empty if neither is known."""
    return plain(run.tolerance if run.step is None else run.step).strip("-")


def size_heading(series: Series) -> str:
    """Return the name of the quantity that `size_text` shows: step, tolerance or nothing."""
    if any(run.step is not None for run in series.runs):
        return "step [s]"
    return "tolerance" if any(run.tolerance is not None for run in series.runs) else ""


def run_name(series: Series, run: Run) -> str:
    """Return a short name of a run: its step or tolerance, its program, or its file."""
    if series.is_one_program and run.step is not None:
        return f"step {plain(run.step)} s"
    if series.is_one_program and run.tolerance is not None:
        return f"tolerance {plain(run.tolerance)}"
    return printable(run.name or Path(run.report.file.path).name)


def short_name(name: str) -> str:
    """Shorten a name to make room for numbers; the end of a path identifies the file."""
    return name if len(name) <= _LONGEST_NAME_SHOWN else f"...{name[3 - _LONGEST_NAME_SHOWN :]}"


def run_words(run: Run) -> str:
    """Return the file of a run, its step and its processor time."""
    path = printable(run.report.file.path)
    parts = [path if run.name in ("", Path(path).name) else f"{printable(run.name)}, {path}"]
    if run.step is not None:
        parts.append(f"step {plain(run.step)} s")
    if run.tolerance is not None:
        parts.append(f"tolerance {plain(run.tolerance)}")
    if run.cpu is not None:
        parts.append(f"{plain(run.cpu, 3)} s of processor time")
    return ", ".join(parts)
