"""The result of checking single states: as text, and as JSON (see `check-1.schema.json`)."""

from __future__ import annotations

from dataclasses import asdict
from difflib import get_close_matches
from typing import Any

from heyoka_bike.bicycle.instant_columns import UNITS
from heyoka_bike.errors import quoted, shortened
from heyoka_bike.scoring.evidence.words import counted
from heyoka_bike.scoring.instants.checked import CheckedColumn, CheckedLevel, CheckedTable
from heyoka_bike.showing.document import Block, Cell, Item, Listing, Paragraph, TableBlock
from heyoka_bike.showing.formats.json import clean
from heyoka_bike.version import __version__

SCHEMA_VERSION = 1
_RESULT_OF_LEVEL = {
    True: ("right", "passed"),
    False: ("WRONG", "failed"),
    None: ("missing", "unmade"),
}
_COLUMNS_SHOWN = 6  # maximum number of columns listed for the level that fails


def document(check: CheckedTable) -> dict[str, Any]:
    """Return the result of a check as JSON values; None replaces NaN and infinity."""
    failed = check.failed
    return {
        "schema_version": SCHEMA_VERSION,
        "version": __version__,
        "bicycle": check.bicycle,
        "file": {"path": check.path, "rows": check.states},
        "own_states": check.is_own,
        "tolerance": check.tolerance,
        "levels": [
            {
                "level": x.level.name,
                "passed": x.passed,
                "parameters": list(x.level.parameters),
                "besides": x.level.besides,
                "columns": [clean(asdict(c)) for c in x.columns],
            }
            for x in check.levels
        ],
        "failed": failed.level.name if failed else None,
        "explained_by": [clean(asdict(x)) for x in check.explained],
        "left_out": [shortened(name) for name in check.left_out],
        "passed": check.passed,
    }


def blocks(check: CheckedTable) -> list[Block]:
    """Return the result of a check as blocks: a row per level, then the first failed level."""
    whose = "of its own" if check.is_own else "known by number"
    states = f"{check.states} state{'s' * (check.states != 1)} {whose}"
    found: list[Block] = [
        Paragraph(
            f"{check.path}: {states}, {check.bicycle}; a value is right "
            f"if its error is at most {check.tolerance:g} (1 + |value|) in SI units, plus rounding "
            "to the digits written"
        ),
        TableBlock(
            ("level", "result", "columns", "values", "wrong", "largest error"),
            [_row(check, x) for x in check.levels],
            left=2,
        ),
    ]
    if failed := check.failed:
        found += _about(check, failed)
    elif missing := [x.level.name for x in check.levels if x.passed is None]:
        found.append(Paragraph(f"All levels in the file are right; missing: {', '.join(missing)}."))
    else:
        found.append(
            Paragraph(
                "All levels are right. Next: simulate one step, then one second, then ten seconds, "
                "and run score."
            )
        )
    if check.left_out:
        names = ", ".join(map(_unknown, check.left_out[:_COLUMNS_SHOWN]))
        more = len(check.left_out) - _COLUMNS_SHOWN
        found.append(Paragraph(f"Unknown columns: {names}{f' and {more} more' * (more > 0)}."))
    return found


def line(check: CheckedTable) -> str:
    """Describe the first level that fails in one line; empty if none fails."""
    failed = check.failed
    if failed is None:
        return ""
    return f"{check.path}: {failed.level.name}: {_worst(failed.columns[0])}"


def _row(check: CheckedTable, x: CheckedLevel) -> list[str | Cell]:
    text, style = _RESULT_OF_LEVEL[x.passed]
    if x.passed is False and x is not check.failed:
        text = "also wrong"
    values = sum(c.values for c in x.columns)
    wrong = sum(c.wrong for c in x.columns)
    error = f"{max(c.max_error for c in x.columns):.1e}" if x.columns else ""
    return [x.level.name, Cell(text, style=style), str(len(x.columns)), str(values), str(wrong),
            error]  # fmt: skip


def _about(check: CheckedTable, failed: CheckedLevel) -> list[Block]:
    wrong = [c for c in failed.columns if c.wrong]
    right = [c.key for c in failed.columns if not c.wrong]
    items = [Item(_worst(c)) for c in wrong[:_COLUMNS_SHOWN]]
    if len(wrong) > _COLUMNS_SHOWN:
        items.append(Item(f"and {counted(len(wrong) - _COLUMNS_SHOWN, 'more column')}"))
    enters = " ".join(failed.level.parameters) or "no parameter"
    said = f"New at this level: {enters}, and {failed.level.besides}."
    if right:
        said += f" Right at this level: {', '.join(right[:_COLUMNS_SHOWN])}."
    before = check.levels[: check.levels.index(failed)]
    missing = [x.level.name for x in before if x.passed is None]
    if missing:
        said += f" Earlier levels that the file does not contain: {', '.join(missing)}."
    explained = (
        Paragraph(
            f"If {x.symbol} were {_short(x.value)} {x.unit} instead of {_short(x.right)}, all "
            "values up to this level would be right."
        )
        for x in check.explained
    )
    return [
        Paragraph(f"The first wrong level is {failed.level.name}:"),
        Listing(tuple(items)),
        Paragraph(said),
        *explained,
    ]


def _worst(c: CheckedColumn) -> str:
    where = c.place if c.state is None else f"state {c.state} ({c.place})"
    off = c.found - c.expected
    return (
        f"{c.key}: {c.wrong} of {c.values} values wrong, the worst in {where}: "
        f"found {c.found:.12g} {c.unit}, expected {c.expected:.12g}, off by {off:.3g}"
    )


def _short(x: float) -> str:
    """Format a fitted value to six digits; values near zero become 0."""
    return f"{x:.6g}" if abs(x) > 1e-6 else "0"


def _unknown(name: str) -> str:
    """Quote an unknown name, with the most similar known name."""
    like = get_close_matches(name.partition("[")[0].strip(), UNITS, 1)
    return f"{quoted(name)} ({like[0]}?)" if like else quoted(name)
