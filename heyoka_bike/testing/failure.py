"""A failed test in words: which requirement, where and since when, and what is known of why."""

import textwrap
from collections.abc import Iterator, Sequence
from math import inf

import numpy as np

from heyoka_bike.errors import printable
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.measures import TOLERANCE
from heyoka_bike.scoring.report import ColumnScore, ManeuverScore, Report, Requirement
from heyoka_bike.scoring.requirements import OF_COLUMN, Parsed, parse
from heyoka_bike.showing import wording as words

# pytest puts nothing in front of the lines, and terminals have 80 columns at least, mostly more.
_WIDTH = 96
_LABEL = 17


def failure(checked: Sequence[Requirement], scored: Report, diagnosis: Sequence[str]) -> str:
    """Return the message about results that are not good enough.

    Parameters
    ----------
    checked
        Requirements, of which at least one is not met; the first such one is explained.
    scored : Report
    diagnosis
        Sentences: why the results differ.
    """
    failed = [r for r in checked if not r.met]
    lines = [f"required {printable(r.text)}, found {words.sentence(r.message)}" for r in failed]
    lines.append("")
    entries = list(_explained(parse(failed[0].text), scored))
    for m in scored.maneuvers:
        digits = (f"{c.key} {words.one_decimal(c.as_understood.measures.scd)}" for c in m.columns)
        entries.append((f"scd, maneuver {m.maneuver}", ", ".join(digits)))
    entries += [("warning", f.message) for f in scored.findings if f.severity == Severity.WARNING]
    short = [r for r in failed if parse(r.text).metric == "coverage"]
    if short:
        entries.append(
            ("short run", "rows that are missing are not judged; of a run that is meant to be "
             "short require that, too, such as coverage=0.1")
        )  # fmt: skip
    entries += [("diagnosis", says) for says in diagnosis]
    labels = [label for label, _ in entries]
    for i, (label, text) in enumerate(entries):
        # A label stands for those below it, too.
        lines.append(_entry("" if i and label == labels[i - 1] else label, text))
    return "\n".join(lines)


def _entry(label: str, text: str) -> str:
    """A label and what belongs to it, wrapped beside it."""
    return textwrap.fill(
        words.sentence(text), _WIDTH,
        initial_indent=f"{label:<{_LABEL}} ", subsequent_indent=" " * (_LABEL + 1),
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _explained(p: Parsed, scored: Report) -> Iterator[tuple[str, str]]:
    """The worst of the columns that a requirement is about."""
    about = [
        (m, c)
        for m in scored.maneuvers
        for c in m.columns
        if c.values and p.maneuver in (None, m.maneuver) and p.column in (None, c.key)
    ]
    if not about:
        return
    m, c = max(about, key=lambda x: _badness(p, x[1]))
    measures, trace = c.as_understood.measures, c.trace
    at = int(np.argmax(np.abs(trace.error)))
    yield (
        "worst column",
        f"{c.key} of maneuver {m.maneuver}, taken as {_taken_as(c)}: wrong by "
        f"{words.in_unit(words.number(measures.max_abs_error), c.unit)}, "
        f"{words.number(measures.max_rel_error)} of its scale "
        f"(scd {words.one_decimal(measures.scd)})",
    )
    yield (
        "worst row",
        f"t = {trace.time[at]:.10g} s: found {float(trace.value[at])!r}, expected "
        f"{float(trace.reference[at])!r}, error {words.in_unit(f'{trace.error[at]:+.2e}', c.unit)}",
    )
    yield "first departure", _departure(p, m, c)


def _badness(p: Parsed, c: ColumnScore) -> float:
    """Rank a column by the metric of a requirement, or by its digits; the largest is worst."""
    metric = p.metric if p.metric in OF_COLUMN else "scd"
    value = getattr(c.as_understood.measures, metric)
    if value is None:
        return -inf
    return -float(value) if metric in ("scd", "mescd", "time_to_tolerance") else float(value)


def _taken_as(c: ColumnScore) -> str:
    """The definition that fits, and what else the column was taken for."""
    taken = ", ".join((c.as_understood.definition, *words.notes(c)))
    remarks = ["the default"] if words.is_default(c) else []
    if c.indistinguishable:
        remarks.append(f"{' and '.join(c.indistinguishable)} fit as well")
    return f"{taken} ({'; '.join(remarks)})" if remarks else taken


def _departure(p: Parsed, m: ManeuverScore, c: ColumnScore) -> str:
    """Since when the error is more than what is allowed, and since when it can be seen."""
    said = []
    scale = c.scale or None
    allowed = {
        "scd": None if scale is None else scale * 10.0**-p.number,
        "max_rel_error": None if scale is None else scale * p.number,
        "max_abs_error": p.number,
    }.get(p.metric)
    if allowed is not None:
        above = np.flatnonzero(np.abs(c.trace.error) > allowed)
        if len(above):
            first = above[0]
            said.append(
                f"t = {c.trace.time[first]:.10g} s (row {first + 1} of {len(c.trace.time)}) is the "
                f"first above {words.in_unit(words.number(allowed), c.unit)}, the error allowed"
            )
    seen = words.first_above(c)
    said.append(
        f"above {TOLERANCE:g} of the scale {seen if seen == 'never' else f'from t = {seen} s'}"
    )
    return "; ".join(said)
