"""`heyoka-bike bench` reports every code in every class, at the accuracy of the class.

No test depends on how long anything takes.
"""

import dataclasses
import importlib.util
import itertools
import json
import shutil
import sys
from contextlib import suppress
from fractions import Fraction

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.errors import Exit
from heyoka_bike.motion.heyoka_adapter import order_of
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.reference.load import load_reference
from heyoka_bike.workbench.bench import batches, compiled, precise, race
from heyoka_bike.workbench.bench.problem import ReferenceProblem
from heyoka_bike.workbench.bench.race import (
    CLASSES,
    Compiled,
    Exudyn,
    SciPy,
    Sundials,
    Timing,
    Tuned,
)
from heyoka_bike.workbench.bench.summary import as_text

pytestmark = pytest.mark.proof

heyoka = pytest.importorskip("heyoka")
pytest.importorskip("scipy")

CODES = {
    ("heyoka_bike simulate", "binary64"),
    ("heyoka", "binary64"),
    ("heyoka unrolled", "binary64"),
    ("heyoka", "binary128"),
    ("SciPy DOP853", "binary64"),
    ("SciPy LSODA", "binary64"),
    ("C DOPRI5", "binary64"),
    ("C DOP853", "binary64"),
    ("C RK4", "binary64"),
    ("SUNDIALS CVODE", "binary64"),
    ("Exudyn", "binary64"),
}
# Codes for which steps are counted. For the other codes, calls of the right-hand side are counted.
STEPS = ("heyoka", "Exudyn")
HAS_COMPILER = shutil.which("gcc") is not None or shutil.which("cc") is not None
KEYS = {
    "maneuver", "class", "code", "precision", "status", "tolerance", "order", "steps", "rhs_calls",
    "runs", "build_s", "min_ms", "median_ms", "cold_ms", "performance_percent", "max_state_error",
    "ratio_to_fastest",
}  # fmt: skip


@pytest.fixture(scope="module")
def document(folder, tmp_path_factory):
    """The report of a short run."""
    path = tmp_path_factory.mktemp("bench") / "bench.json"
    was_enabled = heyoka.llvm_state.get_diskcache_enabled()
    arguments = ["bench", "--runs", "1", "--quick", "--format", "json", "-o", str(path)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HEYOKA_BIKE_CACHE", str(path.parent / "cache"))
        assert main([*arguments, "--reference", str(folder)]) == Exit.OK
    assert heyoka.llvm_state.get_diskcache_enabled() == was_enabled
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def problem(bicycle, maneuvers, folder):
    return ReferenceProblem(bicycle, maneuvers[1], load_reference(folder)[2])


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
    assert set(document["versions"]) == {
        "python", "heyoka_bike", "heyoka", "scipy", "scikit-sundae", "exudyn", "numpy",
    }  # fmt: skip
    assert all(set(r) == KEYS for r in document["results"])


def test_only_what_builds_slowly_is_left_out_when_quick(document):
    for r in document["results"]:
        assert (r["status"] == "left out") == (r["code"] == "heyoka unrolled")
        assert (r["status"] == "ok") == (r["runs"] == 1)


def test_peers_that_are_missing_are_listed_as_such(document):
    status = {r["code"]: r["status"] for r in document["results"] if r["class"] == "performance"}
    for code, module in (("SUNDIALS CVODE", "sksundae"), ("Exudyn", "exudyn")):
        assert (status[code] == "ok") == (importlib.util.find_spec(module) is not None)
        assert status[code] in ("ok", "not installed")
    for code in ("C DOPRI5", "C DOP853", "C RK4"):
        assert status[code] == ("ok" if HAS_COMPILER else "no C compiler")


def test_numbers_of_a_run_are_complete(document):
    for r in document["results"]:
        if r["status"] == "ok":
            assert (r["steps"] is None) != (r["rhs_calls"] is None)
            assert (r["steps"] is None) != r["code"].startswith(STEPS)
            assert (r["order"] is None) != (r["code"] in ("heyoka", "heyoka unrolled"))
            for key in ("tolerance", "min_ms", "median_ms", "cold_ms", "max_state_error"):
                assert r[key] > 0
    for name in CLASSES:
        assert min(r["ratio_to_fastest"] for r in of_class(document, name)) == 1


def test_first_class_meets_the_limit_of_the_benchmark(document):
    for r in of_class(document, "performance"):
        # 1e-3 % is the limit of the benchmark. Each code uses the loosest tolerance that meets it,
        # from a grid of eight per decade. One step of the grid changes the error by a factor of at
        # most 12, the ratio of two orders of heyoka. So the error is not much below the limit.
        assert 1e-3 / 12 < r["performance_percent"] < 1e-3


def test_second_class_has_small_true_error(document):
    for r in of_class(document, "state_error"):
        # The limit 1e-12 defines the class. An error below 1e-14 would show that a code was run
        # with a smaller tolerance than needed.
        assert 1e-14 < r["max_state_error"] < 1e-12


def test_third_class_is_at_roundoff(document):
    # The units of roundoff are 1.1e-16 and 9.6e-35, the speed is near 5 m/s, and the errors of
    # about 70 steps add up. The reference itself is a sum of two binary64 numbers, accurate to
    # 5e-32 of the speed in m/s. SciPy adds up the errors of thousands of steps in binary64.
    limit = {("heyoka", "binary64"): 1e-14, ("heyoka", "binary128"): 2e-31}
    for r in of_class(document, "roundoff"):
        assert r["max_state_error"] < limit.get((r["code"], r["precision"]), 1e-12)


def test_measuring_sees_an_error(problem):
    rows = np.tile(problem.start(float), (problem.maneuver.rows, 1))
    # A motion that remains in the initial state conserves energy, but has an error as large as the
    # largest roll rate.
    performance, error = problem.measure(rows, problem.expected)
    assert performance < 1e-60  # the energies are computed with 256 bits
    assert 0.5 < error < 1
    rows[500, 5] *= 1 + 1e-9  # change the speed: kinetic energy is most of the 1837 J
    performance, _ = problem.measure(rows, problem.expected)
    assert performance == pytest.approx(100 * 2e-9 * 1037 / 1837, rel=0.02)
    assert problem.measure(rows[:-1], problem.expected) == (np.inf, np.inf)
    rows[0, 0] = np.nan
    assert problem.measure(rows, problem.expected) == (np.inf, np.inf)


@pytest.mark.parametrize("slope", [0.7, 1, 1.2])
def test_search_finds_the_loosest_tolerance(slope):
    # The error decreases with the tolerance, here as a power of it, so it crosses the limit once.
    for loosest in range(129):

        def excess(i, loosest=loosest):
            return slope * (loosest - 0.5 - i) / 8

        assert race._loosest(excess) == loosest
    assert race._loosest(lambda i: 99.0) is None


@pytest.mark.parametrize(
    ("code", "modules"),
    [
        (SciPy("SciPy LSODA", []), ["scipy", "scipy.integrate"]),
        (Sundials("SUNDIALS CVODE", []), ["sksundae", "sksundae.cvode"]),
        (Exudyn("Exudyn", []), ["exudyn"]),
    ],
)
def test_a_peer_that_is_not_installed_is_listed(problem, monkeypatch, code, modules):
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)
    code.problems = [problem]
    line = Timing("performance", code)
    race._prepare(line, code.at, None)
    assert (line.status, line.trial) == ("not installed", None)


def test_a_compiler_that_is_missing_is_listed(problem, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compiled.shutil, "which", lambda _: None)
    code = Compiled("C DOPRI5", [problem])
    line = Timing("performance", code)
    race._prepare(line, code.at, None)
    assert (line.status, line.trial) == ("no C compiler", None)


def test_the_fast_path_is_tuned_by_one_number(problem):
    code = Tuned("", [problem])
    trials = [code.at(race.tolerance_of(i)) for i in range(24, 97, 24)]
    for looser, tighter in itertools.pairwise(trials):
        assert tighter.tolerance < looser.tolerance
        assert tighter.error < looser.error / 10
        assert tighter.count > looser.count
        # Both trials use the same compiled code.
        assert tighter.build == looser.build


def test_columns_in_other_definitions_are_measured_in_those(problem, reference):
    rows = reference[2].rows.hi
    given = np.array([rows[race._EXUDYN.get(c, c)] for c in BENCHMARK_COLUMNS])
    # The values are right to binary64, but their definitions differ from the default ones by 1e-3
    # or more.
    assert problem.measure_columns(given, race._EXUDYN)[1] == 0
    assert problem.measure_columns(given, {})[1] > 1e-3
    assert problem.measure_columns(given[:, :-1], {}) == (np.inf, np.inf)


def test_a_figure_is_written_beside_the_table(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(race, "bench", lambda *_, **__: [])
    point = {"code": "SciPy LSODA", "min_ms": 1.0, "max_state_error": 1e-4}
    monkeypatch.setattr(race, "work_precision", lambda *_: [point, point])
    for suffix, head in (("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")):
        path = tmp_path / f"bench.{suffix}"
        arguments = ["bench", "-o", str(path), "--format", "json", "--reference", str(folder)]
        assert main(arguments) == Exit.OK
        assert path.read_bytes().startswith(head)
        (first, _) = json.loads(capsys.readouterr().out)["work_precision"]
        assert (first["code"], first["min_ms"]) == ("SciPy LSODA", 1.0)


def test_table_shows_all_of_it(document):
    results = [dict(r) for r in document["results"]]
    results[3] = dict.fromkeys(KEYS) | {
        key: results[3][key] for key in ("maneuver", "class", "code", "precision")
    }
    results[3]["status"] = "not installed"
    text = as_text(document | {"results": results})
    for part in (*CLASSES.values(), *(code for code, _ in CODES), "not installed", "left out"):
        assert part in text
    headings = ("build [s]", "min [ms]", "median [ms]", "cold [ms]", "eq. (1) [%]", "[m/s]")
    for heading in headings:
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
    monkeypatch.setattr("heyoka_bike.workbench.bench.problem.load_reference", lambda _: other)
    assert main(["bench", "--reference", "other"]) == Exit.INPUT
    error = capsys.readouterr().err
    assert error == (
        "heyoka-bike: other: found a reference of other inputs, expected maneuver 2 of the "
        "benchmark bicycle\n"
    )


def test_several_maneuvers_count_by_the_worst(problem, bicycle, maneuvers, reference):
    problems = [
        ReferenceProblem(bicycle, m, reference[i]) for i, m in enumerate(maneuvers, start=1)
    ]
    for code in race.codes(problems):
        if code.name == "heyoka_bike simulate" or (code.name == "C DOPRI5" and HAS_COMPILER):
            whole = code.at(1e-5)
            single = [type(code)(code.name, [x]).at(1e-5) for x in problems]
            # On the fast path, a run of one maneuver rounds differently from a run of all
            # maneuvers. This may change the last step.
            assert abs(whole.count - sum(x.count for x in single)) <= len(problems)
            assert whole.error == pytest.approx(max(x.error for x in single), rel=1e-6)
            assert whole.performance == pytest.approx(max(x.performance for x in single), rel=1e-6)
            assert whole.order == single[0].order
            whole.run()


def test_codes_beyond_binary64_are_right_where_they_stop(candidate):
    span = Fraction(1, 1000)
    found = precise.precise(candidate[1], ("binary128",), runs=1, mpmath_span=span)
    wholes = {"heyoka": True, "mpmath odefun": False, "Taylor in balls": False}
    with suppress(compiled.NoCompilerError):
        compiled.QuadruplePeer(candidate[1].bicycle)
        wholes["C extrapolation"] = True
    assert {x["code"]: x["measured_over"] == 10 for x in found} == wholes
    for x in found:
        # The unit of roundoff of binary128 is 1e-34. About 70 steps with a speed near 5 m/s add up.
        # The extrapolation code has a tolerance of 1e-30.
        assert x["error"] < (1e-30 if x["code"] == "C extrapolation" else 1e-31)
    assert precise._part(candidate[1], Fraction(10)) == 1
    assert 0 < precise._part(candidate[1], span) < 1 / 78


def test_costs_are_scaled_to_the_maneuver(candidate):
    published = candidate[1]
    short = dataclasses.replace(published.maneuver, duration=Fraction(1, 50))
    for precision, limit in (("longdouble", 1e9), (25, 0.0)):
        (x,) = precise.costs(published, (precision,), longest=limit)
        assert x["order"] == integrate(published.bicycle, short, precision).order
        # If only one step is timed, the number of the other steps is that of the published run.
        assert (x["steps"] == 1) == (limit == 0)
        count = published.steps if limit == 0 else x["steps"] + 1
        assert x["seconds"] == pytest.approx(x["seconds_per_step"] * count)
    assert order_of(5000) == 1734  # binary64 cannot represent this tolerance


def test_long_runs_are_judged_at_their_end(bicycle, maneuvers):
    of_both = "eq1", 1e-6
    loose, tight = batches.long_runs(bicycle, maneuvers[1], (10,), of_both, most_turns=1)
    assert (loose["duration"], tight["accuracy"]) == (10, 1e-6)
    assert 1e-7 < loose["error"] < 1e-3
    assert 1e-10 < tight["error"] < 1e-6
    assert tight["performance"] < loose["performance"] < 1e-3
