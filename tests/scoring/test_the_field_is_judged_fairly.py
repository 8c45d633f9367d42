"""Files of the compared programs get fair diagnoses; each of these once got a wrong one."""

from pathlib import Path

import pytest

from heyoka_bike.scoring.diagnosis import numerical
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.wrong_columns import columns_apart
from heyoka_bike.scoring.findings import Severity
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.showing.wording import finding_text
from heyoka_bike.system.resources import data_folder

JUDGED = Path(__file__).parent / "judged"


def results(name):
    return read_results(data_folder() / "results" / f"{name}.txt.gz")


def test_errors_of_roll_and_steer_alone_are_of_the_motion(reference):
    """In nearly straight riding the errors of speed and energies are a thousand times smaller."""
    read = read_results(JUDGED / "exudyn-trapezoidal.txt.gz")
    assert columns_apart(score(read, reference)) is None


def test_single_precision_is_no_cause_of_what_a_tolerance_does(reference):
    """Diffrax's Dopri5 with rtol = atol = 1e-5 has an error of 1.4e-3 in binary32 and 2.3e-3 in
    binary64."""
    read = read_results(JUDGED / "diffrax-default.txt.gz")
    *others, single = finding_text.findings(numerical.causes(score(read, reference)))
    assert (single.code, single.severity) == ("single_precision", Severity.INFO)
    assert "look for another cause first" in single.message
    assert others


@pytest.mark.proof
def test_a_start_that_the_first_row_contradicts_is_no_input(reference):
    """The program solves its equations by LU with pivots down to 1e-12, so the energy jumps after
    the first row."""
    found, *_ = diagnose(results("pydy-default"), reference).diagnosis
    assert found.code == "parameters"
    assert "But the first row has forward_speed of maneuver 1 as given" in found.message
    assert "Check this parameter" not in found.message


@pytest.mark.proof
def test_what_has_nothing_of_the_motion_left_has_no_direction(reference):
    said = diagnose(results("ode-default"), reference).diagnosis
    assert [f.code for f in said] == ["no_mistake_found", "too_far"]
