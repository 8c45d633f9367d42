"""Values at roots of unity give Taylor coefficients, within a bound of two necessary terms."""

from __future__ import annotations

from typing import Any

import flint
import pytest

from heyoka_bike.numbers import analytic
from heyoka_bike.numbers.analytic import Samples
from oracles.power_series import PowerSeries

BITS, LENGTH, RADIUS = 100, 20, 3


def formula(a: Any, x: Any) -> Any:
    """A formula with every operation, analytic for abs(x) <= 3; singular at -4 and 4."""
    y = a.sqrt(x + 4) * a.number(3)
    return a.sum([a.sin(x) / y, a.cos(x), -a.atan2(x, y + 8), 2 - x * x])


def test_coefficients_are_those_of_series() -> None:
    points, series = Samples(BITS, LENGTH, RADIUS), PowerSeries(BITS, LENGTH)
    with series.precision():
        expected = series.coefficients(formula(series, series.series([0, 1])))
        state = points.polynomials([[flint.arb(0), flint.arb(1)]])
        (found,) = points.coefficients([formula(points, state[0])])
        # The function is at most 20 for abs(s) = 3, so the folded terms are at most 20 * 2^-64. The
        # truncation error of the series itself is 1e-28.
        folded = 20 * analytic.folded(RADIUS, LENGTH + 41) + 1e-28
        assert folded < 1e-25
        for x, y in zip(found, expected, strict=True):
            assert abs(x - y) < folded
            assert x.rad() < 1e-25


def test_constants_and_long_polynomials_have_coefficients() -> None:
    points = Samples(BITS, 4, 2)
    with points.precision():
        long = [flint.arb(0)] * 50 + [flint.arb(1)]
        (values,) = points.polynomials([long])
        (node,) = points.polynomials([[flint.arb(0), flint.arb(1)]])
        assert all(abs(x - z**50) < 1e-25 for x, z in zip(values, node, strict=True))
        assert [float(c) for c in points.coefficients([7])[0]] == pytest.approx([7, 0, 0, 0])


def test_a_matrix_of_functions_has_zeros_where_it_is_zero() -> None:
    points = Samples.of(BITS, 3, RADIUS)
    with points.precision():
        (node,) = points.polynomials([[flint.arb(0), flint.arb(1)]])
        found = points.matrices([[node, 0], [node * node + 2, 5]])
    expected = [[0, 0, 2, 5], [1, 0, 0, 0], [0, 0, 1, 0]]
    for m, terms in zip(found, expected, strict=True):
        assert all(x.contains(y) for x, y in zip(m.entries(), terms, strict=True))
        assert max(float(x.rad()) for x in m.entries()) < 1e-25
        assert m[0, 1] == 0


def distances() -> list[tuple[float, float]]:
    """Return the distance of each power of s from its polynomial on the unit circle, and its bound.

    The number of points is as small as possible.
    """
    points = Samples(BITS, 6, RADIUS, folded_bits=0)
    angles = [flint.fmpq(j, 12) for j in range(13)]
    circle = [flint.acb(flint.arb.cos_pi_fmpq(q), flint.arb.sin_pi_fmpq(q)) for q in angles]
    found = []
    with points.precision():
        (node,) = points.polynomials([[flint.arb(0), flint.arb(1)]])
        for power in range(20):
            (c,) = points.coefficients([node**power])
            off = max(float(abs(flint.acb_poly(c)(s) - s**power).upper()) for s in circle)
            bound = float((flint.arb(RADIUS) ** power * points.left_out).lower())
            found.append((off, bound))
    return found


def test_what_is_left_out_is_bounded() -> None:
    assert all(off <= bound for off, bound in distances())


@pytest.mark.parametrize("part", ["geometric", "folded"])
def test_both_parts_of_what_is_left_out_are_needed(
    part: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(analytic, part, lambda radius, length: flint.arb(0))
    assert not all(off <= bound for off, bound in distances())
