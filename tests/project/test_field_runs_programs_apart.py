"""The compared programs run one by one; a program that hangs, crashes or is missing
gives one line."""

import gzip
import hashlib
import json
import os
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from support.peers import PEERS, apart, field, measured, on_path, problem, race

FIELD, FIELD_TOML = PEERS / "field.py", field.read_field()


@pytest.fixture(autouse=True)
def _modules_are_found():
    with on_path():
        yield


def maker(what):
    """Return a function that hangs, crashes or raises as `what` says."""
    if what == "absent":
        raise ImportError("no module that is called so")
    return behave


def behave(what):
    if what == "hangs":
        subprocess.run([sys.executable, "-c", "import time; time.sleep(600)"], check=True)
    if what == "crashes":
        os._exit(7)
    if what == "raises":
        raise ZeroDivisionError("by nothing")
    return what, os.getpid()


@pytest.mark.proof
def test_a_call_that_fails_leaves_the_next_one_whole():
    with apart.Apart(20, maker, "there") as called:
        first = called("first")
        assert first[0] == "first"
        assert first[1] != os.getpid()
        assert called("second")[1] == first[1]
        for what, word in (("raises", "ZeroDivisionError: by nothing"), ("crashes", "code 7")):
            with pytest.raises(apart.FailedError, match=word):
                called(what)
        called.start()
        called.limit = 1
        with pytest.raises(apart.FailedError, match="no end after 1 s"):
            called("hangs")
        called.limit = 20
        assert called("last")[0] == "last"


def test_what_is_not_here_says_so():
    with (
        apart.Apart(20, maker, "absent") as called,
        pytest.raises(apart.AbsentError, match="called so"),
    ):
        called("first")


def line(entry, family, value, **found):
    """A run as it is stored."""
    about = measured.told(entry, "sweep", family, value)
    return (
        about | {"started": "2026-11-24T12:00Z", "failure": None, "cpu": 1.0, "digits": 3.0} | found
    )


STEPS = {"measure": "step", "language": "C"}


def test_orders_are_those_between_neighbours_of_a_family():
    even, other = {"words": "even"}, {"words": "other", "set": {"method": "other"}}
    runs = [
        line(STEPS, even, 0.1, digits=2.0), line(STEPS, even, 0.001, digits=6.0),
        line(STEPS, even, 0.01, digits=4.0), line(STEPS, other, 0.01, digits=1.0),
        line(STEPS, even, 0.01, digits=0.0, failure="crashed"),
    ]  # fmt: skip
    found = measured.orders(runs, "step")
    assert [(x["from"], x["to"], x["order"]) for x in found] == [(0.1, 0.01, 2), (0.01, 0.001, 2)]


def test_a_run_is_told_by_its_family_and_its_step():
    found = measured.told(STEPS, "sweep", {"words": "Euler", "set": {"mu": 1}}, 1 / 3)
    assert found["words"] == "Euler, h = 0.333"
    assert found["setting"] == {"step": 1 / 3, "mu": 1}
    assert measured.told(STEPS, "default", {"words": ""}, 0.5)["words"] == "h = 0.5"
    assert measured.told(STEPS, "default", {"words": "x", "language": "D"}, 1)["language"] == "D"


def test_the_best_run_is_the_most_right_one_within_the_budget():
    family = {"words": "x"}
    runs = [
        line(STEPS, family, 4.0, digits=2.0), line(STEPS, family, 3.0, digits=5.0),
        line(STEPS, family, 2.0, digits=9.0, cpu=measured.BUDGET + 1), line(STEPS, family, 1.0),
    ]  # fmt: skip
    assert measured.best(runs) == {"step": 3.0}
    assert measured.best([runs[2]]) is None
    assert measured.best([line(STEPS, family, 1.0, failure="crashed")]) is None


@pytest.mark.parametrize(
    ("measure", "found", "asked"),
    [
        # A sweep of steps ends after two successive refinements that gain less than 0.15 digits
        # each.
        ("step", [1, 2, 2.1, 2.05], [1, 0.5, 0.25, 0.125]),
        ("step", [1, 0.9, 2, 1.9, 2.1, 9], [1, 0.5, 0.25, 0.125, 0.0625]),
        # Failures count only after the first successful run.
        ("step", [None, None, None, 2, None, 3, None, None], [0.5**i for i in range(8)]),
        # A tolerance is reduced to the rounding unit, or until two successive runs fail.
        ("tolerance", [2] * 16, [0.1**i for i in range(16)]),
        ("tolerance", [1, None, 2, None, None], [0.1**i for i in range(5)]),
    ],
)
def test_a_sweep_ends_where_refining_gains_nothing(measure, found, asked):
    values = []

    def tried(value):
        digits = found[len(values)]
        values.append(value)
        return {"failure": None if digits else "no end", "digits": digits, "cpu": 0.01}

    field.sweep(measure, {"from": 1}, tried)
    assert values == pytest.approx(asked)


def test_a_sweep_ends_where_the_next_run_would_take_too_long_or_is_beyond_rounding():
    def tried(costs):
        values = []

        def run(value):
            cpu = costs(len(values))
            values.append(value)
            return {"failure": None, "digits": float(len(values)), "cpu": cpu}

        return values, run

    values, run = tried(lambda n: 1.1 * 2**n)
    field.sweep("step", {"from": 1}, run)
    assert 1.1 * 2 ** len(values) > measured.BUDGET > 1.1 * 2 ** (len(values) - 1)
    # The cost of the next tolerance is extrapolated from the last increase of the cost.
    values, run = tried(lambda n: 1.1 * 1.5**n)
    field.sweep("tolerance", {"from": 1e-3}, run)
    assert 1.1 * 1.5 ** len(values) > measured.BUDGET > 1.1 * 1.5 ** (len(values) - 1)
    values, run = tried(lambda _: 0.01)
    field.sweep("tolerance", {"from": 1e-3}, run)
    assert values[-1] == 1e-15


def test_what_is_written_down_is_kept_while_it_holds(tmp_path):
    path = tmp_path / "field.json"
    family = {"words": "x"}
    good, failed = (
        line(STEPS, family, 1.0, failure=failure) | {"made_of": made_of}
        for failure, made_of in ((None, "this"), ("crashed", "that"))
    )
    said = {"measure": "step", "program": "A"}
    document = measured.Document.of(path, "here", ["b", "a"])
    document.keep_runs("a", said, [good, failed])
    document.keep_runs("b", said, [])
    document.keep_harder("b", said, "H4", [good])
    document.keep_harder("b", said, "H2", [])
    content = json.loads(path.read_text())
    assert list(content["programs"]) == ["b", "a"]
    assert content["programs"]["a"]["best"] == {"step": 1.0}
    assert list(content["harder"]["programs"]["b"]["problems"]) == ["H2", "H4"]
    again = measured.Document.of(path, "here", ["b", "a"])
    assert again.line("a", "H1", "this") == again.line("b", "H4", "this") == good
    again.keep_runs("a", said, [])
    assert again.line("a", "H1", "this") == good, "earlier runs must remain"
    for name, asked, made_of in (
        ("a", "H1", "other"), ("a", "H1", "that"), ("a", "H4", "this"), ("b", "H1", "this"),
        ("b", "H2", "this"),
    ):  # fmt: skip
        assert again.line(name, asked, made_of) is None
    # Runs of the benchmark on a different machine are not reused. The runs of the harder tier state
    # the machine on which they were made.
    elsewhere = measured.Document.of(path, "elsewhere", [])
    assert elsewhere.line("a", "H1", "this") is elsewhere.line("b", "H4", "this") is None
    assert elsewhere.content["harder"]["machine"] == "here"
    elsewhere.keep_harder("a", said, "H4", [good])
    assert elsewhere.content["harder"]["machine"] == "elsewhere"
    assert list(elsewhere.content["harder"]["programs"]) == ["a"]


class Told:
    """A program that runs nothing."""

    def start(self):
        """Pretend that the program is installed."""


def test_what_is_done_of_the_harder_tier_is_said(monkeypatch):
    entry = FIELD_TOML["boost"] | {"harder": {"best": ["H3", "H4"], "default": ["H4"]}}
    document = measured.Document.of(None, "here", [])
    runs = [line(STEPS, {"words": "x"}, value) for value in (2.0, 1.0)]
    runs[0]["kind"], runs[1]["digits"] = "default", 7.0
    document.content["programs"]["boost"] = {"runs": runs}
    monkeypatch.setattr(field, "measure", lambda *_: ({"failure": None, "digits": 4.0}, "text"))
    for name, kinds in (("H4", ["best", "default"]), ("H3d", ["best"]), ("H2", [])):
        told = field.Runs("boost", entry, Told(), document, False, lambda *_: None)
        told.harder(problem.Problem.of(name), None, False)
        found = document.content.get("harder", {"programs": {}})["programs"]
        lines = found.get("boost", {"problems": {}})["problems"].get(name, [])
        assert [x["kind"] for x in lines] == kinds
        assert [x["beside"] for x in lines] == [7.0, 3.0][: len(kinds)]
    assert problem.problems("H3") == ["H3a", "H3b", "H3c", "H3d", "H3e", "H3f"]


def test_a_problem_has_the_inputs_and_rows_of_its_files():
    longer, another = problem.Problem.of("H2"), problem.Problem.of("H4")
    assert (longer.rate, longer.rows, longer.seconds, longer.only) == (10, 1001, 100, 1)
    assert longer.bicycle == problem.Problem.of("H1").bicycle
    assert longer.starts == problem.Problem.of("H1").starts[:1]
    assert (another.rate, another.rows, another.only) == (100, 1001, None)
    assert another.starts == [[4.5, 0.5], [6, 0.5], [8, 0.5]]
    assert another.bicycle["w"] == 1.121
    edge = problem.Problem.of("H3d")
    assert (edge.starts, edge.only) == ([[4.6, 2.4649]], 4)
    assert longer.text([[0.0, 1 / 3]] * 3, [3, 2]).splitlines()[1:] == ["0.1 0 0.33", "0.2 0 0.33"]


def test_a_file_is_shortened_to_the_digits_that_are_right(reference):
    asked, times = problem.Problem.of("H1"), np.arange(1001) / 100
    rows = np.hstack([np.column_stack([r[key] for key in BENCHMARK_COLUMNS])
                      for r in reference.values()])  # fmt: skip
    rows[:, 0] += 1e-5 * np.sin(times)
    text = asked.text(rows, [17] * 24)
    short = asked.shortened(text, reference)
    first, *others = (word.lstrip("-0.") for word in short.splitlines()[500].split()[1:])
    # A lean error of 1e-5, relative to the largest lean of 0.18 rad, is 4.3 correct digits.
    assert len(first) <= 7 < min(map(len, others))
    whole, part = asked.judge(text, reference), asked.judge(short, reference)
    assert part["scd"]["roll_angle"] == pytest.approx(whole["scd"]["roll_angle"], abs=0.03)
    assert asked.judge(asked.text(rows, [4] * 24), reference)["digits"] < 4
    assert [m["maneuver"] for m in whole["maneuvers"]] == [1, 2, 3]
    first, second, third = (m["digits"] for m in whole["maneuvers"])
    assert whole["digits"] == first < 5 < min(second, third)
    assert whole["maneuvers"][0]["worst"] == whole["worst"]["column"] == "roll_angle"


def test_a_published_file_is_that_of_its_line():
    path = field.result_file("ode", "best")
    sha256 = hashlib.sha256(gzip.decompress(path.read_bytes())).hexdigest()
    assert field.is_submitted(path, {"sha256": sha256})
    assert not field.is_submitted(path, {"sha256": "0"})
    assert not field.is_submitted(path.with_name("none.txt.gz"), {"sha256": sha256})


def test_the_race_is_among_the_cheapest_runs_that_pass_in_maneuver_2():
    def run(step, cpu, drift, failure=None, family="x"):
        of = [{"maneuver": n, "performance": drift if n == 2 else 9, "cpu": cpu} for n in (1, 2, 3)]
        said = {"failure": failure, "maneuvers": of, "family": family}
        return said | {"setting": {"step": step}}

    def program(script, *runs):
        return {"script": script, "measure": "step", "runs": runs}

    programs = {
        "a": program("a/x.py", run(4, 3, 1e-4), run(3, 2, 9e-4), run(9, 1, 2e-3)),
        # The step of size 7 is finer than that of size 8, but its run happened to be faster.
        "b": program("a/y.py", run(8, 1.6, 1e-4), run(7, 1.5, 1e-4), run(9, 0.5, 0, "crashed"),
                     run(9, 5, 1e-4, family="y")),
        "c": program("c/x.py", run(1, 1, 1e-2)),
    }  # fmt: skip
    found = race.cheapest(programs)
    assert {folder: (name, x["setting"]) for folder, (name, x) in found.items()} == {
        "a": ("b", {"step": 8})
    }


@pytest.mark.proof
def test_a_set_that_is_not_there_is_one_line(tmp_path):
    code, _, err = ran("linear", "--problem", "H4", "--sets", tmp_path)
    assert code == 2
    assert "no manifest.json found" in err.splitlines()[-1]


def test_versions_are_those_that_are_installed():
    line = "apt-get install not-there; pip install numpy==0.1 'pytest<90' && pip install -U no==1"
    found = measured.installed(line)
    assert list(found) == ["numpy", "pytest"]
    assert found["numpy"] != "0.1"
    assert measured.pinned(line) == {"numpy": "0.1", "no": "1"}
    assert measured.lacking(line) == ["no"]


def ran(*arguments):
    done = subprocess.run(
        [sys.executable, FIELD, *map(str, arguments)], capture_output=True, text=True, check=False,
        timeout=300,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.proof
def test_a_program_is_run_scored_and_kept(tmp_path):
    path = tmp_path / "field.json"
    code, out, err = ran("linear", "-o", path)
    assert (code, err) == (0, "")
    assert "-0.57 digits" in out
    (run,) = json.loads(path.read_text())["programs"]["linear"]["runs"]
    assert run["maneuvers"][1]["performance"] == pytest.approx(0.87, rel=0.01)
    before = path.read_text()
    time.sleep(0.01)
    assert ran("linear", "-o", path)[0] == 0
    assert path.read_text() == before


@pytest.mark.proof
def test_an_unknown_program_is_one_line():
    code, _, err = ran("mujocco")
    assert code == 2
    assert "found 'mujocco', expected some of mujoco" in err.splitlines()[-1]


@pytest.mark.proof
def test_rows_that_are_proved_alone_are_those_of_the_set(reference, tmp_path):
    pytest.importorskip("heyoka")
    with on_path():
        from rows_alone import rows_alone
    (tmp_path / "short.toml").write_text(
        'name = "short"\n'
        + "".join(
            f'[[maneuver]]\nname = "{name}"\nspeed = "{speed}"\nroll_rate = "0.05"\n'
            'duration = "0.1"\nspacing = "0.01"\n'
            for name, speed in (("p", "8.0"), ("q", "4.0"))
        )
    )

    def made(how):
        return rows_alone("benchmark", tmp_path / "short.toml", [2], tmp_path / "set", how)

    found, computed = made("prove"), made("compute")
    assert (found.parameters, len(found)) == (reference.parameters, 2)
    assert np.isnan(found[1]["roll_angle"]).all()
    short, whole = found[2], reference[1]
    assert set(short.rows.hi) == set(whole.rows.hi)
    for name in short.rows.hi:
        for part in ("hi", "lo"):
            ours, published = (getattr(m.rows, part)[name] for m in (short, whole))
            assert np.array_equal(ours, published[:11]), (name, part)
            # The values that were only computed, with 70 digits, are rounded to the same numbers as
            # the proved ones. They differ only where the exact value is zero.
            found_too = getattr(computed[2].rows, part)[name]
            assert np.abs(found_too - ours).max() < 1e-60, (name, part)
    middle = short.evaluate("0.055", "roll_angle")["roll_angle"]
    assert middle == whole.evaluate("0.055", "roll_angle")["roll_angle"]
    columns = [short.rows[key] for key in ("roll_angle", "roll_rate", "forward_speed_wheel_spin",
               "potential_energy", "kinetic_energy", "mechanical_energy", "steer_angle",
               "steer_rate")]  # fmt: skip
    asked = replace(problem.Problem.of("H1"), numbers=(2,), rows=11)
    text = asked.text(np.column_stack(columns), [17] * 8)
    judged = asked.judge(text, found)
    assert judged["digits"] > 15
    assert judged["definitions"] == {"forward_speed": "wheel_spin"}
    kept = {p: p.read_bytes() for p in (tmp_path / "set").rglob("*") if p.is_file()}
    assert kept
    assert made("prove")[2].rows.hi.keys() == short.rows.hi.keys()
    assert {p: p.read_bytes() for p in kept} == kept
