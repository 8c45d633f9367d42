"""Every rate in the table of derivatives is the derivative of its angle.

The slopes are central differences of the reference's Chebyshev series of the angle.
"""

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import ANGLE_OF, COMPARED, DERIVATIVES, RATE_OF

STEP = 1e-4  # [s] step of the central differences
TIMES = np.linspace(0.1, 9.9, 99)
# The error of central differences is STEP**2 / 6 times the third derivative. The fastest mode has a
# time constant of about 1/20 s, so this is below 20**2 * STEP**2 / 6 = 7e-7 of the rate. Rounding
# of the angle adds 1e-16 / STEP = 1e-12.
OFF = 1e-6


def name_of(key, definition):
    return next(c.name for c in COMPARED[key] if c.definition == definition)


@pytest.mark.parametrize(("rate", "angle"), DERIVATIVES.items(), ids=lambda x: "_".join(x))
def test_the_rate_is_the_slope_of_its_angle(rate, angle, reference):
    rate, angle = name_of(*rate), name_of(*angle)
    maneuver = reference[2]
    later, sooner = (maneuver.approximate(TIMES + h, [angle])[angle] for h in (STEP, -STEP))
    exact = maneuver.approximate(TIMES, [rate])[rate]
    slope = (later - sooner) / (2 * STEP)
    assert np.max(np.abs(slope - exact)) < OFF * maneuver.scale(rate)


def test_a_key_has_one_rate_and_one_angle():
    assert {angle: rate for rate, angle in ANGLE_OF.items()} == RATE_OF
    assert {(rate, angle) for (rate, _), (angle, _) in DERIVATIVES.items()} == {*ANGLE_OF.items()}
