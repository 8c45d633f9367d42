"""`heyoka-bike bench` reports every code in every class, at the accuracy of the class.

Nothing here looks at how long anything took.
"""

import dataclasses
import json
import sys

import numpy as np
import pytest

from heyoka_bike import bench
from heyoka_bike.bench import CLASSES, Line, Problem, SciPy
from heyoka_bike.cli import main
from heyoka_bike.commands.bench import _table
from heyoka_bike.errors import Exit
from heyoka_bike.reference import load_reference

heyoka = pytest.importorskip("heyoka")
pytest.importorskip("scipy")

CODES = {
    ("heyoka", "binary64"),
    ("heyoka unrolled", "binary64"),
    ("heyoka", "binary128"),
    ("SciPy DOP853", "binary64"),
    ("SciPy LSODA", "binary64"),
}
KEYS = {
    "class", "code", "precision", "status", "tolerance", "order", "steps", "rhs_calls", "runs",
    "build_s", "min_ms", "median_ms", "performance_percent", "max_state_error", "ratio_to_fastest",
}  # fmt: skip


@pytest.fixture(scope="module")
def document(folder, tmp_path_factory):
    """The report of a short run."""
    path = tmp_path_factory.mktemp("bench") / "bench.json"
    was_enabled = heyoka.llvm_state.get_diskcache_enabled()
    arguments = ["bench", "--runs", "1", "--quick", "--format", "json", "-o", str(path)]
    assert main([*arguments, "--reference", str(folder)]) == Exit.OK
    assert heyoka.llvm_state.get_diskcache_enabled() == was_enabled
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def problem(bicycle, maneuvers, folder):
    return Problem(bicycle, maneuvers[1], load_reference(folder)[2])


def of_class(document, name):
    return [r for r in document["results"] if r["class"] == name and r["status"] == "ok"]


def test_every_code_in_every_class(document):
    found = [(r["class"], r["code"], r["precision"]) for r in document["results"]]
    assert len(found) == len(set(found))
    assert set(found) == {(name, *code) for name in CLASSES for code in CODES}


def test_keys_are_stable(document):
    assert document["schema_version"] == 1
    assert set(document) == {
        "schema_version", "maneuver", "rows", "runs", "quick", "machine", "versions", "results",
    }  # fmt: skip
    assert (document["maneuver"], document["rows"]) == ("maneuver 2", 1001)
    assert set(document["machine"]) == {"cpu", "cores", "system"}
    assert set(document["versions"]) == {"python", "heyoka_bike", "heyoka", "scipy", "numpy"}
    assert all(set(r) == KEYS for r in document["results"])


def test_only_the_unrolled_form_is_left_out_when_quick(document):
    for r in document["results"]:
        assert (r["status"] == "left out") == (r["code"] == "heyoka unrolled")
        assert (r["status"] == "ok") == (r["runs"] == 1)


def test_numbers_of_a_run_are_complete(document):
    for r in document["results"]:
        if r["status"] == "ok":
            assert (r["steps"] is None) != (r["rhs_calls"] is None)
            assert (r["order"] is None) == r["code"].startswith("SciPy")
            for key in ("tolerance", "build_s", "min_ms", "median_ms", "max_state_error"):
                assert r[key] > 0
    for name in CLASSES:
        assert min(r["ratio_to_fastest"] for r in of_class(document, name)) == 1


def test_first_class_meets_the_limit_of_the_benchmark(document):
    for r in of_class(document, "performance"):
        # 1e-3 % is the limit of the benchmark. A grid of four tolerances a decade does not overdo
        # it: a step of the grid changes the error of these codes by a factor of 12 at most, the
        # ratio of two orders of heyoka.
        assert 1e-3 / 12 < r["performance_percent"] < 1e-3


def test_second_class_has_small_true_error(document):
    for r in of_class(document, "state_error"):
        # 1e-12 defines the class; below 1e-14 a code would have been run tighter than needed.
        assert 1e-14 < r["max_state_error"] < 1e-12


def test_third_class_is_at_roundoff(document):
    # Units of roundoff are 1.1e-16 and 9.6e-35, the speed is near 5 m/s and some 70 steps add up.
    # The reference itself is a sum of two binary64, good to 5e-32 of the speed in m/s. SciPy has to
    # sum thousands of steps of binary64.
    limit = {("heyoka", "binary64"): 1e-14, ("heyoka", "binary128"): 2e-31}
    for r in of_class(document, "roundoff"):
        assert r["max_state_error"] < limit.get((r["code"], r["precision"]), 1e-12)


def test_measuring_sees_an_error(problem):
    rows = np.tile(problem.start(float), (problem.maneuver.rows, 1))
    # Standing still in the initial state keeps the energy and is wrong by the largest roll rate.
    performance, error = problem.measure(rows, problem.expected)
    assert performance < 1e-60  # of the 256 bits it is measured with
    assert 0.5 < error < 1
    rows[500, 5] *= 1 + 1e-9  # the speed: kinetic energy is most of 1837 J
    performance, _ = problem.measure(rows, problem.expected)
    assert performance == pytest.approx(100 * 2e-9 * 1037 / 1837, rel=0.02)
    assert problem.measure(rows[:-1], problem.expected) == (np.inf, np.inf)
    rows[0, 0] = np.nan
    assert problem.measure(rows, problem.expected) == (np.inf, np.inf)


@pytest.mark.parametrize("slope", [0.7, 1, 1.2])
def test_search_finds_the_loosest_tolerance(slope):
    # Errors that fall with the tolerance, here as a power of it, cross the limit once.
    for loosest in range(65):

        def excess(i, loosest=loosest):
            return slope * (loosest - 0.5 - i) / 4

        assert bench._loosest(excess) == loosest
    assert bench._loosest(lambda i: 99.0) is None


def test_a_peer_that_is_not_installed_is_listed(problem, document, monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy", None)
    monkeypatch.setitem(sys.modules, "scipy.integrate", None)
    code = SciPy("SciPy LSODA", problem)
    line = Line("performance", code)
    bench._prepare(line, code.at, None)
    assert (line.status, line.trial) == ("not installed", None)


def test_table_shows_all_of_it(document):
    results = [dict(r) for r in document["results"]]
    results[3] = dict.fromkeys(KEYS) | {
        key: results[3][key] for key in ("class", "code", "precision")
    }
    results[3]["status"] = "not installed"
    text = _table(document | {"results": results}, is_shown=False)
    for part in (*CLASSES.values(), *(code for code, _ in CODES), "not installed", "left out"):
        assert part in text
    for heading in ("build [s]", "min [ms]", "median [ms]", "eq. (1) [%]", "[rad/s]", "[m/s]"):
        assert heading in text
    assert text.count("SciPy LSODA") == len(CLASSES)
    assert document["machine"]["cpu"] in text
    assert "\x1b" not in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--runs", "0"], "--runs: found 0, expected 1 to 10000"),
        (["-o", "absent/x.json"], "absent/x.json: cannot be written: its folder does not exist"),
        (["-o", "."], ".: cannot be written: is a folder, expected a file"),
        (["--reference", "absent"], "absent: no manifest.json found"),
    ],
)
def test_bad_input_gives_one_line(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(["bench", *arguments]) == Exit.INPUT
    error = capsys.readouterr().err
    assert error.startswith(f"heyoka-bike: {message}")
    assert error.count("\n") == 1


def test_a_reference_of_other_inputs_is_refused(folder, monkeypatch, capsys):
    reference = load_reference(folder)
    other = dataclasses.replace(reference, parameters={**reference.parameters, "w": "1"})
    monkeypatch.setattr("heyoka_bike.reference.load_reference", lambda _: other)
    assert main(["bench", "--reference", "other"]) == Exit.INPUT
    error = capsys.readouterr().err
    assert error == (
        "heyoka-bike: other: found a reference of other inputs, expected maneuver 2 of the "
        "benchmark bicycle\n"
    )
