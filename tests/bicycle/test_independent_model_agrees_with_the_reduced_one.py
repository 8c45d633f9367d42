"""The equations of the package and the Newton-Euler oracle describe the same bicycle.

Both forms of the reduced equations, the energies and the stored columns are compared at random
states with both wheels on the floor, far from upright, for the benchmark bicycle and for others.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import flint
import pytest

from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, read_bicycle
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle
from oracles import vectors
from oracles.newton_euler import solve_pitch
from support.two_models import (
    Both,
    Pairs,
    from_the_columns,
    from_the_few_product_form,
    from_the_regular_form,
)

BENCHMARK = read_bicycle(benchmark_bicycle())
DIGITS = 80
# The values have 80 digits, less a few for cancellation and for a small mechanical trail.
TOLERANCE = "1e-60"
BALLS = Balls(400)
ORACLE_BALLS = vectors.Balls(100)


@dataclass(frozen=True)
class Case:
    """A bicycle and its state."""

    seed: int
    bicycle: Bicycle
    roll: Fraction
    steer: Fraction
    roll_rate: Fraction
    steer_rate: Fraction
    speed: Fraction
    yaw: Fraction

    @classmethod
    def random(cls, seed: int) -> Case:
        rng = random.Random(seed)
        return cls(
            seed,
            BENCHMARK,
            roll=_between(rng, -1, 1),
            steer=_between(rng, -1, 1),
            roll_rate=_between(rng, -3, 3),
            steer_rate=_between(rng, -3, 3),
            speed=_between(rng, -3, 10),
            yaw=_between(rng, -3, 3),
        )

    def with_another_bicycle(self) -> Case:
        """Return a case with every parameter changed by up to a quarter, and another trail sign."""
        rng = random.Random(f"bicycle {self.seed}")
        changes = {}
        for symbol in PARAMETERS:
            factor, x = 1 + _between(rng, -1, 1) / 4, BENCHMARK[symbol]
            changes[symbol] = Exact(factor * x.rational, factor * x.pi_multiple)
        if rng.random() < Fraction(1, 2):
            changes["c"] = Exact(-changes["c"].rational)
        return replace(self, bicycle=BENCHMARK.replace(**changes))


def _between(rng: random.Random, low: int, high: int) -> Fraction:
    return Fraction(rng.randint(low * 10**6, high * 10**6), 10**6)


def both_of(case: Case) -> Both:
    """Return the state in both models, in balls."""
    return Both.of(
        case.bicycle, BALLS, ORACLE_BALLS, case.yaw, roll=case.roll,
        pitch=solve_pitch(case.bicycle, case.roll, case.steer, DIGITS), steer=case.steer,
        roll_rate=case.roll_rate, steer_rate=case.steer_rate, speed=case.speed,
    )  # fmt: skip


@pytest.fixture(autouse=True)
def _working_precision() -> Iterator[None]:
    with BALLS.precision():
        yield


def compare(pairs: Pairs, seed: int) -> None:
    limit = flint.arb(TOLERANCE)
    for name, (found, expected) in pairs.items():
        # A comparison of balls is true only if it is certain. It is false if one of the balls is
        # NaN.
        assert abs(found - expected) <= limit * abs(expected), f"{name}, seed {seed}"


def compare_all(case: Case) -> None:
    both = both_of(case)
    compare(from_the_regular_form(both), case.seed)
    compare(from_the_few_product_form(both), case.seed)
    compare(from_the_columns(both), case.seed)


# An error in any term shows in almost every state, so a few states are enough.
def test_at_20_random_states_of_the_benchmark() -> None:
    for seed in range(20):
        compare_all(Case.random(seed))


@pytest.mark.parametrize("seed", range(1000, 1020))
def test_at_random_states_of_other_bicycles(seed: int) -> None:
    compare_all(Case.random(seed).with_another_bicycle())


@pytest.mark.slow
def test_at_many_random_states_of_the_benchmark_and_of_other_bicycles() -> None:
    for seed in range(10_000, 15_000):
        compare_all(Case.random(seed))
        compare_all(Case.random(seed + 10_000).with_another_bicycle())


@pytest.mark.parametrize("symbol", sorted(PARAMETERS))
def test_a_parameter_off_by_1e_50_is_noticed(symbol: str) -> None:
    case = Case.random(1)
    both, x = both_of(case), case.bicycle[symbol]
    factor = 1 + Fraction(1, 10**50)
    other = case.bicycle.replace(**{symbol: Exact(factor * x.rational, factor * x.pi_multiple)})
    wrong = replace(both, k=constants(other, BALLS))
    with pytest.raises(AssertionError):
        compare(from_the_regular_form(wrong), case.seed)
