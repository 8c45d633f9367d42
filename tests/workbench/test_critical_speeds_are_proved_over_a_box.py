"""Statements on every bicycle in a box of parameters are true of all bicycles that are tried."""

import json
import random
from fractions import Fraction
from functools import cache

import flint
import mpmath
import pytest

from bicycle_table import NAMES, committed, speeds
from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import collection
from heyoka_bike.workbench.boxes import box
from heyoka_bike.workbench.boxes.box import stability_box
from heyoka_bike.workbench.boxes.box_range import Affine, Affines, corner, is_negative, sign_over

pytestmark = pytest.mark.proof

MEASURED = ("browser", "crescendo", "pista", "rigid", "rigid-jason", "yellow", "yellowrev")
SAMPLES = 25
# Number of digits to which the speeds of the box are computed, before they are rounded outward.
DIGITS = 15


def _bicycle(name):
    return read_bicycle(collection("bicycles")[name])


@cache
def _box(name):
    """Return the box of one standard deviation, cached for several tests."""
    return stability_box(_bicycle(name), Fraction(1), DIGITS)


def _exact(v):
    return Fraction(mpmath.nstr(v, 30))


def _somewhere(bicycle, rng, sigmas=1):
    """Return a bicycle of the box, mostly at corners, where speeds are extreme."""
    changes = {}
    for symbol, u in bicycle.uncertainties.items():
        k = (
            rng.choice((-1, 1))
            if rng.random() < 0.8
            else Fraction(rng.randrange(-1000, 1001), 1000)
        )
        x, k = bicycle[symbol], k * Fraction(sigmas)
        changes[symbol] = Exact(x.rational + k * u.rational, x.pi_multiple + k * u.pi_multiple)
    return bicycle.replace(**changes)


@pytest.mark.parametrize("name", MEASURED)
def test_bicycles_of_the_box_have_their_speeds_within_the_bounds(name):
    bicycle = _bicycle(name)
    box = _box(name)
    rng = random.Random(name)
    for _ in range(SAMPLES):
        linear = linearise(_somewhere(bicycle, rng), 20)
        ranges = [
            (_exact(low), None if high is None else _exact(high))
            for low, high in linear.stable_ranges
        ]
        ((weave, _),) = linear.weave_speeds
        assert box.weave[0].low <= _exact(weave) <= box.weave[0].high
        if box.capsize is not None:
            assert len(box.capsize) == len(linear.capsize_speeds)
            for bound, v in zip(box.capsize, linear.capsize_speeds, strict=True):
                assert bound.low <= _exact(v) <= bound.high
        if box.every is not None:
            ((low, high),) = ranges
            assert low <= box.every[0]
            assert high is None or box.every[1] <= high
        for low, high in ranges:
            assert box.some[0] <= low
            assert box.some[1] is None or high <= box.some[1]


@pytest.mark.parametrize("name", MEASURED)
def test_the_bounds_are_attained(name):
    box = _box(name)
    for bound in (*box.weave, *(box.capsize or ())):
        assert bound.low <= bound.least < bound.most <= bound.high
        # If a derivative changes sign inside the box, at most this part of the width is lost.
        lost = Fraction(1, 1000) * (bound.high - bound.low)
        assert bound.least - bound.low <= lost
        assert bound.high - bound.most <= lost


def test_attained_speeds_are_those_of_a_bicycle_of_the_box():
    """Linearising the corner indicated by differences reproduces the speeds."""
    bicycle = _bicycle("pista")
    (bound,) = _box("pista").weave

    def weave(b):
        return linearise(b, 20).weave_speeds[0][0]

    def moved(symbol, k):
        x, u = bicycle[symbol], bicycle.uncertainties[symbol]
        return Exact(x.rational + k * u.rational)

    middle = weave(bicycle)
    rising = {s: 1 if weave(bicycle.replace(**{s: moved(s, 1)})) > middle else -1
              for s in bicycle.uncertainties}  # fmt: skip
    for sign, found in ((1, bound.most), (-1, bound.least)):
        v = weave(bicycle.replace(**{s: moved(s, sign * k) for s, k in rising.items()}))
        assert abs(v - mpmath.mpf(found.numerator) / found.denominator) < 1e-12


def test_the_standard_deviation_is_that_of_differences():
    bicycle, box = _bicycle("rigid"), _box("rigid")
    step = Fraction(1, 10**6)
    total = mpmath.mpf(0)
    for symbol, u in bicycle.uncertainties.items():
        ahead, behind = (
            linearise(
                bicycle.replace(**{symbol: Exact(bicycle[symbol].rational + k * u.rational)}), 20
            ).capsize_speeds[0]
            for k in (step, -step)
        )
        total += ((ahead - behind) / (2 * mpmath.mpf(float(step)))) ** 2
    # The differences are over 1e-6 of a standard deviation, and are computed with 20 digits.
    assert abs(mpmath.sqrt(total) - float(box.capsize[0].deviation)) < 1e-9


def test_a_tiny_box_is_the_bicycle_itself():
    bicycle = _bicycle("crescendo")
    linear = linearise(bicycle, 20)
    box = stability_box(bicycle, Fraction(1, 10**12), DIGITS)
    for (bound,), v in (
        (box.weave, linear.weave_speeds[0][0]), (box.capsize, linear.capsize_speeds[0]),
    ):  # fmt: skip
        assert bound.low < _exact(v) < bound.high
        assert bound.high - bound.low < 1e-11


def test_a_larger_box_says_less():
    one, three = _box("rigid"), stability_box(_bicycle("rigid"), Fraction(3), DIGITS)
    assert three.weave[0].low < one.weave[0].low < one.weave[0].high < three.weave[0].high
    assert one.every[0] < three.every[0] < three.every[1] < one.every[1]


def test_without_uncertainties_there_is_no_box(bicycle):
    with pytest.raises(InputError, match="found no uncertainties of 'benchmark bicycle'"):
        stability_box(bicycle, Fraction(1), DIGITS)


def test_a_box_outside_the_model_is_refused():
    with pytest.raises(InputError, match=r"-200 standard deviations: .*expected zero or more"):
        stability_box(_bicycle("pista"), Fraction(200), DIGITS)


def test_what_cannot_be_proved_is_not_said(capsys):
    """The uncertainty of the trail is 24 %, that of the tilt 10 %."""
    box = stability_box(_bicycle("balanceassistv1"), Fraction(1), 6)
    assert box.weave is None
    assert box.every is None
    assert main(["linear", "--bicycle", "yellowrev", "--speeds", "1", "--uncertainty"]) == 0
    assert "not decided" in capsys.readouterr().out


def test_the_command_prints_the_box_as_table_and_json(capsys):
    arguments = ["linear", "--bicycle", "browser", "--speeds", "1", "--digits", "8"]
    assert main([*arguments, "--uncertainty"]) == 0
    table = capsys.readouterr().out
    assert main([*arguments, "--uncertainty", "1", "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)["uncertainty"]
    box = stability_box(_bicycle("browser"), Fraction(1), 8)
    assert found["standard_deviations"] == "1"
    assert found["parameters"] == 26
    assert found["all_stable"] is None
    assert "no speed" in table
    for name in ("weave", "capsize"):
        (entry,), (bound,) = found[name], getattr(box, name)
        assert Fraction(entry["from"]) <= bound.low < bound.high <= Fraction(entry["to"])
        assert Fraction(entry["attained_from"]) >= bound.least
        assert Fraction(entry["attained_to"]) <= bound.most
        assert all(text in table for text in entry.values())
    assert main([*arguments, "--format", "json"]) == 0
    assert "uncertainty" not in json.loads(capsys.readouterr().out)


def test_intervals_are_rounded_to_the_safe_side(capsys):
    arguments = ["--bicycle", "rigid", "--speeds", "1", "--digits", "5", "--format", "json"]
    assert main(["linear", *arguments, "--uncertainty"]) == 0
    found = json.loads(capsys.readouterr().out)["uncertainty"]
    box = stability_box(_bicycle("rigid"), Fraction(1), 20)
    low, high = (Fraction(found["all_stable"][end]) for end in ("from", "to"))
    assert box.every[0] < low < high < box.every[1]
    low, high = (Fraction(found["some_stable"][end]) for end in ("from", "to"))
    assert low < box.some[0] < box.some[1] < high


@pytest.mark.parametrize("sigmas", ["0", "-1", "a", "pi", ""])
def test_bad_numbers_of_deviations_are_refused_in_one_line(sigmas, capsys):
    assert main(["linear", "--bicycle", "pista", f"--uncertainty={sigmas}"]) == 1
    assert "--uncertainty: found" in capsys.readouterr().err


def _expression(x, y, a):
    """Return an expression with every operation."""
    return a.sqrt(2 + x * y) / (3 - a.sin(x) * a.cos(y)) + 1 / (4 + x) - (5 - y) * x


@pytest.mark.parametrize("seed", range(20))
def test_affine_numbers_enclose_values_and_slopes(seed):
    rng = random.Random(seed)
    balls = Balls(200)
    with balls.precision():
        mid = [flint.arb(rng.uniform(-1, 1)) for _ in "xy"]
        rad = [flint.arb(rng.choice((1e-6, 1e-2, 0.3))) for _ in "xy"]
        whole = [m + r.union(-r) for m, r in zip(mid, rad, strict=True)]
        affines = Affines(balls)
        found = _expression(*Duals(affines).variables(affines.variables(whole)), Duals(affines))
        for _ in range(20):
            at = [m + r * rng.choice((-1, 1, rng.uniform(-1, 1)))
                  for m, r in zip(mid, rad, strict=True)]  # fmt: skip
            exact = _expression(*Duals(balls).variables(at), Duals(balls))
            assert found.value.ball.contains(exact.value.mid())
            for slope, expected in zip(found.slopes, exact.slopes, strict=True):
                assert slope.ball.contains(expected.mid())


def test_affine_numbers_remember_what_balls_forget():
    balls = Balls(100)
    with balls.precision():
        (x,) = Affines(balls).variables([flint.arb(1, 0.5)])
        assert isinstance(x, Affine)
        assert (x - x).ball.is_zero()
        # The terms of first order cancel, so only the squared radius of 1/4 remains.
        assert (x * x - 2 * x).ball.rad() <= 0.26


def test_a_function_that_is_positive_only_inside_is_not_called_negative():
    balls = Balls(64)
    with balls.precision():
        side = flint.arb(-1), flint.arb(1)
        for top, expected in ((Fraction(1, 100), False), (Fraction(-1, 100), True)):
            highest = balls.number(top)
            found = is_negative(
                lambda x, highest=highest: highest - (x[0] - 0.3) * (x[0] - 0.3), [side], balls
            )
            assert found is expected


def test_signs_over_a_box_are_proved_and_never_guessed():
    balls = Balls(100)
    with balls.precision():
        box = [(flint.arb(-1), flint.arb(1))] * 2

        def least_is_one(x):
            return x[0] * x[0] - x[0] * x[1] + x[1] * x[1] + 1

        def negative_in_a_corner(x):
            return 2 * least_is_one(x) - 3 * x[0] - 3 * x[1]

        assert sign_over(least_is_one, box, balls) == 1
        assert sign_over(lambda x: -least_is_one(x), box, balls) == -1
        assert sign_over(negative_in_a_corner, box, balls) is None
        assert not is_negative(negative_in_a_corner, box, balls)
        assert is_negative(lambda x: x[0] + x[1] - 3, box, balls)
        assert not is_negative(lambda x: x[0] + x[1] - 2, box, balls)
        assert [float(x) for x in corner(lambda x: x[0] - 2 * x[1], box, balls)] == [1, -1]


@pytest.mark.parametrize("name", NAMES)
def test_the_page_shows_these_speeds(name):
    assert committed("speeds")[name] == speeds(name)


SPEED = box.CriticalSpeed(*map(Fraction, range(5)))
POLYNOMIALS = {"a": 1, "b": 2, "c": (1, 1), "d": (-1, 1), "e": (4, -1)}
"""By their signs there is one weave speed, and one capsize speed at v^2 = 4."""


def with_signs(**changes):
    """Return the box of a bicycle whose characteristic polynomial has these coefficients."""
    balls = Balls(64)
    with balls.precision():
        numbers = {
            k: tuple(map(flint.arb, x)) if isinstance(x, tuple) else flint.arb(x)
            for k, x in (POLYNOMIALS | changes).items()
        }

    class Constant(box._Box):
        def polynomials(self, x):
            return box._Polynomials(**numbers)

        def _speed(self, *arguments):
            return SPEED

    with balls.precision():
        side = flint.arb(1), flint.arb(1)
        of = Constant([side], [flint.arb(1)], [flint.arb(0)], balls)
        return of.weave().speeds, of.capsize().speeds


def test_a_speed_is_claimed_only_where_signs_show_that_there_is_one():
    assert with_signs() == ((SPEED,), (SPEED,))
    for changes in (
        {"d": (1, 1)},  # d does not vanish in this case
        {"d": (-1, 0)},
        {"e": (-4, 1)},  # e is negative at the speed where d vanishes
        {"c": (1, 0)},  # Hurwitz' determinant is negative at high speeds
    ):
        assert with_signs(**changes)[0] is None, changes
    assert with_signs(d=(-1, -1))[0] == ()  # this bicycle is never stable
    assert with_signs(e=(4, 1))[1] == with_signs(e=(-4, -1))[1] == ()


def test_a_bound_of_speeds_is_one_that_is_proved():
    balls = Balls(64)
    with balls.precision():
        of = box._Box([], [], [], balls)
        one = flint.arb(1)
        assert 1.01 < of._outward(one, 1, lambda x: x > 1.01) < 1.1
        assert 0.9 < of._outward(one, -1, lambda x: x < 0.99) < 0.99
        assert of._outward(one, 1, lambda x: False) is None
