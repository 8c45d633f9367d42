"""A submission is one archive: the text, the form's two numbers, and the true digits."""

from io import BytesIO
from zipfile import ZipFile

import numpy as np
import pytest

import heyoka_bike as hb
from heyoka_bike.cli import main
from heyoka_bike.system.resources import data_folder

FILE = data_folder() / "peers" / "exudyn-h0.001.txt"
GIVEN = ["--program", "Mine 1.0", "--cpu", "0.8", "--machine", "a computer"]


def packed(path):
    with ZipFile(BytesIO(path.read_bytes())) as archive:
        return {name: archive.read(name).decode() for name in archive.namelist()}


def test_the_archive_has_what_the_form_asks_for(tmp_path, capsys):
    path = tmp_path / "a.zip"
    assert main(["submit", str(FILE), *GIVEN, "-o", str(path)]) == 0
    files = packed(path)
    assert list(files) == ["results.txt", "submission.txt", "report.html"]
    np.testing.assert_array_equal(np.loadtxt(files["results.txt"].splitlines()), np.loadtxt(FILE))
    report = hb.score(FILE)
    said = files["submission.txt"]
    assert f"eq. (1) of maneuver 2: {report[2].performance:.4g} %" in said
    assert "processor time: 0.8 s" in said
    assert "machine: a computer" in said
    for number, maneuver in report.items():
        assert f"maneuver {number}: {maneuver.worst.scd:.1f} ({maneuver.worst.column})" in said
    assert files["report.html"].lower().startswith("<!doctype html>")
    assert said in capsys.readouterr().out


def test_named_columns_in_any_order_become_the_25(tmp_path):
    table = np.loadtxt(FILE)
    shuffled = np.roll(np.arange(25), 7)
    names = [
        "time",
        *(f"m{n}_{key}" for n in (1, 2, 3) for key in hb.load_reference()[1].columns[:8]),
    ]
    path = tmp_path / "mine.csv"
    header = ",".join(names[i] for i in shuffled)
    np.savetxt(path, table[:, shuffled], "%.17g", ",", header=header, comments="")
    assert main(["submit", str(path), *GIVEN, "-o", str(tmp_path / "a.zip")]) == 0
    made = np.loadtxt(packed(tmp_path / "a.zip")["results.txt"].splitlines())
    np.testing.assert_array_equal(made, table)


def test_a_result_beyond_the_limit_is_packed_and_told(tmp_path, capsys):
    table = np.loadtxt(FILE)
    table[:, 9 + 5] += 0.1 * np.arange(len(table)) / len(table)
    np.savetxt(tmp_path / "far.txt", table, "%.17g")
    path = tmp_path / "a.zip"
    assert main(["submit", str(tmp_path / "far.txt"), *GIVEN, "-o", str(path)]) == 3
    assert path.exists()
    assert "is not below 1e-3 %" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t[:, :9], "found maneuvers [1], expected all of [1, 2, 3]"),
        (lambda t: t * np.where(np.arange(25) % 8 == 7, 180 / np.pi, 1.0),
         "found steer_angle in degree, expected rad"),
    ],
)  # fmt: skip
def test_what_is_no_submission_is_refused_in_one_line(tmp_path, capsys, change, said):
    np.savetxt(tmp_path / "a.txt", change(np.loadtxt(FILE)), "%.17g")
    path = tmp_path / "a.zip"
    assert main(["submit", str(tmp_path / "a.txt"), *GIVEN, "-o", str(path)]) == 1
    found = capsys.readouterr().err
    assert said in found
    assert found.count("\n") == 1
    assert not path.exists()
