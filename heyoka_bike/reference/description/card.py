"""README.md of the published set: its card, for who finds the folder and nothing else."""

from collections.abc import Sequence
from importlib.resources import files
from string import Template

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.reference.description import facts
from heyoka_bike.reference.manifest import DATASET_DATE


def render_card(version: str, content_sha256: str, columns: Sequence[Column]) -> bytes:
    """Bytes of the card of a published set."""
    template = Template((files(__package__) / "card.md").read_text(encoding="utf-8"))
    filled = template.substitute(
        title=facts.TITLE,
        summary=facts.SUMMARY,
        version=version,
        date=DATASET_DATE,
        year=DATASET_DATE[:4],
        content=content_sha256,
        creator=facts.CREATOR,
        copyright=facts.COPYRIGHT,
        licence=facts.LICENCE,
        benchmark=facts.BENCHMARK,
        files=_files(),
        columns=_columns(columns),
        papers=_papers(),
    )
    return filled.encode()


def _files() -> str:
    return "\n".join(f"| `{name}` | {about.summary} |" for name, about in facts.FILES.items())


def _columns(columns: Sequence[Column]) -> str:
    lines = []
    for c in columns:
        place = f"{BENCHMARK_COLUMNS.index(c.name) + 1}" if c.name in BENCHMARK_COLUMNS else ""
        positive = f"; positive {c.positive}" if c.positive else ""
        lines.append(f"| {place} | `{c.name}` | {c.unit} | {c.long_name}: {c.meaning}{positive} |")
    return "\n".join(lines)


def _papers() -> str:
    return "\n".join(
        f"- {authors}: {title} ({year}). <{address}>"
        for address, (authors, title, year) in facts.PAPERS.items()
    )
