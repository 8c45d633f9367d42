"""A reference set, or the whole motion of one: its maneuvers."""

from fractions import Fraction

from heyoka_bike.reference.load import Motion, Reference
from heyoka_bike.showing.document import Block, TableBlock
from heyoka_bike.showing.document.notebook import head
from heyoka_bike.showing.wording import plain

_NAMES = ("maneuver", "name", "speed [m/s]", "roll rate [rad/s]", "ends at [s]", "rows", "columns")


def blocks(found: Reference | Motion) -> tuple[Block, ...]:
    """What it is, and a row for each maneuver."""
    rows = [
        (
            str(number), m.name, _decimal(m.inputs["speed"]), _decimal(m.inputs["roll_rate"]),
            plain(float(m.duration)), str(len(m.time)), str(len(m.columns)),
        )
        for number, m in found.items()
    ]  # fmt: skip
    facts = f"content sha256 {found.content_sha256}; {found.folder}"
    title = "Whole motion"
    if isinstance(found, Reference):
        title = f"Reference {found.dataset_version} of {found.bicycle}"
    return *head(title, facts), TableBlock(_NAMES, rows, "Maneuvers")


def _decimal(exact: str) -> str:
    return plain(float(Fraction(exact)))
