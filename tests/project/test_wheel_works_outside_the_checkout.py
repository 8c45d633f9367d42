"""A built wheel, unpacked in a temporary folder, has all it needs."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

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


def test_wheel(tmp_path, reference):
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation",
         "--no-index", "-w", str(tmp_path), str(ROOT)],
        check=True, timeout=300,
    )  # fmt: skip
    (wheel,) = tmp_path.glob("*.whl")
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as z:
        z.extractall(site)
    environment = os.environ | {"PYTHONPATH": str(site)}
    run = subprocess.run(
        [sys.executable, "-c", CODE], cwd=tmp_path, env=environment,
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert float(run.stdout) == reference[1].rows.hi["roll_angle"][-1]
    bundled = site / "heyoka_bike" / "bundled" / "reference"
    published = ROOT / "reference"
    for path in (p for p in published.rglob("*") if p.is_file()):
        assert (bundled / path.relative_to(published)).read_bytes() == path.read_bytes()
