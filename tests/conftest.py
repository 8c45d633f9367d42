"""Shared inputs of the tests: the benchmark, the published dataset, and a longer run to compare
with."""

from __future__ import annotations

import gc
import os
import pickle
import shutil
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path
from typing import Any

# Use one thread, as `score` and `diagnose` do. With small systems on a busy machine, several
# threads only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import pytest

from generators.made_sets import make as make_set
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.cli import main
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.scoring.diagnosis.budget import DEFAULT_BUDGET, NEVER, Budget, Deadline
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.system.parallel import using
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers, reference_folder
from support.browser import chromium, opened, visited  # noqa: F401, fixtures of many modules

# This folder is a separate project, which one of the tests runs.
collect_ignore = ["example_project"]

MadeOnce = Callable[[str, Callable[[Path], object]], Path]

# These variables change how pytest, rich and argparse print in the processes that the tests start.
# For example, if a runner sets CI, pytest repeats every failure in its summary.
# PYTHONDONTWRITEBYTECODE would make every process compile the modules again.
for name in (
    *("CI", "BUILD_NUMBER", "PYTEST_ADDOPTS", "PY_COLORS", "FORCE_COLOR", "NO_COLOR"),
    *("COLUMNS", "LINES", "PYTHONDONTWRITEBYTECODE"),
):
    os.environ.pop(name, None)
if "PYTEST_XDIST_WORKER" in os.environ:
    # Processes started by a test run without coverage measurement, as those of users do.
    os.environ.pop("COVERAGE_PROCESS_START", None)

# Hypothesis draws the same examples in every run, so a new failure is due to a change. New examples
# are drawn with pytest --hypothesis-profile=search.
hypothesis.settings.register_profile("same", derandomize=True, deadline=None)
hypothesis.settings.register_profile("search", print_blob=True, deadline=None)
hypothesis.settings.load_profile("same")


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> Iterator[int]:
    """Use one more process for the proofs, which wait for browsers, servers and other processes."""
    processors = yield
    return processors + (config.option.markexpr == "proof")


def pytest_configure(config: pytest.Config) -> None:
    # Collection creates thousands of test items, and all of them remain until the end. Collecting
    # garbage meanwhile would only cost time.
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    gc.freeze()
    gc.set_threshold(50_000)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def jobs_in_the_process_of_the_test() -> Iterator[None]:
    """Jobs run in the test's own process by default: there is already one process per processor."""
    with using(workers=1):
        yield


@pytest.fixture(scope="session", autouse=True)
def diagnoses_without_time_limit() -> Iterator[None]:
    """A diagnosis with the default budget has no time limit in the tests, so what it finds does not
    depend on the speed of the machine."""
    begun = Budget.begun

    def patient(budget: Budget) -> Deadline:
        deadline = begun(budget)
        return replace(deadline, end=inf) if budget.seconds == DEFAULT_BUDGET else deadline

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Budget, "begun", patient)
        yield


@pytest.fixture(scope="session")
def bicycle() -> Bicycle:
    return read_bicycle(benchmark_bicycle())


class RememberingSimulator(Simulator):
    """Caches the first motions that are simulated: those of the usual mistakes, which every file
    needs."""

    most = 500  # largest number of motions, each of which takes a third of a megabyte

    def __init__(self) -> None:
        super().__init__()
        self.known: dict[Hashable, dict[str, Array]] = {}

    def run_all(
        self, motions: Sequence[MotionRequest], deadline: Deadline = NEVER
    ) -> list[dict[str, Array]]:
        keys = [
            (*m.bicycle.values.items(), *m.start, *m.amounts.items(), m.time.tobytes())
            for m in motions
        ]
        new = {k: m for k, m in zip(keys, motions, strict=True) if k not in self.known}
        made = dict(zip(new, super().run_all(list(new.values()), deadline), strict=True))
        for key in list(new)[: self.most - len(self.known)]:
            self.known[key] = made[key]
            for values in made[key].values():
                values.setflags(write=False)
        return [dict(made.get(k) or self.known[k]) for k in keys]


@pytest.fixture(scope="session")
def simulator() -> Simulator:
    """A simulator for any bicycle, which caches the motions of the usual mistakes."""
    return RememberingSimulator()


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


@pytest.fixture(scope="session")
def made_once(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> MadeOnce:
    """Return a function that makes a folder once for all tests: its name, and a function that
    fills it."""

    def make(name: str, fill: Callable[[Path], object]) -> Path:
        from filelock import FileLock  # only tests that use this fixture need it

        # The first process that runs such a test fills the folder. The other processes wait for it.
        base = tmp_path_factory.getbasetemp()
        place = (base if worker_id == "master" else base.parent) / name
        made = place.with_name(f"{name}.made")
        with FileLock(f"{made}.lock"):
            if not made.exists():
                shutil.rmtree(place, ignore_errors=True)
                place.mkdir()
                fill(place)
                made.touch()
        return place

    return make


@pytest.fixture(scope="session")
def long_run(
    bicycle: Bicycle, maneuvers: tuple[Maneuver, ...], made_once: MadeOnce
) -> Callable[[int], Trajectory]:
    """Return a function that runs a maneuver, by number, at 90 digits, independently of the
    published files."""

    @cache
    def run(number: int) -> Trajectory:
        def fill(place: Path) -> None:
            (place / "run").write_bytes(pickle.dumps(integrate(bicycle, maneuvers[number - 1], 90)))

        place = made_once(f"long-run-{number}", fill)
        found: Trajectory = pickle.loads((place / "run").read_bytes())
        return found

    return run


@pytest.fixture(scope="session")
def small_set(made_once: MadeOnce) -> Path:
    """A dataset of one maneuver with eleven rows. Tests must not change it."""
    return made_once("small-set", lambda place: make_set(place, ("0.1", "0.01"))) / "set"


@pytest.fixture(scope="session")
def small_atlas(made_once: MadeOnce) -> Path:
    """An atlas of 6 by 6 initial conditions. Tests must not change it."""
    grid = ["--speed", "3:8:6", "--roll-rate", "0.3:3.3:6", "--longest", "60"]
    place = made_once("small-atlas", lambda to: main(["atlas", *grid, "-o", str(to / "zarr")]))
    return place / "zarr"


@pytest.fixture(scope="session")
def honest_outcomes(made_once: MadeOnce) -> list[Any]:
    """The first 125 files of the game of honest variations, played once."""
    from games.play import play

    def fill(place: Path) -> None:
        (place / "outcomes").write_bytes(pickle.dumps(play("honest", range(125), processes=1)))

    found: list[Any] = pickle.loads((made_once("honest-game", fill) / "outcomes").read_bytes())
    return found
