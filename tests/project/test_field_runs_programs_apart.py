"""The field is run program by program: what hangs, crashes or is absent is one line."""

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
from support.peers import PEERS, apart, field, measured, on_path, problem

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS

FIELD = PEERS / "field.py"


@pytest.fixture(autouse=True)
def _modules_are_found():
    with on_path():
        yield


def maker(what):
    """A function that behaves as it is told to."""
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


def test_orders_are_those_between_neighbours_of_a_family():
    def run(digits, **setting):
        same = measured.family(
            {"measure": "step", "follows": "stiffness", "beside": ["newton"]}, setting
        )
        return {"setting": setting, "digits": digits, "failure": None, "family": same}

    runs = [
        run(2.0, step=0.1, stiffness="0.2 1"),
        run(6.0, step=0.001, stiffness="0.002 1", newton=1e-12),
        run(4.0, step=0.01, stiffness="0.02 1"),
        run(5.0, step=0.01, stiffness="0.2 1"),
        run(1.0, step=0.01, method="other"),
        run(0.0, step=0.01, stiffness="0.02 1") | {"failure": "crashed"},
    ]
    found = measured.orders(runs, "step")
    assert [(x["from"], x["to"], x["order"]) for x in found] == [(0.1, 0.01, 2), (0.01, 0.001, 2)]


def test_what_is_written_down_is_kept_while_it_holds(tmp_path):
    path = tmp_path / "field.json"
    entry = {"measure": "step", "default": {"step": 1}, "sweep": [{"step": 1}, {"step": 2}]}
    assert measured.settings(entry) == [("default", {"step": 1}), ("sweep", {"step": 2})]
    document = measured.Document.of(path, "here", "peer", ["b", "a"])
    line, failed = (
        measured.named(entry, kind, setting)
        | {"started": document.started, "made_of": "made of this", "failure": failure}
        for (kind, setting), failure in zip(
            measured.settings(entry), (None, "crashed"), strict=True
        )
    )
    said = {"measure": "step"}
    document.keep("a", {"runs": [line, failed]})
    document.keep_runs("b", said, "H4", [line])
    document.keep_runs("b", said, "H2", [])
    assert list(document.content["programs"]["b"]["harder"]) == ["H2", "H4"]
    assert list(json.loads(path.read_text())["programs"]) == ["b", "a"]
    again = measured.Document.of(path, "here", "peer", ["b", "a"])
    assert again.line("a", "H1", "default", "made of this") == line
    assert again.line("b", "H4", "default", "made of this") == line
    again.keep("a", {"runs": []})
    assert again.line("a", "H1", "default", "made of this") == line, "runs that follow are kept too"
    for name, asked, kind, made_of in (
        ("a", "H1", "default", "made of that"), ("a", "H1", "sweep", "made of this"),
        ("a", "H4", "default", "made of this"), ("b", "H1", "default", "made of this"),
        ("b", "H2", "default", "made of this"),
    ):  # fmt: skip
        assert again.line(name, asked, kind, made_of) is None
    elsewhere = measured.Document.of(path, "elsewhere", "peer", [])
    assert elsewhere.line("a", "H1", "default", "made of this") is None


def test_what_is_done_of_the_harder_tier_is_said():
    entry = {
        "default": {"step": 2}, "best": {"step": 1}, "sweep": [{"step": 3}],
        "harder": {"best": ["H3", "H4"], "default": ["H4"], "submitted": ["H2", "H3d"]},
    }  # fmt: skip
    best = ("best", {"step": 1})
    assert measured.settings(entry, "H4") == [("default", {"step": 2}), best]
    assert measured.settings(entry, "H3d") == [best]
    assert measured.settings(entry, "H2") == []
    assert measured.submitted(entry, "H3d") == ("best",)
    assert measured.submitted(entry, "H3a") == measured.submitted({}, "H3d") == ()
    assert measured.submitted(entry, "H1") == ("default", "best")
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
    short = asked.shortened(text, reference, 17)
    first, *others = (word.lstrip("-0.") for word in short.splitlines()[500].split()[1:])
    # An error of 1e-5 of the largest lean, 0.18 rad: 4.3 digits.
    assert len(first) <= 7 < min(map(len, others))
    whole, part = asked.judge(text, reference), asked.judge(short, reference)
    assert part["scd"]["roll_angle"] == pytest.approx(whole["scd"]["roll_angle"], abs=0.03)
    assert asked.judge(asked.text(rows, [4] * 24), reference)["digits"] < 4
    assert [m["maneuver"] for m in whole["maneuvers"]] == [1, 2, 3]
    first, second, third = (m["digits"] for m in whole["maneuvers"])
    assert whole["digits"] == first < 5 < min(second, third)
    assert whole["maneuvers"][0]["worst"] == whole["worst"]["column"] == "roll_angle"


def test_published_files_are_judged_again_without_a_run(reference, tmp_path):
    """Only a file that is still that of its line, and has its digits."""
    path, problem_1 = tmp_path / "field.json", problem.Problem.of("H1")
    found = field.result_file("ode", "best")
    text = gzip.decompress(found.read_bytes())
    whole = problem_1.judge(text.decode(), reference)
    line = {"kind": "best", "failure": None, "sha256": hashlib.sha256(text).hexdigest()}
    lines = {
        "ode": line | {"digits": whole["digits"], "maneuvers": [{"maneuver": 2, "cpu": 7.0}]},
        "dart": line | {"digits": whole["digits"]},  # of another file
    }
    content = {"programs": {
        name: {"program": name, "runs": [x, x | {"kind": "sweep"}, {"failure": "crashed"}]}
        for name, x in lines.items()
    }}  # fmt: skip
    path.write_text(json.dumps(content))
    said = field.judge_again(path, reference)
    assert len(said) == 1
    runs = {name: p["runs"] for name, p in json.loads(path.read_text())["programs"].items()}
    assert [m["digits"] for m in runs["ode"][0]["maneuvers"]] == [
        m["digits"] for m in whole["maneuvers"]
    ]
    assert runs["ode"][0]["maneuvers"][1]["cpu"] == 7.0
    assert (runs["ode"][1:], runs["dart"]) == (
        content["programs"]["ode"]["runs"][1:], content["programs"]["dart"]["runs"]
    )  # fmt: skip
    lines["ode"]["digits"] += 1
    path.write_text(json.dumps(content | {"programs": {"ode": {
        "program": "ode", "runs": [lines["ode"]]
    }}}))  # fmt: skip
    before = path.read_text()
    assert "expected" in field.judge_again(path, reference)[0]
    assert json.loads(path.read_text()) == json.loads(before)


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
    pytest.importorskip("heyoka")
    path = tmp_path / "field.json"
    code, out, err = ran("linear", "-o", path)
    assert (code, err) == (0, "")
    assert "-0.57 digits" in out
    (run,) = json.loads(path.read_text())["programs"]["linear"]["runs"]
    assert run["performance"][1] == pytest.approx(0.87, rel=0.01)
    assert run["ratio"] == pytest.approx(run["cpu"] / run["peer"], rel=0.01)
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
            # A run in 70 digits rounds the same way, but where the exact value is zero.
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
