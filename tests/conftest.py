"""Shared inputs of the tests: the benchmark, the published set, and a longer run to judge it by."""

from __future__ import annotations

import gc
import os
import pickle
import re
import shutil
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import replace
from functools import cache, wraps
from importlib.util import find_spec
from pathlib import Path
from typing import Any

# As `score` and `diagnose` have it: threads of small systems wait for each other at full load.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import pytest
from support.browser import chromium, opened, visited  # noqa: F401, fixtures of many modules
from support.game_files import keep_values
from support.made_sets import make as make_set

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.cli import main
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.reference.proof import certificate
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.values import Dense
from heyoka_bike.reference.verification import schema
from heyoka_bike.scoring.diagnosis.budget import NEVER, Deadline
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.system.parallel import using
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
hypothesis.settings.register_profile("same", derandomize=True, deadline=None)
hypothesis.settings.register_profile("search", print_blob=True, deadline=None)
hypothesis.settings.load_profile("same")


# Files of more than a quarter of a minute with the proofs, then those of the fast tests that take
# longest, more than five seconds. They begin first, so that the processes end at the same time.
LONGEST = (
    "test_odds_are_what_they_say", "test_mistakes_are_recognised",
    "test_verify_sees_what_hashes_do_not", "test_checker_agrees_with_score",
    "test_a_browser_scores_a_file", "test_nothing_is_lost_or_made_twice",
    "test_published_set_is_proved", "test_verify_finds_every_damage",
    "test_bench_reports_every_code", "test_figures_of_the_pages_show_the_reference",
    "test_pages_show_what_their_commands_print",
    "test_pytest_plugin_failures_teach", "test_sensitivities_are_proved",
    "test_certificate_refuses_or_widens", "test_few_unknowns_explain_a_file",
    "test_the_tutorial_runs", "test_generate_command", "test_an_atlas_says_what_becomes",
    "test_atlas_page_computes_the_models_motion",
    "test_digits_do_not_depend_on_how_code_is_compiled",
    "test_critical_speeds_are_proved_over_a_box", "test_animate_page",
    "test_commands_run_where_names_are_missing", "test_wheel_works_outside_the_checkout",
    "test_dense_output_is_good_to_25_digits", "test_numerical_causes",
    "test_python_makes_and_checks_sets", "test_a_set_says_which_definitions_it_has",
    "test_linearised_programs_are_told_as_such", "test_score_diagnoses",
    "test_another_integrator_agrees", "test_what_follows_ten_seconds_is_proved",
    "test_programs_of_others_are_judged_fairly", "test_harder_tier_is_what_the_page_says",
    "test_energy_and_contact_are_kept_at_every_precision", "test_definitions_are_recognised",
    "test_plot_draws_every_maneuver", "test_what_remains_names_the_force",
    "test_forces_that_are_applied", "test_score_command", "test_events_are_found_where_they_are",
    "test_exports_are_read_back", "test_input_fuzz_never_crashes", "test_export_command",
    "test_pytest_plugin_requires_digits", "test_integrators_are_named_with_their_step",
    "test_leaderboard_ranks_by_true_error", "test_linear_works_for_unusual_bicycles",
    "test_whatever_holds_columns_is_scored", "test_files_are_scored_by_a_page",
    "test_a_server_keeps_its_bounds",
)  # fmt: skip


_ALL_PROOF = re.compile(r"^pytestmark = \[?pytest\.mark\.proof", re.MULTILINE)
_SOME_PROOF = re.compile(r"mark\.proof|@browser")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    rank = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path.stem, len(LONGEST)))


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> Iterator[int]:
    """One more for the proofs, which wait for browsers, servers and other processes."""
    processors = yield
    return processors + (config.option.markexpr == "proof")


def pytest_configure(config: pytest.Config) -> None:
    # Files of proofs hold slow tests, which are asked for by their own name.
    if config.option.markexpr == "proof":
        config.option.markexpr = "proof and not slow"
    # Thousands of tests are collected, and none of them is garbage before the end.
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    gc.freeze()
    gc.set_threshold(50_000)
    gc.enable()


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out files of the other tier: importing them takes seconds."""
    asked = config.option.markexpr
    if collection_path.match("test_*.py"):
        text = collection_path.read_text(encoding="utf-8")
        if asked.startswith("not proof and "):
            return bool(_ALL_PROOF.search(text)) or None
        if asked == "proof and not slow":
            return not _SOME_PROOF.search(text) or None
    return None


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
        self, motions: Sequence[AskedMotion], deadline: Deadline = NEVER
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


@cache
def shared_simulator() -> Simulator:
    return RememberingSimulator()


@pytest.fixture(scope="session")
def simulator() -> Simulator:
    """Of any bicycle; it remembers the motions of the usual mistakes."""
    return shared_simulator()


@pytest.fixture(scope="session", autouse=True)
def diagnoses_share_their_motions() -> Iterator[None]:
    """A diagnosis that is told no simulator takes that of all tests, too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(f"{explain.__module__}.Simulator", shared_simulator)
        yield


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


@pytest.fixture(scope="module")
def keep_proofs() -> Iterator[None]:
    """What follows from a candidate alone is proved once, however many copies of one set there are.

    What is published in a copy is compared with it, unless the same was compared before.
    """
    with pytest.MonkeyPatch.context() as patch:
        for name in ("enclosed", "differentiate", "round_rows", "rounded", "moved", "varied"):
            patch.setattr(certificate, name, kept(getattr(certificate, name)))
        yield


@pytest.fixture(scope="module")
def keep_structure() -> Iterator[None]:
    """How a file is built is looked at once, however many copies of one set have it."""
    known: dict[bytes, list[str]] = {}
    look_at = schema.problems_of

    def once(look: Callable[..., Iterator[str]], raw: bytes, form: schema.SetForm) -> list[str]:
        # Of the other files a form has the names; sizes and hashes of files are checked elsewhere.
        manifest = replace(form.manifest, files=dict.fromkeys(form.manifest.files), sha256="")
        of = pickle.dumps((look, raw, replace(form, manifest=manifest)))
        if of not in known:
            known[of] = look_at(look, raw, form)
        return known[of]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(schema, "problems_of", once)
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
    once.__module__ = certificate.__name__
    return once


@pytest.fixture(scope="session")
def small_atlas(made_once: MadeOnce) -> Path:
    """An atlas of 6 by 6 starts; not to be changed."""
    grid = ["--speed", "3:8:6", "--roll-rate", "0.3:3.3:6", "--longest", "60"]
    place = made_once("small-atlas", lambda to: main(["atlas", *grid, "-o", str(to / "zarr")]))
    return place / "zarr"


@pytest.fixture(scope="session")
def honest_outcomes(made_once: MadeOnce) -> list[Any]:
    """The first 125 files of the game of honest variations, played once."""
    from support.play import play

    def fill(place: Path) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Dense, "evaluate", Dense.evaluate)
            keep_values()
            outcomes = play("honest", range(125), processes=1)
        (place / "outcomes").write_bytes(pickle.dumps(outcomes))

    found: list[Any] = pickle.loads((made_once("honest-game", fill) / "outcomes").read_bytes())
    return found


@pytest.fixture(scope="module")
def keep_reference_values() -> Iterator[None]:
    """Values of the reference at the times that many files share are evaluated once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Dense, "evaluate", Dense.evaluate)
        keep_values()
        yield
