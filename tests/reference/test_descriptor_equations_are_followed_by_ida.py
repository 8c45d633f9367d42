"""The descriptor form that `export` writes in C and Python is right, and IDA follows it.

IDA is the solver of differential-algebraic equations of SUNDIALS, in Python by scikit-sundae.
"""

import importlib.util
import re

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.descriptor import Descriptor, to_reduced
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Multiprecision
from support.equation_programs import STEM, export
from support.export_programs import need, run

pytestmark = pytest.mark.proof

SIZE, COORDINATES, MULTIPLIERS = 24, 9, 6
# A state off the floor with slipping velocities, and its rates. The formulas are the same as on the
# floor.
Z = [round(0.3 + 0.1 * (i % 7) - 0.05 * (i % 4), 3) for i in range(SIZE)]
RATES = [round(0.2 * (i % 5) - 0.3, 3) for i in range(SIZE)]

_C = """
#include "bicycle.h"
#include <stdio.h>

static void show(const double *x, int n)
{
    for (int i = 0; i < n; i++)
        printf("%.17g ", x[i]);
}

int main(void)
{
    const double z[24] = {STATE}, rates[24] = {RATES};
    double m[9][9], f[9], g[6][9], h[2], r[24], y[11], x[11], j[11][11];
    bicycle_mass(z, m), show(&m[0][0], 81);
    bicycle_force(z, f), show(f, 9);
    bicycle_constraint_jacobian(z, g), show(&g[0][0], 54);
    bicycle_heights(z, h), show(h, 2);
    bicycle_residual_2(z, rates, r), show(r, 24);
    bicycle_residual_3(z, rates, r), show(r, 24);
    bicycle_reduced(z, y), show(y, 11);
    bicycle_rates(y, x), show(x, 11);
    bicycle_jacobian(y, j), show(&j[0][0], 121);
    bicycle_columns(y, x), show(x, 8);
    return 0;
}
"""


@pytest.fixture(scope="module")
def python_equations(tmp_path_factory):
    folder = tmp_path_factory.mktemp("equations")
    export(folder, "python")
    spec = importlib.util.spec_from_file_location(STEM, folder / f"{STEM}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def right(bicycle):
    """Mass, force, constraint Jacobian, heights, both residuals and the state, with 40 digits."""
    a = Multiprecision(40)
    b = Equations.of(bicycle, a).b
    form = Descriptor(b, a)
    z, rates = ([a.context.mpf(x) for x in values] for values in (Z, RATES))
    q, v = z[:COORDINATES], z[COORDINATES : 2 * COORDINATES]
    still = form.inertia_forces(q, v, [a.number(0)] * COORDINATES)
    return [
        np.ravel(np.array(x, float))
        for x in (
            form.mass(q), [-x for x in still], form.rolling(q), form.heights(q),
            *(form.residual(z, rates, index=index) for index in (2, 3)), to_reduced(b, a, z),
        )
    ]  # fmt: skip


def agree(found, right):
    for values, expected in zip(found, right, strict=True):
        # The values result from a few hundred operations. The limit is 1e4 units of roundoff of the
        # largest value.
        assert np.abs(np.ravel(values) - expected).max() < 1e-12 * np.abs(expected).max()


def test_python_has_the_numbers(python_equations, right):
    b = python_equations
    parts = [f(Z) for f in (b.mass, b.force, b.constraint_jacobian, b.heights)]
    residuals = [f(0.0, Z, RATES) for f in (b.residual_2, b.residual_3)]
    agree([*parts, *residuals, b.reduced(Z)], right)


def test_c_has_the_numbers(tmp_path, python_equations, right):
    """C also has the numbers of the reduced form; this needs no solver for C."""
    b = python_equations
    y = b.reduced(Z)
    reduced = [np.ravel(x) for x in (b.rates(0.0, y), b.jacobian(0.0, y), b.columns(y))]
    export(tmp_path, "c")
    words = {"STATE": Z, "RATES": RATES}
    code = re.sub("STATE|RATES", lambda m: ", ".join(map(str, words[m[0]])), _C)
    (tmp_path / "main.c").write_text(code)
    run([need("gcc"), "-std=c99", "-O1", "main.c", f"{STEM}.c", "-o", "all", "-lm"], tmp_path)
    found = np.array(run([tmp_path / "all"], tmp_path).split(), float)
    expected = [*right, *reduced]
    agree(np.split(found, np.cumsum([len(x) for x in expected])[:-1]), expected)


@pytest.mark.parametrize("number", [1, 2, 3])
@pytest.mark.parametrize(("index", "digits"), [(2, 9.5), (3, 6.5)])
def test_ida_follows_them(index, digits, number, python_equations, reference):
    ida = pytest.importorskip("sksundae.ida", reason="scikit-sundae (SUNDIALS) is not installed")
    b = python_equations
    residual = getattr(b, f"residual_{index}")

    def put(t, z, rates, out):
        out[:] = residual(t, z.tolist(), rates.tolist())

    start, rates = (
        np.array(getattr(b, f"descriptor_{x}_{number}")()) for x in ("start", "start_rates")
    )
    # The residual of the initial state is in N and m/s^2. It is a sum of forces of a few hundred N.
    assert np.abs(residual(0.0, start, rates)).max() < 1e-10
    # The tolerance does not apply to forces. At index 3 it does not apply to rates either. With
    # smaller steps, the errors of forces and rates do not decrease as those of the coordinates do.
    tolerances = np.full(SIZE, 1e-14)
    tolerances[2 * COORDINATES if index == 2 else COORDINATES :] = 100
    solver = ida.IDA(
        put, rtol=1e-12, atol=tolerances, algebraic_idx=list(range(SIZE - MULTIPLIERS, SIZE)),
        max_num_steps=100_000,
    )  # fmt: skip
    rows = range(0, 1001, 50)
    found = solver.solve([row / 100 for row in rows], start, rates)
    assert found.success
    columns = np.transpose([b.columns(b.reduced(z)) for z in found.y.tolist()])
    exact = np.array([reference[number].rows.hi[c] for c in BENCHMARK_COLUMNS])
    error = np.abs(columns - exact[:, rows]).max(1) / np.abs(exact).max(1)
    assert -np.log10(error.max()) > digits, dict(zip(BENCHMARK_COLUMNS, error, strict=True))
