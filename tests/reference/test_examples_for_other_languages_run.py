"""docs/examples and the hooks run and pass, and fail if their bicycle is wrong."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder
from support.export_programs import STEM, export, need

ROOT = data_folder().parent
EXAMPLES = ROOT / "docs" / "examples"
COARSE = ROOT / "data" / "peers" / "exudyn-h0.01.txt"


@pytest.fixture
def shell(tmp_path, monkeypatch):
    """Runs lines of shell in a folder, with heyoka-bike on the PATH."""
    tool = tmp_path / "bin" / "heyoka-bike"
    tool.parent.mkdir()
    tool.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m heyoka_bike "$@"\n')
    tool.chmod(0o755)

    def run(lines, folder, **environment):
        path = f"{tool.parent}{os.pathsep}{os.environ['PATH']}"
        return subprocess.run(
            ["bash", "-e", "-c", lines], cwd=folder, env=os.environ | {"PATH": path} | environment,
            capture_output=True, text=True, timeout=300,
        )  # fmt: skip

    return run


def copied(name, tmp_path, old="", new=""):
    """Copy an example, with a piece of its code changed."""
    folder = tmp_path / f"copy{'-changed' if new else ''}"
    shutil.copytree(EXAMPLES / name, folder)
    if new:
        (changed,) = [p for p in folder.iterdir() if old in p.read_text()]
        changed.write_text(changed.read_text().replace(old, new))
    return folder


def commands(path):
    """Return the commands in the opening comment of a file, which are indented."""
    comment = re.match(r"([#%!].*\n)+", path.read_text())[0]
    return "".join(re.findall(r"^[#%!]   (.*\n)", comment, re.MULTILINE))


# An error of one percent in every value must fail the requirement scd >= 6.
@pytest.mark.proof
@pytest.mark.parametrize(
    ("name", "starter", "tools", "old", "new"),
    [
        ("ctest", "CMakeLists.txt", ("cmake", "ctest", "gcc", "g++"),
         "bicycle_evaluate(maneuver, i, t)", "1.01 * bicycle_evaluate(maneuver, i, t)"),
        ("fortran", "my_bicycle.f90", ("gfortran",),
         "= bicycle_evaluate(", "= 1.01*bicycle_evaluate("),
        ("octave", "score_my_bicycle.m", ("octave-cli",),
         "= uncontrolled_bicycle(", "= 1.01 * uncontrolled_bicycle("),
    ],
)  # fmt: skip
def test_an_example_passes_and_fails_as_it_should(name, starter, tools, old, new, shell, tmp_path):
    for tool in tools:
        need(tool)
    folder = copied(name, tmp_path)
    lines = commands(folder / starter)
    assert "heyoka-bike" in (folder / starter).read_text()
    done = shell(lines, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    (results,) = folder.rglob("results.txt")
    assert main(["score", str(results), "--require", "scd >= 13"]) == 0
    done = shell(lines, copied(name, tmp_path, old, new))
    assert done.returncode != 0
    assert "required scd >= 6, found" in done.stdout + done.stderr


def test_the_action_runs(shell, tmp_path):
    action = yaml.safe_load((EXAMPLES / "github-action" / "action.yml").read_text())
    assert set(action) == {"name", "description", "inputs", "runs"}
    assert action["runs"]["using"] == "composite"
    assert all(set(x) <= {"description", "required", "default"} for x in action["inputs"].values())
    steps = action["runs"]["steps"]
    for step in steps:
        # A step that runs commands needs a shell. A step that uses another action has no shell.
        assert ("uses" in step) != ({"run", "shell"} <= set(step))
    (install,) = [s for s in steps if "pip install" in s.get("run", "")]
    assert install["env"] == {"PACKAGE": "${{ inputs.package }}"}
    (step,) = [s for s in steps if "heyoka-bike" in s.get("run", "")]
    given = {"results": str(COARSE), "require": "scd >= 1", "junit": "report.xml"}
    environment = {}
    for variable, text in step["env"].items():
        wanted = re.fullmatch(r"\$\{\{ inputs\.(\w+) \}\}", text)[1]
        assert wanted in action["inputs"]
        environment[variable] = given[wanted]
    done = shell(step["run"], tmp_path, **environment)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "report.xml").read_text().startswith("<?xml")
    # The default requirement and the names of files are treated as text, and the shell does not
    # interpret them.
    default = action["inputs"]["require"]["default"]
    done = shell(step["run"], tmp_path, **environment | {"REQUIRE": default})
    assert done.returncode == 3
    done = shell(step["run"], tmp_path, **environment | {"RESULTS": "$(touch made).txt"})
    assert done.returncode == 1
    assert not (tmp_path / "made").exists()


def test_the_hook_scores_the_files_it_is_given(tmp_path):
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert {"id", "name", "entry", "language"} <= set(hook)
    assert set(hook) <= {
        "id", "name", "entry", "language", "description", "args", "files", "require_serial",
        "language_version",
    }  # fmt: skip
    assert hook["id"] == "heyoka-bike-score"
    program, *arguments = shlex.split(hook["entry"])
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    assert program in scripts
    for name, matches in (
        ("bicycle.txt", True), ("out/bicycle-2.h5", True), ("my_bicycle.txt", False),
        ("bicycle.py", False), ("bicycle/readme.txt", False),
    ):  # fmt: skip
        assert bool(re.search(hook["files"], name)) == matches, name
    export(tmp_path, "csv")
    good = str(tmp_path / f"{STEM}.csv")
    assert main([*arguments, *hook["args"], good]) == 0
    assert main([*arguments, *hook["args"], good, str(COARSE)]) == 3


def test_the_commands_of_the_page_work(tmp_path, monkeypatch):
    page = (ROOT / "docs" / "any-language.md").read_text()
    blocks = re.findall(r"^```sh\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines()]
    assert len(lines) == 4
    monkeypatch.chdir(tmp_path)
    export(Path("results.csv"), "csv")
    Path("results.csv").rename("results.txt")
    for line in lines:
        words = shlex.split(line)
        arguments = words[words.index("heyoka-bike") + 1 :]
        assert main(arguments) == 0, line
    for code in re.findall(r"^\| (\d+) \|", page, re.MULTILINE):
        assert code in "01234"
    for link in re.findall(r"\]\((examples/[\w-]+)\)", page):
        assert (ROOT / "docs" / link).is_dir()


def test_the_compile_lines_of_the_page_work(tmp_path):
    page = (ROOT / "docs" / "any-language.md").read_text()
    lines = re.findall(r"`((?:cc|gfortran) [^`]*)`", page)
    assert [line.split()[0] for line in lines] == ["cc", "cc", "gfortran"]
    for kind in ("c", "fortran"):
        export(tmp_path, kind)
    (tmp_path / "your-code.c").write_text(
        f'#include "{STEM}.h"\nint main(void) {{ return bicycle_evaluate(1, 0, -1) < 0; }}\n'
    )
    (tmp_path / "your-code.f90").write_text(f"use {STEM}\nend\n")
    for line in lines:
        need(line.split()[0])
        subprocess.run(shlex.split(line), cwd=tmp_path, check=True, timeout=120)
    assert (tmp_path / "libbicycle.so").exists()
