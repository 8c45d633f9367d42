"""What a table of single instants says of its program."""

from heyoka_bike.scoring.instants.checked import CheckedTable
from heyoka_bike.showing.document import text as as_text
from heyoka_bike.showing.formats.check import blocks as blocks
from heyoka_bike.showing.formats.output import WIDTH


def text(check: CheckedTable) -> str:
    """As ``heyoka-bike check`` prints it."""
    return as_text.render(blocks(check), WIDTH).strip("\n")
