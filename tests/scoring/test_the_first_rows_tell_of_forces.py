"""The beginning of an error shows work and asymmetry, even in files of a single column."""

import numpy as np
import pytest

from generators.simulated_tables import TIME, right_program, simulated
from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.diagnosis.beginnings import (
    BeginsAs,
    NoForceAlong,
    Unsymmetric,
    WorkFromStart,
    beginnings,
)
from heyoka_bike.scoring.diagnosis.claims import LINEAR
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES, apply
from heyoka_bike.scoring.diagnosis.numerical import causes
from heyoka_bike.scoring.score import score

SYMMETRIC = (
    "sign_IHxz", "trail_normal", "spin_F_missing", "centre_B_from_hub", "roll_rate_in_degrees",
    "speed_in_km_h", "one_step_early", "no_gyroscopic",
)  # fmt: skip


@pytest.fixture(scope="module")
def right(bicycle, reference):
    return right_program(bicycle, reference)


def made(simulator, program, key, **amounts):
    """One column of all maneuvers, written with 12 digits."""
    table = simulated(simulator, program, (key,), **amounts)
    return {name: x if name == "time" else np.array([float(f"{v:.12g}") for v in x])
            for name, x in table.items()}  # fmt: skip


def test_a_force_along_the_motion_is_told_with_its_size(simulator, right, reference):
    table = made(simulator, right, "kinetic_energy", frame_push=-2.0)
    (found,) = beginnings(score(table, reference))
    assert isinstance(found, WorkFromStart)
    assert found.forces == pytest.approx(dict.fromkeys((1, 2, 3), -2.0), rel=0.01)
    powers = {n: x * start.speed for (n, x), start in zip(
        found.forces.items(), right.motion.starts.values(), strict=True)}  # fmt: skip
    assert found.powers == pytest.approx(powers)


@pytest.mark.parametrize("force", [{"side_B": 0.002}, {"roll_torque": 0.1}, {"side_wind": 0.5}])
def test_what_is_not_symmetric_is_told_by_two_roll_rates(simulator, right, reference, force):
    table = made(simulator, right, "roll_angle", **force)
    found, *_ = beginnings(score(table, reference))
    assert isinstance(found, Unsymmetric)
    assert (found.key, found.small, found.large) == ("roll_angle", 1, 2)
    # A single maneuver cannot show that the motions are asymmetric.
    alone = {"time": TIME, "roll_angle": table["roll_angle_2"]}
    found = beginnings(score(alone, reference, maneuver=2))
    assert all(isinstance(x, BeginsAs) for x in found)


@pytest.mark.parametrize("key", ["roll_angle", "steer_rate", "forward_speed", "kinetic_energy"])
@pytest.mark.parametrize("code", SYMMETRIC)
def test_mistakes_of_a_symmetric_model_are_neither(simulator, right, reference, key, code):
    program = apply(right, [m for m in MISTAKES if m.code == code])
    found = beginnings(score(made(simulator, program, key), reference))
    assert not [x for x in found if isinstance(x, WorkFromStart | Unsymmetric)]


def test_a_speed_shows_a_force_along_the_motion_as_an_energy_does(simulator, right, reference):
    table = made(simulator, right, "forward_speed", frame_push=-2.0)
    (found,) = beginnings(score(table, reference))
    assert isinstance(found, WorkFromStart)
    # In maneuver 2 the roll has 2 % of the kinetic energy.
    assert found.forces == pytest.approx(dict.fromkeys((1, 2, 3), -2.0), rel=0.03)


@pytest.mark.parametrize("amounts", [{"steer_damping": 0.2}, {"roll_stiffness": -20.0}])
def test_a_speed_that_is_wrong_later_excludes_a_force_along_the_motion(
    simulator, right, reference, amounts
):
    report = score(made(simulator, right, "forward_speed", **amounts), reference)
    (found,) = beginnings(report)
    assert isinstance(found, NoForceAlong)
    assert 0.0 < max(found.forces.values()) < 0.01
    # With a column of roll or steer, that column shows more.
    table = simulated(simulator, right, ("forward_speed", "roll_angle"), **amounts)
    found = beginnings(score(table, reference))
    assert not [x for x in found if isinstance(x, NoForceAlong)]


@pytest.mark.parametrize(
    ("force", "order"),
    [({"steer_torque": 0.1}, 2), ({"steer_stiffness": 1.0}, 3), ({"roll_damping": 1.0}, 2)],
)
def test_a_rate_alone_shows_the_power_of_its_angle(simulator, right, reference, force, order):
    table = made(simulator, right, "steer_rate", **force)
    (found,) = (x for x in beginnings(score(table, reference)) if isinstance(x, BeginsAs))
    assert (found.keys, found.order) == (("steer_rate",), order)
    powers = {2: "proportion to the time.", 3: "the square of the time, or to a higher"}
    assert powers[order] in found.message()


def orders(simulator, program, reference, **amounts):
    """Powers of the time with which the errors of the angles begin, if visible."""
    table = simulated(simulator, program, ("roll_angle", "steer_angle"), **amounts)
    return {x.order for x in beginnings(score(table, reference)) if isinstance(x, BeginsAs)}


def test_mistakes_of_the_model_do_not_begin_with_the_time(simulator, right, reference):
    """This holds for every mistake of the library."""
    found = {
        m.code: orders(simulator, apply(right, [m]), reference)
        for m in (*MISTAKES, *EQUATION_MISTAKES)
        if m.kind == "model" and m.code not in LINEAR
    }
    assert sum(map(bool, found.values())) > 0.9 * len(found)
    assert not {code for code, x in found.items() if 1 in x}


@pytest.mark.parametrize("code", ["roll_rate_in_degrees", "no_roll_rate"])
def test_another_rate_begins_with_the_time(simulator, right, reference, code):
    program = apply(right, [m for m in MISTAKES if m.code == code])
    assert 1 in orders(simulator, program, reference)


@pytest.mark.parametrize(
    ("force", "order"),
    [({"steer_torque": 0.1}, 2), ({"steer_stiffness": 1.0}, 3), ({"roll_damping": 1.0}, 2)],
)
def test_forces_begin_at_once_or_with_the_angles(simulator, right, reference, force, order):
    assert min(orders(simulator, right, reference, **force)) == order


def test_it_is_said_where_nothing_explains_the_file(simulator, right, reference):
    table = made(simulator, right, "roll_angle", side_wind=0.5)
    found, _ = causes(score(table, reference))
    assert isinstance(found, Unsymmetric)
    # The finding needs no search, so it is reported even if the time for the search is used up.
    said = [f.code for f in diagnose(table, reference, budget=1e-3).diagnosis]
    assert said == ["unsymmetric", "begins_as", "stopped_early"]


def of_wrong_roll(reference, keys):
    """Return what the first rows show of a roll angle that is computed wrongly."""
    table = {"time": TIME}
    for n in reference:
        for key, x in reference[n].approximate(TIME, keys).items():
            table[f"{key}_{n}"] = np.tan(1.05 * x) if key == "roll_angle" else x
    return tuple(beginnings(score(table, reference)))


@pytest.mark.parametrize("keys", [LATERAL, ("roll_angle", "steer_angle")])
def test_an_angle_that_is_computed_wrongly_begins_as_nothing(reference, keys):
    assert of_wrong_roll(reference, keys) == ()


def test_an_angle_alone_may_also_be_computed_wrongly(reference):
    (found,) = of_wrong_roll(reference, ("roll_angle", "forward_speed"))
    assert found == BeginsAs(("roll_angle",), 1, (1, 2, 3), is_alone=True)
    assert "only the angle computed wrongly" in found.message()
    (found,) = of_wrong_roll(reference, ("roll_angle",))
    assert found.is_alone


@pytest.mark.parametrize("code", ["trail_sign", "inertia_H_about_origin", "trail_zero"])
def test_an_angle_of_a_wrong_motion_is_not_alone(simulator, right, reference, code):
    program = apply(right, [m for m in MISTAKES if m.code == code])
    found = beginnings(score(simulated(simulator, program, LATERAL), reference))
    powers = [x for x in found if isinstance(x, BeginsAs)]
    assert powers
    assert not any(x.is_alone for x in powers)
