"""Imports of every task, loaded once: the processes of tasks are forked from one that has them.

Where processes are not forked, each of them imports this itself.
"""

# Readers of result files and writers of reports, which are otherwise imported when needed.
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.reading.formats import FORMATS
from heyoka_bike.showing.document import html  # noqa: F401
from heyoka_bike.showing.formats import csv, json, junit, report  # noqa: F401

for _format in FORMATS:
    _format.reader()
REFERENCE = load_reference()
"""The published set."""
