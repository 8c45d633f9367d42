"""A torque that depends on a single angle or rate is found as a function, whatever its form."""

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.pushed_motions import exact_motions, with_torque
from heyoka_bike.scoring.diagnosis.conclusions import TorqueLaw
from heyoka_bike.scoring.diagnosis.residual.laws import hats


@pytest.fixture(scope="module")
def motions(reference):
    return exact_motions(reference)


# None of the known forces has these laws: regularised friction, a stop with play, and a hardening
# spring.
LAWS = {
    "friction": (1, "steer rate", lambda s, _: -0.02 * np.tanh(s["steer_rate"] / 0.01)),
    "play": (
        1,
        "steer angle",
        lambda s, _: -3.0 * np.sign(s["steer_angle"]) * np.maximum(abs(s["steer_angle"]) - 0.02, 0),
    ),
    "spring": (0, "roll angle", lambda s, _: -5.0 * np.sinh(10 * s["roll_angle"])),
}


@pytest.mark.parametrize("name", LAWS)
def test_the_variable_and_the_values_are_found(reference, motions, name):
    equation, variable, torque = LAWS[name]
    law = with_torque(reference, motions, equation, torque).law
    assert (law.equation, law.variable) == (("roll", "steer")[equation], variable)
    places = np.array(law.places[-6:])
    exact = torque({variable.replace(" ", "_"): places}, None)
    # The law is interpolated linearly between points a factor of 1.4 apart, hence the tolerance of
    # 5 %.
    np.testing.assert_allclose(law.values[-6:], exact, rtol=0.05, atol=0.02 * abs(exact).max())


def test_friction_is_said_to_brake(reference, motions):
    said = TorqueLaw(with_torque(reference, motions, *LAWS["friction"][::2]).law).message()
    assert said.startswith("The program applies an extra torque on the steer axis, or lacks one. ")
    assert "It brakes, as friction does" in said
    said = TorqueLaw(with_torque(reference, motions, *LAWS["play"][::2]).law).message()
    assert "brakes" not in said


def test_a_torque_over_the_time_has_no_such_law(reference, motions):
    assert with_torque(reference, motions, 0, lambda _, time: 0.3 * np.sin(3 * time)).law is None


def test_hats_are_odd_and_add_up_to_what_they_stand_for():
    places = np.array([1.0, 2.0, 4.0])
    x = np.array([-3.0, -0.5, 0.0, 0.5, 2.0, 4.0])
    np.testing.assert_allclose(places @ hats(x, places), x)
    np.testing.assert_array_equal(hats(-x, places), -hats(x, places))
