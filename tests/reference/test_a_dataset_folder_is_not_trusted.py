"""Every command that opens a dataset folder refuses a hostile one in one line, and ends.

Each change updates the manifest's hashes, because hashes only detect accidental damage.
"""

import json
import os
import shutil

import h5py
import numpy as np
import pytest

from generators.made_sets import accept, manifest
from heyoka_bike.cli import main
from heyoka_bike.reference.layout import content_sha256
from heyoka_bike.reference.manifest import MANIFEST

pytestmark = [pytest.mark.proof, pytest.mark.timeout(120, func_only=True)]

SECRET = 1234.5678


@pytest.fixture
def copy(small_set, tmp_path):
    return shutil.copytree(small_set, tmp_path / "copy")


def run(capsys, *words):
    """Return exit code and lines on standard error; no output contains another file's content."""
    code = main(list(map(str, words)))
    out, err = capsys.readouterr()
    assert "1234.5" not in out + err
    assert "root:" not in out + err
    return code, err.splitlines()


def replaced(name, make):
    """Return a change that replaces a column of the rows with the object that `make` creates."""

    def change(folder):
        with h5py.File(folder / "uncontrolled-bicycle.h5", "r+") as f:
            group = f["maneuver_1"]
            values, attributes = group[name][:], dict(group[name].attrs)
            del group[name]
            make(group, name, values, folder.parent)
            for key, x in attributes.items():
                group[name].attrs[key] = x
        accept(folder)

    return change


def secret(folder, values):
    with h5py.File(folder / "secret.h5", "w") as f:
        f["x"] = values + SECRET
    (folder / "secret.raw").write_bytes((values + SECRET).tobytes())


def virtual(group, name, values, outside):
    secret(outside, values)
    layout = h5py.VirtualLayout(values.shape, values.dtype)
    layout[:] = h5py.VirtualSource(str(outside / "secret.h5"), "x", shape=values.shape)
    group.create_virtual_dataset(name, layout)


def stored_elsewhere(group, name, values, outside):
    secret(outside, values)
    external = [(str(outside / "secret.raw"), 0, values.nbytes)]
    group.create_dataset(name, values.shape, values.dtype, external=external)


def linked(group, name, values, outside):
    secret(outside, values)
    with h5py.File(outside / "secret.h5", "r+") as f:
        f["x"].attrs["units"] = "rad"
    group[name] = h5py.ExternalLink(str(outside / "secret.h5"), "x")


def zeros(group, name, values, outside):
    group.create_dataset(name, data=np.zeros(2 * 10**7), chunks=(10**6,), compression="gzip")


def huge(group, name, values, outside):
    group.create_dataset(name, (2**40,), "f8", chunks=(2**16,))


def shorter(group, name, values, outside):
    group[name] = values[:3]


def integers(group, name, values, outside):
    group[name] = np.arange(len(values))


def not_finite(group, name, values, outside):
    group[name] = np.where(np.arange(len(values)) == 3, np.inf, values)


READERS = (
    ("verify",), ("certify", "--workers", "1"), ("export", "--format", "csv", "--reference"),
    ("score", "RESULTS", "--reference"), ("diagnose", "RESULTS", "--workers", "1", "--reference"),
    ("animate", "RESULTS", "--reference"), ("plot",),
)  # fmt: skip


@pytest.mark.parametrize(
    "make", [virtual, stored_elsewhere, linked, zeros, huge, shorter, integers, not_finite]
)
def test_a_hostile_column_is_refused_by_every_command(copy, capsys, make, monkeypatch):
    replaced("roll_angle", make)(copy)
    monkeypatch.chdir(copy.parent)
    rows = np.column_stack([np.arange(7) / 100, np.random.default_rng(1).random((7, 8))])
    np.savetxt("results.txt", rows)
    for words in READERS:
        words = ["results.txt" if x == "RESULTS" else x for x in words]
        code, lines = run(capsys, *words, copy)
        assert code in (1, 3), words
        named = [line for line in lines if "roll_angle" in line or "content_sha256" in line]
        assert named, (words, lines)
        # For each failed check `verify` prints one line. The other commands print a single line.
        assert len(lines) == 1 or words[0] == "verify"


def test_coefficients_kept_elsewhere_are_refused(copy, capsys):
    with h5py.File(copy / "candidate.h5", "r+") as f:
        group = f["maneuver_1"]
        values = group["coefficients"][:]
        del group["coefficients"]
        (copy.parent / "secret.raw").write_bytes(values.tobytes())
        external = [(str(copy.parent / "secret.raw"), 0, values.nbytes)]
        group.create_dataset("coefficients", values.shape, "u1", external=external)
    accept(copy)
    for words in (("verify",), ("certify", "--workers", "1")):
        code, lines = run(capsys, *words, copy)
        assert code in (1, 3)
        assert "candidate.h5: " in lines[0]
        assert "/maneuver_1/coefficients is stored in another file" in lines[0]


def entry(name, **changes):
    """Return a change of the manifest's first entry: its file name, and optionally other keys."""

    def change(folder):
        document = json.loads((folder / MANIFEST).read_text())
        document["files"][0] |= {"file": name} | changes
        manifest(folder, files=document["files"])

    return change


def special(name, make):
    def change(folder):
        (folder / name).unlink()
        make(folder / name)

    return change


def link_outside(folder):
    (folder / "states.csv").rename(folder.parent / "states.csv")
    (folder / "states.csv").symlink_to(folder.parent / "states.csv")


def text(name, content):
    def change(folder):
        (folder / name).write_bytes(content)
        if name != MANIFEST:
            accept(folder)

    return change


def certificate(**changes):
    def change(folder):
        path = folder / "certificate.json"
        document = json.loads(path.read_text())
        document["maneuvers"][0] |= changes
        path.write_text(json.dumps(document))
        accept(folder)

    return change


def of_candidate(**attributes):
    def change(folder):
        with h5py.File(folder / "candidate.h5", "r+") as f:
            f["maneuver_1"].attrs.update(attributes)
        accept(folder)

    return change


def sparse(folder):
    os.truncate(folder / "states.csv", 2 << 30)
    document = json.loads((folder / MANIFEST).read_text())
    for x in document["files"]:
        x["bytes"] = 2 << 30 if x["file"] == "states.csv" else x["bytes"]
    manifest(folder, files=document["files"])


def limits(folder):
    document = json.loads((folder / MANIFEST).read_text())
    document["performance_limits"] = {"1": "1e-999999999"}
    (folder / MANIFEST).write_text(json.dumps(document))


CHANGES = {
    "a name outside": (entry("../../../../etc/passwd"), "expected a name inside the folder"),
    "an absolute name": (entry("/dev/zero"), "expected a name inside the folder"),
    "a pipe": (special("motion.h5", os.mkfifo), "it is a pipe"),
    "a folder": (special("motion.h5", os.mkdir), "motion.h5"),
    "a device": (special("states.csv", lambda x: x.symlink_to("/dev/zero")), "outside the folder"),
    "a pipe for a manifest": (special(MANIFEST, os.mkfifo), "it is a pipe"),
    "a link outside": (link_outside, "it is a link to a file outside the folder"),
    "two gigabytes": (sparse, "expected at most 1000000000"),
    "brackets": (text(MANIFEST, b"[" * 200_000), "is not a manifest"),
    "a long integer": (text(MANIFEST, b'{"schema_version": ' + b"9" * 5000 + b"}"), "manifest"),
    "a limit without end": (limits, "is not a manifest"),
    "a certificate of brackets": (text("certificate.json", b"[" * 200_000), "cannot be read"),
    "a certificate of no text": (text("certificate.json", b"\xff\xfe{}"), "cannot be read"),
    "a bound without end": (certificate(bound="1e-" + "9" * 400), "certificate.json"),
    "a list by name": (certificate(state_bounds=[1]), "certificate.json"),
    "a grid of 2^62": (of_candidate(grid=np.int64(2**62)), "attribute grid"),
    "a grid below zero": (of_candidate(grid=np.int64(-5)), "attribute grid"),
    "another order": (of_candidate(taylor_order=np.int64(10**12)), "coefficients"),
    "a time without end": (of_candidate(duration="1e999999999"), "candidate.h5"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_hostile_folder_is_refused_by_verify_and_certify(copy, capsys, name):
    change, said = CHANGES[name]
    change(copy)
    code, lines = run(capsys, "verify", copy)
    assert code == 3, lines
    found = [run(capsys, "certify", copy, "--workers", "1"), (code, lines)]
    assert found[0][0] in (1, 3), found
    assert len(found[0][1]) == 1
    assert any(said in line for line in found[0][1]), found


@pytest.mark.parametrize(
    ("file", "place", "attribute", "text"),
    [
        ("uncontrolled-bicycle.h5", "maneuver_1/roll_angle", "units", "deg"),
        ("motion.h5", "maneuver_1/com_z", "units", "mm"),
        ("sensitivities.h5", "maneuver_1/yaw", "units", "deg"),
        ("states.h5", "roll_rate", "units", "deg s-1"),
        ("uncontrolled-bicycle.h5", "/", "license", "all rights reserved"),
        ("candidate.h5", "/", "license", "all rights reserved"),
    ],
)
def test_other_units_and_another_licence_are_not_certified(
    copy, capsys, file, place, attribute, text
):
    with h5py.File(copy / file, "r+") as f:
        # A custom dataset does not state a licence.
        is_known = attribute in f[place].attrs
        assert is_known == (attribute != "license")
        f[place].attrs[attribute] = text
    accept(copy)
    code, (line,) = run(capsys, "certify", copy, "--workers", "1")
    assert code == 3
    assert f"{file}: " in line
    found = f"attribute {attribute}: found {text!r}"
    assert (found if is_known else f"unknown attribute {attribute!r}") in line


@pytest.mark.parametrize("place", ["dense/order", "dense/piece"])
def test_other_indices_are_not_certified(copy, capsys, place):
    """Indices are the only numbers that no proof recomputes."""
    with h5py.File(copy / "uncontrolled-bicycle.h5", "r+") as f:
        f["maneuver_1"][place][-1] += 4
    accept(copy)
    code, (line,) = run(capsys, "certify", copy, "--workers", "1")
    assert code == 3
    assert f"maneuver_1/{place}: found other numbers than 0, 1, 2, ..." in line


def test_a_doubled_entry_of_the_manifest_is_not_certified(copy, capsys):
    document = json.loads((copy / MANIFEST).read_text())
    first = document["files"][0]
    manifest(copy, files=[first | {"sha256": "0" * 64}, *document["files"]])
    code, (line,) = run(capsys, "certify", copy, "--workers", "1")
    assert code == 3
    assert line.endswith(
        f"{MANIFEST}: the files are not listed in alphabetical order, or one is listed twice"
    )
    raw = (copy / MANIFEST).read_text()
    (copy / MANIFEST).write_text(raw.replace('"dataset_version"', '"files": [], "dataset_version"'))
    assert run(capsys, "certify", copy, "--workers", "1")[0] == 3


def test_numbers_whose_hash_is_right_are_accepted(copy, capsys):
    """A copy with an updated manifest is accepted, so it is the changes above that are refused."""
    with h5py.File(copy / "uncontrolled-bicycle.h5", "r+") as f:
        assert f.attrs["content_sha256"] == content_sha256(f)
    accept(copy)
    assert run(capsys, "verify", copy) == (0, [])
    assert run(capsys, "certify", copy, "--workers", "1") == (0, [])
