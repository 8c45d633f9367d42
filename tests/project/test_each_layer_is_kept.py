"""The package keeps each contract of import-linter, and one wrong import breaks it."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# For each contract: a package, and a module that the contract forbids it to import.
WRONG = {
    "Each wing uses only those below it": ("numbers", "heyoka_bike.scoring"),
    "Inside the workbench": ("workbench/fast", "heyoka_bike.workbench.bench"),
    "Inside the reference": ("reference/proof", "heyoka_bike.reference.verification"),
    "Inside scoring": ("scoring/reading", "heyoka_bike.scoring.diagnosis"),
    "Inside showing": ("showing/formats", "heyoka_bike.showing.views"),
    "Inside a bicycle": ("bicycle/equations", "heyoka_bike.bicycle.stability"),
    "Reading a reference, scoring and its reports need NumPy and h5py only": (
        "showing/formats", "rich",
    ),
    "heyoka is used through its adapter": ("workbench/atlas", "heyoka"),
    # Mistakes are applied to programs, so a program must not import the mistakes.
    "No circles anywhere": (
        "scoring/diagnosis/programs", "heyoka_bike.scoring.diagnosis.mistakes",
    ),
}  # fmt: skip


@pytest.fixture
def copy(tmp_path):
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    ignored = shutil.ignore_patterns("__pycache__")
    return shutil.copytree(ROOT / "heyoka_bike", tmp_path / "heyoka_bike", ignore=ignored)


def verdicts(package):
    """Return KEPT or BROKEN for each contract."""
    code = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    run = subprocess.run(
        [sys.executable, "-c", code, "--no-cache"], cwd=package.parent, capture_output=True,
        env=os.environ | {"COLUMNS": "200"}, text=True, timeout=300,
    )  # fmt: skip
    found = dict(re.findall(r"^(.+?) (KEPT|BROKEN)(?: \(.*\))?$", run.stdout, re.M))
    assert (run.returncode == 0) == (set(found.values()) == {"KEPT"}), run.stdout + run.stderr
    return found


def test_the_package_keeps_every_contract(copy):
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    names = {c["name"] for c in contracts["contracts"]}
    assert verdicts(copy) == dict.fromkeys(names, "KEPT")
    assert set(WRONG) == names


@pytest.mark.parametrize("contract", WRONG)
def test_a_wrong_import_breaks_it(copy, contract):
    package, name = WRONG[contract]
    with (copy / package / "__init__.py").open("a") as f:
        f.write(f"\nimport {name}\n")
    assert verdicts(copy)[contract] == "BROKEN"
