"""The eigenvalues of the benchmark bicycle over speed are the published ones."""

import json
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest

from heyoka_bike.bicycle.stability.linear import linearise

ANCHORS = json.loads((Path(__file__).parents[1] / "anchors" / "linear.json").read_text("utf-8"))
SPEEDS = ANCHORS["eigenvalues"]["by_speed"]


@pytest.fixture(scope="module")
def linear(bicycle):
    return linearise(bicycle, 30)


@pytest.fixture(autouse=True)
def _precision():
    with mpmath.workdps(60):
        yield


def _expected(speed):
    """Real and imaginary parts as text, by real, then by imaginary part."""
    anchor = SPEEDS[speed]
    parts = [(x, "0") for x in anchor["real"]]
    parts += [(x, sign + y) for x, y in anchor["pairs"] for sign in ("-", "")]
    return sorted(parts, key=lambda p: (mpmath.mpf(p[0]), mpmath.mpf(p[1])))


@pytest.mark.parametrize("speed", SPEEDS)
def test_eigenvalues_to_30_digits(linear, speed):
    found = linear.eigenvalues(Fraction(speed))
    for root, (real, imaginary) in zip(found, _expected(speed), strict=True):
        # Both numbers are rounded to 30 digits, so their texts are equal. `nstr` removes trailing
        # zeros.
        assert mpmath.nstr(root.real, 30) == mpmath.nstr(mpmath.mpf(real), 30)
        assert mpmath.nstr(root.imag, 30) == mpmath.nstr(mpmath.mpf(imaginary), 30)


@pytest.mark.parametrize("speed", ["0", "4.6", "10"])
def test_parts_that_are_zero_are_exactly_zero(linear, speed):
    real_roots = len(SPEEDS[speed]["real"])
    assert sum(root.imag == 0 for root in linear.eigenvalues(Fraction(speed))) == real_roots


@pytest.mark.parametrize("digits", [5, 300])
def test_any_number_of_digits(bicycle, digits):
    found = linearise(bicycle, digits).eigenvalues(5)
    better = linearise(bicycle, digits + 20).eigenvalues(5)
    for root, other in zip(found, better, strict=True):
        assert mpmath.nstr(root.real, digits) == mpmath.nstr(other.real, digits)
        assert mpmath.nstr(root.imag, digits) == mpmath.nstr(other.imag, digits)


def test_backwards_the_signs_change(linear):
    forward, backward = linear.eigenvalues(4), linear.eigenvalues(-4)
    assert {(-z.real, -z.imag) for z in backward} == {(z.real, z.imag) for z in forward}


def test_double_root_is_found_twice(linear):
    anchor = ANCHORS["critical"]
    roots = linear.eigenvalues(Fraction(anchor["double_root_speed"]["exact"]))
    expected = mpmath.mpf(anchor["double_root_eigenvalue"]["exact"])
    near = [z for z in roots if abs(mpmath.mpc(z) - expected) < 0.1]
    assert len(near) == 2
    # The speed is rounded to 30 digits. Near the double root, the distance of the two roots is the
    # square root of the error in speed.
    assert all(abs(mpmath.mpc(z) - expected) < 1e-14 for z in near)


def test_weave_pair_is_on_the_imaginary_axis(linear):
    ((speed, frequency),) = linear.weave_speeds
    upper = max(linear.eigenvalues(speed), key=lambda z: z.imag)
    # The speed is rounded to 30 digits, and the pair of roots moves by a few units per m/s.
    assert abs(upper.real) < 1e-28
    assert abs(upper.imag - frequency) < 1e-28


def test_capsize_root_is_zero(linear):
    (speed,) = linear.capsize_speeds
    # The speed is rounded to 30 digits, and the root moves by at most a few units per m/s.
    assert min(abs(z) for z in linear.eigenvalues(speed)) < 1e-28
