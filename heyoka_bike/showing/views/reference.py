"""A reference set, or the whole motion of one: its maneuvers."""

from fractions import Fraction

from heyoka_bike.reference.load import Motion, Reference
from heyoka_bike.showing.formats.wording import plain
from heyoka_bike.showing.views.card import card, head, plain_table

_NAMES = ("maneuver", "name", "speed [m/s]", "roll rate [rad/s]", "ends at [s]", "rows", "columns")


def html(found: Reference | Motion) -> str:
    """What it is, and a row for each maneuver."""
    rows = [
        (
            str(number), m.name, _decimal(m.inputs["speed"]), _decimal(m.inputs["roll_rate"]),
            plain(float(m.duration)), str(len(m.time)), str(len(m.columns)),
        )
        for number, m in found.items()
    ]  # fmt: skip
    facts = f"content sha256 {found.content_sha256}; {found.folder}"
    if isinstance(found, Reference):
        title = f"Reference {found.dataset_version} of {found.bicycle}"
    else:
        title = "Whole motion"
    return card(head(title, facts), plain_table(_NAMES, rows, "Maneuvers"))


def _decimal(exact: str) -> str:
    return plain(float(Fraction(exact)))
