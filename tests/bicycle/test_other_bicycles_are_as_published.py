"""The bicycles of the collection are the published ones, and so are their linearised equations."""

import json
from fractions import Fraction
from pathlib import Path

import flint
import mpmath
import pytest

from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle, read_maneuvers
from heyoka_bike.bicycle.stability.linear import closed_form, linearise
from heyoka_bike.numbers.arithmetic import Balls, Multiprecision, exact_ball
from heyoka_bike.system.resources import collection

ANCHORS = json.loads((Path(__file__).parents[1] / "anchors" / "bicycles.json").read_text("utf-8"))
BICYCLES = collection("bicycles")
OTHERS = [name for name in BICYCLES if name != "benchmark"]
TABLES = [name for name in ANCHORS["tables"] if name in BICYCLES]
MATRICES = [name for name in ANCHORS["matrices"] if name in BICYCLES]
WITHOUT_STABLE_RANGE = {
    f"adversarial/{name}" for name in ("negative-tilt", "no-gyroscope", "zero-mechanical-trail")
}

# The published entries differ from the evaluated ones by 18, 6 and 3 units of the last printed
# digit.
EVALUATED_ANEW = {("browserins", "M", 0, 0), ("browserins", "C1", 0, 1), ("crescendo", "M", 1, 1)}


def _bicycle(name):
    return read_bicycle(BICYCLES[name])


def _half_unit(text):
    """Return half a unit of the last digit of a decimal text."""
    return Fraction(1, 2 * 10 ** len(text.partition(".")[2]))


@pytest.mark.parametrize("name", TABLES)
def test_values_and_deviations_round_to_those_of_the_thesis(name):
    bicycle = _bicycle(name)
    numbers = ANCHORS["tables"][name].split()
    for symbol, value, deviation in zip(
        ANCHORS["tables"]["symbols"].split(), numbers[::2], numbers[1::2], strict=True
    ):
        # A value that ends in 5, such as 3.545 kg, may have been rounded up or down.
        assert abs(bicycle[symbol].rational - Fraction(value)) <= _half_unit(value)
        found = bicycle.uncertainties[symbol].rational
        assert abs(found - Fraction(deviation)) <= _half_unit(deviation)


@pytest.mark.parametrize("name", MATRICES)
def test_matrices_are_those_printed_with_the_first_evaluation(name):
    """The measurements were evaluated again later; most values changed by less than a unit."""
    bicycle = _bicycle(name)
    # In the first published evaluation the diametral inertias of the two wheels were interchanged.
    bicycle = bicycle.replace(IRxx=bicycle["IFxx"], IFxx=bicycle["IRxx"])
    linear = linearise(bicycle, 12)
    for matrix, rows in ANCHORS["matrices"][name].items():
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            x, text = getattr(linear, matrix)[i][j], rows[i][j]
            away = abs(Fraction(str(x)) - Fraction(text)) / (2 * _half_unit(text))
            assert (away > 1) == ((name, matrix, i, j) in EVALUATED_ANEW)


def test_matrices_of_the_stratos_are_what_its_rounded_parameters_allow():
    text = BICYCLES["stratos"].read_text("utf-8")
    printed = ANCHORS["stratos"]
    balls = Balls(100)
    with balls.precision():
        p = {}
        for symbol in PARAMETERS:
            value = text.partition(f"\n{symbol} ")[2].partition('value = "')[2].partition('"')[0]
            p[symbol] = flint.arb(
                exact_ball(Fraction(value)).mid(), float(_half_unit(value)) * (1 + 1e-9)
            )
        for matrix, rows in zip(("M", "C1", "K0", "K2"), closed_form(p, balls), strict=True):
            largest = max(abs(float(number)) for texts in printed[matrix] for number in texts)
            for found, texts in zip(rows, printed[matrix], strict=True):
                for x, number in zip(found, texts, strict=True):
                    assert x.contains(exact_ball(Fraction(number)).mid())
                    # The ball must be narrow: a wide ball would contain the printed number in any
                    # case.
                    assert x.rad() < largest / 200


@pytest.mark.parametrize("name", BICYCLES)
def test_the_closed_form_is_the_linearisation_of_the_nonlinear_model(name):
    bicycle = _bicycle(name)
    found = linearise(bicycle, 30)
    a = Multiprecision(60)
    numbers = {s: a.number(x) for s, x in bicycle.values.items()}
    expected = dict(zip(("M", "C1", "K0", "K2"), closed_form(numbers, a), strict=True))
    with mpmath.workdps(60):
        for matrix in ("M", "C1", "K0", "K2"):
            largest = max(abs(mpmath.mpf(x)) for row in expected[matrix] for x in row)
            for row, exact in zip(getattr(found, matrix), expected[matrix], strict=True):
                for x, y in zip(row, exact, strict=True):
                    # Both values are rounded to 30 digits.
                    assert abs(mpmath.mpf(x) - mpmath.mpf(y)) <= mpmath.mpf("1e-29") * largest


def test_the_two_mass_skate_bicycle_is_stable_from_2_8_metres_per_second_on():
    ((low, high),) = linearise(_bicycle("two-mass-skate"), 10).stable_ranges
    assert mpmath.nstr(low, 2) == "2.8"
    assert high is None


@pytest.mark.parametrize("name", OTHERS)
def test_every_bicycle_has_maneuvers_in_and_beyond_its_stable_range(name):
    first, second, third = read_maneuvers(collection("maneuvers")[name])
    ranges = linearise(_bicycle(name), 15).stable_ranges
    assert (not ranges) == (name in WITHOUT_STABLE_RANGE)
    if not ranges:
        return
    low, high = ranges[-1]
    # In the file the speed is rounded to 1 cm/s.
    half = mpmath.mpf("0.005000001")
    middle, beyond = (low * 5 / 4, 2 * low) if high is None else ((low + high) / 2, high * 5 / 4)
    for maneuver, speed in ((first, middle), (second, low), (third, beyond)):
        assert abs(mpmath.mpf(float(maneuver.speed)) - speed) <= half


def test_measured_bicycles_have_a_deviation_for_every_parameter():
    for name in ("browser", "pista", "stratos", "rigid-jason"):
        assert set(_bicycle(name).uncertainties) == set(PARAMETERS)
    assert set(PARAMETERS) - set(_bicycle("balanceassistv1").uncertainties) == {"g"}
    assert not _bicycle("silver").uncertainties
