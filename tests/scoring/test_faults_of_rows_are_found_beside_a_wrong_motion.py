"""A wrong value in the model and a fault of the rows in one file are both named.

The motions are integrated by SciPy with a changed parameter, and then one fault is made in the
rows. The exact motion does not show such a fault, but the motion with the wrong value does.
"""

import numpy as np
import pytest
from scipy.signal import lfilter

from generators.mistaken_programs import correct, motion, with_changes
from generators.published_columns import side_by_side
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.diagnosis.diagnose import diagnose

TIME = np.arange(401) / 40
# Change of the roll inertia of the rear frame [kg m2].
WRONG = {"IBxx": "0.8"}


def columns(reference, wrong=WRONG, time=TIME):
    """Return the columns of each maneuver with the wrong value."""
    program = correct(reference)
    bicycle = with_changes(program.motion.bicycle, wrong)
    found = {}
    for n, start in program.motion.starts.items():
        made = motion(bicycle, (0.0, 0.0, 0.0, start.roll_rate, 0.0, start.speed), time)
        found[n] = {key: made[key] for key in KEYS}
    return found


def unsigned(table):
    for of in table.values():
        of["steer_rate"] = np.abs(of["steer_rate"])
    return {"unsigned_column": [1, 2, 3]}


def in_degrees(table):
    table[3]["roll_rate"] = np.degrees(table[3]["roll_rate"])
    return {"column_ratio": [3]}


def averaged(table):
    for of in table.values():
        of["steer_angle"] = np.convolve(np.pad(of["steer_angle"], 3, mode="edge"), np.ones(7) / 7,
                                        "valid")  # fmt: skip
    return {"smoothed_columns": None}


def filtered(table):
    for of in table.values():
        of["steer_rate"] = lfilter([0.4], [1.0, -0.6], of["steer_rate"])
    return {"filtered_columns": None}


def exchanged(table):
    of = table[2]
    of["roll_rate"], of["steer_rate"] = of["steer_rate"], of["roll_rate"]
    return {"other_column": [2]}


def mirrored(table):
    table[2] |= {key: -table[2][key] for key in LATERAL}
    return {"mirrored": [2]}


def late(table):
    for key, x in table[1].items():
        table[1][key] = np.r_[x[0], x[:-1]]
    return {"other_clock": None}


def of_another(table):
    table[2]["potential_energy"] = table[1]["potential_energy"].copy()
    return {"column_of_another_maneuver": None}


EVERY = (unsigned, in_degrees, averaged, filtered, exchanged, mirrored, late, of_another)


def named(table, reference):
    """Return codes with maneuvers, and the fitted values of the likeliest cause."""
    said = diagnose(side_by_side(table, TIME), reference).diagnosis
    (cause,) = (f for f in said if f.code == "parameters")
    assert cause.evidence["is_all"]
    found = {x["unknown"]: x["value"] for x in cause.evidence["changes"][0]}
    return {f.code: f.evidence.get("maneuvers") for f in said if f is not cause}, found


@pytest.mark.parametrize(
    "fault", [unsigned, *(pytest.param(f, marks=pytest.mark.proof) for f in EVERY[1:])]
)
def test_both_are_named(fault, reference):
    table = columns(reference)
    expected = fault(table)
    codes, values = named(table, reference)
    assert codes == expected
    assert list(values) == ["IBxx"]
    assert values["IBxx"] == pytest.approx(10.0, abs=1e-4)


@pytest.mark.proof
def test_columns_that_are_not_simulated_are_left_out(reference):
    """Mistakes of the model are simulated without the path on the floor."""
    table = columns(reference)
    for of in table.values():
        of["rear_contact_x"] = of["forward_speed"] * TIME
    expected = unsigned(table)
    codes, values = named(table, reference)
    assert codes.items() >= expected.items()
    assert list(values) == ["IBxx"]


def test_no_fault_is_seen_beside_a_wrong_value_alone(reference):
    codes, values = named(columns(reference), reference)
    assert not codes
    assert list(values) == ["IBxx"]


@pytest.mark.parametrize("key", ["roll_rate", "steer_angle"])
def test_a_flipped_sign_is_named_beside_a_motion_that_resembles_no_other(key, reference):
    """The exact motion does not show the sign, but the angle's slope and the rate do."""
    table = columns(reference, {"w": "0.18"})
    for of in table.values():
        of[key] = -of[key]
    codes, values = named(table, reference)
    assert codes == {"signs_disagree": None}
    assert values == {"w": pytest.approx(1.2, abs=1e-4)}


@pytest.mark.parametrize("wrong", [WRONG, pytest.param({"c": "0.01"}, marks=pytest.mark.proof)])
def test_a_speed_that_is_that_of_the_start_hides_no_wrong_value(wrong, reference):
    """No motion that leans and steers has this speed, so the equations show nothing with it."""
    table = columns(reference, wrong)
    for of in table.values():
        of["forward_speed"] = np.full_like(TIME, of["forward_speed"][0])
    (found, *_) = diagnose(side_by_side(table, TIME), reference).diagnosis
    value, output = found.evidence["mistakes"]
    assert (value, output) == (f"other_{next(iter(wrong))}", "speed_of_start")
