"""The files of the published set that say what it is."""

from collections.abc import Sequence

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.reference.description.card import render_card
from heyoka_bike.reference.description.crate import render_crate
from heyoka_bike.reference.layout import CARD, CRATE
from heyoka_bike.reference.manifest import CUSTOM, Manifest


def describe(manifest: Manifest, columns: Sequence[Column] = COLUMNS) -> dict[str, bytes]:
    """Card and RO-Crate of a set, by file name; none of one's own, whose maker is not known.

    `columns` are those that it has, by default all.
    """
    if manifest.dataset_version == CUSTOM:
        return {}
    card = render_card(manifest.dataset_version, manifest.content_sha256, columns)
    return {CARD: card, CRATE: render_crate(manifest)}
