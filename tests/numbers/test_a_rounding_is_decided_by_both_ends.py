"""An enclosed number is rounded if both ends of the enclosure round to the same number."""

from __future__ import annotations

from fractions import Fraction

import flint
import pytest

from heyoka_bike.errors import UndecidedError
from heyoka_bike.numbers.rounding import (
    Enclosure,
    decided_digits,
    decimal_digits,
    hi_lo,
    nearest_pair,
    upward,
    upward_ball,
)

TIE = 1 + Fraction(1, 2**53)
"""Halfway between 1 and the next binary64."""


def ball(middle: Fraction, radius: Fraction) -> Enclosure:
    with flint.ctx.workprec(300):
        x, r = (flint.arb(flint.fmpq(y.numerator, y.denominator)) for y in (middle, radius))
        return Enclosure.of(flint.arb(x, r))


TINY = Fraction(1, 2**200)


@pytest.mark.parametrize("side", [-1, 1])
def test_beside_a_tie(side: int) -> None:
    hi, lo = hi_lo(ball(TIE + side * 2 * TINY, TINY), "x")
    assert hi == (1 if side < 0 else 1 + 2.0**-52)
    assert lo == -side * 2.0**-53


def test_across_a_tie() -> None:
    with pytest.raises(UndecidedError, match="round it to binary64"):
        hi_lo(ball(TIE, TINY), "x")


def test_across_a_tie_of_the_rest() -> None:
    rest = Fraction(1, 2**60) * TIE
    assert hi_lo(ball(1 + rest + 2 * TINY, TINY), "x") == (1, 2.0**-60 * (1 + 2.0**-52))
    with pytest.raises(UndecidedError, match=r"round it to hi \+ lo"):
        hi_lo(ball(1 + rest, TINY), "x")


def test_decimals_across_a_tie() -> None:
    tie = Fraction(12345, 10000)
    with pytest.raises(UndecidedError, match="round it to 4 digits"):
        decimal_digits(ball(tie, TINY), 4, "x")
    assert decimal_digits(ball(tie + 2 * TINY, TINY), 4, "x") == "1.235e+0"
    assert decimal_digits(ball(tie - 2 * TINY, TINY), 4, "x") == "1.234e+0"


def test_a_ball_around_an_exact_value_decides_only_what_it_does_not_reach() -> None:
    with pytest.raises(UndecidedError, match=r"round it to hi \+ lo"):
        hi_lo(ball(Fraction(4), TINY), "x")
    assert hi_lo(Enclosure.of(Fraction(4)), "x") == (4, 0)
    # A value exactly halfway between two numbers is rounded to the even number.
    assert hi_lo(Enclosure.of(TIE), "x") == (1, 2.0**-53)


@pytest.mark.parametrize(
    ("middle", "found"),
    [
        (TIE, (1, 2.0**-53, False)),
        (Fraction(0), (0, 0, False)),
        (Fraction(4), (4, 0, False)),
        (Fraction(1, 10**50), (1e-50, 0, False)),
        (Fraction(1, 10), (0.1, -5.551115123125783e-18, True)),
    ],
)
def test_candidates_of_what_is_not_decided(middle: Fraction, found: tuple[float, ...]) -> None:
    assert nearest_pair(ball(middle, TINY)) == found


@pytest.mark.parametrize(
    ("middle", "radius", "text"),
    [
        (Fraction(0), Fraction(1, 10**62), "0e-61"),
        (Fraction(1, 3), Fraction(1, 10**9), "3.3333333e-1"),
        (Fraction(-99999, 1000), Fraction(1, 100), "-1.000e+2"),
        (Fraction(12345, 10000), TINY, "1.23e+0"),
    ],
)
def test_fewer_digits_are_good_to_a_unit_of_the_last(
    middle: Fraction, radius: Fraction, text: str
) -> None:
    x = ball(middle, radius)
    found, is_decided = decided_digits(x, 4 if text == "1.23e+0" else 50)
    assert (found, is_decided) == (text, False)
    digits, _, exponent = text.partition("e")
    unit = Fraction(10) ** (int(exponent) - len(digits.partition(".")[2]))
    assert all(abs(end - Fraction(found)) <= unit for end in (x.low, x.high))


def test_an_enclosure_has_all_of_its_ball() -> None:
    x = ball(Fraction(1, 3), Fraction(1, 1000))
    assert x.low <= Fraction(1, 3) - Fraction(1, 1000)
    assert x.high >= Fraction(1, 3) + Fraction(1, 1000)


def test_bounds_are_rounded_up() -> None:
    assert upward(TIE) == 1 + 2.0**-52
    assert upward(Fraction(1)) == 1
    assert upward(1 - Fraction(1, 2**60)) == 1


def test_bounds_of_balls_are_rounded_up() -> None:
    assert upward_ball(flint.arb(1, 2.0**-80)) == 1 + 2.0**-52
    assert 0.25 <= upward_ball(flint.arb(0, 0.25)) < 0.2501
    with flint.ctx.workprec(300):
        assert upward_ball(flint.arb(2) ** 80 - 1) == 2.0**80
        assert upward_ball(flint.arb(2) ** 80) == 2.0**80


def test_the_size_of_an_enclosure_is_that_of_its_farther_end() -> None:
    half = Fraction(1, 2)
    assert Enclosure(-3 * half, 2 * half).size() == 1.5
    assert Enclosure(-half, 1 + half / 2).size() == 1.25
