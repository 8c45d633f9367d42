"""`End` gives the state at the end of a motion with the digits it is asked for."""

import dataclasses
from fractions import Fraction

import flint
import pytest

from heyoka_bike.errors import SingularMotionError
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.workbench.fast.ends import End

pytest.importorskip("heyoka")
pytestmark = pytest.mark.proof


# Units of the last place of the speed over the wheel's radius, some tens of steps.
@pytest.mark.parametrize(("precision", "most"), [("binary128", 2e-32), (40, 2e-39), (70, 2e-69)])
def test_the_end_is_that_of_the_candidate(candidate, precision, most):
    published = candidate[1]
    short = dataclasses.replace(published.maneuver, duration=Fraction(2))
    run = End(published.bicycle, short, precision)
    found = run()
    with Balls(published.bits + 64).precision():
        right = published.state(short.duration)[:6]
        wrong = [
            abs(float((flint.arb(str(x)) - y).mid())) for x, y in zip(found, right, strict=True)
        ]
    # Not more digits than were asked for, either: the precision would not be the one used.
    assert most / 1e5 < max(wrong) < most
    assert 5 < run.steps < 60


def test_a_fall_is_told(bicycle, maneuvers):
    fall = dataclasses.replace(
        maneuvers[0], speed=Exact(Fraction(1, 2)), roll_rate=Exact(Fraction(1))
    )
    with pytest.raises(SingularMotionError) as e:
        End(bicycle, fall, "binary128")()
    assert 0 < e.value.time < 10
