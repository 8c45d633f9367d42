"""The files of the published set that say what it is: its card, and an RO-Crate."""

from collections.abc import Iterator, Sequence
from importlib.resources import files
from string import Template

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS, Column
from heyoka_bike.reference.description import facts
from heyoka_bike.reference.description.crate import render_crate
from heyoka_bike.reference.layout import CARD, CRATE
from heyoka_bike.reference.manifest import CUSTOM, DATASET_DATE, Manifest


def describe(manifest: Manifest, columns: Sequence[Column] = COLUMNS) -> dict[str, bytes]:
    """Card and RO-Crate of a set, by file name; none of one's own, whose maker is not known.

    `columns` are those that it has, by default all.
    """
    if manifest.dataset_version == CUSTOM:
        return {}
    return {CARD: _card(manifest, columns), CRATE: render_crate(manifest)}


def _card(manifest: Manifest, columns: Sequence[Column]) -> bytes:
    """README.md: the card of a published set, for who finds the folder and nothing else."""
    template = Template((files(__package__) / "card.md").read_text(encoding="utf-8"))
    filled = template.substitute(
        title=facts.TITLE,
        summary=facts.SUMMARY,
        version=manifest.dataset_version,
        date=DATASET_DATE,
        year=DATASET_DATE[:4],
        content=manifest.content_sha256,
        creator=facts.CREATOR,
        copyright=facts.COPYRIGHT,
        licence=facts.LICENCE,
        benchmark=facts.BENCHMARK,
        files="\n".join(f"| `{name}` | {of.summary} |" for name, of in facts.FILES.items()),
        columns="\n".join(_columns(columns)),
        papers="\n".join(
            f"- {authors}: {title} ({year}). <{address}>"
            for address, (authors, title, year) in facts.PAPERS.items()
        ),
    )
    return filled.encode()


def _columns(columns: Sequence[Column]) -> Iterator[str]:
    for c in columns:
        place = f"{BENCHMARK_COLUMNS.index(c.name) + 1}" if c.name in BENCHMARK_COLUMNS else ""
        positive = f"; positive {c.positive}" if c.positive else ""
        yield f"| {place} | `{c.name}` | {c.unit} | {c.long_name}: {c.meaning}{positive} |"
