"""A function counts as analytic inside a circle only if the signs on the circle prove it.

The tests use functions of s itself: the candidate is the polynomial s, or a constant, and the
polydisc is a disc.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import pytest

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.analytic import NotAnalyticError, Rim, array
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.reference.proof import cauchy
from heyoka_bike.reference.proof.cauchy import circle_bound, rho


@dataclass(frozen=True)
class Polynomials:
    """A substitute for a segment."""

    rows: tuple[tuple[int, ...], ...]
    grid: int = 0


S = Polynomials(((0, 1),))
RADIUS = 2


@pytest.fixture
def equations(bicycle: Any) -> Equations:
    return Equations.of(bicycle, Balls(64))


def bound(equations: Equations, f: Any, piece: Any = S) -> float:
    """Return the bound on abs(f) on the circle and the polydisc."""
    circle = circle_bound(piece, lambda e, x: [f(e.a, *x)], equations, (RADIUS,))
    return float(circle.values[0])


@pytest.mark.parametrize("pole", [0, 1, Fraction(3, 2), 2])
def test_a_pole_inside_or_on_the_circle_is_seen(equations: Equations, pole: Fraction) -> None:
    n, d = Fraction(pole).as_integer_ratio()
    for f in (lambda a, s: 1 / (d * s - n), lambda a, s: (s + 1) / (d * s - n)):
        with pytest.raises(NotAnalyticError, match=r"may vanish|changes the sign"):
            bound(equations, f)


def test_a_pole_outside_does_no_harm(equations: Equations) -> None:
    assert 1 <= bound(equations, lambda a, s: 1 / (s - 3)) < 10


def test_what_a_division_gives_may_be_a_divisor(equations: Equations) -> None:
    """The pole of 1 / (1 + 1 / (s - 3)) is at 2, where its first divisor is harmless."""
    with pytest.raises(NotAnalyticError, match=r"may vanish|changes the sign"):
        bound(equations, lambda a, s: 1 / (1 + 1 / (s - 3)))


@pytest.mark.parametrize("cut", [1, 2])
def test_a_root_off_its_cut(equations: Equations, cut: int) -> None:
    assert 5**0.5 <= bound(equations, lambda a, s: a.sqrt(s + 3)) < 3
    with pytest.raises(NotAnalyticError):
        bound(equations, lambda a, s: a.sqrt(s + cut))


def test_a_root_of_what_is_negative(equations: Equations) -> None:
    with pytest.raises(NotAnalyticError, match="negative"):
        bound(equations, lambda a, s: a.sqrt(s - 3))


def test_an_angle_off_its_branch_points(equations: Equations) -> None:
    assert 0.4 < bound(equations, lambda a, s: a.atan2(s / 8, (s + 12) / 12)) < 1
    with pytest.raises(NotAnalyticError, match="quarter turn"):
        bound(equations, lambda a, s: a.atan2(s, s - 3))
    with pytest.raises(NotAnalyticError, match="quarter turn"):
        bound(equations, lambda a, s: a.atan2(s, flint.arb(-3)))
    # At s = 2 i the tangent is i, which is the branch point.
    with pytest.raises(NotAnalyticError, match="branch point"):
        bound(equations, lambda a, s: a.atan2(s / 2, 1 + 0 * s))


def test_a_constant_that_may_be_zero_bounds_nothing(equations: Equations) -> None:
    with pytest.raises(NotAnalyticError, match="not finite"):
        bound(equations, lambda a, s: s / flint.arb(0, 1))


def test_signs_are_those_of_the_arcs_before() -> None:
    rim = Rim(64)
    rim.start(1)
    rim.watch(flint.acb(1, 5))
    rim.start(1)
    with pytest.raises(NotAnalyticError, match="changes the sign"):
        rim.watch(flint.acb(-1, 5))


def test_an_arc_that_is_refused_says_nothing_of_signs() -> None:
    rim = Rim(64)
    rim.start(2)
    rim.watch(array([flint.acb(2), flint.acb(flint.arb(0, 1), 5)]))
    rim.watch(array([flint.acb(2), flint.acb(-2)]))
    assert rim.clear.tolist() == [True, False]


def test_the_bound_holds_on_the_whole_polydisc(
    equations: Equations, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_rest = Polynomials(((3,),))
    radius = float(rho(1)[0])
    assert bound(equations, lambda a, x: x, at_rest) >= 3 + radius
    monkeypatch.setattr(cauchy, "rho", lambda variables: [flint.arb(0)] * variables)
    assert bound(equations, lambda a, x: x, at_rest) < 3 + radius


def test_the_bound_holds_between_the_middles_of_the_arcs(equations: Equations) -> None:
    """s + s^2 is largest at s = 2, the end of an arc."""
    assert bound(equations, lambda a, s: s + s * s) >= 6


def test_arcs_together_give_the_bound_of_each_alone(equations: Equations) -> None:
    """The bounds agree to the last bit, because published bounds follow from them."""

    def f(a: Any, s: Any) -> Any:
        return a.sin(s) / (s + 5) + s * s

    largest = 0.0
    line = flint.acb_poly([0, 1])
    with equations.precision():
        for arc in cauchy._HALF_CIRCLE:
            rim = Rim(64)
            rim.start(1)
            (at,) = cauchy._arc([line], [flint.arb(1)], rho(1), RADIUS, *arc)
            largest = max(largest, float(abs(f(rim, rim.value(at)).x).upper()))
            assert rim.clear.all()
    assert bound(equations, f) == largest
