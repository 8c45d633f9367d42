"""Compiled code is not compiled again in a new process, and no cache is required."""

import os
import subprocess
import sys

import pytest

pytest.importorskip("heyoka")

pytestmark = pytest.mark.proof

CODE = """
import heyoka
from fractions import Fraction
from heyoka_bike import integrate, read_bicycle, read_maneuvers
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers
state = heyoka.llvm_state
before = state.get_diskcache_size() if state.get_diskcache_path().exists() else 0
maneuver = read_maneuvers(benchmark_maneuvers())[1]
found = float(integrate(read_bicycle(benchmark_bicycle()), maneuver).state(Fraction(1))[0].mid())
after = state.get_diskcache_size() if before else 0
limit = state.get_diskcache_limit() if state.get_diskcache_enabled() else 0
print(found.hex(), before, after, limit)
"""


def run(folder):
    done = subprocess.run(
        [sys.executable, "-c", CODE], env=os.environ | {"XDG_CACHE_HOME": str(folder)},
        capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found, before, after, limit = done.stdout.split()
    # The limit that heyoka sets itself is 20 GiB, in the user's home.
    assert int(limit) == (2**30 if folder.is_dir() else 0)
    return found, int(before), int(after)


def test_a_new_process_compiles_nothing_again(tmp_path):
    first, before, _ = run(tmp_path)
    assert before == 0
    second, before, after = run(tmp_path)
    assert second == first
    assert after == before > 0


def test_a_folder_that_cannot_be_used_is_no_error(tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert run(tmp_path / "file")[0] == run(tmp_path / "fine")[0]
