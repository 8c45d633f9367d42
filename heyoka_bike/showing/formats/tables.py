"""Tables of the HTML report."""

from collections.abc import Iterable, Sequence
from html import escape

from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.report import Convergence, ManeuverScore, Series
from heyoka_bike.showing.formats.wording import (
    first_above,
    label,
    mark,
    mark_meanings,
    notes,
    number,
    one_decimal,
    plain,
    run_name,
    size_heading,
    unit_text,
)

_SCORES = (
    ("column", "the quantity, and its unit"),
    ("definition", "what the column was found to mean"),
    ("max error", "largest absolute error over the rows, in the unit of the column"),
    ("at [s]", "time of the largest error"),
    ("rms error", "root of the mean squared error of the rows"),
    ("relative", "largest error / largest absolute value of the reference"),
    ("scd", "significant correct digits: -log10 of the relative error"),
    ("mescd", "the same, of the error / (1 + value)"),
    ("floor", "largest error of correctly rounded values, as many digits as the file has"),
    ("above 1e-3 [s]", "first time at which the error exceeds 1e-3 of the scale"),
    ("as written", "largest error if taken as the default definition, SI unit, sign and zero"),
    ("values", "how many were compared"),
)


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    about: str,
    style: str = "scores",
) -> str:
    """A table that scrolls in its box: the first cell of a row is its heading.

    Parameters
    ----------
    head
        Headings as HTML.
    rows
        Cells as HTML; numbers from the second on.
    about
        Name of the table.
    style
        Its class.
    """
    top = "".join(f'<th scope="col">{name}</th>' for name in head)
    body = "".join(
        f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in rest)}</tr>'
        for first, *rest in rows
    )
    return (
        f'<div class="scroll" tabindex="0" role="group" aria-label="{escape(about)}">'
        f'<table class="{style}"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'
    )


def scores(m: ManeuverScore, explained: bool = True) -> str:
    """Scores of a maneuver's columns, and what their headings mean if that is to be explained."""
    if not m.columns:
        return ""
    heads = [escape(name) for name, _ in _SCORES]
    found = table(heads, (_score(c) for c in m.columns), f"Scores of maneuver {m.maneuver}")
    if marks := mark_meanings(m.columns):
        found += f'<p class="facts">{escape("; ".join(marks))}.</p>'
    if not explained:
        return found
    meanings = "".join(f"<dt>{escape(a)}</dt><dd>{escape(b)}</dd>" for a, b in _SCORES[1:])
    return f'{found}<dl class="meanings">{meanings}</dl>'


def _score(c: ColumnScore) -> tuple[str, ...]:
    r = c.as_understood.measures
    definition = c.as_understood.definition.replace("_", " ") + mark(c)
    missing = f" ({c.missing} missing)" if c.missing else ""
    return (
        f"{escape(label(c.key))} <i>[{escape(unit_text(c.unit))}]</i>",
        escape(", ".join((definition, *notes(c)))),
        number(r.max_abs_error, 3),
        plain(r.time_of_max),
        number(r.rms_error, 3),
        number(r.max_rel_error),
        one_decimal(r.scd),
        one_decimal(r.mescd),
        number(c.floor),
        first_above(c),
        number(c.as_written.measures.max_abs_error),
        f"{c.values}{missing}",
    )


def convergence(series: Series, maneuver: int) -> str:
    """Errors of a maneuver for each run, the observed order between neighbours."""
    columns = [c for c in series.convergence if c.maneuver == maneuver]
    heading = size_heading(series).removesuffix(" [s]") or "run"
    has_cpu = any(run.cpu is not None for run in series.runs)
    head = [heading if series.is_one_program else "program"]
    head += ["CPU [s]"] * has_cpu
    head += [f"{escape(label(c.key))} <i>[{escape(unit_text(c.unit))}]</i>" for c in columns]
    blank = ("",) * has_cpu
    has_orders = any(p is not None for c in columns for p in c.orders)
    rows = []
    for i, run in enumerate(series.runs):
        if i and has_orders:
            orders = (f"<i>{one_decimal(_at(c, i - 1))}</i>" for c in columns)
            rows.append(("<i>observed order</i>", *blank, *orders))
        errors = (number(c.errors[i], 3) for c in columns)
        name = f"{plain(run.step)} s" if run.step is not None else run_name(series, run)
        rows.append((escape(name), *[plain(run.cpu, 3)][: len(blank)], *errors))
    said = ["Largest errors."]
    if has_orders:
        rows.append(("extrapolated", *blank, *(number(c.richardson_error) for c in columns)))
        said = [
            "Largest errors, and the observed order between neighbouring runs. Extrapolated: the "
            "error that is left by Richardson's extrapolation of the two finest runs, which "
            "cancels the leading term."
        ]
    if series.is_one_program:
        rows.append(("floor", *blank, *(number(c.floor) for c in columns)))
        said.append("Floor: what the digits written allow.")
    if has_cpu:
        said.append("CPU: processor time of the whole run.")
    return (
        table(head, rows, f"Convergence of maneuver {maneuver}", "numbers")
        + f'<p class="facts">{" ".join(said)}</p>'
    )


def _at(c: Convergence, pair: int) -> float | None:
    return c.orders[pair] if pair < len(c.orders) else None
