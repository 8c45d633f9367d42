"""A wrong column that is not one of the benchmark's is never called correct, and plain errors are
named."""

import numpy as np
import pytest

from heyoka_bike.cli import main
from heyoka_bike.scoring.diagnosis.wrong_columns import faults_in_other_columns
from heyoka_bike.scoring.score import score
from heyoka_bike.showing.wording import finding_text

HEADINGS = {
    "roll_angle": "phi", "steer_angle": "delta", "yaw": "psi", "yaw_rate": "yaw_rate",
    "pitch": "pitch",
}  # fmt: skip


def beside(report):
    """The findings on columns that are not the benchmark's."""
    return finding_text.findings(faults_in_other_columns(report))


def report_of(reference, tmp_path, numbers=(2,), keys=("yaw",), **changes):
    """Score files with a time, roll, steer and the columns `keys`, of 15 digits, with `changes`
    applied."""
    files = {}
    for n in numbers:
        rows = reference[n].rows
        every = ("roll_angle", "steer_angle", *keys)
        changed = [changes.get(key, lambda x: x)(rows[key]) for key in every]
        columns = [reference[n].time, *changed]
        head = ",".join(["t", *(HEADINGS[key] for key in every)])
        files[n] = tmp_path / f"m{n}.csv"
        table = np.column_stack(columns)
        np.savetxt(files[n], table, fmt="%.15g", delimiter=",", header=head, comments="")
    return score(files, reference)


@pytest.mark.parametrize(
    ("change", "evidence", "said"),
    [
        (lambda x: 1.1 * x, {"factor": 1.1, "offset": 0.0}, "is 1.1 times the exact value, "),
        (lambda x: 2 * x - 0.5, {"factor": 2.0, "offset": -0.5},
         "is 2 times the exact value minus 0.5 rad, "),
        (lambda x: 0 * x, {"constant": [0.0]}, "is 0 rad in every row, "),
        (lambda x: 0 * x + 0.1, {"constant": [0.1]}, "is 0.1 rad in every row, "),
    ],
)  # fmt: skip
def test_one_number_that_explains_a_column_is_found(reference, tmp_path, change, evidence, said):
    (found,) = beside(report_of(reference, tmp_path, yaw=change))
    assert found.code == "column_beside"
    assert {key: found.evidence[key] for key in evidence} == {
        key: pytest.approx(value, abs=1e-12) for key, value in evidence.items()
    }
    assert said in found.message


def test_a_constant_is_found_in_a_column_that_has_a_zero(reference, tmp_path):
    (found,) = beside(report_of(reference, tmp_path, keys=("pitch",), pitch=lambda x: x + 0.25))
    assert found.evidence["factor"] == 1.0
    assert found.evidence["offset"] == pytest.approx(0.25, abs=1e-12)
    assert "is the exact value plus 0.25 rad, " in found.message
    assert beside(report_of(reference, tmp_path, yaw=lambda x: x + 0.25)) == ()


def test_a_factor_is_the_same_in_all_maneuvers(reference, tmp_path):
    (found,) = beside(report_of(reference, tmp_path, (1, 2, 3), yaw=lambda x: 1.1 * x))
    assert found.evidence["maneuvers"] == [1, 2, 3]
    assert found.evidence["factor"] == pytest.approx(1.1)
    factors = iter((1.1, 1.2, 1.3))
    (other,) = beside(report_of(reference, tmp_path, (1, 2, 3), yaw=lambda x: next(factors) * x))
    assert "factor" not in other.evidence


def test_what_one_number_does_not_explain_is_wrong_all_the_same(reference, tmp_path):
    (found,) = beside(report_of(reference, tmp_path, yaw=lambda x: x + 0.1 * x**2))
    assert found.code == "column_beside"
    assert "Neither a factor nor an offset explains it" in found.message


def test_right_columns_are_not_mentioned(reference, tmp_path):
    keys = ("yaw", "yaw_rate")
    assert beside(report_of(reference, tmp_path, keys=keys)) == ()
    (found,) = beside(report_of(reference, tmp_path, keys=keys, yaw=lambda x: 1.1 * x))
    assert found.evidence["column"] == "yaw"


def test_a_factor_beside_a_wrong_motion_is_not_explained(reference, tmp_path):
    """If roll is wrong too, a factor in the yaw angle is no evidence."""
    wrong = report_of(
        reference, tmp_path, yaw=lambda x: 1.1 * x, roll_angle=lambda x: x + 0.1 * np.sin(80 * x)
    )
    (found,) = beside(wrong)
    assert (found.code, found.evidence) == ("not_diagnosed", {"columns": ["yaw"]})


@pytest.mark.proof
def test_a_diagnosis_does_not_contradict_its_verdict(reference, tmp_path, capsys):
    report_of(reference, tmp_path, yaw=lambda x: 1.1 * x)
    assert main(["diagnose", str(tmp_path / "m2.csv")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    for said in (
        "wrong; the worst column has 1.0 correct digits (yaw in maneuver 2)",
        "yaw of maneuver 2 is 1.1 times the exact value",
        "roll_angle, steer_angle: each is as exact as the digits written allow",
    ):
        assert said in out
