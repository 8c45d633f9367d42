"""A built wheel contains all its files, and requires all packages except those of
the integrator."""

import os
import subprocess
import sys
import zipfile
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement

pytestmark = pytest.mark.proof

ROOT = Path(__file__).resolve().parents[2]
FILE = "heyoka_bike/bundled/data/peers/exudyn-h0.01.txt"

SMALL = "a small set"

CODE = """
import sys
import heyoka_bike
assert "site" in heyoka_bike.__file__, heyoka_bike.__file__
from heyoka_bike import load_reference, read_bicycle, read_maneuvers
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers
print(load_reference()[1].evaluate("10")["roll_angle"])
assert len(read_maneuvers(benchmark_maneuvers())) == 3
assert read_bicycle(benchmark_bicycle()).name
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with the unpacked wheel and the packages that it requires."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation",
         "--no-index", "-w", str(folder), str(ROOT)],
        check=True, timeout=300,
    )  # fmt: skip
    (wheel,) = folder.glob("*.whl")
    site = folder / "site"
    with zipfile.ZipFile(wheel) as z:
        z.extractall(site)
    (metadata,) = site.glob("*.dist-info/METADATA")
    lines = metadata.read_text(encoding="utf-8").splitlines()
    link([x.split(":", 1)[1] for x in lines if x.startswith("Requires-Dist:")], site)
    return site


def link(requirements, site):
    """Link installed packages, and those that they require, into a folder."""
    for text in requirements:
        required = Requirement(text)
        if required.marker is None or required.marker.evaluate({"extra": ""}):
            found = distribution(required.name)
            for top in {file.parts[0] for file in found.files or () if file.parts[0] != ".."}:
                if top != "__pycache__" and not (site / top).exists():
                    (site / top).symlink_to(found.locate_file(top))
            link(found.requires or (), site)


def run(site, *arguments):
    """Run Python with only the standard library and this folder, from another working directory."""
    folder = site.parent / "elsewhere"
    folder.mkdir(exist_ok=True)
    return subprocess.run(
        [sys.executable, "-S", *arguments], cwd=folder, capture_output=True, text=True,
        timeout=300, env=os.environ | {"PYTHONPATH": str(site)},
    )  # fmt: skip


def command(site, *arguments):
    return run(site, "-m", "heyoka_bike", *arguments)


def test_the_reference_comes_with_it(site, reference):
    found = run(site, "-c", CODE)
    assert found.returncode == 0, found.stderr
    assert float(found.stdout) == reference[1].rows.hi["roll_angle"][-1]
    bundled = site / "heyoka_bike" / "bundled" / "reference"
    published = ROOT / "reference"
    for path in (p for p in published.rglob("*") if p.is_file()):
        assert (bundled / path.relative_to(published)).read_bytes() == path.read_bytes()


def test_it_scores_and_says_what_it_cannot(site):
    assert not any((site / name).exists() for name in ("heyoka", "llvmlite", "scipy"))
    scored = command(site, "score", str(site / FILE))
    assert scored.returncode == 0, scored.stderr
    assert "wrong; the worst column has 1.6 correct digits" in " ".join(scored.stdout.split())
    refused = command(site, "generate")
    assert refused.returncode == 1
    assert refused.stdout == ""
    assert refused.stderr == (
        "heyoka-bike: heyoka is not installed; integration needs it (pip install "
        "'heyoka_bike[generate]' on Linux, or conda install heyoka.py)\n"
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        # The dataset in the wheel equals the dataset of the checkout, byte by byte. A small dataset
        # is used here to save time.
        (["verify", SMALL], "0 failed"),
        (["linear"], "6.02426201538836"),
        (["animate", "-o", "replay.html"], "replay.html"),
        (["export", "--format", "csv"], ".csv"),
        (["selfcheck"], "this installation works"),
    ],
)
def test_all_that_integrates_nothing_works(site, small_set, arguments, said):
    found = command(site, *(small_set if x is SMALL else x for x in arguments))
    assert found.returncode == 0, found.stderr
    assert found.stderr == ""
    assert said in found.stdout
