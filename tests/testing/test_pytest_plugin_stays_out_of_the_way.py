"""The plugin costs nothing where it is not used, and checks its settings first."""

import subprocess
import sys
import tomllib
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from generators.plugin_projects import BARE, QUICK, outcomes, project
from heyoka_bike.errors import InputError
from heyoka_bike.reference.manifest import read_manifest

pytest_plugins = ["pytester"]

LIGHT = {
    "heyoka_bike", "heyoka_bike.errors", "heyoka_bike.testing", "heyoka_bike.testing.plugin",
}  # fmt: skip


def test_the_entry_point_is_that_of_the_project():
    project_file = Path(__file__).resolve().parents[2] / "pyproject.toml"
    declared = tomllib.loads(project_file.read_text())["project"]["entry-points"]["pytest11"]
    assert declared == {"heyoka_bike": "heyoka_bike.testing.plugin"}
    (found,) = (e for e in entry_points(group="pytest11") if e.name == "heyoka_bike")
    assert found.value == declared["heyoka_bike"]


def test_loading_it_imports_nothing_heavy():
    code = """
import pytest, sys
before = set(sys.modules)
import heyoka_bike.testing.plugin
print(*sorted(set(sys.modules) - before))
"""
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    loaded = set(run.stdout.split())
    assert "heyoka_bike.testing.plugin" in loaded, run.stderr
    assert {name for name in loaded if name.startswith("heyoka_bike")} == LIGHT
    assert not {name.partition(".")[0] for name in loaded} & {"numpy", "h5py", "heyoka", "rich"}


# This plugin checks the imports at the end. Nothing else in the run imports numpy, except the
# plugin of zarr.
SPY = """
import sys
def pytest_unconfigure():
    print("loaded:", *sorted(m for m in sys.modules if m.startswith("heyoka_bike") or m == "numpy"))
"""


@pytest.mark.parametrize("options", [(), ("--bicycle-scd=8",), ("--bicycle-diagnose=never",)])
def test_a_run_that_does_not_use_it_does_not_load_it(pytester, options):
    pytester.makeconftest(SPY)
    pytester.makeini("[pytest]\nfilterwarnings = error\naddopts = --strict-markers --strict-config")
    pytester.makepyfile("def test_x():\n    pass")
    result = pytester.runpytest_subprocess(*BARE, *options)
    result.assert_outcomes(passed=1)
    (line,) = (x for x in result.outlines if x.startswith("loaded:"))
    assert set(line.split()[1:]) == LIGHT
    assert "reference" not in result.stdout.str()


def test_it_is_absent_if_not_wanted(pytester):
    pytester.makepyfile("def test_x(bicycle_score):\n    pass")
    result = pytester.runpytest_inprocess(*BARE, "-p", "no:heyoka_bike")
    result.stdout.fnmatch_lines(["*fixture 'bicycle_score' not found"])


def test_its_options_marker_and_fixtures_are_listed(pytester):
    pytester.makepyfile("")
    shown = pytester.runpytest_inprocess(*BARE, "--help").stdout.str()
    for name in ("scd", "reference", "diagnose"):
        assert f"--bicycle-{name}=" in shown
        assert f"bicycle_{name} (string)" in shown
    pytester.runpytest_inprocess(*BARE, "--markers").stdout.fnmatch_lines(
        ["@pytest.mark.bicycle(*"]
    )
    fixtures = pytester.runpytest_inprocess(*BARE, "--fixtures").stdout
    fixtures.fnmatch_lines(["bicycle_reference ?session scope?*", "bicycle_score -- *"])


TEST = """
import pytest

def test_settings(table, bicycle_score):
    bicycle_score(table(9)).require()

def test_call(table, bicycle_score):
    bicycle_score(table(9)).require(scd=8.9)

@pytest.mark.bicycle(scd=8.9)
def test_marker(table, bicycle_score):
    bicycle_score(table(9)).require()

@pytest.mark.bicycle(maneuver=2)
def test_marker_without_number(table, bicycle_score):
    bicycle_score(table(9)).require()

@pytest.mark.bicycle(scd=9.5)
def test_call_before_marker(table, bicycle_score):
    bicycle_score(table(9)).require(scd=8.9)
"""
P, F = "PASSED", "FAILED"


@pytest.mark.parametrize(
    ("ini", "options", "expected"),
    [
        # Requirements of the call and of the marker take precedence over the settings, so the
        # outcomes differ by test.
        ("", (), (F, P, P, F, P)),
        ("bicycle_scd = 8.5", (), (P, P, P, P, P)),
        ("bicycle_scd = 9.5", (), (F, P, P, F, P)),
        ("bicycle_scd = 8.5", ("--bicycle-scd=9.5",), (F, P, P, F, P)),
        ("bicycle_scd = 9.5", ("--bicycle-scd=8.5",), (P, P, P, P, P)),
        ("", ("--bicycle-scd", "8.5"), (P, P, P, P, P)),
    ],
)
def test_the_call_comes_before_the_marker_the_command_line_and_the_file(
    pytester, ini, options, expected
):
    project(pytester, TEST, ini)
    found = outcomes(pytester.runpytest_inprocess("-rA", *QUICK, *options))
    assert tuple(found.values()) == () or len(found) == 5
    names = ("settings", "call", "marker", "marker_without_number", "call_before_marker")
    assert tuple(found[f"test_{name}"] for name in names) == expected


@pytest.fixture
def other_set(folder, tmp_path):
    """The published dataset under another version, like a custom dataset."""
    other = tmp_path / "other"
    other.mkdir()
    for path in filter(Path.is_file, folder.iterdir()):
        text = path.read_bytes()
        if path.name == "manifest.json":
            version = read_manifest(folder).dataset_version
            text = text.replace(f'"{version}"'.encode(), b'"9.9.9"')
        (other / path.name).write_bytes(text)
    return other


def test_the_reference_is_chosen_by_call_then_command_line_then_file(pytester, folder, other_set):
    project(
        pytester,
        f"""
        def test_version(bicycle_reference, bicycle_score, table):
            print("used", bicycle_reference.dataset_version)

        def test_call(bicycle_score, table):
            score = bicycle_score(table(9), reference={str(other_set)!r})
            print("scored", score.require(scd=8).report.dataset_version)
        """,
        f"bicycle_reference = {other_set}",
    )
    published = read_manifest(folder)
    from_file = pytester.runpytest_inprocess(*QUICK, "-s")
    from_file.stdout.fnmatch_lines(
        ["heyoka_bike: reference 9.9.9 (content *)", "*used 9.9.9*", "*scored 9.9.9*",
         "heyoka_bike: scored against reference 9.9.9 (content *)"]
    )  # fmt: skip
    by_option = pytester.runpytest_inprocess(*QUICK, "-s", f"--bicycle-reference={folder}")
    words = f"reference {published.dataset_version} (content {published.content_sha256[:12]})"
    by_option.stdout.fnmatch_lines(
        [f"heyoka_bike: {words}", f"*used {published.dataset_version}*", "*scored 9.9.9*"]
    )


@pytest.mark.proof
def test_folders_are_relative_to_where_they_are_named(pytester, other_set):
    project(pytester, "def test_x(bicycle_reference):\n    pass", "bicycle_reference = ../other")
    inner = pytester.mkdir("inner")
    other_set.rename(pytester.path.parent / "other")
    (pytester.path / "elsewhere").symlink_to(pytester.path.parent / "other")
    pytester.chdir()
    assert pytester.runpytest_inprocess(*QUICK).ret == 0
    run = ["-m", "pytest", *QUICK, "-c", "../pytest.ini", "--rootdir=..", ".."]
    for extra, code in ([], 0), (["--bicycle-reference=../elsewhere"], 0), (
        ["--bicycle-reference=elsewhere"], 4,
    ):  # fmt: skip
        found = subprocess.run([sys.executable, *run, *extra], cwd=inner, capture_output=True)
        assert found.returncode == code, found.stdout.decode() + found.stderr.decode()


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("scd", "eight", "found 'eight', expected a number of digits such as 8"),
        ("scd", "nan", "found 'nan', expected a number of digits such as 8"),
        ("diagnose", "always", "found 'always', expected auto or never"),
        ("reference", "no/such", "*no/such: no manifest.json found, expected *"),
    ],
)
def test_bad_settings_are_usage_errors_of_one_line(pytester, name, value, expected):
    pytester.makepyfile("def test_x():\n    pass")
    by_option = pytester.runpytest_inprocess(*BARE, f"--bicycle-{name}={value}")
    pytester.makeini(f"[pytest]\nbicycle_{name} = {value}")
    by_file = pytester.runpytest_inprocess(*BARE)
    for run, where in ((by_option, f"--bicycle-{name}"), (by_file, f"bicycle_{name}")):
        assert run.ret == pytest.ExitCode.USAGE_ERROR
        (line,) = filter(None, run.errlines)
        run.stderr.fnmatch_lines([f"ERROR: {where}: {expected}"])
        assert "test session starts" not in run.stdout.str()
        assert line


def test_maneuvers_with_times_of_their_own_have_no_common_times(reference):
    first, *others = reference.maneuvers
    shorter = replace(first, time=first.time[:-1])
    odd = replace(reference, maneuvers=(shorter, *others))
    with pytest.raises(InputError, match=r"1000 rows to 9.99 s in maneuver 1 and 1001 to 10"):
        _ = odd.times
    assert reference.times is first.time
