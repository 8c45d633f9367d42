"""An interpretation gives the same SI values in binary64 and in twice its precision.

The oracle is rational arithmetic on the written numbers.
"""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.scoring.definitions import Understanding

SI_SIZES = {
    "m s-1": Fraction(1),
    "km h-1": Fraction(10, 36),
    "mm s-1": Fraction(1, 1000),
    "J": Fraction(1),
    "kJ": Fraction(1000),
}
WRITTEN = np.array([4.6, -0.1, 0.0, 1837.03117630952380952, 1e-300])
REST = WRITTEN * 2.0**-60
OFFSET = 794.1195
# Computations in binary64 round twice. Each rounding error is at most half a unit of the last digit
# of the largest term. Conversion factors are rounded once more.
ROUNDING = 2 * 2.0**-53
# hi + lo contains 106 bits. The errors of a product and two sums take a few of these bits.
ROUNDING_OF_PAIRS = 2.0**-100


def exact(values, unit, sign, offset):
    return [sign * SI_SIZES[unit] * Fraction(x) - Fraction(offset) for x in values]


@pytest.mark.parametrize(("unit", "sign", "offset"), [*product(SI_SIZES, (1, -1), (0.0, OFFSET))])
def test_both_precisions_are_those_of_rational_arithmetic(unit, sign, offset):
    key = "mechanical_energy" if unit.endswith("J") else "forward_speed"
    u = Understanding(COMPARED[key][0], unit, sign, offset)
    sizes = np.abs(WRITTEN) * float(SI_SIZES[unit]) + offset
    right = exact(WRITTEN, unit, sign, offset)
    off = [Fraction(x) - y for x, y in zip(u.in_si(WRITTEN), right, strict=True)]
    assert all(abs(x) <= ROUNDING * s for x, s in zip(off, sizes, strict=True))
    hi, lo = u.exactly_in_si((WRITTEN, REST))
    whole = [Fraction(x) + Fraction(y) for x, y in zip(WRITTEN, REST, strict=True)]
    right = exact(whole, unit, sign, offset)
    off = [Fraction(x) + Fraction(y) - z for x, y, z in zip(hi, lo, right, strict=True)]
    # In binary64, products with the smallest number underflow.
    tiny = Fraction(1, 10**300)
    assert all(abs(x) <= ROUNDING_OF_PAIRS * s + tiny for x, s in zip(off, sizes, strict=True))
