"""`evaluate` agrees with the 90-digit run at random times, for every column and alternate."""

import random
from dataclasses import replace
from fractions import Fraction

import flint
import numpy as np
import pytest

from heyoka_bike.motion.trajectory import evaluator
from support.tiers import ONE_MANEUVER


def times(maneuver, breaks):
    rng = random.Random(20)
    at_random = [Fraction(rng.randrange(10**30), 10**29) for _ in range(150)]
    around_breaks = [Fraction(float(b)) + d for b in breaks[1:-1]
                     for d in (0, Fraction(1, 2**80), -Fraction(1, 2**80))]  # fmt: skip
    return [Fraction(0), *at_random, *around_breaks, maneuver.duration]


@pytest.mark.parametrize("number", ONE_MANEUVER)
def test_every_column_at_random_times(reference, long_run, number):
    maneuver, run = reference[number], long_run(number)
    at = evaluator(run, run.bits + 64)
    ts = times(run.maneuver, maneuver.breaks)
    values = maneuver.evaluate(ts)
    with at.balls.precision():
        for i, t in enumerate(ts):
            truth = at.columns(t)
            for name in maneuver.columns:
                scale = np.abs(maneuver.rows.hi[name]).max()
                found = flint.arb(float(values.hi[name][i])) + float(values.lo[name][i])
                error = abs(found - truth[name])
                # The documentation promises 25 digits. The times are pairs hi + lo with 32 digits,
                # so they do not limit the accuracy.
                assert error < scale * 1e-25, (name, float(t))


@pytest.mark.proof
def test_rows_are_reproduced(reference):
    for maneuver in reference.values():
        values = maneuver.evaluate((maneuver.time, maneuver.time_lo))
        for name in maneuver.columns:
            scale = np.abs(maneuver.rows.hi[name]).max()
            error = (values.hi[name] - maneuver.rows.hi[name]) + (
                values.lo[name] - maneuver.rows.lo[name]
            )
            assert np.abs(error).max() <= 1e-28 * scale, name


@pytest.mark.proof
def test_plain_clenshaw_gives_binary64(reference):
    """The hi coefficients alone, in binary64 arithmetic, give binary64 accuracy."""
    for maneuver in reference.values():
        t = np.linspace(0, 10, 1000, endpoint=False) + 0.003
        piece = np.searchsorted(maneuver.breaks, t, side="right") - 1
        a, b = maneuver.breaks[piece], maneuver.breaks[piece + 1]
        x = 2 * (t - a) / (b - a) - 1
        for name in maneuver.columns:
            c = maneuver.dense.hi[name]
            value = np.array([np.polynomial.chebyshev.chebval(xi, c[p])
                              for xi, p in zip(x, piece, strict=True)])  # fmt: skip
            scale = np.abs(maneuver.rows.hi[name]).max()
            # The argument x has an error of 2 eps times 2 t / (b - a). A column that changes
            # rapidly amplifies this error.
            assert np.abs(value - maneuver.evaluate(t)[name]).max() < 1e-12 * scale, name


@pytest.mark.proof
def test_a_damaged_coefficient_is_seen(reference):
    """A coefficient that is wrong by 1e-24 of the column's scale breaks the promise."""
    maneuver = reference[1]
    lo = {n: x.copy() for n, x in maneuver.dense.lo.items()}
    scale = np.abs(maneuver.rows.hi["steer_rate"]).max()
    lo["steer_rate"][5, 0] += 1e-24 * scale
    damaged = replace(maneuver, dense=replace(maneuver.dense, lo=lo))
    t = Fraction(float(maneuver.breaks[5])) + Fraction(1, 100)
    good, bad = maneuver.evaluate([t]), damaged.evaluate([t])
    shift = (bad["steer_rate"] - good["steer_rate"]) + (
        bad.lo["steer_rate"] - good.lo["steer_rate"]
    )
    assert abs(shift[0]) > 1e-25 * scale
