"""A requirement covers all eight columns over the whole run, unless the user says that less is
enough.

The wrong columns here are the correct ones times a factor. A requirement on such a file must fail
even if the program does not understand the names of these columns, or sees no error in the rows.
"""

import csv
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

from generators.published_columns import published_columns, write_csv
from heyoka_bike import load_reference, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.requirements import parse

WITHOUT_ENERGIES = tuple(key for key in KEYS if "energy" not in key)


@cache
def right(number=2):
    return published_columns(load_reference(), number, every=10)


def some(*keys, number=2):
    return {key: right(number)[key] for key in ("time", *keys)}


def of_all(keys=KEYS, **fewer):
    """Return all maneuvers in one mapping; `fewer` sets the keys of some of them (m2=...)."""
    return {n: some(*fewer.get(f"m{n}", keys), number=n) for n in (1, 2, 3)}


ODD_NAMES = [
    # For each case: a name, the column that the name resembles, and the factor by which its values
    # differ from that column.
    ("bike.v", "forward_speed", 1.1), (".bicycle.speed.Q", "forward_speed", 1.1),
    ("Ground Speed [km/h]", "forward_speed", 1.1 * 3.6), ("roll\u02cdt(t)", "roll_rate", 1.5),
    ("Differential(t)(roll(t))", "roll_rate", 1.5), ("D(roll)", "roll_rate", 1.5),
    ("der_delta", "steer_rate", 1.5), ("roll_angel", "roll_angle", 1.1),
    ("steer_rte", "steer_rate", 1.1), ("kinetic_engery", "kinetic_energy", 1.01),
    ("d(steer)/dt", "steer_rate", 1.5), ("Derivative(phi(t), t)", "roll_rate", 1.5),
]  # fmt: skip


@pytest.mark.parametrize(("name", "key", "factor"), ODD_NAMES)
def test_a_wrong_column_of_an_odd_name_does_not_pass(name, key, factor, tmp_path, capsys):
    columns = some(*(k for k in WITHOUT_ENERGIES if k != key))
    path = write_csv(tmp_path / "a.csv", {**columns, name: factor * right()[key]})
    report = score(path, require="scd >= 6")
    assert not report.is_right
    assert "right, compared only in part" in report.verdict
    assert not report.passed
    count = len(columns) - 1
    assert main(["score", str(path), "--require", "scd >= 6"]) == 3
    said = capsys.readouterr().err
    assert f"found only {count} of 8 columns compared (maneuver 2)" in said
    assert f"add --require 'columns >= {count}'" in said


@pytest.mark.parametrize(("name", "key"), [x[:2] for x in ODD_NAMES if x[0] != "der_delta"])
def test_what_an_odd_name_may_mean_is_said(name, key, tmp_path):
    columns = some(*(k for k in WITHOUT_ENERGIES if k != key))
    report = score(write_csv(tmp_path / "a.csv", {**columns, name: right()[key]}))
    (found,) = [f for f in report.findings if f.code == "columns_not_understood"]
    assert f"'{name}' was not understood; did you mean {key}? " in found.message
    assert found.evidence["columns"] == [key]


def test_a_misspelt_name_is_said_beside_the_right_one(tmp_path):
    columns = {**right(), "roll_angel": 1.1 * right()["roll_angle"]}
    report = score(write_csv(tmp_path / "a.csv", columns), require="scd >= 6")
    assert report.passed
    assert report.is_right
    said = [f.message for f in report.findings if f.code == "columns_not_understood"]
    assert ["did you mean roll_angle?" in x for x in said] == [True]


def test_a_column_with_a_meaning_of_its_own_is_not_said(tmp_path):
    columns = {**right(), "roll_angle_setpoint": np.zeros(101), "wheel_speed": np.ones(101)}
    report = score(write_csv(tmp_path / "a.csv", columns), require="scd >= 6")
    assert report.is_right
    assert "columns_not_understood" not in [f.code for f in report.findings]


def test_a_constant_energy_proves_no_motion(tmp_path):
    columns = some("mechanical_energy")
    report = score(write_csv(tmp_path / "a.csv", columns), require="scd >= 6", maneuver=2)
    assert not report.is_right
    assert "compared only in part (1 of 8 columns" in report.verdict
    assert not report.passed


@pytest.mark.parametrize("rows", [[0, 100], [0, 50, 100], range(0, 101, 10), range(10), range(11)])
def test_few_rows_may_be_those_at_which_a_wrong_motion_is_right(rows, tmp_path):
    columns = {key: x[list(rows)] for key, x in right().items()}
    report = score(write_csv(tmp_path / "a.csv", columns), require=["scd >= 6"], maneuver=2)
    assert not report.is_right
    assert not report.passed
    assert "% of the run compared" in report.requirements[0].message
    covered = report[2].coverage
    assert score(write_csv(tmp_path / "a.csv", columns), maneuver=2,
                 require=["scd >= 6", f"coverage >= {covered}"]).passed  # fmt: skip


@pytest.mark.parametrize("text", [
    "scd >= 1", "max_abs_error < 1e9", "gap <= 10", "2.scd >= 1", "roll_angle.scd >= 6",
    "2.roll_angle.max_abs_error < 1e-6", "coverage >= 1",
])  # fmt: skip
@pytest.mark.parametrize(("enough", "is_met"), [
    ([], False), (["columns >= 5"], True), (["columns > 4"], True), (["2.columns >= 5"], True),
    (["columns <= 8"], False), (["1.columns >= 5"], False), (["coverage >= 0.5"], False),
])  # fmt: skip
def test_fewer_columns_are_enough_where_that_is_said(text, enough, is_met):
    """A `columns` or `coverage` limit applies to all requirements given with it, in any order, and
    to requirements on one column."""
    for asked in ([text, *enough], [*enough, text]):
        found = score(some(*WITHOUT_ENERGIES), require=asked, maneuver=2).requirements
        assert next(r for r in found if r.text == text).met is is_met


def test_more_columns_than_there_are_are_not_met():
    report = score(some(*WITHOUT_ENERGIES), require=["columns >= 6", "columns >= 5"], maneuver=2)
    assert [(r.met, r.found) for r in report.requirements] == [(False, 5), (True, 5)]


def test_every_maneuver_of_the_file_counts():
    results = of_all(m2=WITHOUT_ENERGIES)
    report = score(results, require=["scd >= 6", "1.scd >= 6", "2.scd >= 6"])
    assert [r.met for r in report.requirements] == [False, True, False]
    assert not report.is_right
    assert "compared only in part (5 of 8 columns in maneuver 2)" in report.verdict
    assert "(maneuver 2)" in report.requirements[0].message
    assert score(results, require=["scd >= 6", "2.columns >= 5"]).passed
    assert not score(results, require=["scd >= 6", "1.columns >= 5"]).passed


def test_one_whole_maneuver_is_whole():
    report = score(right(), require="scd >= 6", maneuver=2)
    assert report.is_right
    assert report.passed


def test_columns_and_run_may_both_be_short():
    columns = {key: x[:51] for key, x in some(*WITHOUT_ENERGIES).items()}
    report = score(columns, require="scd >= 6", maneuver=2)
    assert report.requirements[0].message == (
        "only 5 of 8 columns and 50 % of the run compared (maneuver 2); if that is intended, add "
        "--require 'columns >= 5' --require 'coverage >= 0.5'"
    )
    enough = report.requirements[0].outcome.enough
    assert score(columns, require=["scd >= 6", *enough], maneuver=2).passed
    for one in enough:
        assert not score(columns, require=["scd >= 6", one], maneuver=2).passed


def test_a_wrong_value_is_said_before_what_is_missing():
    columns = some(*WITHOUT_ENERGIES) | {"roll_angle": 1.3 * right()["roll_angle"]}
    (r,) = score(columns, require="scd >= 6", maneuver=2).requirements
    assert not r.met
    assert r.message.startswith("0.5")


def test_columns_of_the_whole_motion_are_none_of_the_eight(tmp_path):
    m = load_reference()[2]
    yaw = {"time": m.time, "yaw": m["yaw"]}
    report = score(write_csv(tmp_path / "a.csv", yaw), require="yaw.scd >= 6", maneuver=2)
    assert not report.passed
    assert "only 0 of 8 columns" in report.requirements[0].message
    assert score(tmp_path / "a.csv", require=["yaw.scd >= 6", "columns >= 0"], maneuver=2).passed


def test_every_format_says_so(tmp_path):
    report = score(some(*WITHOUT_ENERGIES), maneuver=2)
    said = report.to_dict()
    assert (said["is_right"], said["is_whole"]) == (False, False)
    assert said["maneuvers"][0]["column_count"] == 5
    for suffix in ("xml", "html", "csv"):
        report.save(tmp_path / f"r.{suffix}")
    suite = ElementTree.parse(tmp_path / "r.xml").getroot().find("testsuite")
    assert (suite.get("tests"), suite.get("skipped")) == ("8", "3")
    assert "compared only in part (5 of 8 columns" in (tmp_path / "r.html").read_text("utf-8")
    rows = csv.DictReader((tmp_path / "r.csv").read_text("utf-8").splitlines())
    (counts,) = {row["column_count"] for row in rows}
    assert counts == "5"


def test_a_short_run_passes_no_case_of_junit(tmp_path):
    score({key: x[:51] for key, x in right().items()}, maneuver=2).save(tmp_path / "r.xml")
    suite = ElementTree.parse(tmp_path / "r.xml").getroot().find("testsuite")
    assert (suite.get("tests"), suite.get("skipped")) == ("8", "8")


def test_a_column_has_no_number_of_columns():
    with pytest.raises(InputError, match="of a whole maneuver"):
        parse("roll_angle.columns >= 1")
