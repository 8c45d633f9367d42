"""Columns at some times, as a table; at one time a column is a row, with all its digits."""

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.reference.values import Values
from heyoka_bike.showing.document import Block, TableBlock
from heyoka_bike.showing.document import text as as_text
from heyoka_bike.showing.document.notebook import head
from heyoka_bike.showing.formats.output import WIDTH
from heyoka_bike.showing.wording import unit_text

_MOST_ROWS = 10
_MOST_COLUMNS = 9
_SHOWN = 10  # significant digits of a value among others
_UNITS = {c.name: c.unit for columns in COMPARED.values() for c in columns}


def text(values: Values) -> str:
    """The table as lines; a word where there are no times to show it by."""
    for most in range(_MOST_COLUMNS, 0, -1):
        found = as_text.render([table(values, most)], WIDTH)
        if max(map(len, found.splitlines()), default=0) <= WIDTH:
            break
    return found.rstrip("\n") or _in_a_word(values)


def blocks(values: Values) -> tuple[Block, ...]:
    """The table."""
    shown = table(values, _MOST_COLUMNS)
    return (shown,) if shown.rows else head(_in_a_word(values))


def table(values: Values, most: int, about: str = "Values") -> TableBlock:
    """At most so many columns of the values; nothing without their times."""
    if values.time is None or any(x.shape != values.time.shape for x in values.hi.values()):
        return TableBlock((), (), about)
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
    names = ["time [s]", *map(_heading, shown)]
    return TableBlock(names, lines, about, "numbers", note=", ".join(said))


def _at_one_time(values: Values) -> TableBlock:
    lo = {name: float(values.lo.get(name, 0.0)) for name in values}
    rows = [[_heading(name), repr(float(x)), repr(lo[name])] for name, x in values.items()]
    names = (f"at {float(values.time or 0.0)!r} s", "value", "+ the rest")
    return TableBlock(names, rows, "Values", "numbers")


def _heading(name: str) -> str:
    return f"{name} [{unit_text(_UNITS[name])}]" if name in _UNITS else name


def _in_a_word(values: Values) -> str:
    return f"<values of {len(values)} columns>"
