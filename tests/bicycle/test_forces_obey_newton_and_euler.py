"""Every column of the whole motion agrees with the Newton-Euler oracle at random states.

The oracle solves for all accelerations and the 21 reactions at once; it shares no line with
`forces` and `configuration`.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import pytest
from test_independent_model_agrees_with_the_reduced_one import BALLS, Case, both_of, compare

from heyoka_bike.bicycle.equations.bodies import bodies
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.numbers.exact import Exact
from support.two_models import found_motion, from_the_integrals, from_the_whole_motion, whole_motion


@pytest.fixture(autouse=True)
def _working_precision() -> Iterator[None]:
    with BALLS.precision():
        yield


def compare_all(case: Case) -> None:
    both = both_of(case)
    compare(from_the_integrals(both), case.seed)
    for is_regular in (True, False):
        compare(from_the_whole_motion(both, is_regular=is_regular), case.seed)


def test_every_column_is_compared() -> None:
    both = both_of(Case.random(0))
    names = {c.name for c in MOTION_COLUMNS}
    quaternions = {f"{end}_frame_q{i}" for end in ("rear", "front") for i in range(4)}
    assert set(found_motion(both, is_regular=True)) == names
    assert names - quaternions <= set(whole_motion(both))


def test_at_random_states_of_the_benchmark() -> None:
    for seed in range(20):
        compare_all(Case.random(seed))


@pytest.mark.parametrize("seed", range(1000, 1030))
def test_at_random_states_of_other_bicycles(seed: int) -> None:
    compare_all(Case.random(seed).with_another_bicycle())


@pytest.mark.parametrize("symbol", sorted(PARAMETERS))
def test_a_parameter_off_by_1e_50_is_noticed(symbol: str) -> None:
    """Only the bodies have the wrong parameter; the equations of motion have the right one."""
    case = Case.random(1)
    both, x = both_of(case), case.bicycle[symbol]
    factor = 1 + Fraction(1, 10**50)
    other = case.bicycle.replace(**{symbol: Exact(factor * x.rational, factor * x.pi_multiple)})
    with pytest.raises(AssertionError):
        compare(from_the_whole_motion(both, is_regular=True, b=bodies(other, BALLS)), case.seed)
