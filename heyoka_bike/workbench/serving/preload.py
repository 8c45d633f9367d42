"""Import what every task needs, once, so that forked task processes share it.

If processes are not forked, each one imports this module itself.
"""

# Readers of result files and writers of reports are otherwise imported at their first use, in each
# process.
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.reading.formats import FORMATS
from heyoka_bike.showing.document import html  # noqa: F401
from heyoka_bike.showing.formats import csv, json, junit, report_document  # noqa: F401

for _format in FORMATS:
    _format.reader()
REFERENCE = load_reference()
"""The published dataset."""
