"""The virtual power of the four bodies vanishes for the accelerations of Newton and Euler.

`oracles.newton_euler` computes these accelerations and all reactions from 45 equations.
`oracles.virtual_power` contains no reactions.
"""

from __future__ import annotations

import random
from fractions import Fraction

import flint
import pytest

from heyoka_bike.bicycle.parameters import Bicycle, read_bicycle
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle
from oracles.newton_euler import Motion, move
from oracles.vectors import Balls
from oracles.virtual_power import FREE, Balance, Jet, balance

BENCHMARK = read_bicycle(benchmark_bicycle())
OTHER = BENCHMARK.replace(IBxz=Exact(Fraction(-3)), IHxz=Exact(Fraction(1, 100)))
DIGITS = 60
NUMBER = Balls(DIGITS)
# The pitch of the independent model has 60 digits, and forces below 1e4 N multiply its error.
TOLERANCE = "1e-50"


def random_motion(seed: int, bicycle: Bicycle) -> Motion:
    rng = random.Random(seed)
    roll, steer, roll_rate, steer_rate, speed = (
        Fraction(rng.randint(-1000, 1000), 1000) * size for size in (1, 1, 3, 3, 10)
    )
    rates = {"roll_rate": roll_rate, "steer_rate": steer_rate, "speed": speed}
    return move(bicycle, roll, None, steer, **rates, digits=DIGITS)


def balance_of(m: Motion, bicycle: Bicycle, added: dict[str, Fraction]) -> Balance:
    """Return the balance of a motion after adding to its accelerations."""
    radius = NUMBER.exact(bicycle["rR"])
    rates = {
        "yaw": Jet(m.yaw_rate, m.yaw_acc),
        "roll": Jet(m.roll_rate, m.roll_acc),
        "pitch": Jet(m.pitch_rate, m.pitch_acc),
        "steer": Jet(m.steer_rate, m.steer_acc),
        "spin": Jet(m.speed / radius, m.speed_acc / radius),
    }
    for name, x in added.items():
        rates[name] = Jet(rates[name].value, rates[name].rate + NUMBER.exact(x))
    values = {"yaw": flint.arb(0), "roll": m.roll, "pitch": m.pitch, "steer": m.steer}
    angles = {name: Jet(x, rates[name].value) for name, x in values.items()}
    return balance(NUMBER, bicycle, angles, rates)


@pytest.mark.parametrize("bicycle", [BENCHMARK, OTHER], ids=["benchmark", "other"])
@pytest.mark.parametrize("seed", range(5))
def test_at_random_states(seed: int, bicycle: Bicycle) -> None:
    with NUMBER.working():
        found = balance_of(random_motion(seed, bicycle), bicycle, {})
        for x in (*found.powers.values(), *found.slip, found.height):
            assert abs(x) < flint.arb(TOLERANCE)


@pytest.mark.parametrize("rate", ["yaw", "pitch", *FREE])
def test_another_acceleration_is_noticed(rate: str) -> None:
    with NUMBER.working():
        added = {rate: Fraction(1, 10**40)}
        found = balance_of(random_motion(1, BENCHMARK), BENCHMARK, added)
        assert max(map(abs, found.powers.values())) > flint.arb("1e-43")


def test_another_bicycle_is_noticed() -> None:
    with NUMBER.working():
        found = balance_of(random_motion(1, BENCHMARK), OTHER, {})
        assert max(map(abs, found.powers.values())) > 1
