"""Estimation finds the fewest parameters that explain a file, and none if the errors are
numerical."""

import json
import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("heyoka")

from scipy.optimize import brentq

from generators.made_results import exact_columns, rows
from generators.mistaken_programs import correct, motion, results, results_of, with_changes
from generators.simulated_tables import right_program, simulated
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arrays, Multiprecision
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.programs.program import other_values
from heyoka_bike.scoring.diagnosis.ranking import _different
from heyoka_bike.scoring.diagnosis.residual.linear_fits import best_subsets, blocks, solve
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.system.resources import data_folder
from support.said import said_of

ARE_MET = "The motion in the file satisfies the equations of motion"
RNG = np.random.default_rng(5)


def made(changes, noise, count=80, many=12, unknowns=9):
    """Blocks of very different sizes. Their error is that of the changes, plus noise."""
    errors, jacobians = [], []
    for b in range(many):
        j = RNG.standard_normal((count, unknowns)) * 10.0 ** (b % 4)
        e = sum(j[:, u] * x for u, x in changes.items())
        errors.append(e + noise * 10.0 ** (b % 4) * RNG.standard_normal(count))
        jacobians.append(j)
    return blocks(errors, jacobians, [1e-14] * many)


@pytest.mark.proof
@pytest.mark.parametrize("changes", [{3: 0.5}, {1: -2.0, 7: 1e-2}, {0: 1.0, 4: 1.0, 8: -3.0}])
def test_the_right_subset_is_the_best(changes):
    b = made(changes, 1e-4)
    found = best_subsets(b, len(changes), 3)
    assert tuple(found.members[0]) == tuple(changes)
    # The fit averages the noise of 1e-4 over 12 blocks of 80 rows.
    assert found.changes[0] == pytest.approx(list(changes.values()), abs=3e-5)
    assert found.gains[0] > 30 * found.gains[1] or len(changes) == 2


@pytest.mark.proof
def test_gains_are_those_of_the_errors_themselves():
    """Compute the gains again, from the residuals of a weighted least-squares fit."""
    b_rows = [(RNG.standard_normal(50), RNG.standard_normal((50, 4))) for _ in range(5)]
    b = blocks([e for e, _ in b_rows], [j for _, j in b_rows], [1e-9] * 5)
    for members in combinations(range(4), 2):
        changes, gains = solve(b, np.array([members]))
        before = [np.sqrt(np.mean(e**2)) for e, _ in b_rows]
        after = [np.sqrt(np.mean((e - j[:, members] @ changes[0]) ** 2)) for e, j in b_rows]
        expected = np.exp(np.mean(np.log(np.array(before) / after)))
        assert gains[0] == pytest.approx(expected, rel=1e-9)
        # Any small step away from the fitted changes increases the sum of the logarithms of the
        # errors.
        for step in np.vstack([np.eye(2), -np.eye(2)]) * 1e-3:
            worse = [
                np.sqrt(np.mean((e - j[:, members] @ (changes[0] + step)) ** 2)) for e, j in b_rows
            ]
            assert np.sum(np.log(worse)) > np.sum(np.log(after))


@pytest.mark.proof
def test_unknowns_that_do_nothing_are_left_out():
    b = made({2: 1.0}, 1e-3)
    b.products[:, 5, :] = b.products[:, :, 5] = b.moments[:, 5] = 0.0
    for size in (1, 2, 3):
        assert 5 not in best_subsets(b, size, 20).members


@pytest.mark.proof
def test_two_unknowns_that_do_the_same_are_no_trouble():
    j = RNG.standard_normal((60, 1))
    b = blocks([2 * j[:, 0]], [np.hstack([j, j, RNG.standard_normal((60, 1))])], [1e-12])
    found = best_subsets(b, 2, 3)
    assert np.isfinite(found.changes).all()
    assert np.isfinite(found.gains).all()


def file_of(reference, parameters=None, starts=None, level=1e-5):
    """The file that SciPy makes with changed parameters (by symbol) and starts (by maneuver and
    name)."""
    program = correct(reference)
    bicycle = with_changes(program.motion.bicycle, parameters or {})
    columns = {}
    for number in reference:
        start = program.motion.starts[number]
        state = dict.fromkeys(("roll", "pitch", "steer", "roll_rate", "steer_rate"), 0.0)
        state |= {"roll_rate": start.roll_rate, "speed": start.speed}
        for name, change in (starts or {}).get(number, {}).items():
            state[name] += change
        found = motion(bicycle, tuple(state.values()), reference[number].time)
        columns[number] = {key: found[key] for key in BENCHMARK_COLUMNS}
    return results(reference, columns, level)


def fitted(reference, simulator, file):
    found = explain(align(file, reference).parts, reference, simulator=simulator)
    values = found.classes[0][0].found if found.classes else ()
    return found, {(x.name, x.maneuver): x for x in values}


@pytest.mark.parametrize(
    ("symbol", "change", "value"),
    [
        pytest.param("w", "-0.016", 1.004, marks=pytest.mark.proof),
        pytest.param("lam", "0.005", np.pi / 10 + 0.005, marks=pytest.mark.proof),
        pytest.param("IBxx", "0.5", 9.7, marks=pytest.mark.slow),
    ],
)
def test_one_parameter_is_found_with_its_value(reference, simulator, symbol, change, value):
    file = file_of(reference, {symbol: change})
    found, values = fitted(reference, simulator, file)
    assert list(values) == [(symbol, None)]
    got = values[symbol, None]
    assert abs(got.value - value) < 3 * got.uncertain
    # The fit reduces the error from a few tenths to 1e-5, so the fitted value is accurate.
    assert got.uncertain < 1e-3 * abs(value)
    said = said_of(found, score(file, reference))
    assert said[0].code == "parameters"
    assert f"({symbol})" in said[0].message
    assert said[0].evidence["changes"][0][0]["unknown"] == symbol


def partial(results, keys, every):
    """Maneuver 2 with only some columns and every `every`-th row."""
    m = results.maneuvers[1]
    values = {key: m.values[key][::every] for key in keys}
    time, lo = m.time[::every], m.time_lo[::every]
    return replace(results, maneuvers=(replace(m, time=time, time_lo=lo, values=values, lo={}),))


@pytest.mark.proof
@pytest.mark.parametrize(
    ("keys", "every"),
    [
        (("roll_angle", "steer_angle"), 10),
        (("roll_angle", "steer_angle", "forward_speed"), 1),
        (("roll_angle", "forward_speed", "kinetic_energy"), 5),
        (BENCHMARK_COLUMNS, 20),
    ],
)
@pytest.mark.parametrize(
    ("changes", "starts", "name", "value"),
    [
        ({"xB": "0.01"}, None, "xB", 0.31),
        (None, {2: {"steer": 0.003}}, "initial_steer", 0.003),
    ],
)
def test_values_are_found_where_the_equations_do_not_show_them(
    reference, simulator, keys, every, changes, starts, name, value
):
    file = partial(file_of(reference, changes, starts, level=1e-8), keys, every)
    _, values = fitted(reference, simulator, file)
    assert [n for n, _ in values] == [name]
    (found,) = values.values()
    assert found.value == pytest.approx(value, rel=1e-4)


def test_the_wheel_base_is_found_from_one_column_of_one_maneuver(reference, simulator):
    """To first order, four other parameters explain up to twice as much of the error of 8 %."""
    file = partial(file_of(reference, {"w": "0.01"}, level=1e-8), ("roll_rate",), 1)
    _, values = fitted(reference, simulator, file)
    assert list(values) == [("w", None)]
    assert values["w", None].value == pytest.approx(1.03, rel=1e-6)


@pytest.mark.proof
def test_whole_runs_tell_forces_apart_that_to_first_order_do_the_same(
    bicycle, reference, simulator
):
    """Wheel friction and air drag both reduce the speed and an energy, alike to first order."""
    keys = ("forward_speed", "mechanical_energy")
    program = right_program(bicycle, reference)
    made = simulated(simulator, program, keys, wheel_friction=0.005)
    table = {k: np.array([float(f"{x:.10g}") for x in made[k]])
             for k in ("time", *(f"{key}_3" for key in keys))}  # fmt: skip
    (found,) = diagnose(table, reference).diagnosis
    ((change,),) = found.evidence["changes"]
    assert change["unknown"] == "wheel_friction"
    assert change["value"] == pytest.approx(0.005, rel=1e-6)


@pytest.mark.proof
def test_a_value_that_is_nearly_a_mistake_of_the_library_is_told_by_whole_runs(
    bicycle, reference, simulator
):
    """The axial inertia equals the diametral one, so a falling wheel has no gyroscopic moment."""
    program = right_program(bicycle, reference)
    value = Bicycle(bicycle.name, {**bicycle.values, "IFyy": bicycle["IFxx"]})
    made = simulated(simulator, program.moving(bicycle=value), ("roll_angle", "steer_angle"))
    table = {k: made[k][:301] for k in ("time", "roll_angle_3", "steer_angle_3")}
    found = diagnose(table, reference).diagnosis[0]
    ((change,),) = found.evidence["changes"]
    assert (change["unknown"], change["value"]) == ("IFyy", pytest.approx(0.1405))


@pytest.mark.proof
def test_errors_of_a_correct_program_seen_in_two_columns_are_no_parameter(reference, simulator):
    """Another inertia of the rear wheel reduces these errors by a factor of 47, by chance."""
    file = read_results(data_folder() / "results" / "maximal-best.txt.gz")
    one = replace(file, maneuvers=file.maneuvers[:1] * 2)
    _, values = fitted(reference, simulator, partial(one, ("roll_angle", "steer_angle"), 5))
    assert values == {}


@pytest.mark.proof
def test_the_start_of_one_maneuver_is_found(reference, simulator):
    file = file_of(reference, starts={2: {"roll_rate": 0.05}})
    found, values = fitted(reference, simulator, file)
    assert list(values) == [("initial_roll_rate", 2)]
    assert values["initial_roll_rate", 2].value == pytest.approx(0.55, rel=1e-4)
    said = said_of(found, score(file, reference))
    assert "the initial roll rate of maneuver 2 is 0.55 " in said[0].message


@pytest.mark.parametrize("parameters", [{"xB": "0.01"}, {"IBxz": "-4.8"}])
def test_starts_are_found_beside_a_value_that_the_equations_show(reference, simulator, parameters):
    """More values are wrong than a search over all combinations would try."""
    starts = {n: {"roll": 0.01} for n in reference}
    file = file_of(reference, parameters, starts, level=1e-8)
    found, _ = fitted(reference, simulator, file)
    values = {(x.name, x.maneuver): x.value for m in found.classes[0][0].mistakes for x in m.found}
    rolls = {n: values.pop(("initial_roll", n)) for n in reference}
    assert rolls == pytest.approx(dict.fromkeys(reference, 0.01), rel=1e-3)
    assert values == pytest.approx({} if "IBxz" in parameters else {("xB", None): 0.31}, rel=1e-4)


@pytest.mark.proof
def test_a_steer_angle_at_the_start_brings_its_pitch(reference, simulator):
    """The pitch that puts both wheels on the floor is passed to the other integrator."""
    k = constants(correct(reference).motion.bicycle, Multiprecision(25)).convert(float)
    pitch = brentq(
        lambda x: front_contact_height(k, Arrays(), 0.0, x, 0.02), -0.01, 0.01, xtol=1e-15
    )
    assert abs(pitch) > 1e-6
    file = file_of(reference, starts={3: {"steer": 0.02, "pitch": pitch}})
    _, values = fitted(reference, simulator, file)
    assert list(values) == [("initial_steer", 3)]
    assert values["initial_steer", 3].value == pytest.approx(0.02, rel=1e-3)


@pytest.mark.proof
def test_two_parameters_of_very_different_effect_are_found(reference, simulator):
    _, values = fitted(reference, simulator, file_of(reference, {"w": "-0.016", "g": "-0.003"}))
    assert set(values) == {("w", None), ("g", None)}
    assert values["g", None].value == pytest.approx(9.807, abs=1.5e-4)


@pytest.mark.slow
def test_three_parameters_are_found(reference, simulator):
    changes = {"IBxz": "-0.4", "xB": "0.01", "IFyy": "0.02"}
    _, values = fitted(reference, simulator, file_of(reference, changes, level=1e-6))
    assert {name for name, _ in values} == set(changes)


@pytest.mark.proof
@pytest.mark.parametrize("name", ["exudyn-h0.01.txt", "scipy-rtol1e-4.txt"])
def test_errors_of_integrators_are_no_parameters(reference, simulator, name):
    file = read_results(data_folder() / "peers" / name)
    found, values = fitted(reference, simulator, file)
    assert values == {}
    assert found.causes.fitted == ()
    said = said_of(found, score(file, reference))
    (nothing,) = (f for f in said if f.code == "no_mistake_found")
    # The errors of the integrator may hide a wrong term, so the report must not state that the file
    # satisfies the equations.
    assert ARE_MET not in nothing.message


@pytest.mark.proof
def test_equations_that_are_met_show_that_nothing_is_changed(reference, simulator):
    m = reference[2]
    columns = exact_columns(m)
    columns["kinetic_energy"] += 3.0 * m.time * np.sin(3.0 * m.time)
    file = Results("made.txt", "text", (rows(reference, 2, columns),), 16)
    found, values = fitted(reference, simulator, file)
    assert values == {}
    said = said_of(found, score(file, reference))
    (nothing,) = (f for f in said if f.code == "no_mistake_found")
    assert ARE_MET in nothing.message


@pytest.mark.proof
def test_a_mistake_of_the_library_is_not_called_a_parameter(reference, simulator):
    found, values = fitted(reference, simulator, file_of(reference, {"g": "-0.00335"}))
    assert found.classes[0][0].codes == ("gravity_9.80665",)
    assert values == {}


NO_HEYOKA = """
import sys
sys.modules |= dict.fromkeys(("heyoka", "llvmlite", "scipy"))
from heyoka_bike.cli import main
sys.exit(main(["diagnose", sys.argv[1], "--format", "json"]))
"""


def without_heyoka(parts, tmp_path, rows=None):
    """Findings on a file of the first `rows` rows, by code, in a process without heyoka."""
    table = [parts[0].time, *(p.values[key] for p in parts for key in BENCHMARK_COLUMNS)]
    np.savetxt(tmp_path / "file.txt", np.array(table).T[:rows], "%.17g")
    command = [sys.executable, "-c", NO_HEYOKA, str(tmp_path / "file.txt")]
    run = subprocess.run(command, capture_output=True, text=True, check=True, timeout=600)
    assert run.stderr == ""
    return {f["code"]: f for f in json.loads(run.stdout)["findings"]}


@pytest.mark.slow
def test_without_heyoka_parameters_are_found(reference, tmp_path):
    file = file_of(reference, {"mB": "0.05"}, level=1e-7)
    found = without_heyoka(file.maneuvers, tmp_path)
    (change,) = found["parameters"]["evidence"]["changes"][0]
    assert change["unknown"] == "mB"
    assert change["value"] == pytest.approx(85.05, abs=1e-5)


@pytest.mark.proof
def test_without_heyoka_mistakes_of_the_model_are_found(reference, tmp_path):
    made = {m.code: m for m in MISTAKES}["trail_normal"]
    # Only one maneuver is used, because each additional one takes as much time as this one.
    found = without_heyoka(results_of(reference, [made], 1e-6).maneuvers[1:2], tmp_path, 201)
    assert found["mistake"]["evidence"]["mistakes"] == ["trail_normal"]


@pytest.mark.slow
def test_without_heyoka_mistakes_of_the_output_are_found(reference, tmp_path):
    late = {m.code: m for m in MISTAKES}["one_step_late"]
    found = without_heyoka(results_of(reference, [late], 1e-6).maneuvers, tmp_path)
    assert found["mistake"]["evidence"]["mistakes"] == ["one_step_late"]


def test_a_usual_mistake_is_not_repeated_as_a_fitted_value(reference):
    program = correct(reference)
    (gravity,) = (m for m in MISTAKES if m.code == "gravity_9.8")
    fitted, another = (
        other_values({name: x}, {name: 0.0}, program) for name, x in (("g", -0.01), ("mB", 1.0))
    )
    classes = [(Hypothesis((m,), {}, {}, ()),) for m in (gravity, fitted, another)]
    kept = _different(SimpleNamespace(program=program), classes)
    assert kept == (classes[0], classes[2])
