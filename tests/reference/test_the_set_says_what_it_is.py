"""The published dataset states its maker, terms, sources and meaning, to people and machines.

Custom datasets state only what is known about them. The texts follow from the manifest, and the
example lines that read the files work.
"""

import json
import re
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import version

import h5py
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.reference import description as facts
from heyoka_bike.reference.description import describe
from heyoka_bike.reference.layout import CARD, CRATE
from heyoka_bike.reference.making import versions_of_packages
from heyoka_bike.reference.manifest import (
    CUSTOM,
    DATASET_DATE,
    DATASET_VERSION,
    MANIFEST,
    read_manifest,
    sha256,
)
from heyoka_bike.system.resources import reference_folder
from support.export_programs import need

FILES = [p.relative_to(reference_folder()).as_posix() for p in reference_folder().rglob("*.h5")]
OF_THE_MAKER = {"id", "product_version", "creator_name", "creator_type", "license"}
OF_ANY = {"title", "summary", "keywords", "Conventions", "source", "references", "history"}


def test_a_later_version_of_the_package_names_the_one_that_first_made_the_set(folder):
    """Otherwise `generate` would write another manifest, and every command would refuse it."""
    named = read_manifest(folder).made_by["packages"]
    assert versions_of_packages(DATASET_VERSION)["heyoka_bike"] == named["heyoka_bike"]
    assert versions_of_packages(CUSTOM)["heyoka_bike"] == version("heyoka_bike")


@pytest.mark.parametrize("name", sorted(FILES))
def test_every_file_says_whose_it_is_and_what(folder, name):
    with h5py.File(folder / name) as f:
        said = dict(f.attrs)
        undescribed = []

        def visit(path, item):
            if isinstance(item, h5py.Dataset) and not all(
                item.attrs.get(key) for key in ("units", "long_name", "definition")
            ):
                undescribed.append(path)

        f.visititems(visit)
    assert all(said[key] for key in OF_ANY | OF_THE_MAKER)
    assert "ACDD-1.3" in said["Conventions"]
    assert said["id"] == f"heyoka_bike/{said['product_version']}/{name.rpartition('/')[2]}"
    assert not re.search(r"\s", said["id"])
    assert "MIT" in said["license"]
    assert not undescribed


def test_no_two_files_have_the_same_id(folder):
    found = []
    for path in folder.rglob("*.h5"):
        with h5py.File(path) as f:
            found.append(f.attrs["id"])
    assert len(set(found)) == len(found) == len(FILES) >= 5


@pytest.mark.parametrize(
    "name", [name for name in facts.FILES if name.endswith(".h5") and "/" not in name]
)
def test_a_set_of_ones_own_has_no_maker_here(folder, name):
    inputs = read_manifest(folder).inputs
    assert facts.about(name, inputs, "1.0.0", "").keys() >= OF_ANY | OF_THE_MAKER
    own = facts.about(name, inputs, CUSTOM, "")
    assert own.keys() >= OF_ANY
    assert not own.keys() & OF_THE_MAKER
    assert "heyoka_bike developers" not in json.dumps(own)


def test_card_and_crate_follow_from_the_manifest(folder):
    manifest = read_manifest(folder)
    made = describe(manifest)
    assert made.keys() == {CARD, CRATE} <= manifest.files.keys()
    # The texts of an older dataset may be worded differently.
    if manifest.dataset_version == DATASET_VERSION:
        for name, data in made.items():
            assert (folder / name).read_bytes() == data
    # The files that describe the other files do not describe themselves.
    others = {n: f for n, f in manifest.files.items() if n not in made}
    assert describe(replace(manifest, files=others)) == made
    assert describe(replace(manifest, dataset_version=CUSTOM)) == {}


@pytest.fixture(scope="module")
def crate(folder):
    document = json.loads((folder / CRATE).read_text(encoding="utf-8"))
    return {entity["@id"]: entity for entity in document["@graph"]}


def references(value):
    if isinstance(value, dict):
        yield value["@id"]
    elif isinstance(value, list):
        for item in value:
            yield from references(item)


def test_the_crate_is_one(crate):
    root, descriptor = crate["./"], crate[CRATE]
    assert descriptor["about"] == {"@id": "./"}
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert root["@type"] == "Dataset"
    assert root["datePublished"] == DATASET_DATE
    assert crate[root["license"]["@id"]]["name"] == "MIT License"
    for entity in crate.values():
        assert entity["@type"]
        assert entity["@id"] in ("./", CRATE) or entity["name"]
        for key, value in entity.items():
            if key != "@id":
                known = {*crate, "https://w3id.org/ro/crate/1.1"}
                assert set(references(value)) <= known, (entity["@id"], key)


def test_the_crate_has_the_files_of_the_folder(crate, folder):
    parts = set(references(crate["./"]["hasPart"]))
    assert parts == {*read_manifest(folder).files, MANIFEST} - {CRATE}
    for name in parts - {CARD, MANIFEST}:
        data = (folder / name).read_bytes()
        assert crate[name]["contentSize"] == str(len(data))
        assert crate[name]["sha256"] == sha256(data)
    assert {f"#{name}" for name in BENCHMARK_COLUMNS} == set(
        references(crate["./"]["variableMeasured"])
    )


@pytest.fixture(scope="module")
def card(folder):
    return (folder / CARD).read_text(encoding="utf-8")


def test_the_card_has_every_file_column_and_the_hash(card, folder):
    manifest = read_manifest(folder)
    for name in (*manifest.files, MANIFEST):
        assert f"| `{name}` | {facts.FILES[name].summary} |" in card
    for column in COLUMNS:
        assert f"| `{column.name}` | {column.unit} |" in card
    assert f"Version {manifest.dataset_version} of {DATASET_DATE}" in card
    assert manifest.content_sha256 in card
    assert "$" not in card


def test_the_cards_bound_is_above_the_certificates(card, folder):
    said = float(re.search(r"within (\S+) of `candidate.h5`", card)[1])
    certificate = json.loads((folder / "certificate.json").read_text())
    assert 0.5 * said < max(float(m["bound"]) for m in certificate["maneuvers"]) <= said


PROGRAMS = {
    "python": ("card.py", lambda p: [[sys.executable, p]]),
    "matlab": ("card.m", lambda p: [[need("octave-cli"), "--norc", "-q", p]]),
    "julia": ("card.jl", lambda p: [[need("julia"), p]]),
    "c": ("card.c", lambda p: [
        [need("gcc"), "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", p, "-o", f"{p}.out"],
        [f"{p}.out"],
    ]),
}  # fmt: skip


@pytest.mark.parametrize("language", PROGRAMS)
def test_the_lines_that_read_the_files_do(card, folder, reference, tmp_path, language):
    name, commands = PROGRAMS[language]
    (lines,) = re.findall(rf"```{language}\n(.*?)```", card, re.DOTALL)
    assert len([line for line in lines.splitlines() if line]) <= 7
    (tmp_path / name).write_text(lines)
    for command in commands(str(tmp_path / name)):
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60)
        assert run.returncode == 0, run.stderr
    time, roll = map(float, run.stdout.split())
    assert (time, roll) == (1.0, reference[2].rows.hi["roll_angle"][100])


def test_the_c_program_says_when_there_is_no_file(card, tmp_path):
    (lines,) = re.findall(r"```c\n(.*?)```", card, re.DOTALL)
    (tmp_path / "card.c").write_text(lines)
    subprocess.run(
        [need("gcc"), "-std=c99", "card.c", "-o", "card"], cwd=tmp_path, check=True, timeout=60
    )
    assert subprocess.run([tmp_path / "card"], cwd=tmp_path, timeout=60).returncode == 1


def test_julia_takes_the_column_that_matlab_takes(card):
    """This test replaces a run of Julia, which may not be installed."""
    formulas = re.findall(r"^roll = x[\[(]:, (.*?)[\])];? +[%#]", card, re.MULTILINE)
    assert len(formulas) == 2
    assert len(set(formulas)) == 1
