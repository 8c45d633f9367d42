"""Views of objects in Python and notebooks, as document blocks and as text.

A class selects its function in this module by the attribute ``_view``, see `display.Displayed`.
Notebooks show a piece of HTML without a script, not a whole page.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.reference.load import Motion, Reference, ReferenceManeuver
from heyoka_bike.reference.values import Values
from heyoka_bike.scoring.evidence.words import counted, unit_text
from heyoka_bike.showing.document import Block, Chapter, Chart, Paragraph, TableBlock, head
from heyoka_bike.showing.document import text as as_text
from heyoka_bike.showing.formats.output import WIDTH
from heyoka_bike.showing.wording.number_text import number, plain

if TYPE_CHECKING:
    from heyoka_bike.motion.trajectory import Trajectory
    from heyoka_bike.scoring.instants.checked import CheckedTable
    from heyoka_bike.scoring.report import Report
    from heyoka_bike.scoring.runs import Series
    from heyoka_bike.scoring.scores import ManeuverScore

_MOST_ROWS_SHOWN = 10
_MOST_COLUMNS, _COLUMNS_AMONG_OTHERS = 9, 8
_DIGITS_SHOWN = 10  # number of significant digits of a value in a table of several times
_UNIT_OF_COLUMN = {c.name: c.unit for columns in COMPARED.values() for c in columns}
_OF_MANEUVERS = (
    "maneuver", "name", "speed [m/s]", "roll rate [rad/s]", "ends at [s]", "rows", "columns",
)  # fmt: skip
_TIMES_SHOWN = 6  # maximum number of states shown for a trajectory


def text(shown: Any, view: str) -> str:
    """Return the text of an object, as the named view shows it, without a final line feed."""
    if view == "report":
        return _report_text(shown)
    if view == "values":
        return _values_text(shown)
    return as_text.render(tuple(globals()[view](shown)), WIDTH).strip("\n")


def report(scored: Report | Series) -> Iterable[Block]:
    """Return the report of a score; everything after the verdict and the digits is folded."""
    from heyoka_bike.showing.formats.report_document import document

    return document(scored).blocks


def _report_text(scored: Report | Series) -> str:
    """Return a summary of at most ten lines, or the text of the diagnosis if there is one."""
    from heyoka_bike.scoring.report import Report
    from heyoka_bike.showing.formats import summary

    if isinstance(scored, Report) and scored.diagnosis:
        return summary.diagnosis(scored)
    return summary.render(scored, WIDTH, False, in_python=True).rstrip("\n")


def maneuver(m: ManeuverScore) -> Iterable[Block]:
    """Return the scores of a maneuver and the chart of its errors over time."""
    from heyoka_bike.showing.charts.results import all_errors
    from heyoka_bike.showing.formats.report_document import scores, title

    return Paragraph(title(m), "head"), *scores(m), Chart(partial(all_errors, m))


def check(found: CheckedTable) -> Iterable[Block]:
    """Return the result of a check, as ``heyoka-bike check`` prints it."""
    from heyoka_bike.showing.formats.check import blocks

    return blocks(found)


def reference(found: Reference | Motion) -> Iterable[Block]:
    """Return a title with the dataset and a table with a row for each of its maneuvers."""
    rows = [
        (
            str(n), m.name, _decimal(m.inputs["speed"]), _decimal(m.inputs["roll_rate"]),
            plain(float(m.duration)), str(len(m.time)), str(len(m.columns)),
        )
        for n, m in found.items()
    ]  # fmt: skip
    facts = f"content sha256 {found.content_sha256}; {found.folder}"
    title = "Whole motion"
    if isinstance(found, Reference):
        title = f"Reference {found.dataset_version} of {found.bicycle}"
    return *head(title, facts), TableBlock(_OF_MANEUVERS, rows, "Maneuvers")


def _decimal(exact: str) -> str:
    return plain(float(Fraction(exact)))


def reference_maneuver(m: ReferenceManeuver) -> Iterable[Block]:
    """Return a maneuver's initial conditions, first and last rows, and folded list of columns."""
    facts = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in m.inputs.items())
    rows = Values(
        {name: m.rows[name] for name in m.columns[:_COLUMNS_AMONG_OTHERS]}, {}, time=m.time
    )
    columns = [(c, unit_text(m.units.get(c, "")), number(m.scale(c), 4)) for c in m.columns]
    listed = TableBlock(("column", "unit", "largest value"), columns, "Columns")
    return (
        *head(m.name, facts),
        table(rows, _COLUMNS_AMONG_OTHERS, "Rows"),
        Chapter(f"Columns ({len(columns)})", (listed,), is_folded=True),
    )


def trajectory(run: Trajectory) -> Iterable[Block]:
    """Return a title that describes the run, and a table of states at evenly spaced times."""
    end = min(run.maneuver.duration, run.breaks[-1])
    times = [end * Fraction(i, _TIMES_SHOWN - 1) for i in range(_TIMES_SHOWN)]
    rows = [(plain(float(t)), *(f"{float(x.mid()):.10g}" for x in run.state(t))) for t in times]
    return *head(*run.words), TableBlock(("time [s]", *run.states), rows, "States", "numbers")


def values(found: Values) -> Iterable[Block]:
    """Return the values of columns as a table with a row for each time.

    With a single time, each column is a row with all digits.
    """
    shown = table(found, _MOST_COLUMNS)
    return (shown,) if shown.rows else head(_in_a_word(found))


def _values_text(found: Values) -> str:
    """Return the table with as many columns as fit, or their number if there are no times."""
    shown = ""
    for most in range(_MOST_COLUMNS, 0, -1):
        shown = as_text.render([table(found, most)], WIDTH)
        if max(map(len, shown.splitlines()), default=0) <= WIDTH:
            break
    return shown.rstrip("\n") or _in_a_word(found)


def table(found: Values, most: int, about: str = "Values") -> TableBlock:
    """Return a table of the first `most` columns of the values; empty if there are no times."""
    if found.time is None or any(x.shape != found.time.shape for x in found.hi.values()):
        return TableBlock((), (), about)
    if not found.time.shape:
        return _at_one_time(found)
    time, shown = found.time.ravel(), list(found)[:most]
    columns = [time, *(found[name].ravel() for name in shown)]
    said = []
    half = _MOST_ROWS_SHOWN // 2
    is_cut = len(time) > _MOST_ROWS_SHOWN
    if is_cut:
        said.append(counted(len(time), "row"))
        columns = [np.concatenate([x[:half], x[-half:]]) for x in columns]
    rows = [[f"{x:.{_DIGITS_SHOWN}g}" for x in row] for row in zip(*columns, strict=True)]
    if is_cut:
        rows.insert(half, ["..."] * len(columns))
    if len(found) > len(shown):
        said.append(counted(len(found) - len(shown), "more column"))
    names = ["time [s]", *map(_heading, shown)]
    return TableBlock(names, rows, about, "numbers", note=", ".join(said))


def _at_one_time(found: Values) -> TableBlock:
    lo = {name: float(found.lo.get(name, 0.0)) for name in found}
    rows = [[_heading(name), repr(float(x)), repr(lo[name])] for name, x in found.items()]
    names = (f"at {float(found.time or 0.0)!r} s", "value", "+ the rest")
    return TableBlock(names, rows, "Values", "numbers")


def _heading(name: str) -> str:
    return f"{name} [{unit_text(_UNIT_OF_COLUMN[name])}]" if name in _UNIT_OF_COLUMN else name


def _in_a_word(found: Values) -> str:
    return f"<values of {counted(len(found), 'column')}>"
