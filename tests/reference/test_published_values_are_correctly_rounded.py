"""Every published hi is the binary64 nearest to an independent longer evaluation.

The evaluation uses the 90-digit run and mpmath. It shares neither digits nor arithmetic
(python-flint's balls) nor rounding code with the code that made the files.
"""

import math
from fractions import Fraction
from functools import reduce

import mpmath
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.kinematics import unfold
from heyoka_bike.bicycle.equations.outputs import columns
from heyoka_bike.numbers.arithmetic import Multiprecision
from support.tiers import ONE_MANEUVER

DIGITS = 100


def states(run, a, times):
    """Return the state at each time by Horner's rule in mpmath."""
    mp = a.context
    for t in times:
        i = run.piece_at(t)
        s = a.number((t - run.breaks[i]) / (run.breaks[i + 1] - run.breaks[i]))
        yield [
            mp.ldexp(reduce(lambda y, n: y * s + n, reversed(c), mp.mpf(0)), -run.grid)
            for c in run.pieces[i]
        ]


def nearest(x):
    """Return the nearest binary64 of an mpf, by integer arithmetic."""
    sign, man, exp, _ = x._mpf_
    return float((-1) ** sign * Fraction(int(man)) * Fraction(2) ** exp)


def table(run, bicycle, times):
    a = Multiprecision(DIGITS)
    k = constants(bicycle, a)
    for state in states(run, a, times):
        o, u = unfold(k, a, state, is_regular=run.is_regular)
        yield columns(k, a, o, u, state[0], state[1], state[2], state[6])


@pytest.mark.parametrize("number", ONE_MANEUVER)
def test_hi_and_lo_of_every_entry(reference, long_run, bicycle, number):
    run, published = long_run(number), reference[number]
    times = [run.maneuver.time(i) for i in range(1, run.maneuver.rows)]
    for i, row in enumerate(table(run, bicycle, times), start=1):
        for name in published.columns:
            hi = published.rows.hi[name][i]
            if name == "mechanical_energy":
                # The published energy is the exact E0. The run conserves the energy to about 90
                # digits.
                assert abs(row[name] - float(hi)) < math.ulp(hi)
                continue
            assert nearest(row[name]) == hi, (name, i)
            rest = nearest(row[name] - mpmath.mpf(float(hi)))
            assert rest == published.rows.lo[name][i], (name, i)


@pytest.mark.proof
def test_energy_is_the_exact_initial_one(reference):
    # The energies E0 as fractions, from the published energies at the start of the maneuvers.
    e0 = {1: Fraction(1323145238081, 840000000), 3: Fraction(3291145238081, 840000000)}
    for number, exact in e0.items():
        column = reference[number].rows
        assert set(column.hi["mechanical_energy"]) == {float(exact)}
        assert set(column.lo["mechanical_energy"]) == {float(exact - Fraction(float(exact)))}


@pytest.mark.proof
def test_row_zero_is_exact_and_zero_is_positive(reference):
    for maneuver in reference.values():
        assert maneuver.rows.hi["roll_angle"][0] == 0
        assert maneuver.rows.hi["forward_speed"][0] == float(Fraction(maneuver.inputs["speed"]))
        assert maneuver.rows.hi["potential_energy"][0] == 794.1195
        for values in (maneuver.rows.hi, maneuver.rows.lo, maneuver.dense.hi, maneuver.dense.lo):
            for x in values.values():
                assert not np.any(np.signbit(x) & (x == 0))


@pytest.mark.proof
def test_fifty_digit_text_matches_hi_and_lo(reference, folder):
    lines = (folder / "uncontrolled-bicycle-50digits.txt").read_text().splitlines()
    for i, line in enumerate(lines):
        fields = line.split()
        assert len(fields) == 25
        assert Fraction(fields[0]) == Fraction(i, 100)
        for number, maneuver in reference.items():
            for j, name in enumerate(BENCHMARK_COLUMNS):
                x = Fraction(fields[1 + 8 * (number - 1) + j])
                hi = maneuver.rows.hi[name][i]
                assert float(x) == hi
                rest = x - Fraction(hi)
                # lo is rounded to 53 bits, and the number in the text is rounded to 50 digits.
                assert abs(rest - Fraction(maneuver.rows.lo[name][i])) <= max(
                    abs(rest) / 2**53, abs(x) / 10**49
                )
