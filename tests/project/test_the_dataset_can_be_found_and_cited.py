"""Descriptions of the dataset in other files agree with it; schemas and sources have
identifiers."""

import json
import re
import tomllib
import uuid
from pathlib import Path

import jsonschema
import pytest
import yaml

from heyoka_bike.reference import description as facts
from heyoka_bike.reference.manifest import DATASET_DATE, PUBLISHED_VERSION, read_manifest

ROOT = Path(__file__).resolve().parents[2]
SCHEMAS = sorted((ROOT / "heyoka_bike").rglob("*.schema.json"))
BICYCLES = ROOT / "data" / "bicycles"
DOIS = {address.removeprefix("https://doi.org/") for address in facts.PAPERS}


@pytest.fixture(scope="module")
def citation():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_the_citation_has_the_dataset(citation, folder):
    (data,) = [x for x in citation["references"] if x["type"] == "data"]
    assert data["title"] == facts.TITLE
    assert data["authors"] == citation["authors"] == [{"name": facts.CREATOR}]
    assert data["version"] == PUBLISHED_VERSION == read_manifest(folder).dataset_version
    assert str(data["date-released"]) == DATASET_DATE
    assert data["license"] == citation["license"] == "MIT"
    (named,) = data["identifiers"]
    assert named["value"] == f"content_sha256 {read_manifest(folder).content_sha256}"


def test_the_set_cites_what_the_citation_does(citation):
    articles = {x["doi"]: x for x in citation["references"] if x["type"] == "article"}
    assert articles.keys() == DOIS
    for doi, article in articles.items():
        authors, title, year = facts.PAPERS[f"https://doi.org/{doi}"]
        assert ", ".join(a["family-names"] for a in article["authors"]) == authors
        assert (article["title"], article["year"]) == (title, year)


def test_the_deposit_says_what_the_set_says():
    """The fields are those of https://developers.zenodo.org/#representation."""
    said = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    required = {"upload_type", "title", "creators", "description", "access_right", "license"}
    assert said.keys() == required | {"version", "keywords", "related_identifiers"}
    assert said["upload_type"] == "dataset"
    assert said["title"] == facts.TITLE
    assert said["creators"] == [{"name": facts.CREATOR}]
    assert said["version"] == PUBLISHED_VERSION
    assert tuple(said["keywords"]) == facts.KEYWORDS
    assert f"<p>{facts.SUMMARY}</p>" in said["description"]
    related = [x["identifier"] for x in said["related_identifiers"]]
    assert set(related) == DOIS | {facts.BENCHMARK}


def test_every_schema_has_a_name_of_its_own():
    assert SCHEMAS
    for path in SCHEMAS:
        schema = json.loads(path.read_text(encoding="utf-8"))
        jsonschema.Draft202012Validator.check_schema(schema)
        # The identifier is derived from the name and the major version, so a copied identifier is
        # wrong.
        name = path.name.removesuffix(".schema.json")
        assert schema["$id"] == f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_OID, f'heyoka_bike {name}')}"
        assert re.search(r"-\d+$", name)


def test_every_bicycle_has_its_source_and_its_terms():
    page = (BICYCLES / "README.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    for path in BICYCLES.rglob("*.toml"):
        name = path.relative_to(BICYCLES).with_suffix("").as_posix()
        source = tomllib.loads(path.read_text(encoding="utf-8"))["source"]
        shown = "`adversarial/...`" if name.startswith("adversarial/") else f"`{name}`"
        (row,) = [row for row in rows if shown in row.split("|")[1]]
        if repository := re.search(r"github\.com/\w+/\w+", source):
            above = [r for r in rows[: rows.index(row) + 1] if "github.com" in r]
            assert repository[0] in above[-1], name
            assert "(c)" in above[-1], name
        else:
            assert "made" in source or "doi:10.1098" in source, name
