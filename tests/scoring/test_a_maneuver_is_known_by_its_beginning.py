"""The initial conditions identify the maneuver of a file that does not name it."""

import numpy as np
import pytest

from generators.mistaken_programs import correct
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.cli import main
from heyoka_bike.scoring.diagnosis.programs.program import changed, initial_state
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.scoring.evidence.as_compared import (
    ManeuverGuessed,
    ManeuverRecognised,
    OtherManeuver,
)
from heyoka_bike.scoring.reading.results import Results, Rows
from heyoka_bike.scoring.score import score

# For each of two wrong programs: the change of a parameter [SI]. The first one has a trail of 0.06
# m, the second one a light front wheel.
PROGRAMS = ({"c": -0.02}, {"IFxx": -0.07})
ANGLES = ("roll_angle", "steer_angle")
RATES = ("roll_rate", "steer_rate")
SPEED = ("roll_angle", "forward_speed")
ENERGIES = ("potential_energy", "kinetic_energy", "mechanical_energy")


@pytest.fixture(scope="module")
def wrong(reference):
    """Columns by program and maneuver. Each program has a wrong parameter."""
    asked = {}
    for i, change in enumerate(PROGRAMS):
        program = changed(correct(reference), change)
        for n in reference:
            start = initial_state(program.motion.bicycle, program.motion.starts[n])
            asked[i, n] = MotionRequest(program.motion.bicycle, start, reference[n].time)
    return dict(zip(asked, Simulator().run_all([*asked.values()]), strict=True))


def scored(reference, number, columns, keys, *, keep=slice(None), change=lambda k, x: x, told=None):
    m = reference[number]
    values = {key: np.array(change(key, columns[key][keep])) for key in keys}
    rows = Rows(told, m.time[keep], m.time_lo[keep], values)
    return score(Results("one.csv", "text", (rows,)), reference)


def taken(report):
    """Return the chosen maneuver. If it was guessed, the other possible maneuvers follow."""
    guessed = [x.may_be for x in report.seen if isinstance(x, ManeuverGuessed)]
    assert len(guessed) + sum(isinstance(x, ManeuverRecognised) for x in report.seen) == 1
    return report.maneuvers[0].maneuver, *guessed


@pytest.mark.parametrize("keys", [ANGLES, RATES, LATERAL], ids=["angles", "rates", "both"])
@pytest.mark.parametrize("program", range(len(PROGRAMS)))
def test_two_maneuvers_with_one_roll_rate_leave_a_guess(reference, wrong, program, keys):
    for n, other in ((1, 3), (3, 1)):
        assert taken(scored(reference, n, wrong[program, n], keys)) == (n, (other,))
    assert taken(scored(reference, 2, wrong[program, 2], keys)) == (2,)


@pytest.mark.parametrize(
    "keys", [SPEED, ENERGIES, BENCHMARK_COLUMNS], ids=["speed", "energies", "all"]
)
@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_speed_excludes_the_others(reference, wrong, n, keys):
    assert taken(scored(reference, n, wrong[0, n], keys)) == (n,)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_units_and_signs_are_free(reference, wrong, n):
    def other(key, x):
        factor = 3.6 if key == "forward_speed" else np.rad2deg(-1) if key in LATERAL else 1e-3
        return factor * x

    assert taken(scored(reference, n, wrong[0, n], BENCHMARK_COLUMNS, change=other)) == (n,)

    def spin(key, x):
        return x / 0.3 if key == "forward_speed" else x

    assert taken(scored(reference, n, wrong[0, n], SPEED, change=spin)) == (n,)


@pytest.mark.parametrize("n", [1, 3])
def test_an_encoder_and_noise_hide_the_beginning_only(reference, n):
    def coarse(_, x):
        return np.round(x / 0.002) * 0.002

    assert taken(scored(reference, n, reference[n], ANGLES, change=coarse))[0] == n
    noise = 1e-3 * np.random.default_rng(5).standard_normal(len(reference.times))
    assert taken(scored(reference, n, reference[n], ANGLES, change=lambda k, x: x + noise))[0] == n


@pytest.mark.parametrize("n", [1, 2, 3])
def test_right_columns_are_no_guess(reference, n):
    for keys in (ANGLES, RATES, ("steer_angle",), ("potential_energy",)):
        for keep in (slice(None), slice(None, None, 100), slice(150, None)):
            assert taken(scored(reference, n, reference[n], keys, keep=keep)) == (n,)


def test_a_clock_may_have_run_before(reference, wrong):
    m = reference[1]
    rows = Rows(None, m.time + 3.0, m.time_lo, {k: wrong[0, 1][k] for k in BENCHMARK_COLUMNS})
    assert taken(score(Results("one.csv", "text", (rows,)), reference))[0] == 1


def test_a_guess_is_said_with_the_way_to_choose(reference, wrong, tmp_path, capsys):
    path = tmp_path / "x.csv"
    table = np.column_stack([reference.times, *(wrong[0, 1][k] for k in RATES)])
    np.savetxt(path, table, delimiter=",", header="time,roll_rate,steer_rate", comments="")
    assert main(["score", str(path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "compared with maneuver 1, which is a guess: it may also be maneuver 3" in said
    assert "--maneuver N" in said
    assert main(["score", str(path), "--maneuver", "3"]) == 0
    assert "a guess" not in capsys.readouterr().out


def test_blocks_that_may_be_of_several_share_the_maneuvers(reference, wrong):
    """Blocks without names are assigned to different maneuvers."""
    order = (3, 2, 1)
    rows = [
        Rows(None, reference[n].time, reference[n].time_lo, {k: wrong[0, n][k] for k in RATES})
        for n in order
    ]
    report = score(Results("three.csv", "text", tuple(rows)), reference)
    assert [m.maneuver for m in report.maneuvers] == [1, 2, 3]
    for m in report.maneuvers:
        assert np.array_equal(m.part.values["roll_rate"], wrong[0, m.maneuver]["roll_rate"])


def test_wrong_motions_in_each_others_place_are_told(reference, wrong):
    parts = [
        Rows(
            n,
            reference[n].time,
            reference[n].time_lo,
            {k: wrong[0, of][k] for k in BENCHMARK_COLUMNS},
        )
        for n, of in ((1, 2), (2, 1), (3, 3))
    ]
    report = score(Results("x.csv", "text", tuple(parts)), reference)
    told = [(x.maneuver, x.nearest) for x in report.seen if isinstance(x, OtherManeuver)]
    assert told == [(1, 2), (2, 1)]
