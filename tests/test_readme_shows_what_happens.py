"""The README's blocks of output are what its commands print, and its Python runs."""

import re
import shlex

import pytest

from heyoka_bike.cli import main
from heyoka_bike.resources import data_folder

README = data_folder().parent / "README.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def blocks():
    return BLOCK.findall(README.read_text())


def test_the_scored_table_is_printed_by_the_command_above_it(blocks, capsys, monkeypatch, tmp_path):
    at = next(i for i, (kind, _) in enumerate(blocks) if kind == "text")
    command = shlex.split(blocks[at - 1][1])
    assert command[:2] == [".venv/bin/heyoka-bike", "score"]
    arguments = [str(README.parent / a) if a.startswith("data/") else a for a in command[1:]]
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 0
    printed = capsys.readouterr().out.replace(f"{README.parent}/", "").splitlines()
    shown = [line for line in blocks[at][1].splitlines() if line and line != "..."]
    assert len(shown) > 10
    # The verdict is wrapped elsewhere when the path is longer.
    table = shown[next(i for i, line in enumerate(shown) if line.startswith("maneuver")) :]
    places = [printed.index(line) for line in table]
    assert places == sorted(places)
    verdict = " ".join(shown[: shown.index(table[0])])
    assert " ".join(verdict.split()) in " ".join(" ".join(printed).split())
    assert (tmp_path / "report.html").exists()


def test_the_diagnosis_is_what_the_command_above_it_says(blocks, capsys):
    at = [i for i, (kind, _) in enumerate(blocks) if kind == "text"][1]
    command = shlex.split(blocks[at - 1][1])
    assert command[:2] == [".venv/bin/heyoka-bike", "diagnose"]
    assert main([command[1], str(README.parent / command[2])]) == 0
    said = " ".join(capsys.readouterr().out.split())
    shown = " ".join(blocks[at][1].replace("...", "").split())
    assert len(shown) > 100
    assert shown in said


def test_the_python_runs(blocks, monkeypatch):
    monkeypatch.chdir(README.parent)
    for _, code in (b for b in blocks if b[0] == "python"):
        exec(compile(code, "README.md", "exec"), {})
