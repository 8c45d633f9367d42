"""Code in LLVM's language computes the model's values, in every element of a vector."""

import ctypes
import math

import numpy as np
import pytest

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.workbench.fast.model_code import rates_code
from heyoka_bike.workbench.fast.step_code import collocation
from heyoka_bike.workbench.fast.vector_code import LANES, Code, Loop, function, module, turns


def called(source, name, given, count):
    """Return `count` vectors that a function of vectors computes from the given ones."""
    run = function(source, name, None, ctypes.c_void_p, ctypes.c_void_p)
    given, found = np.ascontiguousarray(given, dtype=float), np.empty((count, LANES))
    run(given.ctypes.data, found.ctypes.data)
    return found


@pytest.mark.parametrize("size", [1e-9, 0.5, 3.0, 100.0, 1e6])
def test_sines_and_cosines_are_rounded_once_or_nearly(size):
    c = Code("void @turns(ptr, ptr)")
    x, y = (a.vectors() for a in c.arguments)
    y.store(turns(x[0]))
    c.do("ret void")
    source = module(c)
    angles = size * np.random.default_rng(4).uniform(-1, 1, (40, LANES))
    angles[0] = size * np.linspace(-1, 1, LANES)
    for x in angles:
        sine, cosine = called(source, "turns", x, 2)
        # The limit of two units of roundoff allows for the last terms of pi/2 and of the
        # polynomials.
        assert np.abs(sine - [math.sin(t) for t in x]).max() < 4.5e-16
        assert np.abs(cosine - [math.cos(t) for t in x]).max() < 4.5e-16
        assert np.allclose(sine, [math.sin(t) for t in x], rtol=1e-15, atol=1e-17 * size)


@pytest.mark.parametrize("is_regular", [False, True])
def test_rates_of_eight_states_are_those_of_each(bicycle, is_regular):
    equations = Equations.binary64(bicycle, is_regular=is_regular)
    random = np.random.default_rng(5)
    states = np.vstack(
        [random.uniform(-0.4, 0.4, (3, LANES)), random.uniform(-2, 2, (2, LANES)),
         random.uniform(5, 30, (1, LANES))]
    )  # fmt: skip
    source = module(rates_code(equations)).replace("internal ", "")
    found = called(source, "rates", states, 6)
    right = np.array(equations.rates(list(states)))
    # The values result from a few hundred operations, some of which are differences. The limit is
    # 1e4 units of roundoff of the largest value.
    assert np.abs(found - right).max() < 1e-12 * np.abs(right).max()
    assert np.ptp(found, axis=1).min() > 1e-3


def test_loops_and_branches_do_what_they_say():
    """Compute the sum of odd numbers up to a limit, in each element."""
    c = Code("void @odd(ptr, ptr)")
    limit, total = (a.vectors() for a in c.arguments)
    most = limit[0].over_places("fmax")
    number, found, is_odd = c.variable(0.0), c.variable(limit[0] * 0.0), c.variable(0)
    with Loop(c) as numbers:
        numbers.leave(number[0] >= most)
        number[0] += 1.0
        is_odd[0] = 1 - is_odd[0]
        numbers.again(is_odd[0] < 1)
        wide = number[0].spread()
        with c.unless(number[0] > 90.0):
            found[0] += (wide <= limit[0]).choose(wide, 0.0)
    total[0] = found[0]
    c.do("ret void")
    limits = [0, 1, 2, 3, 9, 10, 100, 101]
    right = [sum(x for x in range(1, n + 1, 2) if x <= 90) for n in limits]
    assert called(module(c), "odd", limits, 1)[0].tolist() == right


def test_the_constants_are_those_of_radaus_method():
    m = collocation()
    # The method is exact for polynomials of degree 7 at every point, and of degree 14 at the end.
    for degree in range(8):
        right = m.points ** (degree + 1) / (degree + 1)
        assert np.abs(m.integral @ m.points**degree - right).max() < 1e-15
    for degree in range(8, 15):
        assert m.integral[-1] @ m.points**degree == pytest.approx(1 / (degree + 1), rel=1e-14)
    assert abs(m.integral[-1] @ m.points**15 - 1 / 16) > 1e-10
    # In the coordinates of its modes, the inverse matrix consists of blocks of two by two.
    blocks = m.to_modes @ np.linalg.inv(m.integral) @ m.from_modes
    re, im = np.diag(m.eigenvalues.real), np.diag(m.eigenvalues.imag)
    assert np.abs(blocks - np.block([[re, -im], [im, re]])).max() < 1e-9
    # The series follows from the increments since the start, which have no constant part.
    x = 2 * m.points - 1
    increments = np.polynomial.chebyshev.chebval(x, [1, 0, -1, 0, 0, 0, 0, 0.5, 0.5])
    assert m.series @ increments == pytest.approx([0, -1, 0, 0, 0, 0, 0.5, 0.5], abs=1e-14)
