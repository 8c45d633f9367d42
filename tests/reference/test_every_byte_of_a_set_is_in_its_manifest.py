"""The manifest of a dataset of the current version covers every byte."""

import random
import shutil

import pytest
from test_verify_finds_every_damage import flip

from heyoka_bike.bicycle.parameters import benchmark, read_maneuvers
from heyoka_bike.cli import main
from heyoka_bike.errors import DatasetError
from heyoka_bike.reference import making
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.layout import AFTER_FILES, CARD, CRATE, STATES, STATES_HDF5
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.manifest import DATASET_VERSION, MANIFEST, read_manifest
from heyoka_bike.reference.proof.certify import certify
from heyoka_bike.reference.verification.verify import check_files, verify

pytestmark = pytest.mark.proof

FLIPS = 3  # number of flipped bits in each file


@pytest.fixture(scope="module")
def whole(tmp_path_factory, small_set):
    """A dataset made like the published one, of a short maneuver instead of the benchmark's."""
    inputs = benchmark()[0], read_maneuvers(small_set.parent / "m.toml")
    out = tmp_path_factory.mktemp("whole") / "set"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(making, "benchmark", lambda: inputs)
        making.generate(out, maneuvers=inputs[1])
    return out


@pytest.fixture
def copy(whole, tmp_path, monkeypatch):
    """A copy that counts as the published dataset."""
    digest = read_manifest(whole).sha256
    monkeypatch.setattr(manifest_file, "PUBLISHED_MANIFEST_SHA256", digest)
    return shutil.copytree(whole, tmp_path / "copy")


def files(folder):
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


def test_the_manifest_has_every_file_but_itself(copy, folder):
    manifest = read_manifest(copy)
    assert manifest.dataset_version == DATASET_VERSION
    assert files(copy) == {*manifest.files, MANIFEST}
    assert {*AFTER_FILES, STATES, STATES_HDF5, CARD, CRATE} <= manifest.files.keys()
    for name in AFTER_FILES:
        assert (copy / name).read_bytes() == (folder / name).read_bytes()


def test_it_is_verified_certified_and_made_again(copy):
    assert {c.message for c in verify(copy).checks if not c.passed} == set()
    assert len(certify(copy)) == 1
    # A file in the folder takes precedence over the same file of the package.
    (copy / AFTER_FILES[0]).write_bytes(b"{}")
    assert making._after(copy)[AFTER_FILES[0]] == b"{}"
    assert making._after(copy.parent)[AFTER_FILES[0]] != b"{}"


def test_any_flipped_bit_is_found_and_the_file_is_named(copy):
    rng = random.Random(1)
    for name in sorted(files(copy)):
        raw = (copy / name).read_bytes()
        for _ in range(FLIPS):
            flip(copy / name, rng)
            failed = {c.file for c in check_files(copy)[2] if c.passed is False}
            assert name in failed
            (copy / name).write_bytes(raw)
    assert all(c.passed for c in check_files(copy)[2])


def test_a_missing_file_and_an_unknown_one_are_named(copy, capsys):
    for name in AFTER_FILES:
        (copy / name).unlink()
    (copy / "after-ten-seconds" / "more.txt").write_text("anything")
    (copy / "more").mkdir()
    (copy / "more" / "inside.txt").write_text("anything")
    *_, checks = check_files(copy)
    failed = [c for c in checks if c.passed is False]
    assert {(c.file, c.message) for c in failed} == {(name, "is missing") for name in AFTER_FILES}
    assert checks[-1].evidence["files"] == ["after-ten-seconds/more.txt", "more"]
    assert main(["verify", str(copy)]) == 3
    assert f"{copy / AFTER_FILES[0]}: file: is missing" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["../m.toml", "a/../../m.toml", "/etc/hostname", "a//b", "a/b/c"])
def test_a_manifest_cannot_lead_out_of_the_folder(copy, name):
    path = copy / MANIFEST
    path.write_text(path.read_text().replace(AFTER_FILES[0], name))
    messages = [c.message for c in check_files(copy)[2] if c.passed is False]
    assert f"lists the file {name!r}, expected a name inside the folder" in messages


def test_a_damaged_manifest_is_not_loaded(copy, monkeypatch):
    monkeypatch.setattr(manifest_file, "reference_folder", lambda: copy)
    assert load_reference().dataset_version == DATASET_VERSION
    raw = (copy / MANIFEST).read_bytes()
    rng = random.Random(2)
    for _ in range(20):
        flip(copy / MANIFEST, rng)
        with pytest.raises(DatasetError):
            load_reference()
        (copy / MANIFEST).write_bytes(raw)
