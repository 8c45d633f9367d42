"""A diagnosis stops at its budget. It reports what was found until then, and that it stopped early.

The clock advances by one second each time it is read, so a budget is a number of readings.
"""

import json
import re
import time
from dataclasses import replace
from itertools import count
from math import inf, nan
from threading import Thread

import numpy as np
import pytest

from generators.made_results import exact_columns, rows, smooth_error
from heyoka_bike import InputError, diagnose, score
from heyoka_bike.cli import main
from heyoka_bike.scoring.diagnosis import budget as budgets
from heyoka_bike.scoring.diagnosis import pursue
from heyoka_bike.scoring.diagnosis.budget import Budget, BudgetSpentError, Watch
from heyoka_bike.scoring.diagnosis.diagnose import diagnosed
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.rows.maneuvers import Mirrored
from heyoka_bike.scoring.rows.table import Undone
from heyoka_bike.system.resources import data_folder

pytestmark = pytest.mark.proof

RIGHT = data_folder() / "peers" / "scipy-rtol1e-10.txt"
CAUSES = ("mistake", "parameters", "linearised")
# Conclusions that need a complete search, because they are true only if no other cause explains the
# file.
CONCLUSIONS = ("no_mistake_found", "integrator", "term_unexplained", "smooth_error", "cannot_tell")


def exchanged(reference, other_error):
    """Score maneuver 2 with roll and steer angle exchanged and a smooth error like an integrator's.

    The error of the angles is small. The error of the other columns is `other_error`, relative to
    their scale: too large for these columns alone to show a correct motion when the budget stops
    the search.
    """
    columns = exact_columns(reference[2])
    columns["roll_angle"], columns["steer_angle"] = columns["steer_angle"], columns["roll_angle"]
    # The rates would show the exchange without a search.
    del columns["roll_rate"], columns["steer_rate"]
    for key, values in columns.items():
        error = 1e-4 if key in ("roll_angle", "steer_angle") else other_error
        size = error * float(np.max(np.abs(values)))
        columns[key] = values + smooth_error(reference, 2, size)
    return score(Results("made.txt", "text", (rows(reference, 2, columns),), 16), reference)


def after(report, reference, steps):
    """Return the report diagnosed with a budget of `steps`, and the number of steps that it
    used."""
    clock = map(float, count())
    found = diagnosed(report, reference, None, Budget(steps, lambda: next(clock)))
    return found, int(next(clock))


def codes(report):
    return [f.code for f in report.diagnosis]


@pytest.fixture(scope="module", params=[5e-4, 1e-2], ids=["sure", "unsure"])
def file(request, reference):
    """The score, its complete diagnosis, the number of steps, and whether the cause is certain."""
    report = exchanged(reference, request.param)
    # The first diagnosis caches the motions. The number of steps is the same in all later ones.
    after(report, reference, inf)
    whole, steps = after(report, reference, inf)
    return report, whole, steps, request.param < 1e-3


def test_a_budget_that_suffices_changes_nothing(file, reference):
    report, whole, steps, _ = file
    assert whole.diagnosis[0].evidence["mistakes"] == [
        "columns_steer_angle_as_roll_angle_roll_angle_as_steer_angle"
    ]
    found, _ = after(report, reference, steps)
    assert not found.is_stopped_early
    assert found.said == whole.said


def test_without_time_nothing_is_claimed(file, reference):
    report, _, _, _ = file
    found, looks = after(report, reference, 1)
    assert looks == 2
    assert found.is_stopped_early
    # No search is needed to see the beginning of the error and the variation of the energy.
    assert {*codes(found)} <= {"begins_as", "energy_varies", "stopped_early"}
    assert found.explanation is None
    assert not {*codes(found)} & {*CAUSES, *CONCLUSIONS}


def test_what_was_found_until_then_is_said_and_no_more(file, reference):
    report, whole, steps, is_sure = file
    said = {}
    for k in (steps // 2, steps - 40, steps - 1):
        found, looks = after(report, reference, k)
        assert looks == k + 1
        assert found.is_stopped_early
        assert codes(found)[-1] == "stopped_early"
        assert not {*codes(found)} & {*CONCLUSIONS}
        # If a cause is named early, it is the same cause that the complete search names.
        causes = [f.evidence["mistakes"] for f in found.diagnosis if f.code in CAUSES]
        assert causes in ([], [whole.diagnosis[0].evidence["mistakes"]])
        said[k] = found.diagnosis[0]
    last = said[steps - 1]
    assert last.code == ("mistake" if is_sure else "likeliest_until_then")
    assert last.evidence["mistakes"] == whole.diagnosis[0].evidence["mistakes"]


def test_every_format_says_it(file, reference, tmp_path):
    report, _, _, _ = file
    found, _ = after(report, reference, 1)
    for name in ("r.txt", "r.html", "r.xml", "r.json"):
        text = " ".join(found.save(tmp_path / name).read_text().split())
        assert "No cause was found within the limit of 1 s" in re.sub(r"<[^>]*>", "", text), name
    assert json.loads(found.to_json())["stopped_early"] is True
    assert json.loads(report.to_json())["stopped_early"] is False


def wrong(tmp_path):
    """Write a file whose roll and steer angles of maneuver 1 belong to no bicycle."""
    table = np.loadtxt(RIGHT)
    table[:, [1, 7]] *= 1.0 + 0.3 * np.sin(table[:, :1])
    np.savetxt(tmp_path / "x.txt", table, "%.17g")
    return str(tmp_path / "x.txt")


def test_the_commands_end_with_a_code_of_their_own(tmp_path, capsys):
    path = wrong(tmp_path)
    assert main(["diagnose", path, "--budget", "1e-9"]) == 4
    assert "No cause was found within the limit of 1e-09 s" in capsys.readouterr().out
    assert main(["diagnose", path, "--budget", "1e-9", "--format", "json"]) == 4
    told = json.loads(capsys.readouterr().out)
    assert told["stopped_early"] is True
    stopped = next(f for f in told["findings"] if f["code"] == "stopped_early")
    assert (stopped["severity"], stopped["evidence"]) == ("warning", {"seconds": 1e-9})
    asked = ["score", path, "--diagnose", "--budget", "1e-9"]
    assert main([*asked, "--format", "json"]) == 4
    assert json.loads(capsys.readouterr().out)["stopped_early"] is True
    # An unmet requirement determines the exit code even if the diagnosis stops early.
    assert main([*asked, "--require", "scd >= 6"]) == 3
    # A correct file needs no search, so it cannot run out of time.
    assert main(["diagnose", str(RIGHT), "--budget", "1e9"]) == 0


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "x", "", "1,2", "1e999"])
@pytest.mark.parametrize("command", [["diagnose"], ["score", "--diagnose"]])
def test_a_budget_that_is_none_is_refused(capsys, command, text):
    name, *more = command
    assert main([name, str(RIGHT), *more, f"--budget={text}"]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert "--budget: " in told.err


def test_a_budget_needs_a_diagnosis(capsys):
    assert main(["score", str(RIGHT), "--budget", "5"]) == 1
    assert "--budget needs --diagnose" in capsys.readouterr().err


@pytest.mark.parametrize("budget", [0, -1.0, nan, "5", None, [30]])
def test_in_python_a_budget_that_is_none_is_refused(budget):
    with pytest.raises(InputError, match=r"budget: found .*, expected seconds above zero"):
        diagnose(RIGHT, budget=budget)


def test_in_python_it_is_a_keyword(tmp_path):
    found = diagnose(wrong(tmp_path), budget=1e-9)
    assert found.is_stopped_early
    assert codes(found)[-1] == "stopped_early"
    assert not {*codes(found)} & {*CAUSES, *CONCLUSIONS}


def turn_for_ever(*_):
    """A step that never ends and never reads the clock."""
    while True:
        sum(range(1000))


@pytest.fixture
def soon(monkeypatch):
    monkeypatch.setattr(budgets, "OVERRUN", 0.3)


@pytest.mark.timeout(120)
def test_a_step_that_never_ends_is_interrupted(tmp_path, capsys, monkeypatch, soon):
    first, *_ = pursue.ROW_CHECKS
    steps = (replace(first, find=turn_for_ever),)
    monkeypatch.setattr(pursue, "ROW_CHECKS", steps)
    begin = time.process_time()
    assert main(["diagnose", wrong(tmp_path), "--budget", "0.1"]) == 4
    assert time.process_time() - begin < 10.0
    assert "No cause was found within the limit of 0.1 s" in capsys.readouterr().out


@pytest.mark.timeout(120)
def test_what_was_seen_before_it_is_said(tmp_path, monkeypatch, soon):
    """The first step corrects the rows, and the second step is interrupted."""

    def look(report):
        return Undone((Mirrored((2,)),), tuple(m.part for m in report.maneuvers))

    first, *_ = pursue.ROW_CHECKS
    steps = (replace(first, find=look), replace(first, find=turn_for_ever))
    monkeypatch.setattr(pursue, "ROW_CHECKS", steps)
    found = diagnose(wrong(tmp_path), budget=0.1)
    assert codes(found) == ["mirrored", "stopped_early"]
    assert found.is_stopped_early


@pytest.mark.timeout(120)
def test_a_thread_is_interrupted_as_well(soon):
    ends = []

    def work():
        try:
            with Watch(Budget(0.05).begun()):
                turn_for_ever()
        except BudgetSpentError:
            ends.append("interrupted")

    thread = Thread(target=work)
    thread.start()
    thread.join()
    assert ends == ["interrupted"]


def test_nothing_is_raised_after_the_block(soon):
    for _ in range(20):
        with Watch(Budget(1e-9).begun()):
            pass
    end = time.process_time() + 1.0
    while time.process_time() < end:
        sum(range(1000))
