"""``heyoka-bike score`` as a user runs it: formats, exit codes, requirements and refusals."""

import csv
import io
import json
import os
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder

PEERS = data_folder() / "peers"
FINE = str(PEERS / "exudyn-h0.001.txt")
COARSE = str(PEERS / "exudyn-h0.01.txt")


def run(*arguments, capsys):
    code = main(["score", *arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_the_table_is_the_default(capsys):
    code, out, err = run(FINE, capsys=capsys)
    assert (code, err) == (0, "")
    assert "exudyn-h0.001.txt" in out
    assert "tait_bryan_xyz" in out
    assert "next: run heyoka-bike diagnose" in out
    assert max(map(len, out.splitlines())) <= 100
    # The output is a summary of ten lines and a table. With --details it also lists the errors of
    # each maneuver.
    assert len(out.splitlines()) <= 25
    assert "mescd" not in out
    code, out, _ = run(FINE, "--details", capsys=capsys)
    assert code == 0
    assert out.count("mescd ") == 3


@pytest.mark.parametrize(
    ("name", "check"),
    [
        (
            "json",
            lambda text: json.loads(text)["maneuvers"][0]["columns"][0]["key"] == "roll_angle",
        ),
        ("csv", lambda text: len(list(csv.DictReader(io.StringIO(text)))) == 24),
        ("junit", lambda text: len(ET.fromstring(text).findall(".//testcase")) == 24),
        ("html", lambda text: text.startswith("<!DOCTYPE html>")),
        ("badge", lambda text: json.loads(text)["schemaVersion"] == 1),
    ],
)
def test_other_formats_go_to_standard_output(capsys, name, check):
    code, out, err = run(FINE, "--format", name, capsys=capsys)
    assert (code, err) == (0, "")
    assert check(out)


def test_several_formats_at_once(capsys, tmp_path):
    page, document = tmp_path / "new" / "report.html", tmp_path / "report.data"
    code, out, _ = run(
        FINE, "--format", "table", "--format", "json,html", "-o", str(page), "-o", str(document),
        capsys=capsys,
    )  # fmt: skip
    assert code == 0
    assert "maneuver 2" in " ".join(out.split())
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert json.loads(document.read_text())["passed"] is True


def test_the_suffix_of_an_output_tells_its_format(capsys, tmp_path):
    names = {"a.json": "{", "a.csv": "file,", "a.xml": "<?xml", "a.html": "<!DOCTYPE", "a.txt": ""}
    outputs = [x for name in names for x in ("-o", str(tmp_path / name))]
    code, out, _ = run(FINE, *outputs, capsys=capsys)
    assert code == 0
    for name, start in names.items():
        assert (tmp_path / name).read_text().startswith(start), name
    # The screen shows the same verdict. The written file adds details.
    verdict = out.partition("warnings")[0].partition("next:")[0].rstrip()
    assert len(verdict.splitlines()) > 10
    assert (tmp_path / "a.txt").read_text().startswith(verdict)


def test_requirements_set_the_exit_code(capsys):
    code, _, err = run(FINE, "--require", "scd >= 3", "--require", "2.performance < 1e-3",
                       capsys=capsys)  # fmt: skip
    assert (code, err) == (0, "")
    code, out, err = run(FINE, "--require", "scd >= 3", "--require", "scd >= 9", capsys=capsys)
    assert code == 3
    assert err.count("\n") == 1
    assert "required scd >= 9, found 3.6" in err
    assert "FAILED" in out


def test_a_series_shows_the_order_of_convergence(capsys):
    code, out, _ = run(COARSE, FINE, "--step", "0.01,0.001", "--cpu", "0.5,2", capsys=capsys)
    assert code == 0
    assert "order of convergence: 2.0" in out
    code, text, _ = run(str(PEERS / "exudyn.toml"), "--format", "json", capsys=capsys)
    document = json.loads(text)
    assert [r["step"] for r in document["runs"]] == [0.01, 0.001]
    assert document["passed"] is True


def test_runs_with_tolerances_are_not_asked_for_steps(capsys):
    code, out, _ = run(str(PEERS / "scipy.toml"), capsys=capsys)
    assert code == 0
    assert "--step" not in out


def test_rows_that_are_the_steps_make_runs_of_one_program(capsys, tmp_path):
    thin = tmp_path / "thin.txt"
    with open(FINE) as f:
        thin.write_text("".join(line for i, line in enumerate(f) if i % 2 == 0))
    code, out, _ = run(FINE, str(thin), "--step", "rows", "--format", "json", capsys=capsys)
    document = json.loads(out)
    assert code == 0
    assert document["is_one_program"] is True
    assert [r["step"] for r in document["runs"]] == pytest.approx([0.02, 0.01])


def test_several_files_are_programs_side_by_side(capsys, tmp_path):
    scipy = str(PEERS / "scipy-rtol1e-7.txt")
    outputs = [tmp_path / f"both.{suffix}" for suffix in ("json", "csv", "html")]
    given = [x for path in outputs for x in ("-o", str(path))]
    code, out, err = run(COARSE, scipy, "--name", "Exudyn, SciPy", *given, capsys=capsys)
    assert (code, err) == (0, "")
    assert out.startswith(
        "SciPy is the best of 2 programs: close; the worst column has 5.0 correct digits"
    )
    assert "--step" not in out
    assert "runs of one program" not in out
    document = json.loads(outputs[0].read_text())
    assert document["is_one_program"] is False
    # The runs are in the given order, and the definitions of each run are found independently.
    assert [r["name"] for r in document["runs"]] == ["Exudyn", "SciPy"]
    for path, entry in ((COARSE, document["runs"][0]), (scipy, document["runs"][1])):
        _, alone, _ = run(path, "--format", "json", capsys=capsys)
        assert entry["report"] == json.loads(alone)
    assert all(c["orders"] == [None] for c in document["convergence"])
    lines = list(csv.DictReader(io.StringIO(outputs[1].read_text())))
    assert [line["run_name"] for line in lines] == ["Exudyn"] * 24 + ["SciPy"] * 24
    assert "<h1>2 programs compared</h1>" in outputs[2].read_text()


def test_programs_have_their_files_names_unless_told(capsys, tmp_path):
    same = tmp_path / "exudyn-h0.01.txt"
    same.write_bytes((PEERS / "scipy-rtol1e-4.txt").read_bytes())
    _, out, _ = run(COARSE, str(same), FINE, "--format", "json", capsys=capsys)
    names = [r["name"] for r in json.loads(out)["runs"]]
    assert names == [COARSE, str(same), "exudyn-h0.001.txt"]
    _, out, _ = run(COARSE, COARSE, "--format", "json", capsys=capsys)
    assert [r["name"] for r in json.loads(out)["runs"]] == [f"{COARSE} (1)", f"{COARSE} (2)"]


def test_files_of_one_name_are_the_maneuvers_of_one_program(capsys, tmp_path):
    files = []
    for name, path in (("a", COARSE), ("b", FINE)):
        table = [line.split() for line in Path(path).read_text().splitlines()]
        for n in (1, 2, 3):
            file = tmp_path / f"{name}{n}.txt"
            file.write_text(
                "".join(" ".join([r[0], *r[8 * n - 7 : 8 * n + 1]]) + "\n" for r in table)
            )
            files.append(str(file))
    _, out, _ = run(*files[:3], "--format", "json", capsys=capsys)
    assert [m["maneuver"] for m in json.loads(out)["maneuvers"]] == [1, 2, 3]
    _, out, _ = run(*files, "--name", "A,A,A,B,B,B", "--format", "json", capsys=capsys)
    runs = json.loads(out)["runs"]
    assert [(r["name"], len(r["report"]["maneuvers"])) for r in runs] == [("A", 3), ("B", 3)]


def test_the_summary_takes_the_place_of_the_table(capsys, tmp_path):
    document = tmp_path / "a.json"
    code, out, err = run(COARSE, "--summary", "-o", str(document), "--require", "scd >= 3",
                         capsys=capsys)  # fmt: skip
    assert code == 3
    assert len(out.splitlines()) <= 10
    assert f"{COARSE}: wrong; the worst" in out.replace("\n", " ")
    assert "the requirement FAILED: scd >= 3, found 1.64" in out
    assert json.loads(document.read_text())["passed"] is False
    assert err.count("\n") == 1


def test_the_same_date_gives_the_same_page(capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "b").mkdir()
    for path in ("a.html", "b/a.html"):
        run(FINE, "-o", path, capsys=capsys)
    first, second = ((tmp_path / p).read_text() for p in ("a.html", "b/a.html"))
    assert "2023-11-14 22:13 UTC" in first
    assert f"heyoka-bike score {FINE} -o a.html" in first
    assert first == second.replace("b/a.html", "a.html")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700003600")
    run(FINE, "-o", "a.html", capsys=capsys)
    assert (tmp_path / "a.html").read_text() == first.replace("22:13 UTC", "23:13 UTC")


def test_standard_input_is_read(tmp_path):
    with open(FINE, "rb") as f:
        found = subprocess.run(
            [sys.executable, "-m", "heyoka_bike", "score", "-", "--format", "json"],
            stdin=f, capture_output=True, check=True, timeout=60,
        )  # fmt: skip
    assert json.loads(found.stdout)["file"]["path"] == "-"


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["nowhere.txt"], 1, "nowhere.txt"),
        ([FINE, "--format", "yaml"], 1, "expected one of table, json"),
        ([FINE, "--format", "json", "--format", "csv"], 1, "json and csv for standard output"),
        ([FINE, "-o", "report.pdf"], 1, "expected a name ending in"),
        ([FINE, "-o", FINE], 1, "is a result file to be scored"),
        ([FINE, "-o", "/proc/nowhere/report.html"], 1, "cannot be written"),
        ([FINE, "--require", "accuracy > 1"], 1, "expected one of scd"),
        ([FINE, "--maneuver", "4"], 1, "expected 1 to 3"),
        ([FINE, "--maneuver", "1,2"], 1, "found 2 numbers for 1 file, expected"),
        ([FINE, "--maneuver", "2"], 1, "contains maneuvers 1, 2, 3"),
        ([FINE, "--step", "0"], 1, "expected more than zero"),
        ([FINE, "--step", "fast"], 1, "--step: found"),
        ([FINE, "--step", "0.1,0.2"], 1, "step: found 2 values for 1 file, expected"),
        ([FINE, "--reference", "nowhere"], 1, "expected a folder written by"),
        ([FINE, "--summary", "--format", "json"], 1, "--summary and --format json"),
        ([FINE, COARSE, "--name", "A"], 1, "name: found 1 name for 2 files, expected"),
        ([FINE, COARSE, "--name", "A,"], 1, "name: found an empty name in 'A,'"),
        ([FINE, COARSE, "--name", "A,A"], 1, "found maneuver 1 twice"),
        ([FINE, COARSE, "--name", "A,B", "--step", "1,2"], 1, "name: found for runs of one"),
        (["-", "-"], 1, "standard input) more than once"),
        ([str(PEERS / "exudyn.toml"), FINE], 1, "only the list of runs"),
        ([str(PEERS / "exudyn.toml"), "--step", "1"], 1, "into the list"),
        ([str(PEERS / "README.md")], 1, "README.md"),
        ([], 1, "FILE"),
    ],
)
def test_bad_usage_is_one_line(capsys, arguments, code, says):
    try:
        found, out, err = run(*arguments, capsys=capsys)
    except SystemExit as refused:  # the parser raises it
        found, (out, err) = refused.code, capsys.readouterr()
    assert found == code, err
    assert err.count("\n") == 1
    assert says in err
    assert out == ""


def test_nothing_to_score_is_exit_code_2(capsys, tmp_path):
    late = tmp_path / "late.txt"
    late.write_text("".join(f"{20 + i} " + "1 " * 24 + "\n" for i in range(5)))
    code, out, err = run(str(late), capsys=capsys)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "found times from 20 to 24 s, expected times within 0 to 10 s" in err


def test_a_failed_write_leaves_the_old_file(capsys, tmp_path, monkeypatch):
    report = tmp_path / "report.json"
    report.write_text("old")
    monkeypatch.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left")))
    code, _, err = run(FINE, "-o", str(report), capsys=capsys)
    assert code == 1
    assert "cannot be written: No space left" in err
    assert report.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["report.json"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected one or more [[run]]"),
        ("[run]\nfile = 'a'\n", "expected [[run]]"),
        ("[[run]]\nstep = '0.1'\n", "expected one"),
        ("[[run]]\nfile = 'a'\nsteps = '0.1'\n", ": run 1: found unknown entry"),
        ("[[run]]\nfile = 'a'\nstep = -1\n", ": run 1, step: found"),
        ("[[run]]\nfile = 'a'\ncpu = 'long'\n", ": run 1, cpu: found"),
        ("[[run]]\nfile = 'a'\ncpu = true\n", ": run 1, cpu: found"),
        ("[[run]]\nfile = 7\n", ": run 1, file: found"),
    ],
)
def test_a_bad_list_of_runs_names_the_key(capsys, tmp_path, text, says):
    listing = tmp_path / "runs.toml"
    listing.write_text(text)
    code, out, err = run(str(listing), capsys=capsys)
    assert (code, out) == (1, "")
    assert err.count("\n") == 1
    assert says in err


def test_a_page_that_was_written_is_named_and_not_advised(capsys, tmp_path):
    _, out, _ = run(FINE, capsys=capsys)
    assert "-o report.html writes a report with charts" in out
    page = tmp_path / "mine.html"
    _, out, _ = run(FINE, "-o", str(page), capsys=capsys)
    assert "-o report.html" not in out
    assert f"written: {page}" in " ".join(out.split())


def test_a_file_whose_name_looks_like_an_option_is_told_about(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("-x.txt").write_text("1 2\n")
    with pytest.raises(SystemExit, match="1"):
        main(["score", "-x.txt"])
    assert "-x.txt is a file: write -- before it" in capsys.readouterr().err
    _, _, err = run("--", "-x.txt", capsys=capsys)
    assert "found 2 columns" in err


def test_a_name_gets_no_guess_from_its_ending(capsys, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,handlebarAngle,REQ_ROLL.ANGVEL,Rollwinkel\n0,1,2,3\n1,2,3,4\n")
    _, _, err = run(str(path), capsys=capsys)
    assert "'handlebarAngle', 'REQ_ROLL.ANGVEL', 'Rollwinkel' (roll_angle?)" in err


def test_what_is_to_be_copied_is_on_one_line(capsys, tmp_path):
    rows = np.loadtxt(FINE)[:, :9]
    order = [0, 3, 1, 2, 4, 5, 6, 7, 8]
    path = tmp_path / "other.txt"
    np.savetxt(path, rows[:, order], "%.17g")
    _, out, _ = run(str(path), "--details", capsys=capsys)
    told = {x.rstrip(".;") for x in out.split() if x.startswith("time,")}
    assert {x.count(",") for x in told} == {len(BENCHMARK_COLUMNS)}
    assert all(x.startswith("time,forward_speed,roll_angle,roll_rate,") for x in told)


def test_one_row_is_one_row(capsys, tmp_path):
    path = tmp_path / "one.txt"
    np.savetxt(path, np.loadtxt(FINE)[:1, :9], "%.17g")
    _, out, _ = run(str(path), "--maneuver", "1", "--details", capsys=capsys)
    assert " 1 row, " in out
    assert "1 rows" not in out


def test_a_pipe_that_stays_silent_is_told_about(capsys, tmp_path, monkeypatch):
    from heyoka_bike.commands import result_files

    monkeypatch.setattr(result_files, "_SECONDS_OF_SILENCE", 0.05)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    text = Path(FINE).read_text()

    def write():
        time.sleep(0.5)
        pipe.write_text(text)

    writer = threading.Thread(target=write)
    writer.start()
    code, _, err = run(str(pipe), "--summary", capsys=capsys)
    writer.join()
    assert code == 0
    assert err == f"heyoka-bike: still reading {pipe}, waiting for its end\n"
