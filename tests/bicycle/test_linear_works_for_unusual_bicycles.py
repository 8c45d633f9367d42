"""The linearisation works for unusual bicycles, with or without weave or capsize speed.

The expected values are from the closed form of the coefficient matrices in Meijaard, Papadopoulos,
Ruina and Schwab (2007), doi:10.1098/rspa.2007.1857, Appendix A, entered by hand.
"""

import random
from fractions import Fraction
from functools import cache
from itertools import pairwise

import mpmath
import pytest

from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.model import regular
from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle

SKATES = dict.fromkeys(("mR", "IRxx", "IRyy", "mF", "IFxx", "IFyy"), "0")
POINT_B = dict.fromkeys(("IBxx", "IByy", "IBzz", "IBxz"), "0")
POINT_H = dict.fromkeys(("IHxx", "IHyy", "IHzz", "IHxz"), "0")
# A bicycle without spin, trail or tilt, whose front assembly is balanced about the steer axis.
DECOUPLED = dict.fromkeys(("c", "lam", "IRyy", "IFyy", "IHxz"), "0") | {"xH": "1.02"}
BICYCLES = {
    "benchmark": {},
    "vertical steer axis": {"lam": "0"},
    "no trail": {"c": "0"},
    "no trail and vertical steer axis": {"lam": "0", "c": "0"},
    "negative trail and tilt": {"lam": "-0.3", "c": "-0.1"},
    "no gravity": {"g": "0"},
    "little gravity": {"g": "1e-20"},
    "skates": SKATES,
    "two point masses on skates": SKATES | POINT_B | POINT_H | {"lam": "pi/36", "c": "-0.02"},
    "two point masses, stable": SKATES | POINT_B | POINT_H
    | {"w": "1", "rR": "0.1", "rF": "0.1", "xB": "1.2", "zB": "-0.4", "mB": "10", "mH": "1"}
    | {"xH": "1.02", "zH": "-0.2", "lam": "-pi/36", "c": "-0.02"},
    "steering does not feel the lean": DECOUPLED,
    "very long": {"w": "1e6"},
    "nearly horizontal steer axis": {"lam": "1.57"},
}  # fmt: skip
SEEDS = range(6)
CASES = pytest.mark.parametrize("case", [*BICYCLES, *SEEDS])


@pytest.fixture(autouse=True)
def _precision():
    with mpmath.workdps(80):
        yield


def _bicycle(case):
    benchmark = read_bicycle(benchmark_bicycle())
    if isinstance(case, str):
        return benchmark.replace(**{k: Exact.parse(v) for k, v in BICYCLES[case].items()})
    # Each value is 0.25 to 2 times that of the benchmark, so that the inertia matrices stay
    # physically possible.
    rng = random.Random(case)
    factors = {s: Fraction(rng.randrange(250, 2000), 1000) for s in PARAMETERS}
    for body in "BH":
        factors[f"I{body}xz"] = min(factors[f"I{body}xx"], factors[f"I{body}zz"])
    values = {s: Exact(f * benchmark[s].rational) for s, f in factors.items()}
    signs = {s: rng.choice((-1, 1)) for s in ("c", "lam")}
    values["lam"] = Exact(signs["lam"] * factors["lam"] * Fraction(3, 10))
    values["c"] = Exact(signs["c"] * values["c"].rational)
    return benchmark.replace(**values)


@cache
def _linear(case, digits):
    return linearise(_bicycle(case), digits)


def _closed_form(bicycle):
    """Return M, C1, K0, K2 of Appendix A, in its symbols."""
    a = Multiprecision(80)
    p = {s: a.number(x) for s, x in bicycle.values.items()}
    w, c = p["w"], p["c"]
    sin, cos = a.sin(p["lam"]), a.cos(p["lam"])
    rear, front = (p["mR"], 0, -p["rR"]), (p["mF"], w, -p["rF"])
    body, fork = (p["mB"], p["xB"], p["zB"]), (p["mH"], p["xH"], p["zH"])
    every = (rear, body, fork, front)
    mass = sum(m for m, _, _ in every)
    x_t, z_t = (sum(part[0] * part[k] for part in every) / mass for k in (1, 2))
    own_xx = p["IRxx"] + p["IBxx"] + p["IHxx"] + p["IFxx"]
    own_zz = p["IRxx"] + p["IBzz"] + p["IHzz"] + p["IFxx"]
    t_xx = own_xx + sum(m * z * z for m, _, z in every)
    t_xz = p["IBxz"] + p["IHxz"] - sum(m * x * z for m, x, z in every)
    t_zz = own_zz + sum(m * x * x for m, x, _ in every)
    mass_a = p["mH"] + p["mF"]
    x_a, z_a = (sum(part[0] * part[k] for part in (fork, front)) / mass_a for k in (1, 2))
    a_xx = p["IHxx"] + p["IFxx"] + sum(m * (z - z_a) ** 2 for m, _, z in (fork, front))
    a_xz = p["IHxz"] - sum(m * (x - x_a) * (z - z_a) for m, x, z in (fork, front))
    a_zz = p["IHzz"] + p["IFxx"] + sum(m * (x - x_a) ** 2 for m, x, _ in (fork, front))
    u = (x_a - w - c) * cos - z_a * sin
    a_ll = mass_a * u * u + a_xx * sin * sin + 2 * a_xz * sin * cos + a_zz * cos * cos
    a_lx = -mass_a * u * z_a + a_xx * sin + a_xz * cos
    a_lz = mass_a * u * x_a + a_xz * sin + a_zz * cos
    mu = c / w * cos
    s_f = p["IFyy"] / p["rF"]
    s_t = p["IRyy"] / p["rR"] + s_f
    s_a = mass_a * u + mu * mass * x_t
    m12 = a_lx + mu * t_xz
    c12 = mu * s_t + s_f * cos + t_xz / w * cos - mu * mass * z_t
    c22 = a_lz / w * cos + mu * (s_a + t_zz / w * cos)
    return {
        "M": ((t_xx, m12), (m12, a_ll + 2 * mu * a_lz + mu * mu * t_zz)),
        "C1": ((0, c12), (-(mu * s_t + s_f * cos), c22)),
        "K0": ((mass * z_t, -s_a), (-s_a, -s_a * sin)),
        "K2": ((0, (s_t - mass * z_t) / w * cos), (0, (s_a + s_f * sin) / w * cos)),
    }


@CASES
def test_matrices_are_those_of_the_closed_form(case):
    bicycle = _bicycle(case)
    found = linearise(bicycle, 30)
    for name, expected in _closed_form(bicycle).items():
        for i in (0, 1):
            for j in (0, 1):
                x, y = mpmath.mpf(getattr(found, name)[i][j]), mpmath.mpf(expected[i][j])
                # The matrices are rounded to 30 digits. Their zeros are accurate to the 75 digits
                # of the computation, less 15 for rounding.
                assert abs(x - y) <= mpmath.mpf("6e-30") * abs(y) + mpmath.mpf("1e-60")


@CASES
def test_nothing_is_missing_at_2_m_per_s(case):
    """The nonlinear accelerations at 2 m/s agree with the matrices, computed at 0 and 1 m/s."""
    bicycle, speed = _bicycle(case), 2
    a = Multiprecision(80)
    k, step = constants(bicycle, a), a.context.mpf("1e-25")
    x = linearise(bicycle, 40)
    m, c1, k0, k2 = (mpmath.matrix(matrix) for matrix in (x.M, x.C1, x.K0, x.K2))
    stiffness, damping = x.g * k0 + speed**2 * k2, speed * c1
    columns = {0: stiffness[:, 0], 2: stiffness[:, 1], 3: damping[:, 0], 4: damping[:, 1]}
    for entry, column in columns.items():
        ahead, behind = ([a.number(0)] * 5 + [speed / k.length] for _ in range(2))
        ahead[entry] += step
        behind[entry] -= step
        difference = zip(regular(k, a, ahead), regular(k, a, behind), strict=True)
        slopes = [(u - v) / (2 * step) for u, v in difference][3:5]
        for i in (0, 1):
            forces = [m[i, 0] * slopes[0], m[i, 1] * slopes[1], column[i]]
            # The matrices are computed with 40 digits. The central differences of the accelerations
            # are accurate to 45 to 55 digits.
            assert abs(sum(forces)) < 1e-37 * (1 + sum(abs(f) for f in forces))


def test_dual_numbers_differentiate_the_accelerations_of_a_turning_bicycle():
    """The test is away from upright, where no term is zero."""
    a = Multiprecision(80)
    dual = Duals(a)
    bicycle, step = _bicycle("benchmark"), a.context.mpf("1e-25")
    point = [a.number(Fraction(x)) for x in ("0.3", "0.02", "-0.4", "0.5", "0.7", "15")]
    k = constants(bicycle, a)
    found = regular(k, dual, dual.variables(point))
    for i in range(6):
        ahead, behind = ([x + s * step * (i == j) for j, x in enumerate(point)] for s in (1, -1))
        sides = zip(regular(k, a, ahead), regular(k, a, behind), strict=True)
        # Central differences have an error of step^2 times a third derivative of up to 1e5. Their
        # rounding error is 1e-52.
        for (u, v), rate in zip(sides, found, strict=True):
            slope = rate.slopes[i] if isinstance(rate, Dual) else 0
            assert abs((u - v) / (2 * step) - slope) < 1e-43


def _speeds_between(linear):
    """Return critical speeds, one speed between each two of them, and one beyond the last."""
    critical = [v for v, _ in (*linear.weave_speeds, *linear.double_roots)]
    edges = [mpmath.mpf(0), *sorted(mpmath.mpf(v) for v in (*critical, *linear.capsize_speeds))]
    return [(u + v) / 2 for u, v in pairwise([*edges, 2 * edges[-1] + 1])]


def _is_in(speed, ranges):
    return any(low < speed and (high is None or speed < high) for low, high in ranges)


@CASES
def test_stable_ranges_agree_with_the_eigenvalues(case):
    linear = _linear(case, 15)
    for speed in _speeds_between(linear):
        is_stable = all(z.real < 0 for z in linear.eigenvalues(speed))
        assert is_stable == _is_in(speed, linear.stable_ranges)


@CASES
def test_critical_speeds_agree_with_the_eigenvalues(case):
    linear = _linear(case, 30)
    size = max(abs(linear.g), 1)
    for speed, frequency in linear.weave_speeds:
        upper = [abs(z - mpmath.mpc(0, frequency)) for z in linear.eigenvalues(speed)]
        # The critical speed has 30 digits. The eigenvalue loses 5 of them because it changes with
        # speed.
        assert min(upper) < 1e-25 * size
    for speed in linear.capsize_speeds:
        assert min(abs(z) for z in linear.eigenvalues(speed)) < 1e-25 * size
    for speed, value in linear.double_roots:
        apart = sorted(abs(z - mpmath.mpf(value)) for z in linear.eigenvalues(speed))
        # Near a double root, two eigenvalues part with the square root of the error in speed. So
        # half of the 30 digits remain.
        assert apart[1] < 1e-12 * size


@CASES
def test_number_of_real_eigenvalues_changes_at_double_roots_only(case):
    linear = _linear(case, 15)
    reals = [sum(z.imag == 0 for z in linear.eigenvalues(v)) for v in _speeds_between(linear)]
    changes = sum(u != v for u, v in pairwise(reals))
    assert changes == len(linear.double_roots)


@CASES
def test_at_rest_the_eigenvalues_are_opposite_and_real_or_imaginary(case):
    """This is because M is positive definite and K0 symmetric."""
    roots = _linear(case, 15).eigenvalues(0)
    assert {(-z.real, -z.imag) for z in roots} == {(z.real, z.imag) for z in roots}
    assert all(z.real == 0 or z.imag == 0 for z in roots)


def test_without_gravity_nothing_is_critical():
    linear = _linear("no gravity", 15)
    assert linear.eigenvalues(0) == (0, 0, 0, 0)
    assert 0 in linear.eigenvalues(3)
    assert linear.weave_speeds == linear.capsize_speeds == ()
    assert linear.double_roots == linear.stable_ranges == ()


def test_without_gravity_the_weight_matrix_is_still_that_of_the_benchmark():
    assert _linear("no gravity", 15).K0 == _linear("benchmark", 15).K0


@pytest.mark.parametrize(
    ("case", "weave", "capsize", "stable"),
    [
        ("benchmark", 1, 1, 1),
        ("vertical steer axis", 0, 1, 0),
        ("no trail", 1, 1, 1),
        ("no trail and vertical steer axis", 0, 0, 0),
        ("negative trail and tilt", 0, 0, 0),
        ("skates", 0, 0, 0),
        ("two point masses, stable", 1, 0, 1),
    ],
)
def test_what_a_bicycle_does_not_have_is_empty(case, weave, capsize, stable):
    linear = _linear(case, 15)
    found = (linear.weave_speeds, linear.capsize_speeds, linear.stable_ranges)
    assert [len(x) for x in found] == [weave, capsize, stable]


def test_a_stable_range_may_have_no_end():
    linear = _linear("two point masses, stable", 15)
    ((low, high),) = linear.stable_ranges
    assert high is None
    assert low == linear.weave_speeds[0][0]
    assert all(z.real < 0 for z in linear.eigenvalues(1000))


def test_critical_speeds_are_proportional_to_the_root_of_gravity():
    usual = _linear("benchmark", 30)
    weak = _linear("little gravity", 30)
    factor = mpmath.sqrt(mpmath.mpf("1e-20") / mpmath.mpf("9.81"))
    ours = [*sum(usual.weave_speeds + usual.double_roots, ()), *usual.capsize_speeds]
    theirs = [*sum(weak.weave_speeds + weak.double_roots, ()), *weak.capsize_speeds]
    for x, y in zip(ours, theirs, strict=True):
        # Both values are rounded to 30 digits.
        assert abs(mpmath.mpf(y) / (factor * x) - 1) < 1e-29


def test_eigenvalues_that_cross_without_merging_are_no_double_root():
    linear = _linear("steering does not feel the lean", 30)
    (m1, _), (_, m2) = linear.M
    crossing = mpmath.sqrt(-linear.g * linear.K0[0][0] / m1) * m2 / linear.C1[1][1]
    assert linear.double_roots == ()
    for v in (crossing - 1e-3, crossing, crossing + 1e-3):
        assert all(z.imag == 0 for z in linear.eigenvalues(v))
    first, second, *_ = linear.eigenvalues(crossing)
    # The error of a double root is the square root of the error of the coefficients. So half of the
    # 30 digits remain, less 2 as a margin.
    assert abs(first - second) < 1e-13


@pytest.mark.parametrize("speed", [Fraction(1, 10**30), 10**6, 10**100])
def test_speeds_of_any_size(speed):
    found = _linear("benchmark", 15).eigenvalues(speed)
    better = _linear("benchmark", 60).eigenvalues(speed)
    for x, y in zip(found, better, strict=True):
        # The real and the imaginary parts agree to 15 digits.
        assert abs(x.real - y.real) <= 1e-14 * abs(y.real)
        assert abs(x.imag - y.imag) <= 1e-14 * abs(y.imag)


def test_a_singular_mass_matrix_is_refused(bicycle):
    """Nothing resists steering with a point mass on a vertical steer axis without trail."""
    fork = {**SKATES, **POINT_H, "lam": "0", "c": "0", "xH": "1.02"}
    skate = bicycle.replace(**{symbol: Exact.parse(text) for symbol, text in fork.items()})
    with pytest.raises(InputError, match="mass matrix of roll and steer of 'benchmark bicycle' is"):
        linearise(skate, 15)


@pytest.mark.parametrize("digits", [4, 1001, -1])
def test_digits_out_of_range_are_refused(bicycle, digits):
    with pytest.raises(InputError, match=f"found {digits}, expected 5 to 1000"):
        linearise(bicycle, digits)
