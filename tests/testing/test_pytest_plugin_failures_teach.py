"""The message of a failing test is informative, in an example project and for other errors."""

import importlib.util
import re
import shutil
import subprocess
import sys
import textwrap
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.plugin_projects import BARE, QUICK, project
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.testing.regression import Score

pytestmark = pytest.mark.proof

pytest_plugins = ["pytester"]

EXAMPLE = Path(__file__).parents[1] / "example_project"
GUIDE = Path(__file__).parents[2] / "docs" / "pytest.md"
HAS_HEYOKA = importlib.util.find_spec("heyoka") is not None


@pytest.fixture
def example(pytester):
    shutil.copytree(
        EXAMPLE, pytester.path, dirs_exist_ok=True, ignore=shutil.ignore_patterns(".*", "__py*")
    )
    return pytester


def change_the_trail(pytester):
    code = pytester.path / "my_bicycle.py"
    text = code.read_text()
    assert text.count('"0.08"') == 1
    code.write_text(text.replace('"0.08"', '"0.0808"'))


def entries(lines):
    """Return the labelled parts of a failure's message, each on one line."""
    found, label = {}, None
    for line in lines:
        if match := re.match(r"(\w[\w ,]{2,16}?\w) {2,}(\S.*)", line):
            label = match[1]
            found[label] = match[2]
        elif label and line.startswith(" " * 18):
            found[label] += " " + line.strip()
        else:
            label = None
    return found


def columns_of_the_example(pytester):
    """Run the project's code in another process, because pytester unloads imports of a test."""
    code = """
import numpy as np
from heyoka_bike import load_reference
from my_bicycle import run
found = run(load_reference().times)
np.savez("found.npz", **{f"{n} {key}": x for n, m in found.items() for key, x in m.items()})
"""
    subprocess.run([sys.executable, "-c", code], cwd=pytester.path, check=True, timeout=120)
    with np.load(pytester.path / "found.npz") as file:
        named = {tuple(name.split()): file[name] for name in file}
    return {(int(n), key): x for (n, key), x in named.items() if key != "time"}


def test_the_example_is_good_to_eight_digits(example):
    result = example.runpytest_subprocess(*BARE)
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(["heyoka_bike: scored against reference * (content *)"])


def test_a_trail_that_is_one_percent_off_is_told(example, reference):
    change_the_trail(example)
    result = example.runpytest_subprocess(*BARE)
    result.assert_outcomes(failed=1)
    said = entries(result.outlines)
    # Find the worst of all columns by the plain difference from the published rows.
    found = columns_of_the_example(example)
    relative = {
        (n, key): np.abs(found[n, key] - reference[n].rows[key]) / reference[n].scale(key)
        for n, key in found
    }
    (number, key), errors = max(relative.items(), key=lambda x: np.max(x[1]))
    worst = int(np.argmax(errors))
    digits = -np.log10(errors[worst])
    result.stdout.fnmatch_lines(
        [f"required scd >= 8, found {digits:.3g} (maneuver {number}, {key})"]
    )
    assert said["worst column"].startswith(f"{key} of maneuver {number}, read as lean (")
    assert said["worst row"].startswith(f"t = {reference.times[worst]:g} s: found ")
    value, expected = re.search(r"found (\S+), expected (\S+), error", said["worst row"]).groups()
    assert float(value) == pytest.approx(found[number, key][worst], abs=0)
    assert float(expected) == pytest.approx(reference[number].rows[key][worst], rel=4e-16)
    first = reference.times[np.argmax(errors > 1e-8)]
    seen = reference.times[np.argmax(errors > 1e-3)]
    assert said["first departure"].startswith(f"t = {first:g} s (row ")
    assert said["first departure"].endswith(f"above 0.001 of the largest value from t = {seen:g} s")
    assert "checks only that the energy in the file is constant" in said["warning"]
    if HAS_HEYOKA:
        assert re.search(r"trail \(c\) is 0\.08080*\b", said["diagnosis"])
    else:
        assert "heyoka is not installed" in said["diagnosis"]
    for noise in ("Traceback", "site-packages", "regression", "AssertionError", "def require"):
        assert noise not in result.stdout.str()


class FailedError(Exception):
    pass


def fail(message):
    raise FailedError(message)


def test_the_usual_mistake_is_named(reference):
    pytest.importorskip("heyoka")
    from generators.mistaken_programs import columns_of

    mistake = next(m for m in MISTAKES if m.code == "trail_normal")
    made = columns_of(reference, (mistake,))
    columns = [made[n][key] for n in made for key in BENCHMARK_COLUMNS]
    table = np.column_stack([reference.times, *columns])
    scored = Score(score(table, reference), reference, (), 6.0, lambda: "", fail)
    with pytest.raises(FailedError) as failed:
        scored.require()
    said = entries(str(failed.value).splitlines())
    assert said["diagnosis"].lower().startswith(mistake.says)


BROKEN = {
    "raises": "def broken(*_): raise ZeroDivisionError('of all things')",
    "is refused": (
        "from heyoka_bike.errors import MissingPackageError\n"
        "def broken(*_): raise MissingPackageError('heyoka is not installed; integration needs it')"
    ),
    "warns": (
        "import dataclasses, warnings\nfrom heyoka_bike.scoring.findings import Finding\n"
        "def broken(report, *rest):\n    warnings.warn('odd', stacklevel=1)\n"
        "    said = tuple(Finding('x', f'Finding {i}') for i in range(5))\n"
        "    return dataclasses.replace(report, diagnosis=said)"
    ),
    "stops early": (
        "import dataclasses\nfrom heyoka_bike.scoring.findings import Finding\n"
        "from heyoka_bike.scoring.evidence.contradictions import StoppedEarly\n"
        "def broken(report, *rest):\n"
        "    said = tuple(Finding('x', f'Finding {i}') for i in range(5))\n"
        "    return dataclasses.replace(report, diagnosis=said, seen=(StoppedEarly(1.0),))"
    ),
}
SAID = {
    "raises": "none: it failed with ZeroDivisionError: of all things",
    "is refused": "none: heyoka is not installed; integration needs it",
    "warns": "Finding 0 Finding 1",
    "stops early": "Finding 0 Finding 1 Finding 4",
}


@pytest.mark.parametrize("how", list(BROKEN))
def test_a_diagnosis_that_goes_wrong_hides_nothing(pytester, how):
    project(
        pytester,
        """
        def test_x(table, bicycle_score, monkeypatch):
            monkeypatch.setattr("heyoka_bike.testing.regression.diagnosed", broken)
            bicycle_score(table(3)).require(scd=8)
        """,
    )
    path = pytester.path / "test_it.py"
    path.write_text(f"{BROKEN[how]}\n\n{path.read_text()}")
    result = pytester.runpytest_subprocess(*BARE)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["required scd >= 8, found 3 (maneuver *"])
    assert entries(result.outlines)["diagnosis"] == SAID[how]


def test_without_heyoka_the_same_is_said(pytester):
    case = """
        def test_x(table, bicycle_score):
            bicycle_score(table(3)).require(scd=8)
        """
    block = """
        import sys
        import pytest

        class Block:
            def find_spec(self, name, path=None, target=None):
                if name.partition(".")[0] == "heyoka":
                    raise ModuleNotFoundError(f"{name} is blocked", name=name)

        sys.meta_path.insert(0, Block())

        def test_blocked():
            with pytest.raises(ModuleNotFoundError, match="blocked"):
                import heyoka
        """
    said = []
    for source, passed in ((block, 1), ("", 0)):
        project(pytester, textwrap.dedent(source) + textwrap.dedent(case))
        result = pytester.runpytest_subprocess(*BARE)
        result.assert_outcomes(failed=1, passed=passed)
        said.append(entries(result.outlines))
    assert said[0] == said[1]
    assert {"worst column", "first departure", "scd, maneuver 3", "diagnosis"} <= set(said[0])


COUNTED = """
import pytest

def told(report, *rest):
    from dataclasses import replace
    from heyoka_bike.scoring.findings import Finding
    return replace(report, diagnosis=(Finding("x", "Told."),))

@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr("heyoka_bike.testing.regression.diagnosed", told)

@pytest.mark.parametrize("i", range(5))
def test_x(table, bicycle_score, i):
    bicycle_score(table(3)).require(scd=8)

def test_never(table, bicycle_score):
    bicycle_score(table(3), diagnose="never").require(scd=8)
"""


@pytest.mark.parametrize(
    ("ini", "options", "expected"),
    [
        ("", (), (3, 2, 1)),
        ("bicycle_diagnose = never", (), (0, 0, 6)),
        ("bicycle_diagnose = auto", ("--bicycle-diagnose=never",), (0, 0, 6)),
        ("bicycle_diagnose = never", ("--bicycle-diagnose=auto",), (3, 2, 1)),
    ],
)
def test_only_the_first_failures_are_diagnosed_and_none_if_not_wanted(
    pytester, ini, options, expected
):
    project(pytester, COUNTED, ini)
    shown = pytester.runpytest_subprocess(*BARE, *options).stdout.str()
    counts = tuple(
        len(re.findall(rf"^diagnosis +{start}", shown, re.MULTILINE))
        for start in (r"Told\.", "none: only the first 3 failures", "none: switched off")
    )
    assert counts == expected


RECORDED = """
def test_good(table, bicycle_score):
    bicycle_score(table(9)).require(scd=8)

def test_bad(table, bicycle_score):
    bicycle_score(table(7)).require(scd=8)

def test_other():
    pass
"""


def recorded(pytester, *options):
    """Return the properties of each test in the JUnit file of a run."""
    project(pytester, RECORDED)
    result = pytester.runpytest_subprocess(*QUICK, "--junitxml=out.xml", *options)
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(["heyoka_bike: scored against reference * (content *)"])
    return {
        case.get("name"): {p.get("name"): p.get("value") for p in case.iter("property")}
        for case in ET.parse(pytester.path / "out.xml").iter("testcase")
    }


def check_recorded(found, reference):
    for name, digits in (("test_good", 9), ("test_bad", 7)):
        said = found[name]
        assert said["bicycle.dataset_version"] == reference.dataset_version
        assert said["bicycle.content_sha256"] == reference.content_sha256
        for n in reference:
            # The sums of values and errors are rounded, which changes the digits slightly.
            assert float(said[f"bicycle.{n}.scd"]) == pytest.approx(digits, abs=1e-3)
            for key in BENCHMARK_COLUMNS:
                assert float(said[f"bicycle.{n}.{key}.scd"]) == pytest.approx(digits, abs=1e-3)
            assert said[f"bicycle.{n}.roll_angle.definition"] == "lean"
    assert found["test_other"] == {}


def test_digits_are_recorded(pytester, reference):
    check_recorded(recorded(pytester), reference)


def test_digits_are_recorded_by_several_processes(pytester, reference):
    pytest.importorskip("xdist", reason="pytest-xdist is not installed")
    check_recorded(recorded(pytester, "-p", "xdist", "-n", "2"), reference)


def test_the_guide_runs(example):
    """Each Python block of the guide is a test file, with the settings in the guide."""
    blocks = re.findall(r"^```(\w+)\n(.*?)^```$", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    (example.path / "test_my_bicycle.py").unlink()
    (example.path / "my_bicycle.py").rename(example.path / "my_code.py")
    tests = [code for kind, code in blocks if kind == "python"]
    for i, code in enumerate(tests):
        (example.path / f"test_{i}.py").write_text(code)
    (settings,) = (code for kind, code in blocks if kind == "toml")
    (example.path / "pyproject.toml").write_text(settings)
    result = example.runpytest_subprocess(*QUICK, "--strict-markers", "--strict-config")
    result.assert_outcomes(passed=len(tests))
    assert len(tests) >= 3


def test_the_guide_is_right_about_the_sign(reference, tmp_path):
    """A flipped sign changes no digit."""
    table = np.array([reference.times, *(reference[2].rows[k] for k in BENCHMARK_COLUMNS)]).T
    table[:, [1, 2, 7, 8]] *= -1
    found = score(read_results(table, maneuver=2), reference).maneuvers[0].columns[0]
    assert found.as_understood.sign == -1
    assert found.as_understood.measures.scd > 15
