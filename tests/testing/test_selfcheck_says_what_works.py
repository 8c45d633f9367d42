"""`heyoka-bike selfcheck` reports what an installation can do, also for a wheel."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import heyoka_bike.testing.selfcheck as module
from heyoka_bike.cli import main
from heyoka_bike.reference.manifest import PUBLISHED_MANIFEST_SHA256, PUBLISHED_VERSION
from support.without_packages import python

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def quick(monkeypatch):
    """Skips the runs."""
    monkeypatch.setattr(module, "PRECISIONS", ())


@pytest.fixture
def damaged(folder, tmp_path, monkeypatch):
    copy = shutil.copytree(folder, tmp_path / "copy")
    monkeypatch.setattr(module, "reference_folder", lambda: copy)
    return copy


@pytest.mark.proof
def test_a_whole_installation_works(capsys):
    assert main(["selfcheck", "--format", "json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    report = json.loads(out)
    assert report["passed"] is True
    assert report["schema_version"] == 1
    assert report["dataset_version"] == PUBLISHED_VERSION
    assert report["manifest_sha256"] == PUBLISHED_MANIFEST_SHA256
    assert report["versions"]["numpy"] == np.__version__
    assert report["machine"]["cores"] == os.cpu_count()
    checks = {c["check"]: c for c in report["checks"]}
    assert list(checks) == ["reference", "score", "run_binary64", "run_binary128"]
    assert checks["score"]["evidence"]["values"] == 3 * 8 * 1001
    for name, digits in (("run_binary64", 16), ("run_binary128", 34)):
        reached = checks[name]["evidence"]["digits"]
        # Rounding over 10 s costs some digits of a number format, but not many.
        assert digits - 4 < min(reached.values()) <= max(reached.values()) < digits + 1
        assert checks[name]["evidence"]["seconds"] > 0


def test_the_table_is_short(quick, capsys):
    pytest.importorskip("heyoka")
    assert main(["selfcheck"]) == 0
    out = capsys.readouterr().out
    assert len(out.splitlines()) < 30
    for word in ("machine", "python", "numpy", "heyoka", PUBLISHED_VERSION, "as exact as", "works"):
        assert word in out


def test_a_damaged_reference_is_named(quick, damaged, capsys):
    path = damaged / "uncontrolled-bicycle.h5"
    data = bytearray(path.read_bytes())
    data[1000] ^= 1
    path.write_bytes(data)
    assert main(["selfcheck"]) == 3
    out, err = capsys.readouterr()
    assert err.count("\n") == 1
    assert f"{path}: reference: found sha256" in err
    assert "does not work" in out
    path.unlink()
    assert main(["selfcheck"]) == 3
    assert f"{path}: reference: is missing" in capsys.readouterr().err


def test_a_missing_reference_is_named(quick, damaged, capsys):
    shutil.rmtree(damaged)
    assert main(["selfcheck", "--format", "json"]) == 3
    out, err = capsys.readouterr()
    assert err.count("\n") == 1
    assert str(damaged) in err
    assert json.loads(out)["dataset_version"] is None


def test_a_text_that_is_off_its_floor_is_seen(folder, tmp_path):
    """A value is wrong in its 14th digit."""
    lines = (folder / "uncontrolled-bicycle.txt").read_text().splitlines()
    fields = lines[500].split(" ")
    fields[8] = f"{float(fields[8]) * (1 + 1e-14):.17g}"
    lines[500] = " ".join(fields)
    (tmp_path / "uncontrolled-bicycle.txt").write_text("\n".join(lines) + "\n")
    found = module._score(tmp_path)
    assert found.passed is False
    assert "1.steer_rate: less exact than" in found.message


@pytest.mark.proof
def test_a_run_of_too_few_digits_is_seen(folder, monkeypatch):
    import heyoka_bike.reference.verification.numbers as rerun
    from heyoka_bike.motion.integrate import integrate

    monkeypatch.setattr(rerun, "integrate", lambda *a, **k: integrate(*a, **k, tolerance=1e-6))
    _, manifest, data = module._reference(folder)
    assert module._run(folder, manifest, data, "binary64").passed is False


@pytest.mark.parametrize("error", [ImportError("libx.so: cannot open"), RuntimeError("no CPU")])
def test_a_package_that_is_broken_is_said(quick, monkeypatch, capsys, error):
    def broken(name):
        if name in ("h5py", "heyoka"):
            raise error

    monkeypatch.setattr(module, "import_module", broken)
    assert main(["selfcheck", "--format", "json"]) == 3
    out, err = capsys.readouterr()
    report = json.loads(out)
    for name in ("h5py", "heyoka"):
        assert report["versions"][name].startswith(f"not usable: {type(error).__name__}: ")
    # heyoka may be missing, so only h5py is reported as an error, in one line.
    assert err.count("\n") == 1
    assert "h5py" in err


def test_without_heyoka_the_rest_works():
    code = "import sys; from heyoka_bike.cli import main; sys.exit(main(['selfcheck']))"
    run = python(code, {"heyoka", "llvmlite"})
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    assert "not installed" in run.stdout
    assert "not made: heyoka is not installed" in run.stdout
    assert run.stdout.count("heyoka_bike[generate]") >= 3
    assert "this installation works" in run.stdout


@pytest.mark.slow
def test_it_works_from_a_wheel_in_an_empty_folder(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation",
         "--no-index", "-w", str(tmp_path), str(ROOT)],
        check=True, timeout=300,
    )  # fmt: skip
    (wheel,) = tmp_path.glob("*.whl")
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as z:
        z.extractall(site)
    empty = tmp_path / "empty"
    empty.mkdir()
    for command in (["selfcheck", "--format", "json"], ["verify", "--format", "json"]):
        run = subprocess.run(
            [sys.executable, "-m", "heyoka_bike", *command], cwd=empty,
            env=os.environ | {"PYTHONPATH": str(site)}, capture_output=True, text=True, timeout=300,
        )  # fmt: skip
        assert run.returncode == 0, run.stderr
        report = json.loads(run.stdout)
        assert report["folder"] == str(site / "heyoka_bike" / "bundled" / "reference")
        assert report["passed"] is True
    assert list(empty.iterdir()) == []
