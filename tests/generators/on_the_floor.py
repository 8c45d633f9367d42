"""States with both wheels on the floor, and derivatives along the motion, at high precision.

The tests of the equations use this module. A state of the regular form is a list of roll, pitch,
steer, roll rate, steer rate and spin; a state of the few-product form has w1 and w3 instead of the
rates.
"""

import random

from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.kinematics import front_contact_height, posture, rear_rates
from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.system.resources import benchmark_bicycle

DIGITS = 120
"""Working precision of the tests that differentiate numerically."""

STEP = 35
"""Central differences over 1e-35 s: their error is 1e-70 / 6 of the third derivative along the
motion, and 1e-85 from rounding at 120 digits."""


def model(digits=DIGITS, **changes):
    """Return the constants of the benchmark bicycle with `changes`, and the arithmetic used."""
    a = Multiprecision(digits)
    return constants(read_bicycle(benchmark_bicycle()).replace(**changes), a), a


def pitch_on_the_floor(k, a, roll, steer):
    """Return the pitch at which the front wheel touches the floor too."""
    mp = a.context
    return mp.findroot(
        lambda pitch: front_contact_height(k, a, roll, pitch, steer),
        (mp.zero, mp.mpf("0.001")),
        tol=mp.mpf(10) ** (10 - 2 * mp.dps),  # tolerance of the squared height
        maxsteps=60,
    )


def random_state(k, a, seed, lean=0.6, turn=0.8):
    """Return a state of the regular form; angles are 0.4 to 1 times `lean` and `turn` [rad]."""
    mp, rng = a.context, random.Random(seed)

    def number(low, high):
        return mp.mpf(rng.randrange(10**30)) / 10**30 * (high - low) + low

    roll, steer = (mp.mpf(x) * number(0.4, 1) * rng.choice((-1, 1)) for x in (lean, turn))
    pitch = pitch_on_the_floor(k, a, roll, steer)
    assert abs(front_contact_height(k, a, roll, pitch, steer)) < mp.mpf(10) ** (8 - mp.dps)
    assert abs(pitch) < 0.6, "the wrong root: the bicycle is overturned"
    return [roll, pitch, steer, number(-2, 2), number(-2, 2), number(3, 30)]


def few_product_state(k, a, state):
    """Return the same state in the variables of the few-product form."""
    roll, pitch, steer, roll_rate, steer_rate, spin = state
    o = posture(k, a, roll, pitch, steer)
    w1, w3 = rear_rates(o, k.rear.r * spin, roll_rate, steer_rate)
    return [roll, pitch, steer, w1, w3, spin]


def along(a, rates, state, values):
    """Return time derivatives of the list ``values(state)`` when the state moves with `rates`."""
    h = a.context.mpf(10) ** -STEP
    after, before = (
        values([x + side * h * rate for x, rate in zip(state, rates, strict=True)])
        for side in (1, -1)
    )
    return [(x - y) / (2 * h) for x, y in zip(after, before, strict=True)]
