"""The few-product and the regular form of the equations describe one motion."""

import pytest

from generators.on_the_floor import along, few_product_state, model, random_state
from heyoka_bike.bicycle.equations.kinematics import posture, speeds
from heyoka_bike.bicycle.equations.model import few_products, regular

SEEDS = range(12)


def _roll_and_steer_rate(k, a, state):
    roll, pitch, steer, w1, w3, spin = state
    u = speeds(k, posture(k, a, roll, pitch, steer), k.rear.r * spin, w1, w3)
    return [u.p, u.steer_rate]


@pytest.mark.parametrize("seed", SEEDS)
def test_rates_of_the_angles_and_of_the_spin(seed):
    k, a = model(50)
    state = random_state(k, a, seed)
    few, reg = few_products(k, a, few_product_state(k, a, state)), regular(k, a, state)
    scale = max(abs(x) for x in reg)
    for i in (0, 1, 2, 5):
        # The values have 50 digits, less a few for cancellation and for the division by a small
        # mechanical trail.
        assert abs(few[i] - reg[i]) < scale * a.context.mpf("1e-46")


@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_of_roll_and_steer(seed):
    k, a = model()
    state = random_state(k, a, seed)
    few_state = few_product_state(k, a, state)
    found = along(
        a, few_products(k, a, few_state), few_state, lambda s: _roll_and_steer_rate(k, a, s)
    )
    expected = regular(k, a, state)[3:5]
    for x, y in zip(found, expected, strict=True):
        # The difference quotient has an error of 1e-70 times the third derivative (see
        # on_the_floor.STEP). The third derivative is at most about 1e6 times the first derivative.
        assert abs(x - y) < (1 + abs(y)) * a.context.mpf("1e-60")


@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_along_the_axes_of_the_rear_frame(seed):
    k, a = model()
    state = random_state(k, a, seed)
    found = along(a, regular(k, a, state), state, lambda s: few_product_state(k, a, s)[3:5])
    expected = few_products(k, a, few_product_state(k, a, state))[3:5]
    for x, y in zip(found, expected, strict=True):
        assert abs(x - y) < (1 + abs(y)) * a.context.mpf("1e-60")
