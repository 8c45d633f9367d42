"""Files of programs with known mistakes, made by another integrator, are explained by them."""

import json
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from made_results import made, smooth_error
from mistaken_programs import results_of

from heyoka_bike.alignment import align
from heyoka_bike.diagnosis import diagnose
from heyoka_bike.diagnosis_words import findings
from heyoka_bike.mistakes import MISTAKES
from heyoka_bike.reading import read_results
from heyoka_bike.resources import data_folder
from heyoka_bike.scoring import score
from heyoka_bike.simulator import Simulator

BY_CODE = {m.code: m for m in MISTAKES}
# A motion mirrored is the same motion with roll and steer turned round: a sign, no mistake.
MIRRORED = {"roll_rate_sign"}
# Moves no column by more than 1e-11 of its scale.
INVISIBLE = {"printed_p2"}
LEVELS = (0.0, 1e-6, 1e-4)
SOME = ("sign_IHxz", "roll_without_wheels", "one_step_late", "forward_differences")


@pytest.fixture(scope="module")
def simulator():
    return Simulator()


def first(diagnosis):
    return {h.codes for h in diagnosis.classes[0]} if diagnosis.classes else set()


def test_codes_are_unique_and_every_mistake_says_what_to_check():
    assert len(BY_CODE) == len(MISTAKES)
    for m in MISTAKES:
        assert m.says
        assert m.check
        assert m.kind in ("model", "start", "output")


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_simulator_agrees_with_the_reference(reference, bicycle, simulator, number):
    m = reference[number]
    speed, rate = (float(Fraction(m.inputs[key])) for key in ("speed", "roll_rate"))
    found = simulator.run(bicycle, (0.0, 0.0, 0.0, rate, 0.0, speed), m.time)
    for name in m.columns:
        # 50 to 150 steps of 1e-14 each; columns that nearly vanish have the error of the state.
        scale = max(np.max(np.abs(m.rows[name])), 1e-2)
        assert np.max(np.abs(found[name] - m.rows[name])) < 1e-12 * scale


def test_a_motion_that_ends_is_followed_to_its_end(reference, simulator):
    """Without the front wheel's spin inertia maneuver 2 meets a singularity."""
    results = results_of(reference, [BY_CODE["exchanged_F"]])
    ends = [len(rows.time) for rows in results.maneuvers]
    assert min(ends) < 1001
    found = diagnose(align(results, reference), reference, simulator=simulator)
    assert ("exchanged_F",) in first(found)


@pytest.mark.parametrize("code", SOME)
def test_a_mistake_is_named_first(reference, simulator, code):
    results = results_of(reference, [BY_CODE[code]], 1e-6)
    found = diagnose(align(results, reference), reference, simulator=simulator)
    assert (code,) in first(found)
    (finding, *_) = findings(found, score(results, reference))
    assert finding.code == "mistake"
    assert finding.evidence["mistakes"] == [code]
    assert BY_CODE[code].check in finding.message


def test_two_mistakes_are_found_together(reference, simulator):
    pair = [BY_CODE["sign_IBxz"], BY_CODE["gravity_9.80665"]]
    found = diagnose(
        align(results_of(reference, pair, 1e-6), reference), reference, simulator=simulator
    )
    assert {"sign_IBxz", "gravity_9.80665"} in [set(codes) for codes in first(found)]


@pytest.mark.parametrize("level", [1e-8, 1e-3])
def test_a_correct_program_is_not_accused(reference, simulator, level):
    def change(key, values, number):
        scale = np.max(np.abs(reference[number].rows[key]))
        return values + smooth_error(reference, number, level * scale)

    results = made(reference, change)
    found = diagnose(align(results, reference), reference, simulator=simulator)
    assert found.classes == ()
    codes = [f.code for f in findings(found, score(results, reference))]
    assert codes == ["no_mistake_found", "smooth_error"]


def test_noise_and_damping_are_told_from_smooth_errors(reference, simulator):
    random = np.random.default_rng(1)

    def noisy(key, values, number):
        return values + 1e-7 * np.max(np.abs(values)) * random.standard_normal(len(values))

    def damped(key, values, number):
        t = reference[number].time
        lost = {"kinetic_energy": 1e-5, "mechanical_energy": 1e-5}.get(key, 0.0)
        return values * (1 - lost * t)

    for change, code in ((noisy, "rough_error"), (damped, "numerical_damping")):
        results = made(reference, change)
        found = diagnose(align(results, reference), reference, simulator=simulator)
        assert [f.code for f in findings(found, score(results, reference))][1] == code


def test_the_reference_needs_no_explanation(reference, simulator):
    results = made(reference)
    found = diagnose(align(results, reference), reference, simulator=simulator)
    assert [f.code for f in findings(found, score(results, reference))] == ["nothing_to_explain"]


def test_the_command_answers_in_words_and_json(tmp_path, reference):
    table = np.loadtxt(data_folder() / "peers" / "scipy-rtol1e-10.txt")
    table[1:, 1:] = table[:-1, 1:]
    file = tmp_path / "late.txt"
    np.savetxt(file, table, "%.17g")
    command = [sys.executable, "-m", "heyoka_bike", "diagnose", str(file)]
    told = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    assert "Each row is written one step late" in told.stdout
    assert told.stderr == ""
    text = subprocess.run([*command, "--format", "json"], capture_output=True, text=True,
                          check=True, timeout=300).stdout  # fmt: skip
    first_mistake = next(f for f in json.loads(text)["findings"] if f["code"] == "mistake")
    assert first_mistake["evidence"]["mistakes"] == ["one_step_late"]


def test_without_heyoka_it_says_so():
    code = """
import sys
sys.modules["heyoka"] = None
from heyoka_bike.cli import main
from heyoka_bike.resources import data_folder
sys.exit(main(["diagnose", str(data_folder() / "peers" / "scipy-rtol1e-4.txt")]))
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert run.returncode == 1
    assert run.stderr.count("\n") == 1
    assert "heyoka" in run.stderr


@pytest.mark.slow
@pytest.mark.parametrize("level", LEVELS)
def test_nearly_every_mistake_is_named_first(reference, simulator, level):
    right, wrong = [], []
    for mistake in MISTAKES:
        if mistake.code in MIRRORED | INVISIBLE:
            continue
        results = results_of(reference, [mistake], level)
        found = diagnose(align(results, reference), reference, simulator=simulator)
        (right if (mistake.code,) in first(found) else wrong).append(mistake.code)
    print(level, len(right), wrong)
    assert len(right) >= (0.95 if level < 1e-5 else 0.85) * (len(right) + len(wrong)), wrong


@pytest.mark.slow
def test_runs_of_other_programs_are_not_accused(reference, simulator):
    for file in sorted((data_folder() / "peers").glob("*.txt")):
        found = diagnose(align(read_results(file), reference), reference, simulator=simulator)
        assert found.classes == (), file.name
