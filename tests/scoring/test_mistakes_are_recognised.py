"""Files with known mistakes, made by another integrator, are explained by these mistakes."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.correct_programs import METHODS, SOLVERS, STEPS, TOLERANCES, adaptive, fixed_step
from generators.fixed_steps import Equations
from generators.linear_programs import linear_runs
from generators.made_results import made, smooth_error
from generators.mistaken_programs import columns_of, motion, numbers, results, results_of
from generators.random_pairs import LEVEL, random_pairs
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.exact import ZERO
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.system.resources import data_folder
from recognised_table import HYPOTHESES, READ_OFF_THE_FILE, committed, is_right, table
from support.said import said_of

BY_CODE = {m.code: m for m in MISTAKES}
# One mistake of each kind. All mistakes are tried with `-m slow`. Late rows are covered in
# `test_score_diagnoses`.
SOME = ("inertia_B_from_hub", "roll_without_wheels", "maneuver_2_as_1_1_as_2")
# The crude methods whose errors most resemble a mistake, and the maneuvers that show these errors.
CLOSEST = (
    pytest.param("semi-implicit Euler", 0.01, (1, 2, 3), marks=pytest.mark.proof),
    pytest.param("implicit Euler", 0.01, (1,), marks=pytest.mark.proof),
    pytest.param("semi-implicit Euler", 0.01, (1,), marks=pytest.mark.slow),
    pytest.param("explicit Euler", 0.01, (2,), marks=pytest.mark.slow),
)
PAIRS = 60


@pytest.fixture(scope="module")
def equations(reference):
    return Equations(reference, is_regular=True)


def first(diagnosis):
    return {h.codes for h in diagnosis.classes[0]} if diagnosis.classes else set()


def named(diagnosis):
    """The set of codes of each hypothesis in the first three classes."""
    return [set(h.codes) for c in diagnosis.classes[:3] for h in c]


@pytest.mark.proof
def test_codes_are_unique_and_every_mistake_says_what_to_check():
    assert len(BY_CODE) == len(MISTAKES)
    for m in MISTAKES:
        assert m.says
        assert m.check
        assert m.kind in ("model", "start", "output")


@pytest.mark.proof
@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_simulator_agrees_with_the_reference(reference, bicycle, simulator, number):
    m = reference[number]
    speed, rate = (float(Fraction(m.inputs[key])) for key in ("speed", "roll_rate"))
    found = simulator.run(bicycle, (0.0, 0.0, 0.0, rate, 0.0, speed), m.time)
    for name in m.columns:
        # The run takes 50 to 150 steps, each with an error of 1e-14. Columns that are nearly zero
        # have the error of the whole state.
        scale = max(np.max(np.abs(m.rows[name])), 1e-2)
        assert np.max(np.abs(found[name] - m.rows[name])) < 1e-12 * scale


@pytest.mark.proof
def test_the_parts_of_the_energies_agree_with_euler_angles(bicycle, simulator):
    time = np.linspace(0.0, 10.0, 101)
    start = (0.0, 0.0, 0.0, 0.5, 0.0, 4.6)
    found, expected = simulator.run(bicycle, start, time), motion(bicycle, start, time)
    of_bodies = [f"{kind}_energy_of_{b}" for kind in ("kinetic", "potential") for b in "RBHF"]
    for name in ("spin_energy", "rotation_energy", *of_bodies):
        # The tolerance allows for a different integrator.
        assert found[name] == pytest.approx(expected[name], rel=1e-9)
    wheels = sum(float(bicycle[f"I{w}yy"].rational) * (4.6 / r) ** 2 for w, r in
                 (("R", 0.3), ("F", 0.35)))  # fmt: skip
    assert found["spin_energy"][0] == pytest.approx(wheels / 2, rel=1e-13)
    rolling = sum(float(bicycle[f"I{b}xx"].rational) for b in "RBHF") * 0.5**2
    assert found["rotation_energy"][0] == pytest.approx((wheels + rolling) / 2, rel=1e-13)


@pytest.mark.proof
def test_a_bicycle_without_mass_has_no_motion(bicycle, simulator):
    values = {s: ZERO if s[0] in "mI" else x for s, x in bicycle.values.items()}
    nothing = replace(bicycle, values=values)
    with pytest.raises(ZeroDivisionError):
        numbers(nothing)
    found = simulator.run(nothing, (0.0, 0.0, 0.0, 0.5, 0.0, 4.6), np.array([0.0, 1.0]))
    assert all(np.isnan(v).all() for v in found.values())


@pytest.mark.proof
def test_a_motion_that_ends_is_followed_to_its_end(reference, simulator):
    """Without the front wheel's spin inertia, maneuver 2 reaches a singularity."""
    made = results_of(reference, [BY_CODE["exchanged_F"]])
    ended = tuple(rows for rows in made.maneuvers if len(rows.time) < 1001)
    assert 2 in [rows.maneuver for rows in ended]
    found = explain(
        align(replace(made, maneuvers=ended), reference).parts, reference, simulator=simulator
    )
    assert ("exchanged_F",) in first(found)


@pytest.mark.proof
@pytest.mark.parametrize("code", SOME)
def test_a_mistake_is_named_first(reference, simulator, code):
    results = results_of(reference, [BY_CODE[code]], 1e-6)
    found = explain(align(results, reference).parts, reference, simulator=simulator)
    assert (code,) in first(found)
    (finding, *_) = said_of(found, score(results, reference))
    assert finding.code == "mistake"
    assert finding.evidence["mistakes"] == [code]
    assert BY_CODE[code].check in finding.message


@pytest.mark.proof
def test_a_time_scale_is_named_first_with_its_factor(reference, simulator):
    mistake = READ_OFF_THE_FILE[-1]
    results = results_of(reference, [mistake], 1e-6)
    found = explain(align(results, reference).parts, reference, simulator=simulator)
    assert (mistake.code,) in first(found)
    told = found.classes[0][0].mistakes[0].says
    # The number 0.990099 is 1 / 1.01, to the digits that remain with an error of 1e-6.
    assert "0.990099" in told


@pytest.mark.proof
def test_columns_in_another_order_are_found_beside_another_mistake(reference, simulator):
    pair = [BY_CODE["trail_shortened"], READ_OFF_THE_FILE[-2]]
    columns = columns_of(reference, pair)
    file = align(results(reference, {2: columns[2]}, 1e-6), reference).parts
    found = explain(file, reference, simulator=simulator)
    assert {m.code for m in pair} in [set(codes) for codes in first(found)]


@pytest.mark.proof
@pytest.mark.parametrize("code", ["sign_IHxz", "maneuver_1_as_2", "half_step_late"])
def test_one_maneuver_alone_is_enough(reference, simulator, code):
    columns = columns_of(reference, [BY_CODE[code]])
    file = align(results(reference, {2: columns[2]}, 1e-6), reference).parts
    found = explain(file, reference, simulator=simulator)
    assert (code,) in first(found)


@pytest.mark.proof
def test_columns_and_values_may_be_missing(reference, simulator):
    columns = columns_of(reference, [BY_CODE["sign_IBxz"]])
    few = {n: {k: columns[n][k] for k in ("roll_angle", "steer_rate")} for n in (1, 3)}
    few[1]["steer_rate"] = np.full_like(few[1]["steer_rate"], np.nan)
    few[3]["roll_angle"][::3] = np.nan
    made = results(reference, few, 1e-6)
    found = explain(align(made, reference).parts, reference, simulator=simulator)
    assert ("sign_IBxz",) in first(found)


@pytest.mark.proof
def test_two_mistakes_are_found_together(reference, simulator):
    pair = [BY_CODE["sign_IBxz"], BY_CODE["gravity_9.80665"]]
    found = explain(
        align(results_of(reference, pair, 1e-6), reference).parts, reference, simulator=simulator
    )
    assert {"sign_IBxz", "gravity_9.80665"} in [set(codes) for codes in first(found)]


@pytest.mark.proof
def test_two_mistakes_of_the_model_are_found_by_what_remains(reference, simulator):
    pair = ("no_IBxz", "exchanged_R")
    file = align(results_of(reference, [BY_CODE[c] for c in pair], 1e-6), reference).parts
    found = explain(file, reference, simulator=simulator)
    assert first(found) == {pair}
    assert tuple(m.code for m in found.causes.known[0].mistakes) == pair


@pytest.mark.proof
@pytest.mark.parametrize("level", [1e-8, 1e-3])
def test_a_correct_program_is_not_accused(reference, simulator, level):
    def change(key, values, number):
        scale = np.max(np.abs(reference[number].rows[key]))
        return values + smooth_error(reference, number, level * scale)

    results = made(reference, change)
    found = explain(align(results, reference).parts, reference, simulator=simulator)
    assert found.classes == ()
    assert found.causes.fitted == ()
    said = [f.code for f in said_of(found, score(results, reference))]
    # These columns do not belong to any motion. So the report states their residual, but names no
    # cause.
    assert "no_mistake_found" in said


@pytest.mark.parametrize(("method", "step", "shown"), CLOSEST)
def test_errors_of_crude_methods_are_no_mistake(
    reference, equations, simulator, method, step, shown
):
    run = fixed_step(equations, method, step)
    run = replace(run, maneuvers=tuple(rows for rows in run.maneuvers if rows.maneuver in shown))
    found = explain(align(run, reference).parts, reference, simulator=simulator)
    # At most the method itself explains the file.
    causes = [m for of in found.classes for h in of for m in h.mistakes]
    assert all(m.says.startswith(method) for m in causes)
    assert found.causes.fitted == ()


@pytest.mark.proof
def test_the_reference_needs_no_explanation(reference):
    found = diagnose(made(reference), reference)
    assert [f.code for f in found.diagnosis] == ["nothing_to_explain"]


def test_the_page_has_every_mistake():
    codes = [m.code for m in HYPOTHESES]
    assert [*committed()] == codes, (
        "docs/reference/mistakes.md lacks a mistake or has one too many: run "
        "`python docs/_site/recognised_table.py --new`"
    )


@pytest.mark.slow
def test_the_table_of_the_page_is_what_comes_out(reference):
    """The run takes half an hour."""
    said, _, _ = table(reference)
    assert {c: {k: is_right(x) for k, x in s.items()} for c, s in said.items()} == {
        c: {k: is_right(x) for k, x in s.items()} for c, s in committed().items()
    }
    for level, least in (("none", 0.95), ("1e-6", 0.95), ("1e-4", 0.85)):
        visible = [s[level] for s in said.values() if not s[level].startswith("not visible")]
        assert np.mean([is_right(x) for x in visible]) >= least


@pytest.mark.slow
def test_random_pairs_are_found(reference, simulator):
    missed = []
    for codes, columns in random_pairs(reference, PAIRS):
        file = align(results(reference, columns, LEVEL), reference).parts
        found = named(explain(file, reference, simulator=simulator))
        if set(codes) not in found and not set(codes) <= set().union(*found):
            missed.append(codes)
    print(len(missed), missed)
    assert len(missed) <= 0.2 * PAIRS


def of_the_benchmark(results):
    """Remove the columns that a diagnosis does not use."""
    kept = [{k: v for k, v in rows.values.items() if k in BENCHMARK_COLUMNS}
            for rows in results.maneuvers]  # fmt: skip
    parts = zip(results.maneuvers, kept, strict=True)
    filled = tuple(replace(rows, values=values) for rows, values in parts if values)
    return replace(results, maneuvers=filled)


def correct_runs(equations):
    for solver in SOLVERS:
        for tolerance in TOLERANCES:
            yield f"{solver} {tolerance}", adaptive(equations, solver, tolerance)
    for method in METHODS:
        for step in STEPS:
            yield f"{method} {step}", fixed_step(equations, method, step)
    for file in sorted((data_folder() / "peers").glob("*.txt")):
        run = of_the_benchmark(read_results(file))
        if run.maneuvers:
            yield file.name, run


def accused(name, run, reference, simulator, allowed):
    """The mistakes or parameters that are named, in all maneuvers together and in each alone."""
    for file in (run, *(replace(run, maneuvers=(rows,)) for rows in run.maneuvers)):
        found = explain(align(file, reference).parts, reference, simulator=simulator)
        said = {f.code for f in said_of(found, score(file, reference))}
        if said & {"mistake", "parameters", "linearised"} - allowed:
            yield name, [r.maneuver for r in file.maneuvers], first(found)


@pytest.mark.slow
def test_correct_programs_are_not_accused(reference, equations, simulator):
    runs = correct_runs(equations)
    assert not [a for name, run in runs for a in accused(name, run, reference, simulator, set())]


@pytest.mark.slow
def test_correct_linear_programs_are_not_accused(reference, simulator):
    for name, run in linear_runs(reference):
        assert not list(accused(name, run, reference, simulator, {"linearised"}))
