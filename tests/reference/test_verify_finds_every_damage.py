"""`heyoka-bike verify` detects any changed byte, names the file, and never crashes."""

import json
import os
import random
import shutil
import subprocess
import sys
from fractions import Fraction

import pytest

from generators.made_sets import accept, make
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.cli import main
from heyoka_bike.errors import DatasetError
from heyoka_bike.numbers.exact import ZERO, shortest_decimal
from heyoka_bike.reference.layout import text_files
from heyoka_bike.reference.manifest import DATASET_VERSION, MANIFEST, read_manifest
from heyoka_bike.reference.verification.schema import SetForm, of_text
from heyoka_bike.reference.verification.verify import check_files, verify
from heyoka_bike.system.parallel import using

FLIPS, OF_THE_MANIFEST = 400, 60
AFTER = "after-ten-seconds"


@pytest.fixture
def copy(folder, tmp_path):
    return shutil.copytree(folder, tmp_path / "copy")


@pytest.fixture
def small(small_set, tmp_path):
    return shutil.copytree(small_set, tmp_path / "small")


def flip(path, rng):
    """Change one bit of a file; return its position."""
    place = rng.randrange(path.stat().st_size)
    with path.open("r+b") as f:
        f.seek(place)
        old = f.read(1)[0]
        f.seek(place)
        f.write(bytes([old ^ (1 << rng.randrange(8))]))
    return place


def run(folder, capsys, *options):
    """Return exit code and lines on standard error."""
    code = main(["verify", str(folder), *options])
    return code, capsys.readouterr().err.splitlines()


@pytest.mark.proof
def test_the_published_set_passes_every_check(capsys):
    assert main(["verify", "--format", "json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    report = json.loads(out)
    assert report["passed"] is True
    assert {c["passed"] for c in report["checks"]} == {True}
    counted = {(c["check"], c["file"]): c["evidence"]["values"] for c in report["checks"]}
    every_value = 3 * 1001 * 38
    for check in ("columns", "rounding", "row_bounds", "dense_rows"):
        assert counted[check, "uncontrolled-bicycle.h5"] == every_value
    for name in ("uncontrolled-bicycle.txt", "uncontrolled-bicycle-50digits.txt"):
        assert counted["text", name] == 1001 * 24


@pytest.mark.proof
def test_the_report_has_a_stable_structure(small):
    report = verify(small).as_dict()
    assert set(report) == {"schema_version", "dataset_version", "folder", "passed", "checks"}
    assert report["schema_version"] == 1
    assert report["dataset_version"] == "custom"
    for check in report["checks"]:
        assert set(check) == {"check", "passed", "file", "message", "evidence"}
        assert check["evidence"]["values"] >= 0
    assert json.loads(json.dumps(report, allow_nan=False)) == report


@pytest.mark.proof
def test_hundreds_of_flipped_bits_are_found_and_the_files_named(folder, copy, monkeypatch):
    # Only the bytes are compared, so the test makes reading numbers impossible.
    monkeypatch.setattr("h5py.File", None)
    rng = random.Random(1)
    paths = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    names = [path for path in paths if path != MANIFEST]
    assert {"README.md", "ro-crate-metadata.json", f"{AFTER}/{AFTER}.json"} <= {*names}
    done = 0
    while done < FLIPS - OF_THE_MANIFEST:
        # Change several files at a time, one bit in each.
        chosen = rng.sample(names, rng.randint(1, len(names)))
        kept = {name: (copy / name).read_bytes() for name in chosen}
        for name in chosen:
            flip(copy / name, rng)
        *_, checks = check_files(copy)
        assert {c.file for c in checks if c.passed is False} == set(chosen)
        for name, data in kept.items():
            (copy / name).write_bytes(data)
        done += len(chosen)
    raw = (copy / MANIFEST).read_bytes()
    for _ in range(OF_THE_MANIFEST):
        place = flip(copy / MANIFEST, rng)
        *_, checks = check_files(copy)
        assert MANIFEST in {c.file for c in checks if c.passed is False}, place
        (copy / MANIFEST).write_bytes(raw)
    *_, checks = check_files(copy)
    assert all(c.passed for c in checks)


@pytest.mark.proof
def test_what_is_beside_the_published_set_is_looked_at(copy):
    (copy / AFTER / "candidate.h5").unlink()
    (copy / AFTER / "more.txt").write_text("anything")
    *_, checks = check_files(copy)
    (missing,) = [c for c in checks if c.passed is False]
    assert (missing.file, missing.message) == (f"{AFTER}/candidate.h5", "is missing")
    assert "not part of the dataset: 'after-ten-seconds/more.txt'" in checks[-1].message
    shutil.rmtree(copy / AFTER)
    files = [f"{AFTER}/{AFTER}.json", f"{AFTER}/candidate.h5"]
    # Before version 2.0.0 a copy of the dataset may lack the folder, but the dataset in the package
    # may not.
    needed = files if {*files} <= read_manifest(copy).files.keys() else []
    for is_published, missing in ((False, needed), (True, files)):
        *_, checks = check_files(copy, is_published=is_published)
        assert [c.file for c in checks if c.passed is False] == missing


@pytest.mark.proof
@pytest.mark.parametrize(
    "name",
    ["candidate.h5", "certificate.json", "uncontrolled-bicycle.h5", "uncontrolled-bicycle.txt",
     "uncontrolled-bicycle-50digits.txt", "sensitivities.h5"],
)  # fmt: skip
def test_a_flipped_bit_through_the_whole_command(small, capsys, name):
    flip(small / name, random.Random(name))
    assert main(["verify", str(small), "--format", "json"]) == 3
    out, err = capsys.readouterr()
    # There is only one line: items that cannot be checked without this file are not called wrong.
    (line,) = err.splitlines()
    assert f"{small / name}: file: found sha256" in line
    checks = json.loads(out)["checks"]
    unmade = [c for c in checks if c["passed"] is None]
    assert "schema" in {c["check"] for c in unmade}
    assert {c["check"] for c in checks if c["passed"] is False} == {"file"}
    assert all("not checked" in c["message"] for c in unmade)


@pytest.mark.proof
def test_a_byte_of_the_manifest_of_a_published_set(copy, capsys, monkeypatch):
    # The test `test_the_published_set_passes_every_check` covers the numbers, so they are not
    # checked here.
    monkeypatch.setattr("heyoka_bike.reference.verification.verify.CHECKS", ())
    path = copy / MANIFEST
    path.write_bytes(path.read_bytes().replace(b'"digits": 70', b'"digits": 71'))
    with using(workers=1):
        code, lines = run(copy, capsys)
    assert code == 3
    assert "manifest.json: manifest_hash: found sha256" in lines[0]
    # The texts also state the number of digits. The texts of an older dataset are not compared.
    said = ["ro-crate-metadata.json: schema: does not follow from manifest.json"]
    expected = said if read_manifest(copy).dataset_version == DATASET_VERSION else []
    assert [line.split(f"{copy}/")[1] for line in lines[1:]] == expected


@pytest.mark.proof
def test_a_truncated_file_an_empty_one_and_one_that_is_missing(small, capsys):
    candidate, text = small / "candidate.h5", small / "uncontrolled-bicycle.txt"
    candidate.write_bytes(candidate.read_bytes()[:-1])
    text.write_bytes(b"")
    (small / "certificate.json").unlink()
    code, lines = run(small, capsys)
    assert code == 3
    assert len(lines) == 3
    assert any("candidate.h5: file: found" in line and "bytes, expected" in line for line in lines)
    assert any("uncontrolled-bicycle.txt: file: found 0 bytes" in line for line in lines)
    assert any("certificate.json: file: is missing" in line for line in lines)


@pytest.mark.proof
def test_a_folder_in_place_of_a_file(small, capsys):
    (small / "candidate.h5").unlink()
    (small / "candidate.h5").mkdir()
    code, lines = run(small, capsys)
    assert code == 3
    assert "candidate.h5: file: " in lines[0]


@pytest.mark.proof
def test_other_files_are_named_and_do_no_harm(small, capsys):
    (small / "notes.txt").write_text("mine")
    (small / "plots").mkdir()
    assert main(["verify", str(small), "--format", "json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert main(["verify", str(small)]) == 0
    *_, told, counted = capsys.readouterr().out.splitlines()
    assert "WARNING: not part of the dataset and not checked: " in told
    assert counted.endswith("0 failed")
    (other,) = [c for c in json.loads(out)["checks"] if c["check"] == "other_files"]
    assert other["evidence"]["files"] == ["notes.txt", "plots"]
    assert "notes.txt" in other["message"]


@pytest.mark.proof
@pytest.mark.parametrize("text", ["", "{}", "[]", "null", '{"schema_version": 1}', "[" * 9999])
def test_a_manifest_that_is_none_beside_the_files_of_a_set(small, capsys, text):
    (small / MANIFEST).write_text(text)
    code, lines = run(small, capsys)
    assert code == 3
    assert len(lines) == 1
    assert f"{small / MANIFEST}: manifest: " in lines[0]


@pytest.mark.proof
@pytest.mark.parametrize(("version", "word"), [(2, "newer"), (0, "generate the dataset again")])
def test_a_manifest_of_another_schema(small, capsys, version, word):
    path = small / MANIFEST
    path.write_text(path.read_text().replace('"schema_version": 1', f'"schema_version": {version}'))
    code, lines = run(small, capsys)
    assert code == 3
    assert len(lines) == 1
    assert word in lines[0]


@pytest.mark.proof
def test_a_set_without_its_manifest(small, capsys):
    (small / MANIFEST).unlink()
    code, lines = run(small, capsys)
    assert code == 3
    assert "no manifest.json found" in lines[0]


@pytest.mark.proof
def test_what_is_no_reference_set(small, tmp_path, capsys):
    empty, foreign = tmp_path / "empty", tmp_path / "foreign"
    for where in (empty, foreign):
        where.mkdir()
    (foreign / MANIFEST).write_text('{"name": "a web page"}')
    a_file = small / "candidate.h5"
    for where in (empty, foreign, tmp_path / "nothing", a_file):
        code, lines = run(where, capsys)
        assert code == 1, where
        assert len(lines) == 1
        assert str(where) in lines[0]
        with pytest.raises(DatasetError):
            verify(where)


@pytest.mark.proof
@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read everything")
def test_files_that_may_not_be_read(small, capsys):
    (small / "candidate.h5").chmod(0)
    assert run(small, capsys)[0] == 3
    small.chmod(0)
    try:
        assert run(small, capsys)[0] == 1
    finally:
        small.chmod(0o755)


@pytest.mark.proof
def test_a_manifest_that_leads_out_of_its_folder(small, capsys):
    text = (small / MANIFEST).read_text()
    (small / MANIFEST).write_text(text.replace('"candidate.h5"', '"../candidate.h5"'))
    (small.parent / "candidate.h5").write_bytes((small / "candidate.h5").read_bytes())
    code, lines = run(small, capsys)
    assert code == 3
    assert any("expected a name inside the folder" in line for line in lines)


@pytest.mark.proof
def test_damaged_hdf5_that_the_manifest_vouches_for_never_crashes(small, capsys):
    rng = random.Random(3)
    found = 0
    for i in range(15):
        name = ("uncontrolled-bicycle.h5", "candidate.h5", "sensitivities.h5")[i % 3]
        kept = (small / name).read_bytes()
        kept_manifest = (small / MANIFEST).read_bytes()
        place = flip(small / name, rng)
        accept(small)
        code, lines = run(small, capsys)
        # A flipped bit in bytes that HDF5 itself does not use need not be found.
        assert code in (0, 3), (name, place, lines)
        assert not any("internal error" in line for line in lines)
        found += code == 3
        (small / name).write_bytes(kept)
        (small / MANIFEST).write_bytes(kept_manifest)
    assert found > 7


@pytest.mark.proof
def test_truncated_hdf5_that_the_manifest_vouches_for(small, capsys):
    for name, parts in (
        ("uncontrolled-bicycle.h5", (0, 1 / 2)), ("candidate.h5", (1e-3,)),
        ("sensitivities.h5", (0.999,)),
    ):  # fmt: skip
        path = small / name
        kept = path.read_bytes()
        for part in (int(share * len(kept)) for share in parts):
            path.write_bytes(kept[:part])
            accept(small)
            code, lines = run(small, capsys)
            assert code == 3
            assert any(f"{path}: schema: cannot be read" in line for line in lines), lines
        path.write_bytes(kept)


@pytest.mark.proof
def test_heyoka_is_not_needed(small):
    code = (
        "import sys; sys.modules['heyoka'] = None\n"
        f"from heyoka_bike.cli import main; sys.exit(main(['verify', {str(small)!r}]))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""


@pytest.mark.proof
def test_options_that_make_no_sense(small, capsys):
    code, lines = run(small, capsys, "--quick")
    assert code == 1
    assert len(lines) == 1
    assert "--quick needs --rerun" in lines[0]
    with pytest.raises(SystemExit, match="1"):
        run(small, capsys, "--format", "xml")
    assert "found 'xml', expected table or json" in capsys.readouterr().err


@pytest.mark.proof
def test_times_of_no_decimal_are_those_written():
    maneuver = Maneuver("thirds", ZERO, ZERO, Fraction(4), Fraction(1, 3))
    times = [shortest_decimal(maneuver.time(i), 50) for i in range(maneuver.rows)]
    short, _ = text_files([maneuver])
    form = SetForm(None, [maneuver], {})

    def problems(texts):
        zeros = " 0" * len(BENCHMARK_COLUMNS)
        raw = "".join(f"{text}{zeros}\n" for text in texts).encode()
        return list(of_text(raw, form, short))

    assert problems(times) == []
    for wrong in (times[4][:-1], times[4][:-1] + "4", times[4] + "3"):
        said = problems([*times[:4], wrong, *times[5:]])
        assert said == [f"line 5: found time {wrong} s, expected 1.3333333333333333 s"]


@pytest.mark.slow
def test_maneuvers_of_different_rows_have_texts_of_their_own(tmp_path, capsys):
    where = make(tmp_path, ("0.2", "0.05"), ("0.1", "1/30"))
    assert run(where, capsys) == (0, [])
    texts = {c.file for c in verify(where).checks if c.check == "text"}
    assert texts == {
        f"uncontrolled-bicycle{kind}-{i}.txt" for kind in ("", "-50digits") for i in (1, 2)
    }
