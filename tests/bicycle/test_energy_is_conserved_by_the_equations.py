"""Along the motion the energy stays constant and the front wheel stays on the floor."""

import pytest

from generators.on_the_floor import along, few_product_state, model, random_state
from heyoka_bike.bicycle.equations.kinematics import front_contact_height, unfold
from heyoka_bike.bicycle.equations.model import few_products, regular
from heyoka_bike.bicycle.equations.outputs import energies

STATES = [
    *(pytest.param(seed, 0.1, 0.1, id=f"small angles {seed}") for seed in range(4)),
    *(pytest.param(seed, 0.6, 0.8, id=f"middling angles {seed}") for seed in range(4, 10)),
    *(pytest.param(seed, 1.1, 1.0, id=f"large angles {seed}") for seed in range(10, 18)),
]
FORMS = pytest.mark.parametrize("form", [few_products, regular], ids=lambda form: form.__name__)


def _moving(form, seed, lean, turn):
    k, a = model()
    state = random_state(k, a, seed, lean, turn)
    if form is few_products:
        state = few_product_state(k, a, state)
    return k, a, state, form(k, a, state)


@FORMS
@pytest.mark.parametrize(("seed", "lean", "turn"), STATES)
def test_energy(form, seed, lean, turn):
    k, a, state, rates = _moving(form, seed, lean, turn)

    def both(s):
        e = energies(k, *unfold(k, a, s, is_regular=form is regular))
        return [e.potential, e.kinetic]

    potential_rate, kinetic_rate = along(a, rates, state, both)
    # Potential and kinetic energy exchange much power, so the test shows whether the two rates
    # cancel.
    assert abs(potential_rate) > 1e-2
    # The difference quotient has an error of 1e-70 times the third derivative (see
    # on_the_floor.STEP). The third derivative is at most about 1e6 times the first derivative.
    scale = abs(potential_rate) + abs(kinetic_rate) + sum(both(state))
    assert abs(potential_rate + kinetic_rate) < scale * a.context.mpf("1e-60")


@FORMS
@pytest.mark.parametrize(("seed", "lean", "turn"), STATES)
def test_the_front_wheel_stays_on_the_floor(form, seed, lean, turn):
    k, a, state, rates = _moving(form, seed, lean, turn)
    (rate,) = along(a, rates, state, lambda s: [front_contact_height(k, a, *s[:3])])
    (unpitched,) = along(
        a,
        [rates[0], 0, *rates[2:]],
        state,
        lambda s: [front_contact_height(k, a, *s[:3])],
    )
    # Without the pitch rate the wheel would leave the floor.
    assert abs(unpitched) > 1e-6
    assert abs(rate) < a.context.mpf("1e-60")
