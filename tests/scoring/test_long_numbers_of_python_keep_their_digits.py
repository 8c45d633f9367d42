"""Numbers from Python libraries with more digits than binary64 are compared with all their
digits."""

from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score

NAMES = ("time", *KEYS)
BITS = 166  # bits of 50 decimal digits


@pytest.fixture(scope="module")
def rows(reference):
    """Rows of maneuver 2 as fractions: the published hi + lo values at the times i/10."""
    held = reference[2].rows
    pairs = [zip(held[k][::10], held.lo[k][::10], strict=True) for k in KEYS]
    columns = [[Fraction(float(hi)) + Fraction(float(lo)) for hi, lo in x] for x in pairs]
    return [[Fraction(i, 10), *row] for i, row in enumerate(zip(*columns, strict=True))]


def mpf(x):
    with mpmath.workprec(BITS):
        return mpmath.mpf(x.numerator) / x.denominator


def arb(x):
    flint = pytest.importorskip("flint")
    before, flint.ctx.prec = flint.ctx.prec, BITS
    try:
        return flint.arb(flint.fmpq(x.numerator, x.denominator))
    finally:
        flint.ctx.prec = before


def fmpq(x):
    return pytest.importorskip("flint").fmpq(x.numerator, x.denominator)


def each(rows, kind):
    return [[kind(x) for x in row] for row in rows]


def by_name(rows, kind, of=list):
    columns = zip(*each(rows, kind), strict=True)
    return {name: of(list(x)) for name, x in zip(NAMES, columns, strict=True)}


WAYS = {
    "a list of Fraction": lambda rows: rows,
    "a list of mpf": lambda rows: each(rows, mpf),
    "a list of arb": lambda rows: each(rows, arb),
    "a list of fmpq": lambda rows: each(rows, fmpq),
    "a matrix of mpmath": lambda rows: mpmath.matrix(each(rows, mpf)),
    "a matrix of flint": lambda rows: pytest.importorskip("flint").arb_mat(each(rows, arb)),
    "columns of Fraction": lambda rows: by_name(rows, Fraction),
    "columns of mpf": lambda rows: by_name(rows, mpf),
    "columns of arb": lambda rows: by_name(rows, arb),
    "vectors of mpmath": lambda rows: by_name(rows, mpf, mpmath.matrix),
    "mpf beside times of float": lambda rows: (
        by_name(rows, mpf) | {"time": [float(row[0]) for row in rows]}
    ),
}


@pytest.mark.parametrize("way", WAYS)
def test_digits_beyond_binary64_are_compared(way, rows, reference):
    report = score(WAYS[way](rows), reference, maneuver=2)
    # A published value hi + lo has 32 digits.
    assert min(c.scd for c in report[2].columns) > 31
    assert report.file.significant_digits >= 31


def test_values_are_kept_as_pairs(rows):
    (found,) = read_results(each(rows, mpf), maneuver=2).maneuvers
    for j, key in enumerate(KEYS, 1):
        kept = zip(found.values[key].tolist(), found.lo[key].tolist(), strict=True)
        for row, (hi, lo) in zip(rows, kept, strict=True):
            assert abs(Fraction(hi) + Fraction(lo) - row[j]) <= Fraction(1, 2**104) * abs(row[j])


@pytest.mark.parametrize("kind", [mpmath.mpf, lambda x: Fraction(float(x))])
def test_binary64_numbers_in_another_type_are_binary64(kind, rows):
    short = each(rows, lambda x: kind(float(x)))
    given = read_results(each(rows, float), maneuver=2)
    found = read_results(short, maneuver=2)
    for key in KEYS:
        assert np.array_equal(found.maneuvers[0].values[key], given.maneuvers[0].values[key])
    assert not found.maneuvers[0].lo
    assert found.significant_digits == given.significant_digits


def test_a_ball_has_the_digits_of_its_radius(rows):
    flint = pytest.importorskip("flint")
    held = by_name(rows, arb)
    held["roll_angle"] = [x + flint.arb(0, 1e-9) for x in held["roll_angle"]]
    (found,) = read_results(held, maneuver=2).maneuvers
    assert found.quantum["roll_angle"].digits < 40 < 100 < found.quantum["steer_angle"].digits


def test_what_is_not_finite_is_left_out(rows):
    held = by_name(rows, mpf)
    held["roll_angle"][3] = mpmath.mpf("nan")
    held["steer_angle"][3] = None
    held["roll_rate"][3] = Decimal("0.5")
    (found,) = read_results(held, maneuver=2).maneuvers
    assert np.flatnonzero(np.isnan(found.values["roll_angle"])).tolist() == [3]
    assert found.values["roll_rate"][3] == 0.5
