"""Columns at some times, as a table; at one time a column is a row, with all its digits."""

from collections.abc import Sequence

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.reference.values import Values
from heyoka_bike.showing.formats.output import WIDTH
from heyoka_bike.showing.formats.text_page import TextPage, text_table
from heyoka_bike.showing.formats.wording import unit_text
from heyoka_bike.showing.views.card import card, head, plain_table, remark

_MOST_ROWS = 10
_MOST_COLUMNS = 9
_SHOWN = 10  # significant digits of a value among others
_UNITS = {c.name: c.unit for columns in COMPARED.values() for c in columns}

Table = tuple[Sequence[str], Sequence[Sequence[str]], str]
"""Headings, rows, and a word on what is not shown."""


def text(values: Values) -> str:
    """The table as lines; a word where there are no times to show it by."""
    page = TextPage(WIDTH, color=False)
    for most in range(_MOST_COLUMNS, 0, -1):
        names, rows, said = table(values, most)
        if not rows:
            return _in_a_word(values)
        view = text_table(names, rows, left=1)
        if page.fits(view):
            break
    page.show(view)
    if said:
        page.say(said)
    return page.text().rstrip("\n")


def html(values: Values) -> str:
    """The table."""
    names, rows, said = table(values, _MOST_COLUMNS)
    if not rows:
        return card(head(_in_a_word(values)))
    return card(plain_table(names, rows, "Values", "numbers"), remark(said))


def table(values: Values, most: int) -> Table:
    """At most so many columns of the values; nothing without their times."""
    if values.time is None or any(x.shape != values.time.shape for x in values.hi.values()):
        return (), (), ""
    if not values.time.shape:
        return _at_one_time(values)
    shown = list(values)[:most]
    time = values.time.ravel()
    rows = np.arange(len(time))
    cut = len(rows) > _MOST_ROWS
    if cut:
        half = _MOST_ROWS // 2
        rows = np.concatenate([rows[:half], rows[-half:]])
    columns = [values[name].ravel() for name in shown]
    lines = [[f"{time[i]:.{_SHOWN}g}", *(f"{x[i]:.{_SHOWN}g}" for x in columns)] for i in rows]
    if cut:
        lines.insert(_MOST_ROWS // 2, ["..."] * (1 + len(shown)))
    left_out = len(values) - len(shown)
    said = [f"{len(time)} rows"] if cut else []
    said += [f"{left_out} more columns"] if left_out else []
    return ["time [s]", *map(_heading, shown)], lines, ", ".join(said)


def _at_one_time(values: Values) -> Table:
    lo = {name: float(values.lo.get(name, 0.0)) for name in values}
    rows = [[_heading(name), repr(float(x)), repr(lo[name])] for name, x in values.items()]
    return [f"at {float(values.time or 0.0)!r} s", "value", "+ the rest"], rows, ""


def _heading(name: str) -> str:
    return f"{name} [{unit_text(_UNITS[name])}]" if name in _UNITS else name


def _in_a_word(values: Values) -> str:
    return f"<values of {len(values)} columns>"
