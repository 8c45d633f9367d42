"""No binary64 constant enters a model of higher precision.

Two checks: the equations are built with a number type that refuses floats other than small dyadics,
and the compiled right-hand side of each precision agrees with mpmath's at random states.
"""

import random
from fractions import Fraction

import heyoka as hy
import numpy as np
import pytest

from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.kinematics import state_names, unfold
from heyoka_bike.bicycle.equations.model import few_products, regular
from heyoka_bike.bicycle.equations.outputs import columns
from heyoka_bike.motion.heyoka_adapter import NativeNumbers
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.numbers.precision import Precision


class Strict:
    """A number that combines only with its own type, integers, and small dyadics."""

    def __init__(self, value):
        self.value = value

    @staticmethod
    def lift(x):
        if isinstance(x, Strict):
            return x.value
        if isinstance(x, bool) or not isinstance(x, int | float):
            raise TypeError(f"{type(x).__name__} in the model")
        if abs(x) > 4 or Fraction(x).denominator > 4:
            raise TypeError(f"literal {x!r} in the model")
        return Fraction(x)

    def __add__(self, o):
        return Strict(self.value + self.lift(o))

    def __sub__(self, o):
        return Strict(self.value - self.lift(o))

    def __rsub__(self, o):
        return Strict(self.lift(o) - self.value)

    def __mul__(self, o):
        return Strict(self.value * self.lift(o))

    def __truediv__(self, o):
        return Strict(self.value / self.lift(o))

    def __neg__(self):
        return Strict(-self.value)

    __radd__, __rmul__ = __add__, __mul__


class StrictArithmetic:
    """Elementary functions replaced by rational stand-ins: only the literals matter here."""

    def number(self, value):
        exact = getattr(value, "rational", value)
        extra = getattr(value, "pi_multiple", 0)
        return Strict(Fraction(exact) + extra * 3)

    def sin(self, x):
        return Strict(x.value / (1 + x.value**2))

    def cos(self, x):
        return Strict(1 / (1 + x.value**2))

    def sqrt(self, x):
        return Strict(1 + abs(x.value))

    def atan2(self, y, x):
        return Strict(y.value / (1 + x.value**2))

    def sum(self, terms):
        total = Strict(Fraction(0))
        for term in terms:
            total = total + term
        return total


@pytest.mark.parametrize("form", [few_products, regular])
def test_the_equations_hold_no_literal_but_small_dyadics(bicycle, form):
    a = StrictArithmetic()
    k = constants(bicycle, a)
    state = [Strict(Fraction(n, 7)) for n in (1, 2, 3, 4, 5, 6)]
    assert all(isinstance(x, Strict) for x in form(k, a, state))
    o, u = unfold(k, a, state, is_regular=form is regular)
    angle = Strict(Fraction(1, 7))
    assert all(
        isinstance(x, Strict) for x in columns(k, a, o, u, angle, angle, angle, angle).values()
    )


def test_the_strict_number_refuses_a_literal():
    with pytest.raises(TypeError, match="literal"):
        Strict(Fraction(1)) * 9.81


@pytest.mark.parametrize(
    "precision", ["binary64", "longdouble", "binary128", pytest.param(70, marks=pytest.mark.proof)]
)
@pytest.mark.parametrize("is_regular", [pytest.param(False, marks=pytest.mark.proof), True])
def test_accelerations_agree_with_mpmath(bicycle, precision, is_regular):
    p = Precision.of(precision)
    native = NativeNumbers(p)
    system = right_hand_side(bicycle, p, is_regular=is_regular, with_yaw=False)
    options = {"prec": p.bits} if native.is_mpfr else {}
    compiled = hy.cfunc(
        [rate for _, rate in system], [x for x, _ in system], fp_type=native.type,
        compact_mode=True, **options,
    )  # fmt: skip
    a = Multiprecision(100)
    k = constants(bicycle, a)
    rng = random.Random(7)
    for _ in range(10):
        # The states are dyadic fractions, which are exact in every format. They violate the contact
        # constraint, which does not matter for the formulas.
        exact = [Fraction(rng.randrange(-40, 41), 128) for _ in range(5)] + [Fraction(12)]
        inputs = [native.from_integer(x.numerator, x.denominator.bit_length() - 1) for x in exact]
        found = compiled(np.array(inputs, dtype=native.type))
        truth = (regular if is_regular else few_products)(k, a, [a.number(x) for x in exact])
        for name, x, t in zip(state_names(is_regular), found, truth, strict=True):
            as_mp = a.context.mpf(native.to_integer(x, 400 if p.bits > 64 else 200))
            difference = a.context.ldexp(as_mp, -(400 if p.bits > 64 else 200)) - t
            # The limit of 2^12 units of 2^-p allows for a few hundred operations with some
            # cancellation. A constant that passed through binary64 has an error of 2^-53, which is
            # far larger at every precision except binary64.
            assert abs(difference) < 2**12 * a.context.mpf(2) ** -p.bits * (1 + abs(t)), name


def test_the_decomposition_is_small(bicycle):
    """Number of u-variables of the ODE alone in binary64; a straightforward derivation has 1046."""
    system = right_hand_side(bicycle, Precision.of("binary64"), with_yaw=False)
    ta = hy.taylor_adaptive(system, [0.1] * 6, tol=0.1, compact_mode=True)
    assert len(ta.decomposition) - len(system) <= 480
