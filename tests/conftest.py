"""Shared inputs of the tests: the benchmark, the published set, and a longer run to judge it by."""

from __future__ import annotations

import gc
import os
import pickle
import shutil
from collections.abc import Callable, Hashable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

# As `score` and `diagnose` have it: threads of small systems wait for each other at full load.
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
from heyoka_bike.scoring.diagnosis.budget import NEVER, Deadline
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest, Simulator
from heyoka_bike.system.parallel import using
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers, reference_folder
from support.browser import chromium, opened, visited  # noqa: F401, fixtures of many modules

# A project of its own, which a test runs.
collect_ignore = ["example_project"]

MadeOnce = Callable[[str, Callable[[Path], object]], Path]

# What changes how pytest, rich and argparse print in the processes that the tests start: a runner
# that sets CI, for one, has pytest repeat every failure in its summary.
# They read what is compiled to bytecode once.
for name in (
    *("CI", "BUILD_NUMBER", "PYTEST_ADDOPTS", "PY_COLORS", "FORCE_COLOR", "NO_COLOR"),
    *("COLUMNS", "LINES", "PYTHONDONTWRITEBYTECODE"),
):
    os.environ.pop(name, None)
if "PYTEST_XDIST_WORKER" in os.environ:
    # Of what is measured a process that a test starts is as users have it.
    os.environ.pop("COVERAGE_PROCESS_START", None)

# The same examples in every run: what a change breaks is that change's. New ones are looked for by
# pytest --hypothesis-profile=search.
hypothesis.settings.register_profile("same", derandomize=True, deadline=None)
hypothesis.settings.register_profile("search", print_blob=True, deadline=None)
hypothesis.settings.load_profile("same")


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> Iterator[int]:
    """One more for the proofs, which wait for browsers, servers and other processes."""
    processors = yield
    return processors + (config.option.markexpr == "proof")


def pytest_configure(config: pytest.Config) -> None:
    # Thousands of tests are collected, and none of them is garbage before the end.
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    gc.freeze()
    gc.set_threshold(50_000)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def jobs_in_the_process_of_the_test() -> Iterator[None]:
    """The processes that run tests are as many as processors; a job begins one if a test asks."""
    with using(workers=1):
        yield


@pytest.fixture(scope="session")
def bicycle() -> Bicycle:
    return read_bicycle(benchmark_bicycle())


class RememberingSimulator(Simulator):
    """Keeps the first motions asked for: those of the usual mistakes, which all files meet."""

    most = 500  # of a third of a megabyte each

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
    """Of any bicycle; it remembers the motions of the usual mistakes."""
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
    """What many tests need and is long in the making: a folder by its name, and what fills it."""

    def make(name: str, fill: Callable[[Path], object]) -> Path:
        from filelock import FileLock  # only tests that use this fixture need it

        # The first of the processes that run the tests makes it, the others wait for it.
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
    """A maneuver, by its number, at 90 digits; shares no digit with the published files."""

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
    """A set of one maneuver of eleven rows; not to be changed."""
    return made_once("small-set", lambda place: make_set(place, ("0.1", "0.01"))) / "set"


@pytest.fixture(scope="session")
def small_atlas(made_once: MadeOnce) -> Path:
    """An atlas of 6 by 6 starts; not to be changed."""
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
