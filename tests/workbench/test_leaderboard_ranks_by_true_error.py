"""The leaderboard ranks by true error only; a submission that breaks a rule is rejected."""

import gzip
import hashlib
import json
import os
import shutil
from dataclasses import replace

import pytest

from generators.submissions import RESULTS, SCIPY, copied
from heyoka_bike.__main__ import main
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.system.parallel import using
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.leaderboard import ranking
from heyoka_bike.workbench.leaderboard.document import diagnosis
from heyoka_bike.workbench.leaderboard.ranking import (
    PROBLEMS,
    RankedProblem,
    leaderboard,
    read_submission,
)


@pytest.fixture
def folder(tmp_path):
    """A folder with two of the published submissions; SciPy's is the better one."""
    return copied(tmp_path / "results")


def entry(folder, change=lambda text: text, file=None, name="another"):
    """Add a submission: SciPy's with changed text, and optionally another file."""
    text = (RESULTS / SCIPY).read_text()
    if file is not None:
        before = read_submission(RESULTS / SCIPY).files[0]
        text = text.replace(before.path.name, file.name)
        text = text.replace(before.sha256, hashlib.sha256(file.read_bytes()).hexdigest())
    path = folder / f"{name}.toml"
    path.write_text(change(text))
    return path


@pytest.mark.parametrize("of", ["two", pytest.param("all", marks=pytest.mark.proof)])
def test_published_submissions_are_ranked_as_score_sees_them(folder, capsys, of):
    submissions = RESULTS if of == "all" else folder
    assert main(["leaderboard", str(submissions), "--format", "json"]) == 0
    board = json.loads(capsys.readouterr().out)
    assert board["refused"] == []
    (h1,) = (p for p in board["problems"] if p["problem"] == "H1")
    assert len(h1["entries"]) >= 2
    digits = [e["scd"] for e in h1["entries"]]
    assert digits == sorted(digits, reverse=True)
    for e in h1["entries"]:
        file = read_submission(RESULTS / e["source"]).files[0]
        report = score(read_results(file.path))
        worst = min(
            c.as_understood.measures.scd for m in report.maneuvers for c in m.columns
        )  # fmt: skip
        assert e["scd"] == worst
        assert e["grade"] == max((g for g in (3, 6, 9, 12) if g <= worst), default=None)


def test_a_time_that_is_claimed_ranks_nothing(folder):
    entry(folder, lambda text: text.replace('"0.058"', '"1e-9"').replace("SciPy DOP853", "A lie"))
    first, second, *_ = leaderboard(folder, [load_reference()]).entries["H1"]
    assert (first.submission.name[:5], second.submission.name[:5]) == ("A lie", "SciPy")
    assert first.digits == second.digits  # equal digits are sorted by name, not by time


REFUSED = {
    "another file than was hashed": (
        lambda text: text.replace('sha256 = "', 'sha256 = "0').replace('5"\n', '"\n'), "sha256"),
    "a path out of the folder": (
        lambda text: text.replace('path = "', 'path = "../'), "below the folder"),
    "an absolute path": (lambda text: text.replace('path = "', 'path = "/'), "below the folder"),
    "no licence": (
        lambda text: "\n".join(x for x in text.splitlines() if "licence" not in x), "licence"),
    "a slip": (lambda text: text.replace("tolerance", "tolernace"), "tolerance"),
    "no step": (
        lambda text: "\n".join(x for x in text.splitlines() if "tolerance" not in x), "neither"),
    "a time below zero": (lambda text: text.replace('"0.058"', '"-1"'), "more than zero"),
    "another problem": (lambda text: text.replace('"H1"', '"H9"'), "H3a"),
    "a problem without its set": (lambda text: text.replace('"H1"', '"H2"'), "--reference"),
    "one maneuver": (lambda text: text + "maneuver = 2\n", "maneuver"),
    "no TOML": (lambda _: "name", "TOML"),
}  # fmt: skip


def test_what_breaks_a_rule_is_one_line_and_stops_nothing(folder, capsys):
    for what, (change, _) in REFUSED.items():
        entry(folder, change, name=what)
    assert main(["leaderboard", str(folder), "--format", "json"]) == 3
    out, err = capsys.readouterr()
    for what, line in zip(sorted(REFUSED), err.splitlines(), strict=True):
        assert any(name in line for name in (f"{what}.toml", "scipy-rtol1e-10.txt.gz"))
        assert REFUSED[what][1] in line
    assert len(json.loads(out)["problems"][0]["entries"]) == 2


def turned(row):
    """Flip the signs of a row's roll rates, but not of its roll angles."""
    values = row.split()
    for i in (2, 10, 18):
        values[i] = repr(-float(values[i]))
    return " ".join(values)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda rows: rows[:900], "900 rows"),
        (lambda rows: [*rows[:5], rows[5].replace(rows[5].split()[3], "nan", 1), *rows[6:]],
         "a number in every row"),
        (lambda rows: [turned(row) for row in rows], "contradictory signs"),
        (lambda rows: [*rows[:5], "0.051 " + rows[5].split(" ", 1)[1], *rows[6:]], "row 5"),
        (lambda rows: [*rows, *(f"{10 + i} " + rows[i].split(" ", 1)[1] for i in range(1, 100))],
         "99 rows outside the run"),
    ],
)  # fmt: skip
def test_every_row_and_value_is_asked_for(folder, capsys, change, word):
    whole = gzip.decompress((RESULTS / "scipy-rtol1e-10.txt.gz").read_bytes()).decode()
    file = folder / "short.txt"
    file.write_text("\n".join(change(whole.splitlines())) + "\n")
    entry(folder, file=file)
    assert main(["leaderboard", str(folder), "--format", "json"]) == 3
    assert word in capsys.readouterr().err


def test_the_page_escapes_what_a_submission_says(folder, tmp_path):
    entry(folder, lambda text: text.replace("SciPy DOP853 on", "<script>alert(1)</script>"))
    page = tmp_path / "board.html"
    assert main(["leaderboard", str(folder), "-o", str(page)]) == 0
    text = page.read_text()
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text


def test_bad_folders_and_outputs_are_one_line(tmp_path, capsys):
    for words in ([str(tmp_path)], [str(tmp_path / "none")], [str(RESULTS), "-o", "x.txt"]):
        assert main(["leaderboard", *words]) == 1
        assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(SystemExit, match="1"):
        main(["leaderboard", str(RESULTS), "--format", "csv"])
    assert "found 'csv', expected one of table, json, html" in capsys.readouterr().err


def test_every_problem_has_its_inputs():
    for problem in PROBLEMS.values():
        for kind, name in zip(("bicycles", "maneuvers"), problem.inputs, strict=True):
            assert (data_folder() / kind / f"{name}.toml").is_file()


def test_the_table_is_narrow_and_the_page_draws_every_place(folder, capsys, tmp_path):
    name = "a program whose name and settings are told at length, " * 5
    entry(folder, lambda text: text.replace("SciPy DOP853 on", name))
    assert main(["leaderboard", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100
    assert "eq. (1)" in "".join(lines)
    assert " ".join(name.split()[:4]) in "".join(lines)
    page = tmp_path / "board.html"
    assert main(["leaderboard", str(folder), "-o", str(page)]) == 0
    text = page.read_text()
    assert [f"<title>{place}. " in text for place in (1, 2, 3)] == [True, False, True]
    assert text.count("<circle") == 3


def test_what_goes_wrong_is_said_where_it_is_asked_for(folder, monkeypatch, capsys):
    first = json.loads(board(folder, capsys))["problems"][0]["entries"][0]
    assert first["diagnosis"] is None
    monkeypatch.setattr(ranking, "diagnosed_elsewhere", told)
    with using(workers=1):
        found = leaderboard(folder, [load_reference()], is_diagnosed=True).entries["H1"]
    assert [diagnosis(e) for e in found] == ["it is wrong in maneuver 1"] * 2


def board(folder, capsys):
    assert main(["leaderboard", str(folder), "--format", "json"]) == 0
    return capsys.readouterr().out


def told(report, reference, *_):
    """Return a report with a diagnosis whose first finding is that no usual mistake fits."""
    nothing = Finding("no_mistake_found", "none of them", Severity.INFO)
    number = min(reference)
    return replace(
        report,
        diagnosis=(nothing, Finding("other", f"it is wrong in maneuver {number}", Severity.INFO)),
    )


@pytest.mark.proof
def test_each_problem_has_a_table_of_its_own(folder, tmp_path, monkeypatch, capsys):
    """A small dataset replaces H4: another bicycle, one short maneuver."""
    pytest.importorskip("heyoka")
    maneuvers = tmp_path / "m.toml"
    maneuvers.write_text(
        'name = "small"\n[[maneuver]]\nname = "p"\nspeed = "6"\nroll_rate = "0.5"\n'
        'duration = "0.1"\nspacing = "0.01"\n'
    )
    sets = tmp_path / "set"
    inputs = ["--bicycle", "browser-jason", "--maneuvers", str(maneuvers)]
    assert main(["generate", *inputs, "--out", str(sets)]) == 0
    monkeypatch.setitem(PROBLEMS, "H4", RankedProblem(("browser-jason", str(maneuvers))))
    shutil.copy(sets / "uncontrolled-bicycle.txt", folder / "small.txt")
    entry(folder, lambda text: text.replace('"H1"', '"H4"'), file=folder / "small.txt")
    capsys.readouterr()
    assert main(["leaderboard", str(folder), "--reference", str(sets)]) == 0
    lines = capsys.readouterr().out.splitlines()
    titles = [line.strip() for line in lines if line.strip() in PROBLEMS]
    assert titles == ["H1", "H4"]
    page = tmp_path / "board.html"
    assert main(["leaderboard", str(folder), "--reference", str(sets), "-o", str(page)]) == 0
    assert [f'id="{p}"' in page.read_text() for p in ("H1", "H2", "H4")] == [True, False, True]
    # Without its dataset, the submission for H4 is rejected. The submission for H1 remains valid.
    assert main(["leaderboard", str(folder)]) == 3
    assert "problem H4 without its dataset" in capsys.readouterr().err


@pytest.mark.timeout(60)
@pytest.mark.skipif(os.name != "posix", reason="pipes have names on POSIX")
def test_a_pipe_or_a_file_elsewhere_is_refused(folder, capsys):
    """Opening a pipe would wait for a writer, and a link would reveal the hash of any file."""
    file = read_submission(folder / SCIPY).files[0].path
    kept = folder.parent / "elsewhere.gz"
    file.rename(kept)
    for make, said in (
        (lambda: os.mkfifo(file), "it is a pipe, expected a regular file"),
        (lambda: file.symlink_to(kept), "it is a link to a file outside the folder"),
        (lambda: file.symlink_to("/dev/zero"), "it is a link to a file outside the folder"),
    ):
        make()
        assert main(["leaderboard", str(folder)]) == 3
        (line,) = capsys.readouterr().err.splitlines()
        assert said in line
        assert file.name in line
        file.unlink()
