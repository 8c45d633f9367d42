"""Settings of a user's process neither influence the package nor are changed by it."""

import decimal
import locale
import os
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor

import flint
import mpmath
import numpy as np
import pytest
from threadpoolctl import threadpool_info

import heyoka_bike as hb
from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.system.resources import data_folder

FILE = str(data_folder() / "peers" / "exudyn-h0.01.txt")


def state():
    """Return settings of the process that a library might change."""
    return {
        "flint": (flint.ctx.prec, flint.ctx.cap),
        "mpmath": (mpmath.mp.dps, mpmath.iv.dps),
        "numpy": (np.geterr(), np.get_printoptions()),
        "decimal": str(decimal.getcontext()),
        "locale": locale.setlocale(locale.LC_ALL),
        "warnings": [*warnings.filters],
        "folder": os.getcwd(),
        "linear algebra": threads_of_linear_algebra(),
    }


def threads_of_linear_algebra():
    return [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]


def matrices(digits):
    found = hb.linearise(benchmark()[0], digits)
    return [str(x) for m in (found.M, found.C1, found.K0, found.K2) for row in m for x in row]


CALLS = {
    "score": lambda: hb.score(FILE).to_dict()["is_right"],
    "read_results": lambda: hb.read_results(FILE).significant_digits,
    "linearise 15": lambda: matrices(15),
    "linearise 200": lambda: matrices(200),
    "evaluate": lambda: hb.load_reference()[2].evaluate([1 / 3])["roll_angle"].tolist(),
    "sensitivities": lambda: hb.load_sensitivities()[1].evaluate([5.0])["roll_angle"].tolist(),
    "read_bicycle": lambda: hb.read_bicycle(data_folder() / "bicycles" / "benchmark.toml").name,
}


@pytest.mark.parametrize("name", CALLS)
def test_nothing_is_left_changed(name):
    before = state()
    CALLS[name]()
    assert state() == before


@pytest.mark.parametrize("name", CALLS)
def test_threads_get_what_one_gets(name):
    alone = CALLS[name]()
    before = state()
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: CALLS[name](), range(8 if "score" in name else 24)))
    assert all(x == alone for x in found)
    assert state() == before


def test_threads_with_other_digits_get_theirs():
    alone = {digits: matrices(digits) for digits in (15, 30, 60, 200)}
    asked = [15, 30, 60, 200] * 12
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(matrices, asked))
    assert [x == alone[d] for d, x in zip(asked, found, strict=True)] == [True] * len(asked)
    assert flint.ctx.prec == 53


@pytest.mark.parametrize("name", CALLS)
def test_numpy_that_raises_has_no_influence(name):
    expected = CALLS[name]()
    with np.errstate(all="raise"):
        assert CALLS[name]() == expected
        assert np.geterr()["under"] == "raise"


def test_without_a_home_nothing_is_kept(tmp_path):
    """The environment is like that of a batch job, or of a container."""
    code = (
        "from heyoka_bike.motion import heyoka_adapter as a; a.require_heyoka(); import heyoka; "
        "print(heyoka.llvm_state.get_diskcache_enabled())"
    )
    environment = {k: x for k, x in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=tmp_path, capture_output=True, text=True
    )
    assert done.stdout == "False\n", done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_diagnosis_takes_one_thread_of_the_linear_algebra(tmp_path):
    """Even after two parallel diagnoses the number of threads is restored."""
    code = f"""
from concurrent.futures import ThreadPoolExecutor
import sys
sys.path.insert(0, {os.path.dirname(__file__)!r})
from test_the_process_stays_as_it_was import FILE, hb, threads_of_linear_algebra

within = []

def look(_):
    within.append(threads_of_linear_algebra())
    raise KeyError("seen enough")

def diagnosed(_):
    try:
        hb.diagnose(FILE, progress=look)
    except KeyError:
        pass

before = threads_of_linear_algebra()
diagnosed(0)
alone = [*within]
with ThreadPoolExecutor(2) as pool:
    list(pool.map(diagnosed, range(2)))
print(before, alone, len(within), before == threads_of_linear_algebra())
"""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "2"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=tmp_path, capture_output=True, text=True
    )
    assert done.stdout == "[2] [[1]] 3 True\n", done.stderr
