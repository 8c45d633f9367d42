"""The motion of the reduced equations satisfies Lagrange's equations in redundant coordinates.

The descriptor form shares only the bodies' constants with the reduced equations. It has its own
coordinates, energies and rolling conditions, and its multipliers must equal the forces from
`forces`.
"""

from __future__ import annotations

from collections.abc import Iterator

import flint
import pytest
from test_independent_model_agrees_with_the_reduced_one import BALLS, BENCHMARK, Case, both_of

from heyoka_bike.bicycle.equations.bodies import bodies
from heyoka_bike.bicycle.equations.descriptor import (
    COORDINATES,
    Descriptor,
    from_reduced,
    to_reduced,
)
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.exact import Exact
from support.two_models import ANGLES, PLACE

N = len(COORDINATES)
# The values have 400 bits, less a few for cancellation and for a small mechanical trail.
TOLERANCE = flint.arb("1e-60")


@pytest.fixture(autouse=True)
def _working_precision() -> Iterator[None]:
    with BALLS.precision():
        yield


def state_of(case: Case) -> list[Number]:
    both = both_of(case)
    return [*both.regular_state, both.yaw, *map(BALLS.number, (*PLACE, *ANGLES))]


def vanish(values: list[Number], of: list[Number]) -> bool:
    """Return whether all values are far below the largest of some others."""
    largest = max(abs(flint.arb(x)).upper() for x in of)
    return all(abs(flint.arb(x)) <= TOLERANCE * largest for x in values)


CASES = [
    *(Case.random(seed) for seed in range(15)),
    *(Case.random(seed).with_another_bicycle() for seed in range(1000, 1010)),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case.seed))
def test_every_residual_vanishes(case: Case) -> None:
    y = state_of(case)
    equations = Equations.of(case.bicycle, BALLS)
    z, rates = from_reduced(equations, y)
    form = Descriptor(equations.b, BALLS)
    for index in (2, 3):
        assert vanish(form.residual(z, rates, index=index), z)
    back = to_reduced(equations.b, BALLS, z)
    assert vanish([a - b for a, b in zip(back, y, strict=True)], y)


@pytest.mark.parametrize("symbol", ["w", "c", "lam", "g", "rR", "IRyy", "zB", "IBxz", "mF", "IFxx"])
def test_a_parameter_off_by_1e_50_is_noticed(symbol: str) -> None:
    case = Case.random(1)
    x = BENCHMARK[symbol]
    factor = 1 + Exact.parse("1e-50").rational
    other = BENCHMARK.replace(**{symbol: Exact(factor * x.rational, factor * x.pi_multiple)})
    z, rates = from_reduced(Equations.of(BENCHMARK, BALLS), state_of(case))
    found = Descriptor(bodies(other, BALLS), BALLS).residual(z, rates, index=2)
    assert not vanish(found, z)


def test_its_parts_make_up_the_residual() -> None:
    """The state is off the floor, with slipping velocities."""
    generator = iter(range(1, 100))
    z, rates = ([BALLS.number(next(generator)) / 50 for _ in range(2 * N + 6)] for _ in range(2))
    q, v, multipliers = z[:N], z[N : 2 * N], z[2 * N :]
    acceleration = rates[N : 2 * N]
    form = Descriptor(bodies(BENCHMARK, BALLS), BALLS)
    mass, rolling = form.mass(q), form.rolling(q)
    still = form.inertia_forces(q, v, [BALLS.number(0)] * N)

    def times(row: list[Number], x: list[Number]) -> Number:
        return sum((a * b for a, b in zip(row, x, strict=True)), flint.arb(0))

    expected = [
        *(a - b for a, b in zip(rates, v, strict=False)),
        *(
            times(mass[i], acceleration)
            + still[i]
            - times([row[i] for row in rolling], multipliers)
            for i in range(N)
        ),
        *(times(row, v) for row in rolling),
    ]
    found = form.residual(z, rates, index=2)
    assert vanish([a - b for a, b in zip(found, expected, strict=True)], expected)
    assert vanish([mass[i][j] - mass[j][i] for i in range(N) for j in range(i)], mass[2])
    # The vertical velocities are the derivatives of the heights.
    moving = [Dual(x, (rate,)) for x, rate in zip(q, v, strict=True)]
    heights = form.over(Duals(BALLS)).heights(moving)
    by_time = [h.slopes[0] for h in heights]
    assert vanish([by_time[0] - found[2 * N + 2], by_time[1] - found[2 * N + 5]], by_time)
    assert not vanish(form.heights(q), by_time)
