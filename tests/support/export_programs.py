"""Exported source code, compiled or run: values of all maneuvers and columns at given times.

Times and values go through files of binary64 numbers, so that no digit is lost on the way.
"""

import shutil
import subprocess

import numpy as np
import pytest

from heyoka_bike.cli import main

STEM = "uncontrolled_bicycle"

# Compiler flags that forbid the fusing of products and sums, which would change the last bits.
AS_WRITTEN = ("-O2", "-ffp-contract=off")
STRICT = ("-Wall", "-Wextra", "-pedantic", "-Werror")

_C = """
#include "uncontrolled_bicycle.h"
#include <stdio.h>
#include <stdlib.h>

int main(void)
{
    enum { MOST = 20000 };
    double *t = malloc(2 * MOST * sizeof *t), value[3];
    FILE *in = fopen("times.bin", "rb"), *out = fopen("values.bin", "wb");
    size_t count = fread(t, sizeof *t, 2 * MOST, in) / 2;
    for (int m = 1; m <= MANEUVERS; m++)
        for (int c = 0; c < BICYCLE_COLUMNS; c++)
            for (size_t i = 0; i < count; i++) {
                value[0] = bicycle_evaluate(m, c, t[i]);
                bicycle_evaluate_pair(m, c, t[i], t[count + i], value + 1);
                fwrite(value, sizeof *value, 3, out);
            }
    return fclose(in) + fclose(out);
}
"""

_FORTRAN = """
program all_values
   use, intrinsic :: iso_fortran_env, only: real64
   use uncontrolled_bicycle
   implicit none
   real(real64), allocatable :: t(:)
   integer :: bytes, in, out, m, c
   inquire (file='times.bin', size=bytes)
   allocate (t(bytes/16))
   open (newunit=in, file='times.bin', access='stream', form='unformatted', status='old')
   read (in) t
   open (newunit=out, file='values.bin', access='stream', form='unformatted', status='replace')
   do m = 1, MANEUVERS
      do c = 1, COLUMNS
         write (out) bicycle_evaluate(m, c, t)
      end do
   end do
end program all_values
"""

_OCTAVE = """
in = fopen('times.bin'); t = fread(in, Inf, 'double'); fclose(in);
t = t(1:end/2);
out = fopen('values.bin', 'w');
for m = 1:MANEUVERS
  for name = {COLUMNS}
    fwrite(out, uncontrolled_bicycle(m, name{1}, t), 'double');
  end
end
fclose(out);
"""


def need(tool):
    """Return the path of a tool; skip the test if it is missing."""
    path = shutil.which(tool)
    if path is None:
        pytest.skip(f"{tool} is not installed")
    return path


def export(folder, kind, *options):
    assert main(["export", "--format", kind, "-o", str(folder), *options]) == 0


def run(command, folder):
    done = subprocess.run(
        list(map(str, command)), cwd=folder, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def c_values(folder, times, maneuvers, columns, flags=AS_WRITTEN):
    """Return values of `bicycle_evaluate` and of the pairs: (maneuvers, columns, times, 3)."""
    (folder / "main.c").write_text(_C.replace("MANEUVERS", str(maneuvers)))
    sources = ["main.c", f"{STEM}.c"]
    run([need("gcc"), "-std=c99", *STRICT, *flags, *sources, "-o", "all", "-lm"], folder)
    return _values(folder, [folder / "all"], times).reshape(maneuvers, len(columns), -1, 3)


def fortran_values(folder, times, maneuvers, columns, flags=AS_WRITTEN):
    """Return values of `bicycle_evaluate`: shape (maneuvers, columns, times)."""
    code = _FORTRAN.replace("MANEUVERS", str(maneuvers)).replace("COLUMNS", str(len(columns)))
    (folder / "main.f90").write_text(code)
    sources = [f"{STEM}.f90", "main.f90"]
    run([need("gfortran"), "-std=f2008", *STRICT, *flags, *sources, "-o", "all"], folder)
    return _values(folder, [folder / "all"], times).reshape(maneuvers, len(columns), -1)


def octave_values(folder, times, maneuvers, columns):
    """Return values of the function: shape (maneuvers, columns, times)."""
    names = ", ".join(f"'{name}'" for name in columns)
    code = _OCTAVE.replace("MANEUVERS", str(maneuvers)).replace("COLUMNS", names)
    (folder / "all_values.m").write_text(code)
    command = [need("octave-cli"), "--norc", "all_values.m"]
    return _values(folder, command, times).reshape(maneuvers, len(columns), -1)


def _values(folder, command, times):
    np.concatenate(times).tofile(folder / "times.bin")
    run(command, folder)
    return np.fromfile(folder / "values.bin")
