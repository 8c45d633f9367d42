"""Metadata of the published dataset: title, creator, licence, sources, content of each file.

The metadata is defined here once, and repeated by the attributes of the HDF5 files (named as in
ACDD-1.3 and CF), the card and the RO-Crate. The card is README.md, for people.
ro-crate-metadata.json repeats the manifest and states which software made which files from which
inputs, in the terms of RO-Crate 1.1 and schema.org: https://w3id.org/ro/crate/1.1.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from string import Template
from typing import Any

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.reference import layout
from heyoka_bike.reference.layout import CARD, CRATE, as_json
from heyoka_bike.reference.manifest import CUSTOM, DATASET_DATE, MANIFEST, Manifest
from heyoka_bike.reference.structure import UNKNOWNS

TITLE = 'Reference solutions of the IFToMM multibody benchmark "Uncontrolled bicycle"'
CREATOR = "The heyoka_bike developers"
LICENCE = "https://spdx.org/licenses/MIT"
COPYRIGHT = f"MIT, Copyright (c) 2026 {CREATOR}"
SUMMARY = (
    "Three motions of the uncontrolled Carvallo-Whipple bicycle, ten seconds each: its exact "
    "nonlinear equations integrated with 70 digits, every published number proved, with a bound."
)
KEYWORDS = (
    "multibody dynamics", "bicycle", "benchmark", "reference solution", "Carvallo-Whipple model",
    "Taylor method", "ball arithmetic",
)  # fmt: skip
BENCHMARK = "https://www.iftomm-multibody.org/benchmark/problem/Uncontrolled_bicycle/"
CONVENTIONS = "CF-1.8, ACDD-1.3"
"""Conventions of files whose columns all have units of CF."""

Papers = Mapping[str, tuple[str, str, int]]

PAPERS: Papers = {
    "https://doi.org/10.1098/rspa.2007.1857": (
        "Meijaard, Papadopoulos, Ruina, Schwab",
        "Linearized dynamics equations for the balance and steer of a bicycle: a benchmark and "
        "review",
        2007,
    ),
    "https://doi.org/10.1093/mnras/stab1032": (
        "Biscani, Izzo",
        "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics",
        2021,
    ),
}
"""Authors, title and year by address: the sources of the bicycle and of the integrator."""

_SOURCE = (
    "heyoka_bike: the equations of motion of the Carvallo-Whipple bicycle, integrated by heyoka's "
    "adaptive Taylor method and proved in ball arithmetic"
)
_TYPE_OF_HDF5, _TYPE_OF_TEXT, _JSON = "application/x-hdf5", "text/plain", "application/json"


@dataclass(frozen=True, slots=True)
class Holding:
    """Title, summary and media type of a file of a dataset.

    Attributes
    ----------
    title : str
    summary : str
    media_type : str
    """

    title: str
    summary: str
    media_type: str


FILES: Mapping[str, Holding] = {
    layout.HDF5: Holding(
        "Reference solution of the multibody benchmark Uncontrolled bicycle",
        "Roll, steer, speed and energies by every usual definition, pitch and yaw: rows and "
        "piecewise polynomials, hi + lo (32 digits), with certified bounds.",
        _TYPE_OF_HDF5,
    ),
    layout.TEXT: Holding(
        "The 25 columns of the benchmark",
        "Rows of time and eight columns of each maneuver, 17 digits, without a heading.",
        _TYPE_OF_TEXT,
    ),
    layout.TEXT_50: Holding(
        "The 25 columns of the benchmark with 50 digits",
        "The same rows, correctly rounded to 50 significant digits.",
        _TYPE_OF_TEXT,
    ),
    layout.MOTION: Holding(
        "The whole motion of the reference solution: configuration and forces",
        "Places, attitudes, wheel angles, angular velocities, contact and joint forces: rows and "
        "piecewise polynomials, hi + lo, with certified bounds.",
        _TYPE_OF_HDF5,
    ),
    layout.SENSITIVITIES: Holding(
        "Sensitivities of the reference solution: d column / d unknown",
        "Derivatives of every column with respect to the 26 parameters and the start, with "
        "certified bounds.",
        _TYPE_OF_HDF5,
    ),
    layout.STATES: Holding(
        "States: all that a program can compute at single instants",
        "110 states of the bicycle with 189 quantities each, from geometry to forces and "
        "eigenvalues, correctly rounded: to check a model before it moves.",
        "text/csv",
    ),
    layout.STATES_HDF5: Holding(
        "The same states", "The same numbers, each with its unit and meaning.", _TYPE_OF_HDF5
    ),
    layout.CANDIDATE: Holding(
        "Candidate solutions: exact piecewise polynomials",
        "The computed motions as exact integers: what the certificate is about.",
        _TYPE_OF_HDF5,
    ),
    layout.CERTIFICATE: Holding(
        "Certificate", "What is proved, with which bounds, and what is taken as known.", _JSON
    ),
    MANIFEST: Holding(
        "Manifest", "Sizes and hashes of the files, the inputs, and how the set was made.", _JSON
    ),
    layout.CARD: Holding(
        "Card of the dataset", "This page: what it is, how to read and to cite it.", "text/markdown"
    ),
    layout.CRATE: Holding(
        "RO-Crate metadata", "The same for machines (RO-Crate).", "application/ld+json"
    ),
    layout.AFTER_FILES[0]: Holding(
        "After ten seconds",
        "What becomes of the motions later: 23 proved numbers, and sentences.",
        _JSON,
    ),
    layout.AFTER_FILES[1]: Holding(
        "Candidate solutions after ten seconds",
        "The two computed motions from which they are proved.",
        _TYPE_OF_HDF5,
    ),
}
"""The files of the published dataset."""


def title_of(version: str) -> str:
    """Return the title of a dataset of this version, with a separate title for custom datasets."""
    return "Reference solutions of an uncontrolled bicycle" if version == CUSTOM else TITLE


def shared_attributes(version: str) -> dict[str, str]:
    """Return the attributes, except the title, of every HDF5 file of this dataset version.

    A custom dataset gets no creator and no licence, because its maker is not known here.
    """
    papers = "; ".join(f"{who} ({year}), {at}" for at, (who, _, year) in PAPERS.items())
    said = {
        "Conventions": "ACDD-1.3",
        "keywords": ", ".join(KEYWORDS),
        "source": _SOURCE,
        "references": f"{papers}; {BENCHMARK}",
        "history": f"dataset version {version}, written by 'heyoka-bike generate'",
    }
    if version == CUSTOM:
        return said
    return said | {
        "product_version": version,
        "creator_name": CREATOR,
        "creator_type": "group",
        "license": f"{COPYRIGHT}, {LICENCE}",
    }


_COMMENTS = {
    layout.HDF5: "Each value is the correctly rounded exact one; <name>_lo is the exact value "
    "minus it, so <name> + <name>_lo has 32 digits. Axes: x forward, y right, z down.",
    layout.MOTION: "Each value is the correctly rounded exact one, or zero where an enclosure as "
    "narrow as its bound holds zero; <name>_lo is the exact value minus it, so <name> + "
    "<name>_lo has 32 digits. Ground frame: x along the initial heading, y right, z down, "
    "origin where the rear wheel touches the floor at t = 0. Wheel angles are zero at t = 0.",
    layout.SENSITIVITIES: "On the piece [a, b] of breaks the derivative of a column with respect "
    "to unknown u is sum_k c[piece, k, u] T_k(x), c_0 not halved, x = 2 (t - a) / (b - a) - 1; a "
    "break belongs to the piece on its right. The pitch at the start follows from roll and "
    "steer. <name>_bound[piece, u] is the certified distance from the exact derivative. NaN "
    "where a column does not depend smoothly on an unknown.",
    layout.CANDIDATE: "On the piece [a, b] of breaks a state variable is sum_k n_k 2^-grid s^k, "
    "s = (t - a) / (b - a); coefficients[piece, state, k] holds n_k as a little-endian "
    "two's complement integer. Angles in rad, rates in rad/s.",
    layout.STATES_HDF5: "Each value is the binary64 nearest to the exact one, in the state whose "
    "coordinates are the shortest decimals of the binary64 stored here; NaN where a quantity "
    "is not defined. Axes: x forward along the heading, y right, z down, origin where the rear "
    "wheel touches the floor.",
}
"""Comments of the whole files."""


def about(
    name: str, inputs: Mapping[str, Any], version: str, content: str | None = None
) -> dict[str, str]:
    """Return the attributes of a whole HDF5 file; the first ones serve to find and cite the file.

    Parameters
    ----------
    name
    inputs
        Inputs as in the manifest.
    version
        Version of the dataset that last changed the file.
    content
        Hash of the file's numbers, if it has one.
    """
    bicycle, of_file = inputs["bicycle"], FILES[name]
    said = {} if version == CUSTOM else {"id": f"heyoka_bike/{version}/{name}"}
    of_set = version == CUSTOM and name == layout.HDF5
    title = title_of(version) if of_set else of_file.title
    said |= {"title": title, "summary": of_file.summary, **shared_attributes(version)}
    comment = {"comment": _COMMENTS[name]}
    hashed = {} if content is None else {"content_sha256": content}
    hashed |= {"bicycle": bicycle["name"], "parameters": json.dumps(bicycle["parameters"])}
    if name in (layout.HDF5, layout.MOTION):
        own = {"Conventions": CONVENTIONS}
        own |= {"dataset_version": version} if name == layout.HDF5 else {}
        return said | own | hashed | comment
    own = {}
    if name == layout.SENSITIVITIES:
        own["unknowns"] = json.dumps(list(UNKNOWNS))
        own["unknown_units"] = json.dumps(list(UNKNOWNS.values()))
    return said | comment | hashed | own


def describe(manifest: Manifest, columns: Sequence[Column] = COLUMNS) -> dict[str, bytes]:
    """Return the card and the RO-Crate of a dataset by file name; a custom dataset has neither.

    `columns` are those of the dataset, by default all.
    """
    if manifest.dataset_version == CUSTOM:
        return {}
    return {CARD: _card(manifest, columns), CRATE: render_crate(manifest)}


def _card(manifest: Manifest, columns: Sequence[Column]) -> bytes:
    """Return README.md: the card of a published dataset, for readers who have only the folder."""
    template = Template((files(__package__) / "card.md").read_text(encoding="utf-8"))
    filled = template.substitute(
        title=TITLE,
        summary=SUMMARY,
        version=manifest.dataset_version,
        date=DATASET_DATE,
        year=DATASET_DATE[:4],
        content=manifest.content_sha256,
        creator=CREATOR,
        copyright=COPYRIGHT,
        licence=LICENCE,
        benchmark=BENCHMARK,
        files="\n".join(f"| `{name}` | {of.summary} |" for name, of in FILES.items()),
        columns="\n".join(_columns(columns)),
        papers="\n".join(
            f"- {authors}: {title} ({year}). <{address}>"
            for address, (authors, title, year) in PAPERS.items()
        ),
    )
    return filled.encode()


def _columns(columns: Sequence[Column]) -> Iterator[str]:
    for c in columns:
        place = f"{BENCHMARK_COLUMNS.index(c.name) + 1}" if c.name in BENCHMARK_COLUMNS else ""
        positive = f"; positive {c.positive}" if c.positive else ""
        yield f"| {place} | `{c.name}` | {c.unit} | {c.long_name}: {c.meaning}{positive} |"


_PROFILE = "https://w3id.org/ro/crate/1.1"
_MORE_TERMS = {name: f"http://schema.org/{name}" for name in ("sha256", "unitText")}

Entity = dict[str, Any]


def render_crate(manifest: Manifest) -> bytes:
    """Return the bytes of the crate of a published dataset.

    It states sizes and hashes of the files with data, not of those that describe them.
    """
    context = [f"{_PROFILE}/context", _MORE_TERMS]
    document = {"@context": context, "@graph": list(_entities(manifest))}
    return as_json(document)


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
        "name": TITLE,
        "description": SUMMARY,
        "version": version,
        "datePublished": DATASET_DATE,
        "identifier": f"heyoka_bike/{version}, content_sha256 {manifest.content_sha256}",
        "license": _at(LICENCE),
        "author": _at("#developers"),
        "publisher": _at("#developers"),
        "keywords": ", ".join(KEYWORDS),
        "isBasedOn": _at(BENCHMARK),
        "citation": _all(PAPERS),
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
    yield {"@id": "#developers", "@type": "Organization", "name": CREATOR}
    yield {
        "@id": LICENCE,
        "@type": "CreativeWork",
        "name": "MIT License",
        "description": COPYRIGHT,
    }
    for address, (authors, title, year) in PAPERS.items():
        yield {
            "@id": address,
            "@type": "ScholarlyArticle",
            "name": f"{authors}: {title}",
            "datePublished": str(year),
        }
    yield {"@id": BENCHMARK, "@type": "CreativeWork", "name": "Uncontrolled bicycle"}


def _file(name: str, manifest: Manifest) -> Entity:
    about = FILES[name]
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
