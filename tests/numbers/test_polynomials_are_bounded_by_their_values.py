"""Values at Chebyshev nodes bound a polynomial in between, with the smallest possible factor."""

from __future__ import annotations

import random

import flint
import pytest

from heyoka_bike.numbers.ball_chebyshev import chebyshev_nodes, in_between

BETWEEN = [flint.arb(i) / 500 for i in range(-500, 501)]


def largest(p: flint.arb_poly, points: list[flint.arb]) -> float:
    return max(float(abs(p(x)).mid()) for x in points)


@pytest.mark.parametrize(("degree", "count"), [(1, 2), (7, 8), (7, 14), (31, 62)])
def test_a_polynomial_between_nodes_is_bounded(degree: int, count: int) -> None:
    rng = random.Random(degree)
    nodes, factor = chebyshev_nodes(count), float(in_between(degree, count))
    for _ in range(5):
        p = flint.arb_poly([rng.uniform(-1, 1) for _ in range(degree + 1)])
        assert largest(p, BETWEEN) <= factor * largest(p, nodes) * (1 + 1e-12)


def test_the_factor_is_the_smallest() -> None:
    """All values of T_n at the zeros of T_2n are sqrt(1/2) in magnitude."""
    p = flint.arb_poly([-1, 0, 2])
    assert largest(p, chebyshev_nodes(4)) * float(in_between(2, 4)) == pytest.approx(1, rel=1e-12)
    assert largest(p, BETWEEN) == 1
