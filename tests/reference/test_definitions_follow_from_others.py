"""Definitions that no dataset stores agree with an independent model at its states.

The oracle uses Newton's and Euler's equations of the four bodies and does not know the columns.
"""

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, FOLLOWING
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Doubles
from heyoka_bike.reference.following import FOLLOWS
from oracles.newton_euler import move
from oracles.vectors import Multiprecision, axes, rotation

NAMES = [c.name for c in FOLLOWING]
STATE = ("roll_angle", "pitch", "steer_angle", "yaw", "roll_rate", "steer_rate", "forward_speed")
# Largest error, relative to the scale of a column: the dataset is accurate to 1e-31, and a formula
# adds roundoff.
SMALL = 1e-29


def exactly(values, name, row):
    return Fraction(float(values.hi[name][row])) + Fraction(float(values.lo[name][row]))


def from_the_oracle(bicycle, state):
    """Return the definitions from the oracle's motion, rotated by the yaw."""
    number = Multiprecision(40)
    roll, pitch, steer, yaw, roll_rate, steer_rate, speed = state
    pitch, yaw, sqrt = number.exact(pitch), number.exact(yaw), number.sqrt
    m = move(bicycle, roll, pitch, steer, roll_rate=roll_rate, steer_rate=steer_rate,
             speed=speed, arithmetic=lambda _: number)  # fmt: skip
    turn = rotation(number, axes(number)[2], yaw)
    v, omega = turn(m.velocities["B"].linear), turn(m.velocities["B"].angular)
    ahead = turn(m.bodies["B"].attitude(axes(number)[0]))
    change, heading = omega.cross(ahead), turn(axes(number)[0])
    level = ahead[0] ** 2 + ahead[1] ** 2
    return {
        "forward_speed_rear_com_heading": v.dot(heading),
        "forward_speed_rear_com_body_x": v.dot(ahead),
        "forward_speed_rear_com_global_x": v[0],
        "forward_speed_rear_com_norm": sqrt(v.dot(v)),
        "yaw_zyx": ahead[0].context.atan2(ahead[1], ahead[0]),
        "yaw_rate_zyx_rate": (ahead[0] * change[1] - ahead[1] * change[0]) / level,
    }


@pytest.mark.parametrize("time", ["0", "1.234567", "10"])
def test_they_are_those_of_an_independent_model(reference, time):
    bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
    for m in reference.values():
        found = m.evaluate([time], (*STATE, *NAMES))
        wanted = from_the_oracle(bicycle, [exactly(found, name, 0) for name in STATE])
        assert wanted.keys() == set(NAMES)
        for name, x in wanted.items():
            error = Multiprecision(40).exact(exactly(found, name, 0)) - x
            assert abs(error) < SMALL * m.scale(name), name


def test_they_are_the_same_at_rows_between_them_and_in_plain_numbers(reference):
    m = reference[2]
    some = m.time[::7]
    near = m.approximate(some, NAMES)
    between = m.evaluate_many((some, m.time_lo[::7]), NAMES)
    rows = m.evaluate_many((m.time, m.time_lo), NAMES)
    for name in NAMES:
        assert np.max(abs(near[name] - rows[name][::7])) < 4e-15 * m.scale(name)
        rest = (between[name] - rows[name][::7]) + (between.lo[name] - rows.lo[name][::7])
        assert np.max(abs(rest)) < 1e-26 * m.scale(name)


def test_a_set_has_them_if_it_has_what_they_follow_from(reference):
    assert set(NAMES) <= reference[1].at_any_time
    assert not set(NAMES) & set(reference[1].columns)
    assert set(NAMES) <= FOLLOWS.keys()
    with pytest.raises(InputError, match="column 'rear_friction'"):
        reference[1].evaluate(1.0, "rear_friction")
    assert set(reference[1].evaluate(1.0, BENCHMARK_COLUMNS)) == set(BENCHMARK_COLUMNS)


def test_sines_and_angles_have_thirty_one_digits():
    random = np.random.default_rng(1)
    hi = np.concatenate([[0.0, 1e-9, -1e-5, np.pi / 2], random.uniform(-7, 7, 60)])
    x = Doubles(hi, hi * 1e-17 * random.standard_normal(len(hi)))
    y = Doubles(np.flip(x.hi), np.flip(x.lo))
    with mpmath.workdps(50):

        def exact(z):
            parts = zip(z.hi.tolist(), z.lo.tolist(), strict=True)
            return [mpmath.mpf(a) + mpmath.mpf(b) for a, b in parts]

        pairs = [(x.sin(), map(mpmath.sin, exact(x))), (x.cos(), map(mpmath.cos, exact(x))),
                 (x.arctan2(y), map(mpmath.atan2, exact(x), exact(y)))]  # fmt: skip
        for found, wanted in pairs:
            assert max(abs(a - b) for a, b in zip(exact(found), wanted, strict=True)) < 1e-31
