"""An energy may have any zero, and a column may follow an unknown definition.

Neither is an error, and neither excuses one: such files are correct only as far as they show it.
"""

import numpy as np
import pytest

from generators.made_results import codes, is_right_in_part, made
from generators.simulated_tables import simulated
from heyoka_bike import diagnose, score
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.programs.program import Motion, Program, Start
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator

ZEROED = ("potential_energy", "mechanical_energy")
SPEEDS = ("rear_com_global_x", "rear_com_body_x", "rear_com_heading", "rear_com_norm")


def columns(reference, number=2, **changed):
    m = reference[number]
    found = {name: m[name] for name in reference[1].columns[:8]}
    return {"time": m.time, **{k: v for k, v in {**found, **changed}.items() if v is not None}}


@pytest.mark.parametrize("zero", [-794.1195, -20.0, -0.3, 20.0, 100.0, 5000.0])
def test_any_constant_is_a_zero(reference, zero):
    report = score(made(reference, lambda k, v, n: v + zero * (k in ZEROED)), reference)
    assert report.is_right
    assert report[2].meets_limit
    for key in ZEROED:
        assert report[1][key].as_understood.offset == pytest.approx(zero, rel=1e-12)


def test_the_zero_is_amid_what_rounding_left_in_all_maneuvers(reference):
    """A constant column has one rounding error per maneuver; the zero is in the middle of them."""
    zero = -1504.361215153502
    key = "mechanical_energy"
    lateral = ("roll_angle", "roll_rate", "steer_angle", "steer_rate", key)
    written = made(reference, lambda k, v, n: v + zero * (k == key), names=lateral)
    report = score(written, reference)
    last = {n: np.spacing(reference[n].scale(key)) / 2 for n in reference}
    left = {n: report[n][key].trace.error for n in reference}
    # The fitted zero leaves equal margins: the errors are as far from the upper limit as from the
    # lower one.
    above = min(last[n] - np.max(left[n]) for n in reference)
    below = min(last[n] + np.min(left[n]) for n in reference)
    assert above == pytest.approx(below, abs=1e-16)
    assert above > 0
    assert report[1][key].as_understood.offset == pytest.approx(zero, rel=1e-15)


@pytest.mark.parametrize("key", ZEROED)
def test_a_zero_of_only_one_energy_is_an_error(reference, key):
    report = score(made(reference, lambda k, v, n: v + 20.0 * (k == key)), reference)
    assert not report.is_right
    assert report[1][key].as_understood.offset == 0.0


def test_a_constant_that_the_motion_explains_is_no_zero(reference):
    """A mass that is wrong by 2 % changes the kinetic energy by as much."""
    energies = (*ZEROED, "kinetic_energy")
    report = score(made(reference, lambda k, v, n: 1.02 * v if k in energies else v), reference)
    assert report[1]["potential_energy"].as_understood.offset == 0.0


@pytest.mark.parametrize("zero", [-794.1195, 100.0])
def test_without_its_parts_an_energy_of_another_zero_does_not_meet_eq_1(reference, zero):
    energy = reference[2]["mechanical_energy"]
    moved = columns(reference, potential_energy=None, mechanical_energy=energy + zero)
    report = score(moved, reference, ["2.performance < 1e-3", "columns >= 7"], maneuver=2)
    assert is_right_in_part(report)
    assert report[2].meets_limit is False
    assert not report.passed
    # If the motion is wrong, a constant difference of the energy may come from wrong initial
    # conditions. So it is not taken as a different zero.
    wrong = {k: x * 1.01 if k != "time" else x for k, x in moved.items()}
    wrong["mechanical_energy"] = energy + zero
    taken = score(wrong, reference, maneuver=2)[2]["mechanical_energy"]
    assert taken.as_understood.offset == 0.0


@pytest.mark.parametrize("off", [0.0, 1e-5])
def test_a_right_speed_shows_the_motion_of_an_energy_of_another_zero(reference, off):
    """The speed depends on the squares of roll and steer, so it shows the motion."""
    speed, energy = (reference[2][k] for k in ("forward_speed", "mechanical_energy"))
    speed = speed + off * np.sin(reference[2].time) * np.ptp(speed)
    given = {"time": reference[2].time, "forward_speed": speed, "mechanical_energy": energy + 922.1}
    assert is_right_in_part(score(given, reference, maneuver=2))
    # If the speed varies differently from the exact speed, the motion is wrong.
    given["forward_speed"] = speed[0] + 1.02 * (speed - speed[0])
    taken = score(given, reference, maneuver=2)[2]["mechanical_energy"]
    assert taken.as_understood.offset == 0.0


@pytest.mark.parametrize("keys", [("roll_angle",), ("roll_rate", "steer_angle"), ("steer_rate",)])
def test_right_roll_or_steer_shows_the_motion_of_an_energy_of_another_zero(reference, keys):
    right = {key: reference[2][key] for key in keys}
    energy = {
        "time": reference[2].time,
        "mechanical_energy": reference[2]["mechanical_energy"] - 1e3,
    }
    assert is_right_in_part(score({**energy, **right}, reference, maneuver=2))
    # A wrong motion gives no evidence that the energy has a different zero.
    wrong = {k: 1.1 * x for k, x in right.items()}
    taken = score({**energy, **wrong}, reference, maneuver=2)[2]["mechanical_energy"]
    assert taken.as_understood.offset == 0.0


def test_a_start_with_more_energy_is_no_other_zero(reference, bicycle):
    for speed in (4.601, 4.61, 4.65, 4.8):
        program = Program(Motion(bicycle, {2: Start(speed=speed, roll_rate=0.5)}))
        file = simulated(Simulator(), program, ("roll_angle", "mechanical_energy"))
        assert score(file, reference)[2]["mechanical_energy"].as_understood.offset == 0.0


def test_few_digits_of_a_speed_hide_no_zero_of_the_energy(reference):
    file = {"time": reference[3].time}
    file |= {key: reference[3][key] for key in ("roll_angle", "roll_rate")}
    file["forward_speed"] = np.round(reference[3]["forward_speed"], 4)
    file["mechanical_energy"] = reference[3]["mechanical_energy"] - 1e3
    assert score(file, reference, maneuver=3)[3]["mechanical_energy"].is_right


@pytest.mark.parametrize("definition", SPEEDS)
def test_speeds_of_the_riders_centre_of_mass_are_known(reference, definition):
    speed = reference[2][f"forward_speed_{definition}"]
    report = score(columns(reference, forward_speed=speed), reference, maneuver=2)
    assert report.is_right
    assert report[2]["forward_speed"].definition == definition


def test_an_attitude_of_yaw_pitch_and_roll_is_known(reference):
    names = {"roll_angle": "roll_angle_zyx", "roll_rate": "roll_rate_zyx_rate",
             "pitch": "pitch_zyx", "yaw": "yaw_zyx", "yaw_rate": "yaw_rate_zyx_rate"}  # fmt: skip
    attitude = {key: reference[2][name] for key, name in names.items()}
    report = score(columns(reference, **attitude), reference, maneuver=2)
    assert report.is_right
    assert {c.key: c.definition for c in report[2].columns if c.key in names} == {
        key: name.removeprefix(f"{key}_") for key, name in names.items()
    }


def test_a_definition_of_its_own_is_asked_for_before_it_is_called_wrong(reference):
    m = reference[2]
    mean = (m["forward_speed_hub_global_x"] + m["forward_speed_front_contact"]) / 2
    report = score(columns(reference, forward_speed=mean), reference, maneuver=2)
    said = report.verdict.partition(": ")[2]
    assert said.startswith("forward_speed has a definition of its own, or the file is wrong; ")
    assert "definition_unknown" in codes(report)
    assert not report.is_right
    # If another column is also wrong, the verdict does not ask about the definition of the speed.
    wrong = columns(reference, forward_speed=mean, steer_rate=1.3 * m["steer_rate"])
    assert score(wrong, reference, maneuver=2).verdict.partition(": ")[2].startswith("wrong")


def test_what_fits_one_maneuver_to_its_digits_is_of_no_other_definition(reference):
    def moved(key, values, number):
        return values + 0.1 if (key, number) == ("forward_speed", 2) else values

    report = score(made(reference, moved), reference)
    assert "definition_unknown" not in codes(report)
    assert report.verdict.partition(": ")[2].startswith("wrong")


def test_columns_that_were_left_out_are_named(reference):
    report = score(columns(reference, hub_vy=np.sin(reference[2].time)), reference, maneuver=2)
    assert report.verdict.endswith("; hub_vy is not compared")


@pytest.mark.proof
def test_a_mistake_is_found_beside_a_definition_that_no_set_stores(reference):
    m, bicycle = reference[2], Bicycle.parse(reference.bicycle, reference.parameters)
    lighter = Bicycle(bicycle.name, {**bicycle.values, "g": Exact.parse("9.7")})
    start = (0.0, m["pitch"][0], 0.0, m["roll_rate"][0], 0.0, m["forward_speed"][0])
    made = Simulator().run(lighter, start, m.time)
    written = {name: made[name] for name in reference[1].columns[:8]}
    written["forward_speed"] = made["forward_speed_rear_com_norm"]
    report = diagnose({"time": m.time, **written}, reference, maneuver=2)
    assert "the gravity (g) is 9.7 N/kg" in report.diagnosis[0].message
    assert report[2]["forward_speed"].definition == "rear_com_norm"


@pytest.mark.parametrize("more", [(), ("forward_speed",), ("roll_angle", "roll_rate")])
@pytest.mark.parametrize("zero", [-794.1195, 500.0])
def test_the_total_minus_the_kinetic_energy_shows_the_zero(reference, zero, more):
    """Without a potential energy, no other column shows that the motion is right."""
    keys = ("kinetic_energy", "mechanical_energy", *more)
    report = score(columns_of(reference, keys, zero), reference, maneuver=2)
    assert is_right_in_part(report)
    assert report[2]["mechanical_energy"].as_understood.offset == pytest.approx(zero, rel=1e-9)


def test_an_energy_that_grows_has_no_other_zero(reference):
    given = columns_of(reference, ("kinetic_energy", "mechanical_energy"), 0.0)
    given["mechanical_energy"] = given["mechanical_energy"] * (1 + 0.02 * given["time"]) - 500
    report = score(given, reference, maneuver=2)
    assert not report.is_right
    assert ": wrong" in report.verdict


def columns_of(reference, keys, zero):
    m = reference[2]
    return {"time": m.time, **{k: m[k] + zero * (k in ZEROED) for k in keys}}


def test_the_question_of_the_definition_comes_first(reference):
    """The speed of the hub along the ground has no name in the program, and is right to 5
    digits."""
    found = {}
    for n in reference:
        m = reference[n]
        norm = m.evaluate(m.time, ["forward_speed_hub_norm"])["forward_speed_hub_norm"]
        sinking = 0.3 * np.sin(m["roll_angle"]) * m["roll_rate"]
        found[n] = columns(reference, n, forward_speed=np.sqrt(norm**2 - sinking**2))
    report = score({1: found[1], 2: found[2], 3: found[3]}, reference)
    assert ": forward_speed has a definition of its own, or the file is close" in report.verdict
    assert "a smaller step" not in str(report)
    assert "check which point or axis forward_speed refers to" in repr(report)
