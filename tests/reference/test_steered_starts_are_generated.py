"""A maneuver may start steered, and the exact values of its first row are recognised."""

from dataclasses import replace
from fractions import Fraction

import pytest

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import NonnegativeRoots
from heyoka_bike.cli import main
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.proof.rows import exact_columns


def hold_what_is_enclosed(exact, equations, maneuver, within):
    """Check that the exact values are in the enclosures of the start, which are this narrow."""
    with equations.precision():
        columns = equations.columns(initial_state(equations, maneuver))
        for name, value in exact.items():
            found = columns[name] * value.denominator - value.numerator
            assert found.contains(0), name
            assert float(found.abs_upper()) < within, name


@pytest.mark.parametrize("roll", ["0", "1/50"])
def test_exact_columns_are_those_of_the_proved_pitch(bicycle, maneuvers, roll):
    """The exact columns are found without knowing the pitch; here it is enclosed."""
    maneuver = replace(maneuvers[0], steer=Exact(Fraction(1, 40)), roll=Exact(Fraction(roll)))
    exact = exact_columns(bicycle, maneuver)
    assert exact["steer_angle"] == Fraction(1, 40)
    assert exact["forward_speed"] == maneuver.speed.rational
    if roll == "0":
        assert exact["forward_speed_contact"] == maneuver.speed.rational
        assert exact["roll_angle_zyx"] == exact["roll_angle_tait_bryan_xyz"] == 0
    hold_what_is_enclosed(exact, Equations.of(bicycle, Balls(300)), maneuver, within=1e-60)


@pytest.mark.parametrize("roll", ["0", "0.1"])
@pytest.mark.parametrize("speed", ["5", "-5", "0"])
def test_at_zero_rates_every_velocity_but_the_forward_ones_is_zero(bicycle, maneuvers, roll, speed):
    given = {"roll": roll, "speed": speed, "steer": "-0.02", "roll_rate": "0", "steer_rate": "0"}
    maneuver = replace(maneuvers[0], **{key: Exact.parse(x) for key, x in given.items()})
    exact = exact_columns(bicycle, maneuver)
    v = Fraction(speed)
    assert {"roll_rate", "steer_rate", "roll_rate_zyx_rate"} <= exact.keys()
    assert exact["roll_rate"] == exact["steer_rate"] == exact["roll_rate_zyx_rate"] == 0
    assert exact["forward_speed"] == v
    assert exact["forward_speed_hub_norm"] == abs(v)
    if speed == "0":
        assert all(exact[name] == 0 for name in exact if "rate" in name or "speed" in name)
        assert exact["kinetic_energy"] == 0
    # A component along an axis that rotates with the bicycle is listed as zero only if the bicycle
    # is at rest.
    assert ("yaw_rate" in exact) == (speed == "0")
    assert ("forward_speed_wheel_spin" in exact) == (speed == "0" or roll == "0")
    balls = NonnegativeRoots(300)
    hold_what_is_enclosed(exact, Equations.of(bicycle, balls), maneuver, within=1e-40)


@pytest.mark.proof
def test_a_set_that_begins_steered_and_upright_is_made_and_verified(tmp_path):
    (tmp_path / "m.toml").write_text(
        'name = "steered"\n[[maneuver]]\nname = "steered"\nspeed = "4"\nsteer = "0.02"\n'
        'roll_rate = "0.05"\nduration = "0.1"\nspacing = "0.1"\n'
    )
    out = tmp_path / "set"
    assert main(["generate", "--maneuvers", str(tmp_path / "m.toml"), "--out", str(out)]) == 0
    assert main(["verify", str(out)]) == 0
    first = load_reference(out)[1].rows.hi
    assert first["roll_angle_zyx"][0] == 0.0
    assert first["forward_speed_contact"][0] == 4.0
