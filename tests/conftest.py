"""Shared inputs of the tests: the benchmark, the published set, and a longer run to judge it by."""

from __future__ import annotations

import os
import pickle
import shutil
from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import wraps
from importlib.util import find_spec
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from support.game_files import keep_values
from support.made_sets import make as make_set

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.reference.proof import prove_again
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.values import Dense
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers, reference_folder

# A project of its own, which a test runs.
collect_ignore = ["example_project"]
if find_spec("heyoka") is None:
    # These integrate in every test; scoring is tested without it.
    collect_ignore += [
        *(f"scoring/test_{name}.py" for name in (
            "few_unknowns_explain_a_file", "mistakes_are_recognised", "mistakes_in_tilted_axes",
            "numerical_causes", "odds_are_what_they_say",
        )),
        "commands/test_score_diagnoses.py",
    ]  # fmt: skip
if find_spec("uvicorn") is None:
    collect_ignore += ["workbench/test_serve_command.py", "workbench/serving"]

MANEUVERS = (1, 2, 3)
MadeOnce = Callable[[str, Callable[[Path], object]], Path]

# What changes how pytest, rich and argparse print in the processes that the tests start: a runner
# that sets CI, for one, has pytest repeat every failure in its summary.
# They read what is compiled to bytecode once.
for name in (
    *("CI", "BUILD_NUMBER", "PYTEST_ADDOPTS", "PY_COLORS", "FORCE_COLOR", "NO_COLOR"),
    *("COLUMNS", "LINES", "PYTHONDONTWRITEBYTECODE"),
):
    os.environ.pop(name, None)


# The same examples in every run: what a change breaks is that change's. New ones are looked for by
# pytest --hypothesis-profile=search.
hypothesis.settings.register_profile("same", derandomize=True)
hypothesis.settings.register_profile("search", print_blob=True)
hypothesis.settings.load_profile("same")


# Files of more than half a minute. They begin first, so that the processes end at the same time.
LONGEST = (
    "test_verify_sees_what_hashes_do_not", "test_few_unknowns_explain_a_file",
    "test_mistakes_are_recognised", "test_an_atlas_says_what_becomes",
    "test_verify_finds_every_damage", "test_programs_of_others_are_judged_fairly",
    "test_dense_output_is_good_to_25_digits", "test_sensitivities_are_proved",
    "test_bench_reports_every_code", "test_another_integrator_agrees",
    "test_generate_command", "test_published_set_is_proved",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    rank = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path.stem, len(LONGEST)))


def pytest_configure(config: pytest.Config) -> None:
    # Files of proofs hold slow tests, which are asked for by their own name.
    if config.option.markexpr == "proof":
        config.option.markexpr = "proof and not slow"


@pytest.fixture(scope="session")
def bicycle() -> Bicycle:
    return read_bicycle(benchmark_bicycle())


class RememberingSimulator(Simulator):
    """Keeps the first motions asked for: those of the usual mistakes, which all files meet."""

    most = 500  # of a third of a megabyte each

    def __init__(self) -> None:
        super().__init__()
        self.known: dict[Hashable, dict[str, Array]] = {}

    def run_all(self, motions: Sequence[AskedMotion]) -> list[dict[str, Array]]:
        keys = [
            (*m.bicycle.values.items(), *m.start, *m.amounts.items(), m.time.tobytes())
            for m in motions
        ]
        new = {k: m for k, m in zip(keys, motions, strict=True) if k not in self.known}
        made = dict(zip(new, super().run_all(list(new.values())), strict=True))
        for key in list(new)[: self.most - len(self.known)]:
            self.known[key] = made[key]
            for values in made[key].values():
                values.setflags(write=False)
        return [dict(made.get(k) or self.known[k]) for k in keys]


@pytest.fixture(scope="session")
def simulator() -> Simulator:
    """Of any bicycle; it takes seconds to build."""
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
        from filelock import FileLock  # where heyoka is

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
def long_runs(
    bicycle: Bicycle,
    maneuvers: tuple[Maneuver, ...],
    made_once: MadeOnce,
) -> tuple[Trajectory, ...]:
    """The maneuvers at 90 digits, side by side; shares no digit with the published files."""

    def fill(place: Path) -> None:
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            # A function of the package: a spawned process finds none of "conftest", there are two.
            runs = tuple(pool.map(integrate, repeat(bicycle), maneuvers, repeat(90)))
        (place / "runs").write_bytes(pickle.dumps(runs))

    found: tuple[Trajectory, ...] = pickle.loads(
        (made_once("long-runs", fill) / "runs").read_bytes()
    )
    return found


@pytest.fixture(scope="session")
def small_set(made_once: MadeOnce) -> Path:
    """A set of one maneuver of eleven rows; not to be changed."""
    return made_once("small-set", lambda place: make_set(place, ("0.1", "0.01"))) / "set"


@pytest.fixture(scope="module")
def keep_proofs() -> Iterator[None]:
    """What follows from a candidate alone is proved once, for `certify --workers 1`.

    What is published in copies of one set is compared with it each time.
    """
    with pytest.MonkeyPatch.context() as patch:
        for name in ("enclosed", "differentiate", "round_rows"):
            patch.setattr(prove_again, name, kept(getattr(prove_again, name)))
        yield


def kept(prove: Callable[..., Any]) -> Callable[..., Any]:
    """The function, which remembers; its last argument only listens."""
    known: dict[bytes, Any] = {}

    @wraps(prove)
    def once(*arguments: Any) -> Any:
        of = pickle.dumps(arguments[:-1])
        if of not in known:
            known[of] = prove(*arguments)
        return known[of]

    # By its name and place another process finds the function itself.
    once.__module__ = prove_again.__name__
    return once


@pytest.fixture(scope="module")
def keep_reference_values() -> Iterator[None]:
    """Values of the reference at the times that many files share are evaluated once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Dense, "evaluate", Dense.evaluate)
        keep_values()
        yield
