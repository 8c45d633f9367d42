"""The files of the published set that say what it is."""

from heyoka_bike.reference.description.card import render_card
from heyoka_bike.reference.description.crate import render_crate
from heyoka_bike.reference.layout import CARD, CRATE
from heyoka_bike.reference.manifest import CUSTOM, Manifest


def describe(manifest: Manifest) -> dict[str, bytes]:
    """Card and RO-Crate of a set, by file name; none of one's own, whose maker is not known."""
    if manifest.dataset_version == CUSTOM:
        return {}
    card = render_card(manifest.dataset_version, manifest.content_sha256)
    return {CARD: card, CRATE: render_crate(manifest)}
