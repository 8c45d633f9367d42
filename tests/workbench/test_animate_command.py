"""`heyoka-bike animate` writes a page, or reports in one line why it cannot."""

import json
import re
import sys

import numpy as np
import pytest

from heyoka_bike.cli import main
from heyoka_bike.errors import Exit
from heyoka_bike.system.resources import data_folder

RESULT = str(data_folder() / "peers" / "scipy-rtol1e-4.txt")


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def maneuvers(path):
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'id="data">\n(.*?)\n<', text, re.S)[1])["maneuvers"]


def test_a_page_of_the_reference(tmp_path, monkeypatch, capsys):
    for package in ("heyoka", "matplotlib", "scipy"):
        monkeypatch.setitem(sys.modules, package, None)
    assert main(["animate"]) == Exit.OK
    assert capsys.readouterr().out == "uncontrolled-bicycle.html\n"
    found = maneuvers(tmp_path / "uncontrolled-bicycle.html")
    assert [m["number"] for m in found] == [1, 2, 3]
    assert [p.name for p in tmp_path.iterdir()] == ["uncontrolled-bicycle.html"]


def test_a_result_and_one_maneuver(tmp_path, capsys):
    assert main(["animate", RESULT, "--maneuver", "2", "-o", "new/two.htm"]) == Exit.OK
    assert capsys.readouterr().out == "new/two.htm\n"
    (found,) = maneuvers(tmp_path / "new" / "two.htm")
    assert found["number"] == 2
    assert max(map(abs, found["result"]["differences"]["roll"])) > 1e-7


def test_nine_columns_are_of_the_maneuver_told(tmp_path):
    table = np.loadtxt(RESULT)
    np.savetxt("nine.txt", table[:, [0, *range(17, 25)]], fmt="%.15g")
    assert main(["animate", "nine.txt", "--maneuver", "3", "-o", "a.html"]) == Exit.OK
    assert main(["animate", "nine.txt", "-o", "b.html"]) == Exit.OK
    assert maneuvers(tmp_path / "a.html")[0]["result"] is not None
    assert [m["result"] is None for m in maneuvers(tmp_path / "b.html")] == [True, True, False]


def test_the_same_file_again(tmp_path):
    for name in ("a.html", "b.html"):
        assert main(["animate", RESULT, "-o", name]) == Exit.OK
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (
            ["-o", "x.webm"],
            1,
            "--output: found 'x.webm', expected a name ending in .html or .htm",
        ),
        (["-o", "x.gif"], 1, "--output: found 'x.gif', expected a name ending in .html or .htm: a"),
        (["-o", "x.mp4"], 1, "--output: found 'x.mp4', expected a name ending in .html or .htm: a"),
        (["--maneuver", "4"], 1, "--maneuver: found '4', expected 1 to 3"),
        (["no.txt"], 1, "no.txt: cannot be read"),
        (["--reference", "nowhere"], 1, "nowhere: no manifest.json found"),
        (["-o", "file/x.html"], 1, "file/x.html: cannot be written: File exists"),
        (["file.html", "-o", "file.html"], 1, "file.html: is a result file to be scored"),
        (["one.txt", "--maneuver", "2"], 2, "one.txt: found"),
    ],
)
def test_bad_input_gives_one_line(tmp_path, capsys, arguments, code, message):
    for name in ("file", "file.html"):
        (tmp_path / name).write_text("in the way")
    table = np.loadtxt(RESULT)
    np.savetxt("one.txt", table[:1, :9] + np.r_[20, np.zeros(8)])
    before = sorted(p.name for p in tmp_path.iterdir())
    assert main(["animate", *arguments]) == code
    error = capsys.readouterr().err
    assert error.startswith(f"heyoka-bike: {message}")
    assert error.count("\n") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == before
