"""`is_right` follows the verdict, not the requirements; initial conditions alone are not a correct
result."""

import numpy as np
import pytest

from games.files import in_memory
from games.wrong_files import KINDS, wrong_file
from generators.made_results import made
from heyoka_bike.errors import BicycleError
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.showing.formats.output import render


def test_a_right_file_is_right_and_a_wrong_one_is_not(reference):
    right = score(made(reference), reference)
    assert (right.is_right, right.to_dict()["is_right"]) == (True, True)
    assert ": right; " in right.verdict
    wrong = score(made(reference, lambda k, v, n: 1.01 * v if k == "steer_rate" else v), reference)
    # Every file passes if there is no requirement.
    assert (wrong.passed, wrong.is_right, wrong.to_dict()["is_right"]) == (True, False, False)
    assert ": wrong; " in wrong.verdict


def test_one_value_that_is_missing_keeps_a_file_from_being_whole(reference):
    def gap(key, values, number):
        if (number, key) == (3, "kinetic_energy"):
            values[500] = np.nan
        return values

    assert score(made(reference), reference).is_whole
    report = score(made(reference, gap), reference)
    assert not report.is_whole
    assert not report.is_right


def test_six_digits_are_right_and_five_are_close(reference):
    def off(digits):
        def change(key, values, number):
            wave = np.max(np.abs(values)) * np.sin(np.linspace(0.0, 9.0, len(values)))
            return values + 10.0**-digits * wave

        return score(made(reference, change), reference)

    assert off(6.1).is_right
    assert not off(5.1).is_right
    assert ": close; " in off(5.1).verdict


def test_few_digits_cannot_be_right_and_are_not_called_wrong(reference, tmp_path):
    """With four decimals the report does not comment on what they cannot show."""
    rows = reference[2].rows
    table = np.column_stack([reference[2].time, rows["roll_angle"], rows["steer_angle"]])
    np.savetxt(tmp_path / "a.csv", table, "%.4f", ",", header="t,phi,delta", comments="")
    require = ["scd >= 3", "scd >= 6", "columns >= 2"]
    report = score(tmp_path / "a.csv", reference, require, maneuver=2)
    assert report.worst.scd < 4
    assert ": undecided because of rounding, compared only in part (2 of 8" in report.verdict
    assert not report.is_right
    assert [r.met for r in report.requirements] == [True, False, True]


def test_a_wrong_motion_is_wrong_with_few_digits_too(reference, tmp_path):
    rows = reference[2].rows
    table = np.column_stack([reference[2].time, 1.01 * rows["roll_angle"], rows["steer_angle"]])
    np.savetxt(tmp_path / "a.csv", table, "%.4f", ",", header="t,phi,delta", comments="")
    assert ": wrong; " in score(tmp_path / "a.csv", reference, maneuver=2).verdict


def test_signs_that_contradict_each_other_are_not_right(reference):
    turned = made(reference, lambda k, v, n: -v if k == "roll_rate" else v)
    report = score(turned, reference)
    assert not report.is_right
    assert ": wrong, " in report.verdict
    assert "to test this, add" not in render(report, "summary")
    assert {c.key for c in report[1].columns if c.is_contradicted} == {"roll_angle", "roll_rate"}
    left = made(reference, lambda k, v, n: -v if k.startswith(("roll", "steer")) else v)
    assert score(left, reference).is_right


def test_half_a_run_is_right_as_far_as_it_goes(reference, tmp_path):
    rows = [f"{t},{x:.17g}" for t, x in zip(range(6), reference[2].rows["roll_angle"][:600:100],
                                            strict=True)]  # fmt: skip
    (tmp_path / "half.csv").write_text("\n".join(["t,phi", *rows]))
    report = score(tmp_path / "half.csv", reference, maneuver=2)
    assert "right" in report.verdict
    assert "compared only in part" in report.verdict
    assert not report.is_right


@pytest.mark.parametrize("count", [1, 20])
def test_the_start_alone_is_called_so_first(reference, tmp_path, count):
    """The file has one row at t = 0, or a clock that does not advance."""
    (tmp_path / "start.csv").write_text("\n".join(["t phi p v", *["0 0 0.5 4.6"] * count, ""]))
    columns = "time,roll_angle,roll_rate,forward_speed"
    report = score(tmp_path / "start.csv", reference, maneuver=2, columns=columns.split(","))
    said = report.verdict.partition(": ")[2]
    # The values 0.5 and 4.6 in the file are exactly those of the benchmark's initial conditions.
    start = "only the start of the motion, which the benchmark gives, is undecided"
    assert said.startswith(start)
    assert not report.is_right


def test_a_wrong_start_is_wrong(reference, tmp_path):
    (tmp_path / "start.csv").write_text("t,phi,v\n0,0,4.7\n")
    assert ": wrong; " in score(tmp_path / "start.csv", reference, maneuver=2).verdict


@pytest.mark.parametrize("count", range(3))
@pytest.mark.parametrize("kind", [
    "times_of_one_decimal", "digits_of_every_second_row", "rows_where_rounding_is_right",
    "rows_at_whole_numbers", "another_column_beside", "signs_against_each_other",
])  # fmt: skip
def test_nothing_says_that_a_wrong_file_is_right(reference, tmp_path, kind, count):
    """No verdict, summary, requirement, JSON, JUnit or table calls a wrong file correct."""
    wrong = wrong_file(1, list(KINDS).index(kind) + count * len(KINDS))
    file = tmp_path / "file.csv"
    file.write_text(wrong.text or "")
    if wrong.text:
        try:
            results = read_results(file)
            report = score(results, reference, wrong.fails)
        except BicycleError:
            return
    else:
        report = score(in_memory(wrong.parts), reference, wrong.fails)
    assert not report.is_right
    assert not any(r.met for r in report.requirements)
    assert "to test this, add" not in render(report, "summary")
    first = " ".join(render(report, "summary").partition(": ")[2].split())
    assert not first.startswith("right") or "compared only in part" in first
    changed = [c for m in report.maneuvers for c in m.columns if c.key in wrong.keys]
    assert report.not_compared or not all(c.is_right for c in changed)
    assert report.to_dict()["grade"] != "right" or not report.to_dict()["is_whole"]


def test_a_time_shows_nothing_but_its_decimal(reference, tmp_path):
    """The times have one decimal and uneven steps. The motion is wrong, but right within rounded
    times."""
    wrong = wrong_file(1, list(KINDS).index("times_of_one_decimal"))
    (tmp_path / "file.csv").write_text(wrong.text)
    report = score(tmp_path / "file.csv", reference)
    assert ": wrong; " in report.verdict


def test_cases_of_junit_pass_if_their_column_is_right(reference):
    wrong = made(reference, lambda k, v, n: 1.01 * v if k == "steer_rate" else v)
    text = render(score(wrong, reference), "junit")
    assert text.count("<skipped ") == 3
    assert "nothing is required: wrong" in text
    assert "<skipped " not in render(score(made(reference), reference), "junit")
