"""The table of docs/reference/columns.md, from `heyoka_bike.bicycle.columns`.

Run as a script, this writes it.
"""

from __future__ import annotations

from pathlib import Path

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import COLUMNS, FOLLOWING
from marked_parts import filled

PAGE = Path(__file__).parent.parent / "reference" / "columns.md"


def _line(column: Column) -> str:
    definition = f"`{column.definition}`{' (default)' if column.default else ''}"
    meaning = column.meaning + (f"; positive {column.positive}" if column.positive else "")
    return f"| `{column.name}` | {column.unit} | {column.long_name} | {definition} | {meaning} |"


def table() -> str:
    """The table in Markdown."""
    head = ["| dataset | unit | what | definition | meaning |", "|---|---|---|---|---|"]
    return "\n".join([*head, *map(_line, (*COLUMNS, *FOLLOWING))])


def page(text: str) -> str:
    """The page with its table made anew."""
    return filled(text, "columns", table())


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
