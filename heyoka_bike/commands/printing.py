"""Print the output of commands: blocks, tables of checks, JSON, and lines about failures."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from heyoka_bike.system.log import complain

if TYPE_CHECKING:
    from heyoka_bike.reference.verification.outcome import Check
    from heyoka_bike.showing.document import Block, Cell, TableColumn

_WIDTH_OF_FILES = 120  # width of a table of checks in a file or a pipe [characters]
_RESULT_OF_CHECK = {
    True: ("ok", "passed"),
    False: ("FAILED", "failed"),
    None: ("not made", "unmade"),
}


def print_text(text: str) -> None:
    """Print text; letters that standard output cannot encode become question marks."""
    try:
        print(text, end="" if text.endswith("\n") else "\n")
    except UnicodeEncodeError:
        encoding = sys.stdout.encoding or "ascii"
        print(text.encode(encoding, "replace").decode(encoding))


def print_blocks(*blocks: Block, width: int | None = None) -> None:
    """Print blocks with the width of the terminal, or with `width` to a file or a pipe."""
    from heyoka_bike.showing.document.text import render
    from heyoka_bike.system.console import has_colors

    is_terminal = sys.stdout.isatty()
    print_text(render(blocks, None if is_terminal else width, has_colors(is_terminal)))


def print_table(
    columns: Sequence[str | TableColumn], rows: Sequence[Sequence[str | Cell]], *,
    title: str = "", left: int = 1, group: int = 0, width: int | None = None,
) -> None:  # fmt: skip
    """Print one table; see `TableBlock` and `print_blocks`."""
    from heyoka_bike.showing.document import Chapter, TableBlock

    table = TableBlock(columns, rows, left=left, group=group)
    print_blocks(Chapter(title, (table,)) if title else table, width=width)


def print_json(document: Mapping[str, object]) -> None:
    """Print one JSON document; a command prints nothing else on standard output."""
    import json

    print(json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False))


def print_checks(title: str, checks: Sequence[Check]) -> None:
    """Print a line for each check: name, file, result, number of values, measured sizes."""
    from heyoka_bike.showing.document import Cell, TableColumn

    said = TableColumn("what was measured", is_prose=True)
    rows = []
    for c in checks:
        text, style = _RESULT_OF_CHECK[c.passed]
        result = Cell(text, style=style)
        rows.append((c.check, c.file, result, str(c.evidence["values"]), c.message))
    print_table(
        ("check", "file", "result", "values", said),
        rows,
        title=title,
        left=3,
        width=_WIDTH_OF_FILES,
    )


def complain_of_checks(place: str, checks: Sequence[Check]) -> None:
    """Print a line on standard error for each failed check: the file and the difference."""
    for c in checks:
        if c.passed is False:
            where = f"{place}/{c.file}" if c.file else place
            complain(f"{where}: {c.check}: {c.message.removeprefix(f'{where}: ')}")
