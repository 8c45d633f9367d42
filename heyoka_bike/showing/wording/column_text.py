"""Names of columns and maneuvers, and notes on how a column was interpreted."""

from collections.abc import Sequence

from heyoka_bike.errors import printable
from heyoka_bike.scoring.evidence.words import either, unit_text
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.showing.wording.number_text import plain


def label(key: str) -> str:
    """Return the key of a column in words."""
    return printable(key.replace("_", " "))


def heading(m: ManeuverScore) -> str:
    """Return the number of a maneuver, and its name if the name adds something."""
    numbered = f"maneuver {m.maneuver}"
    return numbered if m.name == numbered else f"{numbered}, {printable(m.name)}"


def is_default(column: ColumnScore) -> bool:
    """True if a column is interpreted with the default definition."""
    return column.as_understood.definition == column.as_written.definition


def mark(column: ColumnScore) -> str:
    """Return ``*`` for a column whose definition is not the default, ``~`` if others also fit."""
    return ("" if is_default(column) else "*") + ("~" if column.indistinguishable else "")


def mark_meanings(columns: Sequence[ColumnScore]) -> list[str]:
    """Return the meanings of the marks ``*`` and ``~`` that any of the columns has."""
    found = []
    if not all(map(is_default, columns)):
        found.append("* is not the default definition")
    if open_ones := [c for c in columns if c.indistinguishable]:
        others = (
            f"{either([*map(printable, c.indistinguishable)])} of {label(c.key)}" for c in open_ones
        )
        found.append(f"~ others fit as well: {', '.join(others)}")
    return found


def notes(column: ColumnScore) -> tuple[str, ...]:
    """Return sign, unit and offset of a column, each only if it differs from the default."""
    r = column.as_understood
    found = []
    if not column.is_known:
        found.append("definition unknown")
    if r.sign != column.as_written.sign:
        found.append(f"sign {r.sign}")
    if r.unit != column.as_written.unit:
        found.append(unit_text(r.unit))
    if r.offset != column.as_written.offset:
        found.append(f"offset {plain(r.offset, 5)}")
    return tuple(found)


def first_above(column: ColumnScore) -> str:
    """Return the first time when the error exceeds the tolerance [s]; else ``never`` or ``-``."""
    m = column.as_understood.measures
    if m.max_abs_error is None:
        return "-"
    return "never" if m.time_to_tolerance is None else plain(m.time_to_tolerance)
