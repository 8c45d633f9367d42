"""What every task needs, loaded once: the processes of tasks are forked from one that has it.

Where processes are not forked, each of them imports this itself.
"""

# What reads result files and writes reports, most of which is else imported when it is needed.
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.reading import (  # noqa: F401
    array_files,
    json_files,
    matlab_files,
    table_files,
    text_table,
)
from heyoka_bike.showing.document import html  # noqa: F401
from heyoka_bike.showing.formats import csv, json, junit, report, series  # noqa: F401

REFERENCE = load_reference()
"""The published set."""
