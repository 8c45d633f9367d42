"""The README shows the output of its commands, and its numbers are those of the code."""

import re
import shlex

import pytest

from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder

ROOT = data_folder().parent
README = ROOT / "README.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def blocks():
    return BLOCK.findall(README.read_text(encoding="utf-8"))


def test_the_scored_tables_are_printed_by_the_command_above_them(
    blocks, capsys, monkeypatch, tmp_path
):
    at = next(i for i, (kind, _) in enumerate(blocks) if kind == "text")
    command = shlex.split(blocks[at - 1][1].rpartition(" && ")[2])
    assert command[:2] == ["heyoka-bike", "score"]
    arguments = [str(ROOT / a) if a.startswith("data/") else a for a in command[1:]]
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 0
    printed = capsys.readouterr().out.replace(f"{ROOT}/", "").splitlines()
    shown = [line for line in blocks[at][1].splitlines() if line and line != "..."]
    assert len(shown) > 20
    # Here the path of the file is longer than in the README, so the verdict is wrapped differently.
    # Only the table is compared.
    table = shown[next(i for i, line in enumerate(shown) if line.startswith("correct digits")) :]
    after = 0
    for line in table:
        after = printed.index(line, after) + 1
    verdict = " ".join(shown[: shown.index(table[0])])
    assert " ".join(verdict.split()) in " ".join(" ".join(printed).split())
    assert (tmp_path / "report.html").exists()


def test_the_time_of_making_the_reference_is_the_measured_one():
    text = README.read_text(encoding="utf-8")
    page = (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    measured = re.search(r"generate-wall: begin -->\n(\d+ s)\n", page)[1]
    assert f"It took {measured} on two cores" in text
