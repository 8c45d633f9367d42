"""Wheel angles, heading and position are correct with any zero: no equation depends on it.

The files are the published rows with another program's zero, whole turns or direction.
"""

import numpy as np
import pytest

from generators.made_results import is_right_in_part
from generators.published_columns import published_columns
from heyoka_bike.bicycle.columns import FREE_ZERO
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.score import score

PLACES = ("rear_contact", "front_contact", "rear_hub", "front_hub", "com")


@pytest.fixture(scope="module")
def whole(reference):
    return reference.with_motion()


def table(reference, keys, n=2, every=2):
    return published_columns(reference, n, every, keys)


def scores(report):
    return {c.key: c.as_understood.measures.scd for c in report.maneuvers[0].columns}


def codes(report):
    return [f.code for f in report.findings if f.severity != "info"]


def test_the_free_columns_are_heading_places_and_wheel_angles():
    assert {"yaw", "rear_wheel_angle", "front_contact_y", "rear_hub_x", "com_x"} <= FREE_ZERO
    assert not {"roll_angle", "steer_angle", "pitch", "rear_hub_z", "potential_energy"} & FREE_ZERO


@pytest.mark.parametrize("start", [1.0, -0.3, 1e-3, 57.0])
@pytest.mark.parametrize("key", ["yaw", "rear_wheel_angle", "front_contact_x", "rear_hub_y"])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_column_may_start_anywhere(whole, key, start, sign):
    held = table(whole, ["roll_angle", key])
    held[key] = sign * held[key] + start
    report = score(held, whole, maneuver=2)
    assert scores(report)[key] > 12
    assert is_right_in_part(report)
    assert report[2][key].as_understood.offset == pytest.approx(sign * start, rel=1e-9)
    assert codes(report) == []
    said = [f.message for f in diagnose(held, whole, maneuver=2).diagnosis]
    assert not any(key in x and "plus" in x for x in said)


def test_a_heading_in_degrees_may_start_anywhere(whole):
    held = table(whole, ["roll_angle", "yaw"])
    held["yaw [deg]"] = np.degrees(held.pop("yaw")) + 90
    report = score(held, whole, maneuver=2)
    assert is_right_in_part(report)
    assert report[2]["yaw"].as_understood.offset == pytest.approx(np.pi / 2)


def test_a_column_with_a_zero_is_wrong_from_another_one(whole):
    for key in ("roll_angle", "pitch", "rear_hub_z"):
        held = table(whole, ["roll_rate", "steer_angle", key])
        held[key] += 0.3
        report = score(held, whole, maneuver=2)
        assert scores(report)[key] < 1


def test_a_wrong_motion_is_wrong_from_any_zero(whole):
    held = table(whole, ["roll_angle", "yaw"])
    held["yaw"] = 1 + 1.05 * held["yaw"]
    assert scores(score(held, whole, maneuver=2))["yaw"] < 2


@pytest.mark.parametrize("every", [1, 10, 20])
@pytest.mark.parametrize("low", [0.0, -0.5])
@pytest.mark.parametrize("key", ["rear_wheel_angle", "front_wheel_angle"])
def test_wheel_angles_within_one_turn_are_right(whole, key, low, every):
    """The rows are 0.2 s apart, so a wheel of maneuver 3 turns by 5 rad between two rows."""
    turn = 2 * np.pi
    held = table(whole, ["roll_angle", key], 3, every)
    held[key] -= turn * np.floor(held[key] / turn - low)
    report = score(held, whole, maneuver=3)
    # Wrapping angles of up to 267 rad in binary64 loses digits.
    assert scores(report)[key] > 14
    assert is_right_in_part(report)
    assert "whole_turns" in [f.code for f in report.findings]


@pytest.mark.parametrize("keys", [["roll_angle"], ["roll_angle", "steer_angle", "pitch"]])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("unit", [360.0, 2 * np.pi])
def test_angles_from_zero_to_a_turn_beside_rates_are_right(whole, keys, sign, unit):
    rates = ["roll_rate", "steer_rate", "forward_speed"]
    held = table(whole, [*keys, *rates])
    for key in keys:
        held[key] = np.mod(sign * unit / (2 * np.pi) * held[key], unit)
    for key in rates[:2] if sign < 0 else ():
        held[key] *= -1
    report = score(held, whole, maneuver=2)
    # The pitch is far smaller than a whole turn, so wrapping it leaves only 12 of its digits.
    assert min(scores(report).values()) > 12
    assert is_right_in_part(report)
    assert codes(report) == []


def test_digits_of_a_wrapped_angle_are_those_written(whole, tmp_path):
    held = table(whole, ["roll_angle", "rear_wheel_angle"], 1)
    held["rear_wheel_angle"] = np.mod(held["rear_wheel_angle"], 2 * np.pi)
    path = tmp_path / "r.csv"
    lines = zip(*([f"{x:.6g}" for x in held[k]] for k in held), strict=True)
    path.write_text("\n".join([",".join(held), *map(",".join, lines)]) + "\n")
    column = score(path, whole, maneuver=1)[1]["rear_wheel_angle"]
    # The text 6.28319 has six digits, the last of which is 1e-5. The floor is half a unit of this
    # digit.
    assert column.floor == pytest.approx(5e-6)
    assert column.max_abs_error <= 5.01e-6


def test_an_angle_that_jumps_otherwise_is_wrong(whole):
    held = table(whole, ["roll_angle", "rear_wheel_angle"])
    held["rear_wheel_angle"][250:] += 3.0
    assert scores(score(held, whole, maneuver=2))["rear_wheel_angle"] < 2


@pytest.mark.parametrize("heading", [0.5, -2.0, 3.0])
@pytest.mark.parametrize("left", [1, -1])
def test_a_path_in_another_direction_is_right(whole, heading, left):
    names = [f"{place}_{axis}" for place in PLACES for axis in "xy"]
    held = table(whole, ["roll_angle", "yaw", *names])
    held["yaw"] += heading
    for place in PLACES:
        x, y = held[f"{place}_x"], held[f"{place}_y"]
        held[f"{place}_x"] = 3 + np.cos(heading) * x - np.sin(heading) * y
        held[f"{place}_y"] = left * (np.sin(heading) * x + np.cos(heading) * y - 7)
    report = score(held, whole, maneuver=2)
    assert min(scores(report).values()) > 12
    assert is_right_in_part(report)
    (found,) = [f for f in report.findings if f.code == "path_turned"]
    assert abs(found.evidence["heading"]) == pytest.approx(abs(heading), abs=1e-9)


def test_a_path_of_another_shape_is_not_turned(whole):
    held = table(whole, ["roll_angle", "rear_contact_x", "rear_contact_y"])
    held["rear_contact_y"] *= 1.5
    report = score(held, whole, maneuver=2)
    assert scores(report)["rear_contact_y"] < 2
    assert "path_turned" not in [f.code for f in report.findings]
