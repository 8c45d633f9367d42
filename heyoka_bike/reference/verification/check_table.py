"""Checks as a table for people, and the failed ones as lines on standard error."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from heyoka_bike.reference.verification.checks import Check

_RESULT = {True: ("ok", "green"), False: ("FAILED", "bold red"), None: ("not made", "yellow")}
_WIDTH = 120  # of a table that goes to a file or a pipe; a narrower terminal wraps it


def print_checks(title: str, checks: Sequence[Check]) -> None:
    """A line for each check: name, file, result, how many values, what was measured."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    view = Table(title=Text(title))
    for heading in ("check", "file", "result"):
        view.add_column(heading, no_wrap=True)
    view.add_column("values", justify="right", no_wrap=True)
    view.add_column("what was measured", overflow="fold")
    for c in checks:
        word, style = _RESULT[c.passed]
        view.add_row(
            c.check, Text(c.file), Text(word, style), str(c.evidence["values"]), Text(c.message)
        )
    console = Console()
    console.width = max(console.width, _WIDTH)
    console.print(view)


def complain(place: str, checks: Sequence[Check]) -> None:
    """A line on standard error for each failed check, naming the file and what differs."""
    for c in checks:
        if c.passed is False:
            where = f"{place}/{c.file}" if c.file else place
            message = c.message.removeprefix(f"{where}: ")
            line = f"heyoka-bike: {where}: {c.check}: {message}"
            print(" ".join(line.split()), file=sys.stderr)
