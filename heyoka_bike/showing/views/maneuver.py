"""What a report says of one maneuver: its table, and its errors over time."""

from heyoka_bike.scoring.report import ManeuverScore
from heyoka_bike.showing.document import Block, Paragraph
from heyoka_bike.showing.document import text as as_text
from heyoka_bike.showing.formats.output import WIDTH
from heyoka_bike.showing.formats.report import maneuver


def text(m: ManeuverScore) -> str:
    """Its table."""
    return as_text.render([maneuver(m, is_within=True)], WIDTH).strip("\n")


def blocks(m: ManeuverScore) -> tuple[Block, ...]:
    """Its table and its errors."""
    shown = maneuver(m, is_within=True)
    return (Paragraph(str(shown.title), "head"), *shown.blocks)
