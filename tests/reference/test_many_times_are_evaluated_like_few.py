"""Evaluation by matrix products agrees with exact arithmetic and with Clenshaw's rule."""

from fractions import Fraction

import numpy as np
import pytest

from heyoka_bike.numbers.chebyshev import double_sums, plain_sums


def exact_sums(breaks, c, t):
    """Compute the same sums in rational arithmetic, at hi + lo times."""
    found = []
    for hi, lo in zip(*t, strict=True):
        at = Fraction(hi) + Fraction(lo)
        piece = min(int(np.searchsorted(breaks, hi, side="right")) - 1, len(breaks) - 2)
        a, b = Fraction(breaks[piece]), Fraction(breaks[piece + 1])
        x = (2 * at - a - b) / (b - a)
        polynomials = [Fraction(1), x]
        for _ in range(c[0].shape[-1] - 2):
            polynomials.append(2 * x * polynomials[-1] - polynomials[-2])
        found.append(
            [
                sum((Fraction(h) + Fraction(low)) * p for h, low, p in
                    zip(hi_row[piece], lo_row[piece], polynomials, strict=True))
                for hi_row, lo_row in zip(*c, strict=True)
            ]
        )  # fmt: skip
    return found


def test_sums_are_those_of_rational_arithmetic():
    random = np.random.default_rng(4)
    breaks = np.array([0.0, 0.5, 1.25, 3.0])
    # The coefficients do not decay with their degree. The columns have very different sizes, and
    # one column is zero.
    c = random.uniform(-1, 1, (3, 3, 32)) * np.array([1e-7, 0.0, 3e5])[:, None, None]
    c_lo = c * 2.0**-54 * random.uniform(-1, 1, c.shape)
    hi = np.sort(random.uniform(0, 3, 40))
    t = hi, np.spacing(hi) / 3
    exact = exact_sums(breaks, (c, c_lo), t)
    found, rest = double_sums(breaks, (c, c_lo), t)
    plain = plain_sums(breaks, c, hi)
    for i, row in enumerate(exact):
        for j, value in enumerate(row):
            size = float(np.max(np.abs(c[j])))
            # The sum has two errors: its 32 terms are cut at 2^-95 of the largest term, and its
            # argument has an error of 2^-104.
            assert abs(Fraction(found[j, i]) + Fraction(rest[j, i]) - value) <= size * 1e-25
            # In plain sums, terms of full size and an argument rounded to 2^-53 cause errors that
            # grow with the square of the degree.
            assert abs(Fraction(plain[j, i]) - value) <= size * 1e-12


@pytest.mark.parametrize("number", [1, 2, 3])
def test_every_column_agrees_with_clenshaw(reference, number):
    m = reference[number]
    random = np.random.default_rng(number)
    t = np.sort(np.concatenate([random.uniform(0, 10, 5000), m.breaks]))
    time = t, np.zeros_like(t)
    few, many = m.evaluate(t), m.evaluate_many(time, m.columns)
    near = m.approximate(t, m.columns)
    for name in m.columns:
        scale = np.max(np.abs(m.rows[name]))
        assert np.max(np.abs((many[name] - few[name]) + (many.lo[name] - few.lo[name]))) < (
            1e-26 * scale
        )
        assert np.max(np.abs(near[name] - few[name])) < 2e-15 * scale


def test_no_column_is_no_work(reference):
    assert reference[1].approximate(np.array([1.0]), []) == {}
    assert reference[1].evaluate(1.0, []).hi == {}
