"""The README's block of output is what the command above it prints."""

import re
import shlex

import pytest

from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder

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
    table = shown[next(i for i, line in enumerate(shown) if line.startswith("correct digits")) :]
    places = [printed.index(line) for line in table]
    assert places == sorted(places)
    verdict = " ".join(shown[: shown.index(table[0])])
    assert " ".join(verdict.split()) in " ".join(" ".join(printed).split())
    assert (tmp_path / "report.html").exists()
