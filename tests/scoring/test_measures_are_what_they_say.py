"""Each measure is checked on columns with known errors: exact, perturbed, and not measurable."""

from math import inf

import numpy as np
import pytest

from heyoka_bike.scoring.grades import digits_text
from heyoka_bike.scoring.measures import (
    digits,
    growth,
    measures,
    performance,
    rms,
    time_to_tolerance,
)

T = np.linspace(0.0, 10.0, 1001)
REFERENCE = np.sin(T)


def test_perfect_columns_have_no_error_and_32_digits():
    m = measures(T, np.zeros_like(T), REFERENCE, 1.0)
    assert (m.max_abs_error, m.rms_error, m.max_rel_error) == (0.0, 0.0, 0.0)
    assert (m.scd, m.mescd) == (32.0, 32.0)
    assert m.time_to_tolerance is None


def test_one_wrong_row_is_found_where_it_is():
    error = np.zeros_like(T)
    error[300] = -2e-5
    m = measures(T, error, REFERENCE, 0.5)
    assert m.max_abs_error == 2e-5
    assert m.time_of_max == 3.0
    assert m.max_rel_error == 2e-5 / 0.5
    assert m.rms_error == pytest.approx(2e-5 / np.sqrt(1001))
    assert m.scd == pytest.approx(4 - np.log10(0.4))
    assert m.mescd == pytest.approx(-np.log10(2e-5 / (1 + abs(np.sin(3.0)))))


def test_nothing_compared_is_nothing_measured():
    empty = np.empty(0)
    m = measures(empty, empty, empty, 1.0)
    assert all(getattr(m, name) is None for name in m.__slots__)


def test_a_column_that_is_zero_has_no_relative_error():
    m = measures(T, np.full_like(T, 1e-3), np.zeros_like(T), 0.0)
    assert m.max_abs_error == 1e-3
    assert m.max_rel_error is None
    assert m.scd is None
    assert m.mescd == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("relative", "expected"),
    [(0.0, 32.0), (1e-40, 32.0), (1e-8, 8.0), (1.0, 0.0), (100.0, -2.0), (inf, None), (None, None)],
)
def test_digits(relative, expected):
    assert digits(relative) == expected


@pytest.mark.parametrize(
    ("found", "text"),
    [(5.96, "5.9"), (6.0, "6.0"), (5.94, "5.9"), (2.99, "2.9"), (3.0, "3.0"), (8.96, "9.0"),
     (-0.01, "0.0"), (-2.25, "-2.2")],
)  # fmt: skip
def test_shown_digits_are_not_rounded_up_to_a_better_grade(found, text):
    assert digits_text(found) == text


def test_time_to_tolerance_is_the_first_row_above_a_thousandth_of_the_scale():
    error = np.where(T >= 4.0, 2.1e-3, 1.9e-3)
    assert time_to_tolerance(T, error, 2.0) == 4.0
    assert time_to_tolerance(T, -error, 2.0) == 4.0
    assert time_to_tolerance(T, error, 3.0) is None


def test_growth_takes_each_tenth_with_its_start_and_the_end_with_the_last():
    error = T**2
    parts = growth(T, error, 10.0)
    assert [(p.t_start, p.t_end) for p in parts] == [(i, i + 1) for i in range(10)]
    assert [p.max_abs_error for p in parts[:2]] == pytest.approx([0.99**2, 1.99**2])
    assert parts[-1].max_abs_error == 100.0
    early = growth(T[:150], error[:150], 10.0)
    assert [p.max_abs_error is None for p in early] == [False, False] + [True] * 8


def test_rms_does_not_overflow():
    assert rms(np.array([3e200, 4e200])) == pytest.approx(5e200 / np.sqrt(2))


@pytest.mark.parametrize(
    ("energy", "expected"),
    [
        ([1837.0, 1837.1, 1836.8], 100 * 0.3 / 1837.0),
        ([-2.0, -1.0], 50.0),
        ([5.0] * 3, 0.0),
        ([0.0, 1.0], None),
        ([], None),
        ([1e-300, 1e300], None),
    ],
)
def test_performance_is_eq_1(energy, expected):
    found = performance(np.array(energy))
    assert found == (expected if expected is None else pytest.approx(expected, rel=1e-12))
