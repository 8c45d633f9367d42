"""`is_right` follows the verdict, whatever is required, and a start alone is no right result."""

import numpy as np
import pytest
from support.made_results import made

from heyoka_bike.scoring.score import score


def test_a_right_file_is_right_and_a_wrong_one_is_not(reference):
    right = score(made(reference), reference)
    assert (right.is_right, right.to_dict()["is_right"]) == (True, True)
    assert ": right, " in right.verdict
    wrong = score(made(reference, lambda k, v, n: 1.01 * v if k == "steer_rate" else v), reference)
    # Nothing is required, and everything of that is met.
    assert (wrong.passed, wrong.is_right, wrong.to_dict()["is_right"]) == (True, False, False)
    assert ": wrong, " in wrong.verdict


def test_six_digits_are_right_and_five_are_close(reference):
    def off(digits):
        def change(key, values, number):
            wave = np.max(np.abs(values)) * np.sin(np.linspace(0.0, 9.0, len(values)))
            return values + 10.0**-digits * wave if key == "roll_rate" else values

        return score(made(reference, change), reference)

    assert off(6.1).is_right
    assert not off(5.1).is_right
    assert ": close, " in off(5.1).verdict


def test_digits_written_are_enough(reference, tmp_path):
    rows = reference[2].rows
    table = np.column_stack([reference[2].time, rows["roll_angle"], rows["steer_angle"]])
    np.savetxt(tmp_path / "a.csv", table, "%.4f", ",", header="t,phi,delta", comments="")
    report = score(tmp_path / "a.csv", reference, maneuver=2)
    assert report.worst.scd < 4
    assert report.is_right


def test_signs_that_contradict_each_other_are_not_right(reference):
    turned = made(reference, lambda k, v, n: -v if k == "roll_rate" else v)
    assert not score(turned, reference).is_right
    left = made(reference, lambda k, v, n: -v if k.startswith(("roll", "steer")) else v)
    assert score(left, reference).is_right


def test_half_a_run_is_right_as_far_as_it_goes(reference, tmp_path):
    rows = [f"{t},{x:.17g}" for t, x in zip(range(6), reference[2].rows["roll_angle"][:600:100],
                                            strict=True)]  # fmt: skip
    (tmp_path / "half.csv").write_text("\n".join(["t,phi", *rows]))
    report = score(tmp_path / "half.csv", reference, maneuver=2)
    assert "right" in report.verdict
    assert "as far as it goes" in report.verdict
    assert not report.is_right


@pytest.mark.parametrize("count", [1, 20])
def test_the_start_alone_is_called_so_first(reference, tmp_path, count):
    """One row at t = 0, or a clock that was never moved."""
    (tmp_path / "start.csv").write_text("\n".join(["t phi p v", *["0 0 0.5 4.6"] * count, ""]))
    columns = "time,roll_angle,roll_rate,forward_speed"
    report = score(tmp_path / "start.csv", reference, maneuver=2, columns=columns.split(","))
    said = report.verdict.partition(": ")[2]
    assert said.startswith("only the start is there, which the benchmark gives: right")
    assert not report.is_right


def test_a_wrong_start_is_wrong(reference, tmp_path):
    (tmp_path / "start.csv").write_text("t,phi,v\n0,0,4.7\n")
    assert ": wrong, " in score(tmp_path / "start.csv", reference, maneuver=2).verdict
