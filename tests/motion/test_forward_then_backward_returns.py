"""Integrating forward and back returns to the start, up to the error growth of the reversed flow.

Backward, the castering mode (an eigenvalue of about -13 per s forward) grows: over a span T it
multiplies errors by exp(13.3 T). The span is chosen so that this costs at most half of binary128's
34 digits: T = 1.25 s costs 7.2 digits at maneuver 2's speed.
"""

from math import exp

import heyoka as hy
import numpy as np

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.precision import Precision

SPAN = 1.25
# [1/s] decay rate of the castering mode at 4.6 m/s, from the linearised equations.
CASTERING = 13.2986395157676401323827052583


def test_binary128_returns_to_its_start(bicycle, maneuvers):
    precision = Precision.of("binary128")
    balls = Balls(200)
    with balls.precision():
        start = initial_state(Equations.of(bicycle, balls, is_regular=False), maneuvers[1])
        state = [hy.real128(x.str(40, radius=False)) for x in start]
    ta = hy.taylor_adaptive(
        right_hand_side(bicycle, precision), state, fp_type=hy.real128, compact_mode=True
    )
    before = ta.state.copy()
    ta.propagate_until(hy.real128(SPAN))
    moved = ta.state.copy()
    ta.propagate_until(hy.real128(0))
    back = np.abs((ta.state - before).astype(np.float64)).max()
    assert np.abs((moved - before).astype(np.float64)).max() > 0.05
    epsilon, largest = 2.0**-113, 20.0
    expected = epsilon * largest * exp(CASTERING * SPAN)
    # A few roundings in each of about 40 steps add up. The error is far below 1e-17, which is half
    # of the digits of binary128.
    assert back < 1e3 * expected
    assert back < 1e-17
    # The return does lose digits: without the growth of errors, it would only have an error of
    # roundoff.
    assert back > 10 * epsilon
