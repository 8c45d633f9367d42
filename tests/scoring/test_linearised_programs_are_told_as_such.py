"""Programs of the linearised equations are recognised. SciPy runs them with published matrices."""

from dataclasses import replace

import numpy as np
import pytest

from generators.linear_programs import LATERAL, linear_run, run
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.programs.linear_motion import linear_columns
from heyoka_bike.scoring.score import score
from support.said import said_of


def said(results, reference, simulator):
    found = explain(align(results, reference).parts, reference, simulator=simulator)
    return said_of(found, score(results, reference))


@pytest.mark.proof
@pytest.mark.parametrize("number", [1, 2, 3])
def test_linear_motions_agree_with_scipy(reference, bicycle, number):
    speed, y = run(reference, number, "DOP853", 1e-12)
    start = (0.0, 0.0, 0.0, y[2, 0], 0.0, speed)
    found = linear_columns(bicycle, start, reference[number].time)
    for key, values in zip(LATERAL, y, strict=True):
        # The difference is SciPy's tolerance of 1e-12, amplified over ten seconds by the unstable
        # maneuver 1.
        assert np.max(np.abs(found[key] - values)) < 1e-9 * np.max(np.abs(values))


@pytest.mark.parametrize(
    "energies",
    [
        pytest.param("second order", marks=pytest.mark.proof),
        pytest.param("zero", marks=pytest.mark.slow),
    ],
)
def test_a_linear_program_is_told_as_such(reference, simulator, energies):
    (only,) = said(linear_run(reference, energies=energies), reference, simulator)
    assert only.code == "linearised"
    assert "linearised equations" in only.message
    assert "No other error is visible. Not compared: potential_energy" in only.message


@pytest.mark.proof
@pytest.mark.parametrize("number", [1, 3])
def test_one_maneuver_of_default_tolerance_is_enough(reference, simulator, number):
    whole = linear_run(reference, "RK45", 1e-3)
    one = replace(whole, maneuvers=(whole.maneuvers[number - 1],))
    (only,) = said(one, reference, simulator)
    assert only.code == "linearised"
    # The linear program was run with a tolerance of 1e-3, which shows as an additional error.
    assert f"of maneuver {number} and less in roll and steer elsewhere" in only.message
    assert "Nothing else" not in only.message


@pytest.mark.proof
def test_units_are_those_beside_the_linear_motion(reference, simulator):
    """Maneuver 1 is so far from the nonlinear motion that radians fit it no worse than degrees."""
    whole = linear_run(reference, energies="none")
    (rows,) = (m for m in whole.maneuvers if m.maneuver == 1)
    lateral = {key: np.rad2deg(rows.values[key]) for key in ("roll_angle", "steer_angle")}
    one = replace(whole, maneuvers=(replace(rows, values=lateral),))
    taken = {c.as_understood.unit for c in score(one, reference).maneuvers[0].columns if c.values}
    assert taken == {"rad"}
    linear, units = said(one, reference, simulator)
    assert linear.code == "linearised"
    assert units.code == "units_beside"
    assert units.evidence["units"] == dict.fromkeys(("roll_angle", "steer_angle"), "degree")
