"""Plugin of pytest: precision regression tests for authors of multibody and ODE codes.

It is loaded into every run of pytest where heyoka_bike is installed, so it does nothing and imports
nothing heavy until a test asks for one of its fixtures or carries its marker. Everything that needs
NumPy is in `regression`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from heyoka_bike.errors import BicycleError, InputError

if TYPE_CHECKING:
    from heyoka_bike.reference.load import Reference
    from heyoka_bike.testing.regression import RequirementSpec, Score

_MARKER = "bicycle"
_MARKER_HELP = (
    "bicycle(maneuver=None, column=None, **metrics): default requirements of bicycle_score(...) in "
    "this test, such as bicycle(maneuver=2, column='roll_angle', scd=8)"
)
_DIAGNOSE = ("auto", "never")
_ENOUGH = {
    "columns": "a number of columns such as 5",
    "coverage": "a fraction of the run such as 0.3",
}
# Number of characters shown of a dataset's hash. They are enough to distinguish datasets at a
# glance.
_HASH_SHOWN = 12
# Maximum number of diagnoses in a test run. A diagnosis takes about ten seconds, and a run with a
# hundred failing tests must end. A code usually has the same mistake in all of its tests.
_MOST_DIAGNOSES = 3


@dataclass(slots=True)
class _Settings:
    """The plugin's settings, from the command line, or else from the configuration file.

    Attributes
    ----------
    scd
        Digits that ``require()`` needs by default; None if not set.
    enough : dict of str to number
        Required number of columns and fraction of the run, if set.
    reference
        Folder of the reference; None for the published one.
    diagnose
        True if failures are diagnosed.
    diagnoses_left
        Number of diagnoses that this process may still make.
    """

    scd: float | None
    enough: dict[str, float]
    reference: Path | None
    diagnose: bool
    diagnoses_left: int = _MOST_DIAGNOSES


_SETTINGS = pytest.StashKey[_Settings]()
_SCORES = pytest.StashKey["list[Score]"]()

_fail = partial(pytest.fail, pytrace=False)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the plugin's options to the command line and to the configuration file."""
    group = parser.getgroup("heyoka_bike", "precision of the uncontrolled bicycle (heyoka_bike)")
    for name, metavar, text in (
        ("scd", "N", "correct digits that bicycle_score(...).require() requires by default"),
        ("columns", "N", "least number of the eight columns that must be compared, unless a test "
         "sets it (default: all)"),
        ("coverage", "X", "least fraction of the run that the rows must cover, unless a test sets "
         "it (default: the whole run)"),
        ("reference", "DIR", "folder of the reference dataset (default: the published one)"),
        ("diagnose", "WHEN", "'auto' adds the likely mistake to the first three failures, about "
         "ten seconds each; 'never' does not (default: auto)"),
    ):  # fmt: skip
        group.addoption(f"--bicycle-{name}", metavar=metavar, help=text)
        parser.addini(f"bicycle_{name}", text, default="")


def pytest_configure(config: pytest.Config) -> None:
    """Check the plugin's settings before any test runs."""
    config.addinivalue_line("markers", _MARKER_HELP)
    scd, scd_from = _setting(config, "scd")
    folder, folder_from = _setting(config, "reference")
    when, when_from = _setting(config, "diagnose")
    if when not in ("", *_DIAGNOSE):
        raise pytest.UsageError(f"{when_from}: found {when!r}, expected {' or '.join(_DIAGNOSE)}")
    reference = None
    if folder:
        # A path in a settings file is relative to that file, not to the working directory.
        is_option = folder_from.startswith("--")
        base = config.invocation_params.dir if is_option else config.rootpath
        reference = base / Path(folder).expanduser()
        _described(reference, folder_from)
    config.stash[_SETTINGS] = _Settings(
        scd=_number(scd, scd_from, "a number of digits such as 8") if scd else None,
        enough={
            name: _number(text, source, expected)
            for name, expected in _ENOUGH.items()
            for text, source in [_setting(config, name)]
            if text
        },
        reference=reference,
        diagnose=when != "never",
    )


def _setting(config: pytest.Config, name: str) -> tuple[str, str]:
    """Return a setting and its source: the command line, or else the configuration file."""
    given = config.getoption(f"bicycle_{name}")
    if given is not None:
        return str(given), f"--bicycle-{name}"
    return str(config.getini(f"bicycle_{name}")), f"bicycle_{name}"


def _number(text: str, where: str, expected: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise pytest.UsageError(f"{where}: found {text!r}, expected {expected}")
    return value


def _described(folder: Path, where: str) -> str:
    """Return the version and hash of a reference dataset as text; only its manifest is read."""
    from heyoka_bike.reference.manifest import read_manifest

    try:
        manifest = read_manifest(folder)
    except BicycleError as e:
        raise pytest.UsageError(f"{where}: {e}") from None
    return _dataset_words(manifest.dataset_version, manifest.content_sha256)


def _dataset_words(version: str, content: str) -> str:
    return f"reference {version} (content {content[:_HASH_SHOWN]})"


def pytest_report_header(config: pytest.Config) -> str | None:
    """Return a header line with the reference dataset that the settings choose, if they do.

    References that a test chooses are only known later, see `pytest_terminal_summary`.
    """
    folder = config.stash[_SETTINGS].reference
    return None if folder is None else f"heyoka_bike: {_described(folder, 'bicycle_reference')}"


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the reference datasets that tests used, including tests in other processes."""
    used = set()
    for reports in terminalreporter.stats.values():
        for report in reports:
            said = dict(getattr(report, "user_properties", ()))
            if "bicycle.dataset_version" in said:
                version, content = said["bicycle.dataset_version"], said["bicycle.content_sha256"]
                used.add(_dataset_words(version, content))
    for words in sorted(used):
        terminalreporter.write_line(f"heyoka_bike: scored against {words}")


@pytest.hookimpl(wrapper=True)
def pytest_pycollect_makeitem(collector: pytest.Collector) -> Generator[None, object, object]:
    """Reject invalid ``bicycle`` markers of tests before any test runs."""
    made = yield
    for item in made if isinstance(made, list) else ():
        try:
            _marked(item)
        except InputError as e:
            # Raise a collection error, because pytest-xdist does not show a usage error of a
            # worker.
            raise collector.CollectError(f"{item.nodeid}: @pytest.mark.{_MARKER}: {e}") from None
    return made


def _marked(item: pytest.Item) -> tuple[RequirementSpec, ...]:
    """Return the requirements in the markers of a test, or else of its class, or of its module."""
    marks = list(item.iter_markers_with_node(_MARKER))
    nearest = [mark for node, mark in marks if node is marks[0][0]]
    if not nearest:
        return ()
    from heyoka_bike.testing.regression import asked

    for mark in nearest:
        if mark.args:
            raise InputError(
                f"found {mark.args[0]!r:.60}, expected keywords such as maneuver=2, scd=8"
            )
    return tuple(asked(**mark.kwargs) for mark in nearest)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """Check the scores that a marked test made without calling ``require()``."""
    outcome = yield
    scores = item.stash.get(_SCORES, [])
    if not scores and any(mark.name == _MARKER for mark in item.own_markers):
        _fail(f"marked @pytest.mark.{_MARKER}, but nothing was scored: call bicycle_score(results)")
    for score in scores:
        if not score.is_checked and item.get_closest_marker(_MARKER):
            score.require()
        elif not score.is_checked and not score.is_read:
            _warn(item)
    return outcome


def _warn(item: pytest.Item) -> None:
    """Warn that a test requires nothing of its score; fail the test if warnings are errors."""
    said = (
        "bicycle_score: the test requires nothing of the results, so it passes whatever they are; "
        "use bicycle_score(results).require(scd=6) to require six correct digits"
    )
    try:
        item.warn(pytest.PytestWarning(said))
    except pytest.PytestWarning:
        _fail(said)


@pytest.fixture(scope="session")
def bicycle_reference(pytestconfig: pytest.Config) -> Reference:
    """The reference: ``bicycle_reference.times`` [s], ``bicycle_reference[2].evaluate(t)``."""
    return _load(pytestconfig.stash[_SETTINGS].reference)


def _load(folder: Path | None) -> Reference:
    from heyoka_bike.reference.load import load_reference

    try:
        return load_reference(folder)
    except BicycleError as e:
        _fail(str(e))


@pytest.fixture
def bicycle_score(request: pytest.FixtureRequest) -> Callable[..., Score]:
    """Score results: ``bicycle_score(results).require(scd=8)``.

    Called with the results (a path; an array of 25 columns, or of 9 with ``maneuver=``; columns by
    name; a mapping of maneuvers to any of these; or `Results`), and by keyword ``maneuver``,
    ``reference`` (a folder or a `Reference`) and ``diagnose`` (``"auto"`` or ``"never"``), it
    returns a `regression.Score`.
    """
    item, settings = request.node, request.config.stash[_SETTINGS]
    scores: list[Score] = []
    # Discard the scores of an earlier run of the same test, because a test may be run again.
    item.stash[_SCORES] = scores

    def bicycle_score(
        results: Any, *, maneuver: int | None = None,
        reference: Reference | str | Path | None = None, diagnose: str | None = None,
    ) -> Score:  # fmt: skip
        __tracebackhide__ = True
        from heyoka_bike.scoring.score import score
        from heyoka_bike.testing.regression import Score, properties

        if diagnose not in (None, *_DIAGNOSE):
            _fail(f"diagnose: found {diagnose!r}, expected {' or '.join(_DIAGNOSE)}")
        if reference is None:
            known = request.getfixturevalue("bicycle_reference")
        elif isinstance(reference, str | Path):
            known = _load(Path(reference))
        else:
            known = reference

        def may_diagnose() -> str:
            """Return the reason not to diagnose a failure; empty if it is to be diagnosed."""
            if not (settings.diagnose if diagnose is None else diagnose == "auto"):
                return "switched off"
            if not settings.diagnoses_left:
                return (
                    f"only the first {_MOST_DIAGNOSES} failures are diagnosed; run this test "
                    "alone, or 'heyoka-bike diagnose' on a file of the results"
                )
            settings.diagnoses_left -= 1
            return ""

        try:
            report = score(results, known, maneuver=maneuver)
        except BicycleError as e:
            _fail(f"bicycle_score: {e}")
        scores.append(
            Score(report, known, _marked(item), settings.scd, may_diagnose, _fail, settings.enough)
        )
        item.user_properties.extend(properties(report, known))
        return scores[-1]

    return bicycle_score
