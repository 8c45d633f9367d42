"""The correct motion with times shifted by a constant is recognised, and no other motion is."""

import numpy as np
import pytest

from generators.made_results import codes, made, smooth_error
from heyoka_bike.scoring.diagnosis.programs.program import Start, initial_state
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.rows.wrong_times import late_rows
from heyoka_bike.scoring.score import score
from heyoka_bike.system.resources import data_folder

PEERS = data_folder() / "peers"


def shifted(results, shift):
    parts = [
        Rows(r.maneuver, r.time + shift, r.time_lo, r.values, r.lo, r.quantum)
        for r in results.maneuvers
    ]
    return Results(results.path, results.format, tuple(parts), results.significant_digits)


@pytest.mark.parametrize(
    ("name", "shift"),
    [*(("scipy-rtol1e-7.txt", x) for x in (1.0, -0.05, 1 / 3)),
     *(("exudyn-h0.001.txt", x) for x in (-1.0, 0.37, 2.5))],
)  # fmt: skip
def test_the_constant_is_found(reference, name, shift):
    report = score(shifted(read_results(PEERS / name), shift), reference)
    (found,) = [f for f in report.findings if f.code == "time_shifted"]
    assert found.evidence["shift"] == pytest.approx(shift, abs=1e-3)
    assert ("too late" if shift > 0 else "too early") in found.message
    # A negative shift moves rows to before the start. These rows are left out, so the first
    # compared row is not the initial state.
    assert ("initial state" in found.message) == (shift > 0)


def test_a_decimal_is_told_as_it_is(reference):
    report = score(shifted(read_results(PEERS / "scipy-rtol1e-7.txt"), 1.0), reference)
    assert "All times are 1 s too late" in next(
        f.message for f in report.findings if f.code == "time_shifted"
    )


@pytest.mark.parametrize(
    "change",
    [
        lambda key, v, m: -v,
        lambda key, v, m: np.degrees(v) if "angle" in key else v,
    ],
    ids=["sign", "degrees"],
)
def test_signs_and_units_do_not_hide_it(reference, change):
    report = score(shifted(made(reference, change), 1.0), reference)
    assert "time_shifted" in codes(report)


def test_it_has_to_be_the_same_in_all_maneuvers(reference):
    parts = [shifted(made(reference), float(n)).maneuvers[n - 1] for n in reference]
    assert "time_shifted" not in codes(score(Results("x", "text", tuple(parts), 17), reference))


def test_a_motion_that_is_wrong_in_another_way_is_not_shifted(reference):
    def change(key, values, number):
        return values + smooth_error(reference, number, 0.5 * max(abs(values)))

    assert "time_shifted" not in codes(score(made(reference, change), reference))


def test_one_column_that_resembles_a_later_one_is_not_shifted(simulator, bicycle, reference):
    """The lean after other initial conditions resembles, to a few hundredths, the correct one a
    second later."""
    start = initial_state(bicycle, Start(4.0, 0.05))
    time = reference[1].time
    lean = simulator.run(bicycle, (start[0] + 0.01, *start[1:]), time)["roll_angle"]
    report = score({"time": time, "roll_angle": lean}, reference, maneuver=1)
    assert "time_shifted" not in codes(report)


def test_a_shift_of_one_row_is_left_to_the_diagnosis(reference):
    assert "time_shifted" not in codes(score(shifted(made(reference), 0.01), reference))


def test_the_diagnosis_goes_on_with_the_times_set_right(reference):
    report = score(shifted(made(reference), 1.0), reference)
    asked = late_rows(report).parts
    assert len(asked) == len(report.maneuvers)
    for part in asked:
        assert part.time[0] == 0.0
        assert np.max(np.abs(part.time - np.arange(len(part.time)) / 100)) < 1e-9
        expected = reference[part.number].rows["roll_angle"][: len(part.time)]
        assert np.max(np.abs(part.values["roll_angle"] - expected)) == 0.0
