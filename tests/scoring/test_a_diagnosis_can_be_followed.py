"""`diagnose -v` logs the steps that the page lists, and a cause claims no more than it explains."""

import logging
import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.made_results import exact_columns, rows, smooth_error
from generators.mistaken_programs import columns_of, correct
from heyoka_bike import score
from heyoka_bike.scoring.diagnosis.budget import USUAL, Budget
from heyoka_bike.scoring.diagnosis.diagnose import diagnosed
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.programs.program import other_values
from heyoka_bike.scoring.diagnosis.row_checks import ROW_CHECKS
from heyoka_bike.scoring.diagnosis.search import OF_WHAT_IS_WRITTEN, SEARCH, again, with_output
from heyoka_bike.scoring.reading.results import Results

LINE = re.compile(r"(.+?): (.+?\?) (.+) \((\d+\.\d\d) s\)")


def listed():
    """Names and questions of the steps in the table of the page."""
    page = (Path(__file__).parents[2] / "docs" / "how-diagnosis-works.md").read_text("utf-8")
    return re.findall(r"^\| `(.+?)` \| (.+?) \|", page, re.MULTILINE)


def test_the_page_lists_every_step_with_its_question():
    pages = dict(listed())
    plans = (again([]), with_output(()))
    every = (*ROW_CHECKS, *OF_WHAT_IS_WRITTEN, *SEARCH, *(x for plan in plans for x in plan.steps))
    for step in every:
        question = pages[step.name]
        assert question.lower() == step.question.lower()
    assert [name for name in pages if name not in ("motion", "edited", "method")] == [
        step.name for step in every
    ]


def told(caplog, report, reference, budget=USUAL):
    with caplog.at_level(logging.INFO, "heyoka_bike.scoring.diagnosis"):
        diagnosed(report, reference, budget=budget)
    lines = [r.getMessage() for r in caplog.records if r.name.endswith("step_log")]
    return {m[1]: m for line in lines if (m := LINE.fullmatch(line))}


def made(reference, change):
    columns = exact_columns(reference[2])
    change(columns)
    return score(Results("made.txt", "text", (rows(reference, 2, columns),), 16), reference)


def test_what_ends_the_search_is_told_last(reference, caplog):
    def exchange(columns):
        columns["roll_angle"], columns["steer_angle"] = (
            columns["steer_angle"], columns["roll_angle"],
        )  # fmt: skip

    steps = told(caplog, made(reference, exchange), reference)
    names = [name for name, _ in listed() if name in steps]
    assert [*steps] == names
    last = steps["output"]
    assert "likeliest columns_steer_angle_as_roll_angle" in last[3]
    assert float(re.search(r"largest remaining error ([0-9.e-]+) in", last[3])[1]) < 1e-8
    assert "whole runs" not in steps


@pytest.mark.proof
def test_every_step_of_a_file_that_nothing_explains_is_told(reference, caplog):
    def disturb(columns):
        for key, values in columns.items():
            columns[key] = values + smooth_error(reference, 2, 0.05 * float(np.max(np.abs(values))))

    steps = told(caplog, made(reference, disturb), reference)
    assert {"grid", "clock", "motion", "start and output", "together"} <= steps.keys()
    assert "likeliest" not in steps["together"][3]


def pushed(reference, times):
    """Add a motion to the angles and rates that no force of the collection causes, `times` as
    large."""

    def push(columns):
        time, turn = reference[2].time, 1.7
        waves, slopes = np.sin(turn * time) ** 3, 3 * turn * np.sin(turn * time) ** 2
        for angle, rate, size in (
            ("roll_angle", "roll_rate", 0.003), ("steer_angle", "steer_rate", 0.002),
        ):  # fmt: skip
            columns[angle] = columns[angle] + times * size * waves
            columns[rate] = columns[rate] + times * size * slopes * np.cos(turn * time)
        columns["forward_speed"] = columns["forward_speed"] + times * 0.001 * waves
        for key in [key for key in columns if key.endswith("energy")]:
            del columns[key]

    return push


@pytest.mark.proof
@pytest.mark.parametrize(("times", "code"), [
    (1.0, "term_unexplained"), (1e-5, "left_of_equations"), (1e-8, None),
])  # fmt: skip
def test_what_the_equations_leave_is_called_a_force_where_it_is_enough(reference, times, code):
    """Large residuals indicate a force. Small ones are described by equation and size only.
    Residuals within the digits written are not mentioned."""
    report = diagnosed(made(reference, pushed(reference, times)), reference)
    found = {f.code for f in report.diagnosis} & {"term_unexplained", "left_of_equations"}
    assert found == ({code} if code else set())


@pytest.mark.proof
def test_no_model_is_simulated_for_a_correct_file(reference, caplog):
    """Errors below 1e-6 nearly always come from the integrator or the output, so no model is
    tried."""

    def disturb(columns):
        for key in [key for key in columns if key not in ("roll_angle", "steer_rate")]:
            del columns[key]
        for key, values in columns.items():
            columns[key] = values + smooth_error(reference, 2, 3e-8 * float(np.max(np.abs(values))))

    report = made(reference, disturb)
    assert all(c.is_right for m in report.maneuvers for c in m.columns if c.values)
    assert not {"library", "whole runs", "together"} & told(caplog, report, reference).keys()
    caplog.clear()
    assert {"library", "together"} <= told(
        caplog, report, reference, Budget(is_thorough=True)
    ).keys()


@pytest.mark.proof
def test_an_unexplained_force_ends_the_search(reference, caplog):
    report = made(reference, pushed(reference, 1.0))
    assert "together" not in told(caplog, report, reference)
    hint = "Pairs of mistakes were not tried. To try them, use --thorough"
    assert hint in diagnosed(report, reference).diagnosis[0].message
    thorough = Budget(is_thorough=True)
    caplog.clear()
    assert "together" in told(caplog, report, reference, thorough)
    assert hint not in diagnosed(report, reference, budget=thorough).diagnosis[0].message


@pytest.mark.proof
def test_a_start_and_what_is_written_are_found_together(reference):
    """Each maneuver has other initial conditions, and its potential energy lacks the front fork."""
    mistakes = [m for m in MISTAKES if m.code == "potential_energy_without_H"]
    start = other_values({"initial_speed_2": -0.1}, {"initial_speed_2": 0.0}, correct(reference))
    columns = columns_of(reference, (start, *mistakes))[2]
    report = score(Results("made.txt", "text", (rows(reference, 2, columns),), 16), reference)
    (first, *_) = diagnosed(report, reference).diagnosis
    assert first.evidence["mistakes"] == ["other_initial_speed_2", "potential_energy_without_H"]
    assert first.evidence["is_all"]


@pytest.mark.proof
@pytest.mark.parametrize(("size", "is_all"), [(0.0, True), (1e-4, False)])
def test_a_cause_beside_which_much_is_left_only_looks_like_it(size, is_all, reference, caplog):
    """The trail is wrong, and one energy has an additional error that no motion causes."""
    mistake = next(m for m in MISTAKES if m.code == "trail_normal")
    columns = columns_of(reference, (mistake,))[2]
    scale = float(np.max(np.abs(columns["kinetic_energy"])))
    columns["kinetic_energy"] = columns["kinetic_energy"] + smooth_error(reference, 2, size * scale)
    report = score(Results("made.txt", "text", (rows(reference, 2, columns),), 16), reference)
    first = diagnosed(report, reference).diagnosis[0]
    assert first.evidence["mistakes"] == ["trail_normal"]
    assert first.evidence["is_all"] is is_all
    assert first.message.startswith("The nearest known cause: ") is not is_all
    assert ("Another error remains: kinetic_energy of maneuver 2" in first.message) is not is_all
