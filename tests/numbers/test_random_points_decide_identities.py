"""Random points of a random prime field distinguish identities, with the computed odds."""

from __future__ import annotations

import pytest

from oracles.random_field import RandomField, UnknownRootError


def test_an_identity_is_zero_and_a_tiny_term_is_seen():
    field = RandomField()
    x, y = field.unknown(), field.unknown()
    square = (x + y) ** 2 - x * x - 2 * x * y
    assert (square - y * y).is_zero
    assert not (square - y * y + x / 10**80).is_zero
    assert ((x**2 - y**2) / (x - y) - x - y).is_zero


def test_sine_and_cosine_are_those_of_sums_and_halves():
    field = RandomField()
    a, b = field.angle(), field.angle()
    whole = (a + b) - b
    assert (whole.sin - a.sin).is_zero
    assert (whole.cos - a.cos).is_zero
    half = a / 2
    assert (2 * half.sin * half.cos - a.sin).is_zero
    assert (a.sin * a.sin + a.cos * a.cos - 1).is_zero
    assert not (a.sin + a.cos - 1).is_zero


def test_a_root_is_a_number_of_its_own():
    field = RandomField()
    x = field.unknown()
    root = field.adjoin_root((x * x + 1) / (x - 1))
    assert (root * root * (x - 1) - x * x - 1).is_zero
    assert ((x + root) / (x - root) * (x - root) - x - root).is_zero
    assert not (root - x).is_zero
    field.roots.append(x * root)
    assert (field.sqrt(x * x * root * root) - x * root).is_zero
    with pytest.raises(UnknownRootError):
        1 / field.sqrt(x)


def test_equations_are_solved():
    field = RandomField()
    a, b, c, d, e, f = (field.unknown() for _ in range(6))
    x, y = field.solve([[a, b], [c / e, d]], [e, f])
    assert (x - (e * d - b * f) / (a * d - b * c / e)).is_zero
    assert (a * x + b * y - e).is_zero
    # By Cramer's rule, the degrees of the two rows add up: 1, and 2 because of the division by e.
    assert x.top.degree >= 3
    with pytest.raises(ZeroDivisionError):
        field.solve([[a, b], [2 * a, 2 * b]], [e, f])


@pytest.mark.parametrize(
    ("formula", "degree", "bits"),
    [
        (lambda x, y: x * y * y - 7, 3, 3),
        (lambda x, y: x / y + y / x, 2, 1),
        (lambda x, y: (x + 1) / (x - y) - 5 * y, 2, 3),
        (lambda x, y: 1 / (1 + 1 / (1 + x * y)), 2, 1),
        (lambda x, y: (x + y) ** 20, 20, 20),
    ],
)
def test_sizes_are_at_least_those_of_the_numerator(formula, degree, bits):
    field = RandomField()
    size = formula(field.unknown(), field.unknown()).top
    assert degree <= size.degree <= 2 * degree
    assert bits <= size.bits <= 2 * bits + 4


def test_zeros_are_met_and_no_more_often_than_counted():
    """With primes of eight bits, a wrong equation often passes."""
    runs, passed = 3000, 0
    for _ in range(runs):
        field = RandomField(8)
        x, y = field.unknown(), field.unknown()
        wrong = (x - y) * (x - 2 * y) * (x - 3 * y + 1)
        passed += wrong.is_zero
    # The formula vanishes on three lines in a plane of p^2 points, where p is about 190. So about
    # 47 of 3000 random points are zeros.
    assert 10 < passed < field.missed(wrong) * runs
