"""Checks as a table for people, and the failed ones as lines on standard error."""

import sys
from collections.abc import Sequence

from heyoka_bike.reference.verification.checks import Check
from heyoka_bike.system.console import print_table, table

_RESULT = {True: ("ok", "green"), False: ("FAILED", "bold red"), None: ("not made", "yellow")}

_WIDTH = 120  # of a table that goes to a file or a pipe; a narrower terminal wraps it


def print_checks(title: str, checks: Sequence[Check]) -> None:
    """A line for each check: name, file, result, how many values, what was measured."""
    from rich.text import Text

    headings = ("check", "file", "result", "values", "what was measured")
    rows = [
        (c.check, c.file, Text(*_RESULT[c.passed]), str(c.evidence["values"]), c.message)
        for c in checks
    ]
    print_table(table(headings, rows, title=Text(title), left=3, prose=(4,)), _WIDTH)


def complain(place: str, checks: Sequence[Check]) -> None:
    """A line on standard error for each failed check, naming the file and what differs."""
    for c in checks:
        if c.passed is False:
            where = f"{place}/{c.file}" if c.file else place
            message = c.message.removeprefix(f"{where}: ")
            line = f"heyoka-bike: {where}: {c.check}: {message}"
            print(" ".join(line.split()), file=sys.stderr)
