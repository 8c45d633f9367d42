"""A motion with a small mechanical trail is proved, in either form of the equations.

The few-product form divides by the trail, and its mass matrix by the square of the trail. Over
states a few thousandths of a radian apart these divisors may be zero, however short the time.
"""

import pytest

from generators.drawn_starts import bicycles, starts
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.reference import making
from heyoka_bike.reference.proof import cauchy
from heyoka_bike.reference.proof.enclose import enclose

pytestmark = pytest.mark.proof

NUMBER = 73
"""Number of a drawn start with a trail of 0.02003 front wheel radii."""


@pytest.fixture
def drawn(bicycle, maneuvers):
    *_, maneuver = starts(maneuvers[0], NUMBER + 1)
    found = list(bicycles(bicycle, 20))
    return found[NUMBER % len(found)], maneuver


def test_the_few_product_form_is_proved_in_a_smaller_polydisc(drawn, monkeypatch):
    run = integrate(*drawn, is_regular=False)
    better = integrate(*drawn, 30, is_regular=False)
    ends = (r.state(run.breaks[-1]) for r in (run, better))
    errors = [abs(float(x - y)) for x, y in zip(*ends, strict=True)]
    bounds = enclose(run).end
    assert 0 < max(errors) < max(bounds) < 1e-11
    assert all(e <= b for e, b in zip(errors, bounds, strict=True))
    monkeypatch.setattr(cauchy, "SMALLER_STILL", ())
    with pytest.raises(NotCertifiedError, match="a divisor may vanish"):
        enclose(run)


def test_a_set_is_made_in_the_regular_form(drawn, monkeypatch):
    """The regular form is proved in less time; the candidate shows its form."""

    def is_regular():
        return making._integrated(*drawn, making.MIN_DIGITS, lambda stage, t: None).is_regular

    assert is_regular()
    monkeypatch.setattr(making, "_LEAST_TRAIL", 0.01)
    assert not is_regular()
