"""The exported equations, compiled or run: functions at a state, and a solver's motion.

Each program prints rates, Jacobian by rows and columns at `SOMEWHERE`, and then the columns of
maneuver 2 every half second. Python, Octave and C have available solvers. The compilers of Fortran
and Rust come without one, so these programs use the classic Runge-Kutta method.
"""

import subprocess
import sys

import numpy as np
import pytest

from heyoka_bike.cli import main
from support.export_programs import need, run

STEM = "bicycle"
STATE, COLUMNS = 11, 8
SOMEWHERE = (0.3, -0.02, -0.4, 0.7, -1.1, 13.0, 0.6, 2.0, -3.0, 5.0, 7.0)
"""A state; the wheels need not touch the floor, because the formulas are the same."""
# RK4 has an error of the order (20 h)^4 / 120, because the fastest mode decays at 20/s.
STEPS = 2000  # number of steps per half second

_PYTHON = """
import bicycle as b
from scipy.integrate import solve_ivp

y = [SOMEWHERE]
for row in (b.rates(0.0, y), *b.jacobian(0.0, y), b.columns(y)):
    print(*row)
y = b.start_2()
times = [i / 2 for i in range(HALVES + 1)]
# Between its steps DOP853 interpolates with a lower order, so limit its steps.
run = solve_ivp(b.rates, (0, times[-1]), y, "DOP853", times, rtol=1e-13, atol=1e-16, max_step=0.02)
for at in run.y.T:
    print(*b.columns(at.tolist()))
"""

_C = """
#include "bicycle.h"
#include <gsl/gsl_odeiv2.h>
#include <stdio.h>
#include <string.h>

static int rates(double t, const double y[], double f[], void *unused)
{
    (void)t, (void)unused;
    bicycle_rates(y, f);
    return 0;
}

static int jacobian(double t, const double y[], double *j, double f[], void *unused)
{
    (void)t, (void)unused;
    double found[11][11];
    bicycle_jacobian(y, found);
    memcpy(j, found, sizeof found);
    memset(f, 0, 11 * sizeof *f);
    return 0;
}

static void show(const double x[], int n)
{
    for (int i = 0; i < n; i++)
        printf("%.17g ", x[i]);
}

int main(void)
{
    double y[11] = {SOMEWHERE}, f[11], j[11][11], c[8], t = 0;
    gsl_odeiv2_system system = {rates, jacobian, 11, NULL};
    gsl_odeiv2_driver *driver =
        gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, 1e-3, 1e-16, 1e-14);
    bicycle_rates(y, f);
    bicycle_jacobian(y, j);
    bicycle_columns(y, c);
    show(f, 11), show(&j[0][0], 121), show(c, 8);
    bicycle_start_2(y);
    bicycle_columns(y, c);
    show(c, 8);
    for (int i = 1; i <= HALVES; i++) {
        if (gsl_odeiv2_driver_apply(driver, &t, i / 2.0, y))
            return 1;
        bicycle_columns(y, c);
        show(c, 8);
    }
    gsl_odeiv2_driver_free(driver);
    return 0;
}
"""

_FORTRAN = """
program all_values
   use, intrinsic :: iso_fortran_env, only: real64
   use bicycle
   implicit none
   real(real64), parameter :: h = 0.5_real64/STEPS
   real(real64) :: y(11), c(8), j(11, 11), k1(11), k2(11), k3(11), k4(11)
   integer :: i, n
   y = [SOMEWHERE]
   call rates(y, k1)
   call jacobian(y, j)
   call columns(y, c)
   print '(*(es26.17e3))', k1, transpose(j), c
   call start_2(y)
   call columns(y, c)
   print '(*(es26.17e3))', c
   do i = 1, HALVES
      do n = 1, STEPS
         call rates(y, k1)
         call rates(y + h/2*k1, k2)
         call rates(y + h/2*k2, k3)
         call rates(y + h*k3, k4)
         y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
      end do
      call columns(y, c)
      print '(*(es26.17e3))', c
   end do
end program all_values
"""

_OCTAVE = """
b = bicycle();
y = [SOMEWHERE]';
fprintf('%.17g ', b.rates(0, y), b.jacobian(0, y)', b.columns(y));
y = b.start_2();
fprintf('%.17g ', b.columns(y));
options = odeset('RelTol', 1e-12, 'AbsTol', 1e-16, 'Jacobian', b.jacobian);
for i = 1:HALVES
  [~, found] = ode45(b.rates, [0 0.5], y, options);
  y = found(end, :)';
  fprintf('%.17g ', b.columns(y));
end
"""

_RUST = """
mod bicycle;
use bicycle::{columns, jacobian, rates, start_2};

fn show(x: &[f64]) {
    for v in x {
        print!("{:e} ", v);
    }
}

fn ahead(y: &[f64; 11], h: f64, k: &[f64; 11]) -> [f64; 11] {
    let mut z = *y;
    for i in 0..11 {
        z[i] += h * k[i];
    }
    z
}

fn main() {
    let h = 0.5 / STEPS as f64;
    let mut y = [SOMEWHERE];
    show(&rates(&y));
    for row in jacobian(&y) {
        show(&row);
    }
    show(&columns(&y));
    y = start_2();
    show(&columns(&y));
    for _ in 0..HALVES {
        for _ in 0..STEPS {
            let k1 = rates(&y);
            let k2 = rates(&ahead(&y, h / 2.0, &k1));
            let k3 = rates(&ahead(&y, h / 2.0, &k2));
            let k4 = rates(&ahead(&y, h, &k3));
            for i in 0..11 {
                y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
        }
        show(&columns(&y));
    }
}
"""


def export(folder, language, *options):
    assert main(["export", "--equations", language, "-o", f"{folder}/", *options]) == 0


def _write(folder, name, code, halves):
    kind = "d0" if name.endswith(".f90") else ""
    somewhere = ", ".join(f"{x}{kind}" for x in SOMEWHERE)
    words = {"HALVES": halves, "STEPS": STEPS, "SOMEWHERE": somewhere}
    for word, value in words.items():
        code = code.replace(word, str(value))
    (folder / name).write_text(code)


def python_numbers(folder, halves):
    _write(folder, "main.py", _PYTHON, halves)
    return _numbers([sys.executable, "main.py"], folder)


def c_numbers(folder, halves):
    _write(folder, "main.c", _C, halves)
    _write(folder, "there.c", "#include <gsl/gsl_odeiv2.h>\n", halves)
    flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O1"]
    run([need("gcc"), *flags, "-c", f"{STEM}.c"], folder)
    if subprocess.run(
        ["gcc", "-fsyntax-only", "there.c"], cwd=folder, capture_output=True
    ).returncode:
        pytest.skip("the GNU Scientific Library is not installed (libgsl-dev)")
    libraries = ["-lgsl", "-lgslcblas", "-lm"]
    run(["gcc", *flags, f"{STEM}.o", "main.c", *libraries, "-o", "all"], folder)
    return _numbers([folder / "all"], folder)


def fortran_numbers(folder, halves):
    _write(folder, "main.f90", _FORTRAN, halves)
    flags = ["-std=f2008", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O1"]
    run([need("gfortran"), *flags, f"{STEM}.f90", "main.f90", "-o", "all"], folder)
    return _numbers([folder / "all"], folder)


def matlab_numbers(folder, halves):
    """Return the numbers from GNU Octave."""
    _write(folder, "all_values.m", _OCTAVE, halves)
    return _numbers([need("octave-cli"), "--norc", "all_values.m"], folder)


def rust_numbers(folder, halves):
    _write(folder, "main.rs", _RUST, halves)
    run([need("rustc"), "-D", "warnings", "-O", "main.rs", "-o", "all"], folder)
    return _numbers([folder / "all"], folder)


def _numbers(command, folder):
    """Return rates, Jacobian, columns, and the columns of the motion."""
    found = np.array(run(command, folder).split(), float)
    rates, jacobian, columns, motion = np.split(found, np.cumsum([STATE, STATE * STATE, COLUMNS]))
    return rates, jacobian.reshape(STATE, STATE), columns, motion.reshape(-1, COLUMNS)
