"""The linearised benchmark bicycle is the published one: matrices and critical speeds."""

import json
from pathlib import Path

import mpmath
import pytest

from heyoka_bike.bicycle.stability.linear import linearise

ANCHORS = json.loads((Path(__file__).parents[1] / "anchors" / "linear.json").read_text("utf-8"))
MATRICES = [
    pytest.param(name, i, j, id=f"{name}[{i}][{j}]")
    for name in ("M", "C1", "K0", "K2")
    for i in (0, 1)
    for j in (0, 1)
]


@pytest.fixture(scope="module")
def linear(bicycle):
    return linearise(bicycle, 45)


@pytest.fixture(autouse=True)
def _precision():
    with mpmath.workdps(60):
        yield


def _unit(text):
    """Return one unit of the last digit of a decimal text."""
    return mpmath.mpf(10) ** -len(text.partition(".")[2])


def _critical(linear):
    ((weave_speed, weave_frequency),) = linear.weave_speeds
    ((double_root_speed, double_root_eigenvalue),) = linear.double_roots
    (capsize_speed,) = linear.capsize_speeds
    return {
        "weave_speed": weave_speed,
        "weave_frequency": weave_frequency,
        "capsize_speed": capsize_speed,
        "double_root_speed": double_root_speed,
        "double_root_eigenvalue": double_root_eigenvalue,
    }


@pytest.mark.parametrize(("name", "i", "j"), MATRICES)
def test_matrices_to_all_printed_digits(linear, name, i, j):
    printed = ANCHORS["matrices"][name]["printed"][i][j]
    found = mpmath.mpf(getattr(linear, name)[i][j])
    # The tolerance is half a unit of the last printed digit, because the table is correctly
    # rounded.
    assert abs(found - mpmath.mpf(printed)) <= _unit(printed) / 2


@pytest.mark.parametrize(("name", "i", "j"), MATRICES)
def test_matrices_to_40_digits(linear, name, i, j):
    exact = ANCHORS["matrices"][name]["exact"][i][j]
    found = mpmath.mpf(getattr(linear, name)[i][j])
    # The values in linear.json have 40 digits, the linearisation has 45. Exact values with fewer
    # digits, such as zero, are compared to 1e-38.
    assert abs(found - mpmath.mpf(exact)) <= min(_unit(exact), mpmath.mpf("1e-38"))


def test_zeros_are_exact(linear):
    assert linear.C1[0][0] == linear.K2[0][0] == linear.K2[1][0] == 0


@pytest.mark.parametrize("name", ["weave_frequency", "double_root_speed", "double_root_eigenvalue"])
def test_frequency_and_double_root_to_all_printed_digits(linear, name):
    printed = ANCHORS["critical"][name]["printed"]
    # The tolerance is half a unit of the last printed digit.
    assert abs(mpmath.mpf(_critical(linear)[name]) - mpmath.mpf(printed)) <= _unit(printed) / 2


@pytest.mark.parametrize("name", sorted(ANCHORS["critical"].keys() - {"source", "source_of_exact"}))
def test_critical_values_to_all_digits_of_the_anchors(linear, name):
    exact = ANCHORS["critical"][name]["exact"]
    # The tolerance is one unit in the last digit of the value in linear.json. The weave and capsize
    # speeds have 40 digits there.
    assert abs(mpmath.mpf(_critical(linear)[name]) - mpmath.mpf(exact)) <= _unit(exact)


@pytest.mark.parametrize(
    ("name", "error"), [("weave_speed", "6.0413e-15"), ("capsize_speed", "1.11101e-14")]
)
def test_printed_critical_speeds_are_off_in_their_last_digit(linear, name, error):
    printed = mpmath.mpf(ANCHORS["critical"][name]["printed"])
    # The page states the errors with 5 and 6 digits.
    found = mpmath.mpf(_critical(linear)[name])
    assert abs(printed - found - mpmath.mpf(error)) < 1e-19


def test_stable_between_weave_and_capsize(linear):
    critical = _critical(linear)
    assert linear.stable_ranges == ((critical["weave_speed"], critical["capsize_speed"]),)


@pytest.mark.parametrize("digits", [5, 15, 200])
def test_results_are_rounded_to_the_digits_asked_for(bicycle, digits):
    def numbers(x):
        entries = [v for matrix in (x.M, x.C1, x.K0, x.K2) for row in matrix for v in row]
        return [mpmath.nstr(v, digits) for v in (*entries, *_critical(x).values())]

    found = linearise(bicycle, digits)
    assert numbers(found) == numbers(linearise(bicycle, digits + 30))
