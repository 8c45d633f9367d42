"""Shared inputs of the tests: the benchmark, the published set, and a longer run to judge it by."""

from __future__ import annotations

import os
import pickle
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import hypothesis
import pytest
from support.game_files import keep_values

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.values import Dense
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers, reference_folder

# A project of its own, which a test runs.
collect_ignore = ["example_project"]

MANEUVERS = (1, 2, 3)

# What changes how pytest, rich and argparse print in the processes that the tests start: a runner
# that sets CI, for one, has pytest repeat every failure in its summary.
for name in (
    *("CI", "BUILD_NUMBER", "PYTEST_ADDOPTS", "PY_COLORS", "FORCE_COLOR", "NO_COLOR"),
    *("COLUMNS", "LINES"),
):
    os.environ.pop(name, None)


# The same examples in every run: what a change breaks is that change's. New ones are looked for by
# pytest --hypothesis-profile=search.
hypothesis.settings.register_profile("same", derandomize=True)
hypothesis.settings.register_profile("search", print_blob=True)
hypothesis.settings.load_profile("same")


def pytest_configure(config: pytest.Config) -> None:
    # Files of proofs hold slow tests, which are asked for by their own name.
    if config.option.markexpr == "proof":
        config.option.markexpr = "proof and not slow"


@pytest.fixture(scope="session")
def bicycle() -> Bicycle:
    return read_bicycle(benchmark_bicycle())


@pytest.fixture(scope="session")
def simulator() -> Simulator:
    """Of any bicycle; it takes seconds to build, and keeps nothing of what it ran."""
    return Simulator()


@pytest.fixture(scope="session")
def maneuvers() -> tuple[Maneuver, ...]:
    return read_maneuvers(benchmark_maneuvers())


@pytest.fixture(scope="session")
def folder() -> Path:
    return reference_folder()


@pytest.fixture(scope="session")
def reference() -> Reference:
    return load_reference()


@pytest.fixture(scope="session")
def candidate(folder: Path) -> tuple[Trajectory, ...]:
    return read_candidate(folder)


def _run(job: tuple[Bicycle, Maneuver, int]) -> Trajectory:
    return integrate(*job)


@pytest.fixture(scope="session")
def long_runs(
    bicycle: Bicycle,
    maneuvers: tuple[Maneuver, ...],
    tmp_path_factory: pytest.TempPathFactory,
    worker_id: str,
) -> tuple[Trajectory, ...]:
    """The maneuvers at 110 digits, side by side; shares no digit with the published files."""
    import fcntl  # where heyoka is, that is on Linux

    # The first of the processes that run the tests makes them, the others wait for its file.
    base = tmp_path_factory.getbasetemp()
    shared = base if worker_id == "master" else base.parent
    with (shared / "long-runs").open("a+b") as f:
        fcntl.flock(f, fcntl.LOCK_EX)
        f.seek(0)
        if made := f.read():
            return pickle.loads(made)
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            runs = tuple(pool.map(_run, [(bicycle, m, 110) for m in maneuvers]))
        f.write(pickle.dumps(runs))
        return runs


@pytest.fixture(scope="module")
def keep_reference_values() -> Iterator[None]:
    """Values of the reference at the times that many files share are evaluated once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Dense, "evaluate", Dense.evaluate)
        keep_values()
        yield
