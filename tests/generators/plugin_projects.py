"""A project of a user of the pytest plugin, with results of known errors."""

# This is the conftest.py of the project. The error of each column is a half wave with a maximum of
# 10^-digits of its scale, at a row in the middle of the run, so `digits` digits are correct.
CONFTEST = """
import numpy as np
import pytest
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS

def made(reference, number, digits):
    m = reference[number]
    wave = np.sin(np.pi * m.time / m.time[-1])
    return {"time": m.time} | {
        key: m.rows[key] + 10.0 ** -digits * m.scale(key) * wave for key in BENCHMARK_COLUMNS
    }

@pytest.fixture
def by_name(bicycle_reference):
    return lambda digits: {n: made(bicycle_reference, n, digits) for n in bicycle_reference}

@pytest.fixture
def table(by_name):
    def make(digits):
        found = by_name(digits)
        columns = [found[n][key] for n in found for key in BENCHMARK_COLUMNS]
        return np.column_stack([found[1]["time"], *columns])
    return make
"""
# Options that switch off the cache and other plugins, which together take most of the time of a
# run.
BARE = (
    "-p", "no:cacheprovider",
    *(word for name in ("hypothesispytest", "timeout", "xdist", "xdist.looponfail", "zarr")
      for word in ("-p", f"no:{name}")),
)  # fmt: skip
# In these tests the cause of the errors is known, so the slow diagnosis is switched off.
QUICK = (*BARE, "--bicycle-diagnose=never")


def project(pytester, tests, ini=""):
    pytester.makeconftest(CONFTEST)
    pytester.makefile(".ini", pytest=f"[pytest]\nfilterwarnings = error\n{ini}\n")
    pytester.makepyfile(test_it=tests)
    return pytester


def outcomes(result):
    """Return the outcome of each test by name; `result` is that of a run with -rA."""
    found = {}
    for line in result.outlines:
        word, _, rest = line.partition(" ")
        if word in ("PASSED", "FAILED", "ERROR") and "::" in rest:
            found[rest.split("::", 1)[1].split(" - ")[0]] = word
    return found
