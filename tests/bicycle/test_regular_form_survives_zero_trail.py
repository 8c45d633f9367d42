"""The regular form is finite and continuous where the mechanical trail is zero."""

from fractions import Fraction

import flint
import pytest

from generators.on_the_floor import few_product_state, model, random_state
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.kinematics import posture
from heyoka_bike.bicycle.equations.model import few_products, regular
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact

UPRIGHT = ["0", "0", "0", "0.3", "-0.2", "15"]


def _trail(mm):
    return Exact(Fraction(mm) / 1000)


def _upright(a):
    return [a.context.mpf(x) for x in UPRIGHT]


def test_no_trail_means_a_zero_divisor_upright():
    k, a = model(50, c=_trail(0))
    # The trail is zero up to the rounding of sin(pi/10).
    assert abs(posture(k, a, *_upright(a)[:3]).trail) < a.context.mpf("1e-49")


def test_few_product_form_has_no_finite_value_there(bicycle):
    balls = Balls(200)
    with balls.precision():
        k = constants(bicycle.replace(c=_trail(0)), balls)
        state = [balls.number(Exact.parse(x)) for x in UPRIGHT]
        assert not all(x.is_finite() for x in few_products(k, balls, state))
        assert all(x.is_finite() for x in regular(k, balls, state))
    assert flint.ctx.prec != 200


@pytest.mark.parametrize("seed", [None, *range(6)])
def test_regular_form_is_continuous_in_the_trail(seed):
    """Differences decrease in proportion to the change of the trail."""
    states = {}
    for mm in ("0", "1e-20", "1e-21", "-1e-20"):
        k, a = model(50, c=_trail(mm))
        state = _upright(a) if seed is None else random_state(k, a, seed, 0.3, 0.3)
        states[mm] = regular(k, a, state)
        assert all(a.context.isfinite(x) for x in states[mm])
    for zero, near, nearer, other in zip(*states.values(), strict=True):
        # The accelerations change by less than 1e3 per metre of trail, and the trail is 1e-23 m.
        assert abs(near - zero) < 1e-20
        # The change is linear in the trail: terms of second order are at most 1e-23 of it, and
        # rounding errors are 1e-50.
        assert abs(near - zero - 10 * (nearer - zero)) < 1e-42
        assert abs(near + other - 2 * zero) < 1e-42


def test_the_trail_matters():
    k, a = model(50, c=_trail(0))
    k80, _ = model(50)
    at_zero, at_80 = regular(k, a, _upright(a)), regular(k80, a, _upright(a))
    assert abs(at_zero[4] - at_80[4]) > 0.1


def test_both_forms_agree_near_zero_trail():
    """The few-product form only loses digits."""
    k, a = model(50, c=_trail("1e-10"))
    few_state = few_product_state(k, a, _upright(a))
    few, reg = few_products(k, a, few_state), regular(k, a, _upright(a))
    _, _, _, w1, w3, _ = few_state
    sin, cos = a.sin(k.tilt), a.cos(k.tilt)
    # The roll rate is cos(beta) w1 + sin(beta) w3. For an upright bicycle, the angle beta equals
    # the tilt.
    roll_acceleration = cos * few[3] + sin * few[4] + few[1] * (cos * w3 - sin * w1)
    # The values have 50 digits, less 13 for the division by a trail of 1e-13 m. The mass matrix
    # contains the square of the trail.
    assert abs(few[2] - reg[2]) < 1e-35
    assert abs(roll_acceleration - reg[3]) < 1e-24
    assert abs(few[5] - reg[5]) < 1e-24
