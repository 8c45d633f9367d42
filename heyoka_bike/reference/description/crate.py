"""ro-crate-metadata.json: what the manifest says, in the words of RO-Crate 1.1 and schema.org.

See https://w3id.org/ro/crate/1.1. Nothing in it is new: facts and manifest, and which software made
which files of which inputs.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.reference.description import facts
from heyoka_bike.reference.layout import CARD, CRATE
from heyoka_bike.reference.manifest import DATASET_DATE, MANIFEST, Manifest

_PROFILE = "https://w3id.org/ro/crate/1.1"
_MORE_TERMS = {name: f"http://schema.org/{name}" for name in ("sha256", "unitText")}

Entity = dict[str, Any]


def render_crate(manifest: Manifest) -> bytes:
    """Bytes of the crate of a published set.

    It names sizes and hashes of the files that hold something, not of those that describe them.
    """
    context = [f"{_PROFILE}/context", _MORE_TERMS]
    document = {"@context": context, "@graph": list(_entities(manifest))}
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def _entities(manifest: Manifest) -> Iterator[Entity]:
    held = [name for name in manifest.files if name not in (CARD, CRATE)]
    parts = [*held, MANIFEST, CARD]
    measured = [c for c in COLUMNS if c.name in BENCHMARK_COLUMNS]
    version = manifest.dataset_version
    yield {
        "@id": CRATE,
        "@type": "CreativeWork",
        "conformsTo": _at(_PROFILE),
        "about": _at("./"),
    }
    yield {
        "@id": "./",
        "@type": "Dataset",
        "name": facts.TITLE,
        "description": facts.SUMMARY,
        "version": version,
        "datePublished": DATASET_DATE,
        "identifier": f"heyoka_bike/{version}, content_sha256 {manifest.content_sha256}",
        "license": _at(facts.LICENCE),
        "author": _at("#developers"),
        "publisher": _at("#developers"),
        "keywords": ", ".join(facts.KEYWORDS),
        "isBasedOn": _at(facts.BENCHMARK),
        "citation": _all(facts.PAPERS),
        "variableMeasured": _all(f"#{c.name}" for c in measured),
        "hasPart": _all(parts),
        "mentions": _at("#generate"),
    }
    for name in parts:
        yield _file(name, manifest)
    yield {
        "@id": "#generate",
        "@type": "CreateAction",
        "name": "heyoka-bike generate",
        "description": f"integrated with {manifest.made_by['digits']} digits, then proved",
        "instrument": _all(f"#{name}" for name in manifest.made_by["packages"]),
        "result": _all(held),
    }
    for name, found in manifest.made_by["packages"].items():
        yield {"@id": f"#{name}", "@type": "SoftwareApplication", "name": name, "version": found}
    for column in measured:
        yield {
            "@id": f"#{column.name}",
            "@type": "PropertyValue",
            "name": column.name,
            "description": f"{column.long_name}: {column.meaning}",
            "unitText": column.unit,
        }
    yield {"@id": "#developers", "@type": "Organization", "name": facts.CREATOR}
    yield {
        "@id": facts.LICENCE,
        "@type": "CreativeWork",
        "name": "MIT License",
        "description": facts.COPYRIGHT,
    }
    for address, (authors, title, year) in facts.PAPERS.items():
        yield {
            "@id": address,
            "@type": "ScholarlyArticle",
            "name": f"{authors}: {title}",
            "datePublished": str(year),
        }
    yield {"@id": facts.BENCHMARK, "@type": "CreativeWork", "name": "Uncontrolled bicycle"}


def _file(name: str, manifest: Manifest) -> Entity:
    about = facts.FILES[name]
    entity: Entity = {
        "@id": name,
        "@type": "File",
        "name": about.title,
        "description": about.summary,
        "encodingFormat": about.media_type,
    }
    if name != CARD and name in manifest.files:
        size, digest = manifest.files[name]
        entity |= {"contentSize": str(size), "sha256": digest}
    return entity


def _at(address: str) -> Mapping[str, str]:
    return {"@id": address}


def _all(addresses: Iterable[str]) -> list[Mapping[str, str]]:
    return [_at(address) for address in addresses]
