"""Numerical causes are told apart: order of the step, damping, noise, contact, interpolation."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from support.fixed_steps import SPACING, Equations
from support.made_results import codes, made, smooth_error

from heyoka_bike.scoring.diagnosis.numerical import variation
from heyoka_bike.scoring.diagnosis.numerical.body_coordinates import BodyCoordinates
from heyoka_bike.scoring.diagnosis.numerical.causes import findings
from heyoka_bike.scoring.diagnosis.numerical.elementary import differentials
from heyoka_bike.scoring.diagnosis.numerical.height import Heights
from heyoka_bike.scoring.diagnosis.numerical.variation import NAMES, Variations
from heyoka_bike.scoring.reading import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.system.resources import data_folder

pytestmark = pytest.mark.proof

PEERS = data_folder() / "peers"
ANGLES = ("roll_angle", "steer_angle")
RATES = ("roll_rate", "steer_rate")


@pytest.fixture(scope="module")
def equations(reference):
    return Equations(reference)


@pytest.fixture(scope="module")
def motion(reference):
    return Variations(reference)


def told(results, reference):
    return findings(score(results, reference), reference)


def names(found):
    return [f.code for f in found]


def order(found):
    return next((f.evidence["order"] for f in found if f.code == "step_size_error"), None)


def with_errors(reference, level, more):
    """The reference with a smooth error, and more of another kind."""

    def change(key, values, number):
        scale = np.max(np.abs(reference[number].rows[key]))
        return values + smooth_error(reference, number, level * scale) + more(key, values, number)

    return made(reference, change)


@pytest.mark.parametrize("h", [0.01, 0.0025])
@pytest.mark.parametrize(
    ("name", "expected"),
    [("euler", 1), ("heun", 2), ("midpoint", 2), ("kutta3", 3), ("ssp3", 3), ("rk4", 4),
     ("three_eighths", 4)],
)  # fmt: skip
def test_the_order_of_runge_kutta_methods_is_told(equations, reference, name, expected, h):
    assert order(told(equations.run(equations.explicit(name), h), reference)) == expected


@pytest.mark.parametrize("h", [0.01, 0.0025])
@pytest.mark.parametrize(
    ("name", "expected"),
    [("trapezoidal", 2), ("implicit Euler", 1), ("BDF2", 2), ("AB2", 2)],
)
def test_the_order_of_other_methods_is_told(equations, reference, name, expected, h):
    step = {
        "trapezoidal": equations.implicit(0.5),
        "implicit Euler": equations.implicit(1.0),
        "BDF2": equations.bdf2,
        "AB2": equations.adams_bashforth2,
    }[name]
    assert order(told(equations.run(step, h), reference)) == expected


@pytest.mark.parametrize("h", [0.01, 0.0025])
def test_the_order_of_the_symplectic_euler_method_is_told(reference, h):
    equations = Equations(reference, is_regular=True)
    found = told(equations.run(equations.symplectic_euler, h), reference)
    assert order(found) == 1
    assert "symplectic" in found[0].evidence["method"]


@pytest.mark.parametrize("step", ["0.01", "0.001"])
def test_the_order_of_a_multibody_program_is_told(reference, step):
    found = told(read_results(PEERS / f"exudyn-h{step}.txt"), reference)
    assert order(found) == 2
    assert found[0].evidence["method"] == "multibody"


def test_the_step_for_a_wanted_accuracy_is_right(equations, reference):
    """A step that much smaller gives that accuracy, within the next order."""
    coarse = told(equations.run(equations.implicit(0.5), 0.01), reference)[0].evidence
    fine = told(equations.run(equations.implicit(0.5), 0.0025), reference)[0].evidence
    assert coarse["max_rel_error"] / coarse["step_ratio"] ** 2 == pytest.approx(1e-6)
    assert coarse["step_ratio"] / fine["step_ratio"] == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "BDF", "LSODA"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-7])
def test_no_order_is_claimed_of_steps_chosen_by_a_tolerance(equations, reference, method, rtol):
    time = SPACING * np.arange(1001)
    states = [
        solve_ivp(lambda _, y: equations.slope(y), (0.0, 10.0), start, method,
                  t_eval=time, rtol=rtol, atol=rtol / 100).y
        for start in equations.start.T
    ]  # fmt: skip
    found = told(equations.results(np.stack(states, axis=1)), reference)
    assert order(found) is None
    assert "steps_of_varying_size" in names(found)


def test_the_shipped_runs_of_scipy_tell_no_order(reference):
    for tolerance in ("1e-4", "1e-7", "1e-10"):
        found = told(read_results(PEERS / f"scipy-rtol{tolerance}.txt"), reference)
        assert names(found) == ["steps_of_varying_size"]


@pytest.mark.parametrize("level", [1e-8, 1e-3])
def test_a_smooth_error_of_no_method_is_called_smooth(reference, level):
    found = told(with_errors(reference, level, lambda *_: 0.0), reference)
    assert names(found) == ["smooth_error"]


@pytest.mark.parametrize("rate", [1e-7, 1e-5])
@pytest.mark.parametrize(("sign", "code"), [(-1, "numerical_damping"), (1, "energy_grows")])
def test_energy_that_falls_or_grows_in_every_maneuver_is_told(reference, rate, sign, code):
    def changed(key, values, number):
        lost = {"kinetic_energy": rate, "mechanical_energy": rate}.get(key, 0.0)
        return sign * lost * reference[number].time * values

    assert names(told(with_errors(reference, 0.0, changed), reference)) == [code]


def test_energy_that_falls_in_one_maneuver_only_is_not_damping(reference):
    def changed(key, values, number):
        lost = 1e-6 if number == 2 and key in ("kinetic_energy", "mechanical_energy") else 0.0
        return -lost * reference[number].time * values

    assert names(told(with_errors(reference, 0.0, changed), reference)) == ["smooth_error"]


@pytest.mark.parametrize("level", [1e-8, 1e-5])
def test_noise_is_told_from_smooth_errors(reference, level):
    random = np.random.default_rng(1)

    def noise(key, values, number):
        return level * np.max(np.abs(values)) * random.standard_normal(len(values))

    assert names(told(with_errors(reference, level / 10, noise), reference)) == ["rough_error"]


@pytest.mark.parametrize("level", [1e-6, 1e-4])
def test_noise_of_velocities_is_that_of_iterations(reference, level):
    """Angles have its integral, a hundredth of it from row to row."""
    random = np.random.default_rng(2)
    noise = {(n, kind): random.standard_normal(1001) for n in reference for kind in ANGLES}

    def added(key, values, number):
        kind = key.replace("rate", "angle")
        if key in RATES:
            return level / 10 * np.max(np.abs(values)) * noise[number, kind]
        if key in ANGLES:
            rate = np.max(np.abs(reference[number].rows[key.replace("angle", "rate")]))
            return level / 10 * rate * SPACING * np.cumsum(noise[number, kind])
        return 0.0

    assert names(told(with_errors(reference, level, added), reference)) == ["iteration_noise"]


@pytest.mark.parametrize("level", [1e-6, 1e-4])
def test_velocities_that_alternate_ring(reference, level):
    def added(key, values, number):
        alternating = (-1.0) ** np.arange(len(values))
        return level / 10 * np.max(np.abs(values)) * alternating if key in RATES else 0.0

    assert names(told(with_errors(reference, level, added), reference)) == ["step_ringing"]


def test_the_ringing_of_the_shipped_coarse_run_is_seen(reference):
    """Its steer rate alternates visibly in maneuver 3: see the last rows of the file."""
    rate = np.loadtxt(PEERS / "exudyn-h0.01.txt")[-200:, 24]
    error = rate - reference[3].rows["steer_rate"][-200:]
    differences = np.diff(error, 4)
    assert np.mean(differences[1:] * differences[:-1] < 0) > 0.9
    found = told(read_results(PEERS / "exudyn-h0.01.txt"), reference)
    assert "step_ringing" in names(found)


@pytest.mark.parametrize(("rows", "degree"), [(4, 1), (10, 1), (4, 3), (6, 3)])
def test_rows_interpolated_between_steps_are_told(reference, rows, degree):
    def between(key, values, number):
        m = reference[number]
        knots = m.time[::rows]
        if degree == 1:
            return np.interp(m.time, knots, values[::rows]) - values
        rates = CubicSpline(m.time, values).derivative()(knots)
        return CubicHermiteSpline(knots, values[::rows], rates)(m.time) - values

    found = told(with_errors(reference, 1e-6, between), reference)
    (finding,) = [f for f in found if f.code == "interpolated_output"]
    assert (finding.evidence["rows"], finding.evidence["first"]) == (rows, 0)
    assert finding.evidence["degree"] == degree


@pytest.mark.parametrize("depth", [1e-5, 1e-3])
def test_wheels_that_sink_in_are_told(reference, depth):
    weight = Heights(reference).weight

    def sunk(key, values, number):
        settled = 1.0 - np.exp(-reference[number].time / 0.1)
        return -depth * weight * settled if key in ("potential_energy", "mechanical_energy") else 0

    (finding,) = told(with_errors(reference, 0.0, sunk), reference)
    assert finding.code == "wheels_sink_in"
    assert finding.evidence["height"] == pytest.approx([-depth] * 3, rel=0.01)


@pytest.mark.parametrize("height", [1e-6, 1e-4])
def test_a_height_that_drifts_is_told(reference, height):
    weight = Heights(reference).weight

    def drifted(key, values, number):
        return height * weight * (reference[number].time / 10) ** 2 * (key == "potential_energy")

    found = told(with_errors(reference, 0.0, drifted), reference)
    assert names(found) == ["height_drifts"]
    assert found[0].evidence["height"] == pytest.approx([height] * 3, rel=0.01)


@pytest.mark.parametrize("part", [1e-6, 1e-3])
def test_a_wrong_weight_is_no_drift_and_no_sinking(reference, part):
    def heavier(key, values, number):
        return part * values if key == "potential_energy" else 0.0

    found = told(with_errors(reference, 0.0, heavier), reference)
    assert not {"height_drifts", "wheels_sink_in"} & set(names(found))


@pytest.mark.parametrize("level", [1e-6, 1e-4])
def test_an_error_of_the_angles_is_no_height(reference, level):
    """Roll and steer are wrong, and the potential energy goes with them."""
    heights = Heights(reference)

    def change(key, values, number):
        m = reference[number]
        if key not in (*ANGLES, "potential_energy"):
            return values
        wrong = {a: m.rows[a] + smooth_error(reference, number, level) for a in ANGLES}
        if key in ANGLES:
            return wrong[key]
        return heights._potential(wrong["roll_angle"], wrong["steer_angle"], m.rows["pitch"])

    found = told(made(reference, change), reference)
    assert not {"height_drifts", "wheels_sink_in"} & set(names(found))


def test_the_reference_stands_on_the_floor(reference):
    heights = Heights(reference)
    for m in score(made(reference), reference).maneuvers:
        _, height, floor = heights.of(m)
        assert np.max(np.abs(height)) < 10 * floor < 1e-13


@pytest.mark.parametrize("level", [1e-8, 1e-4])
def test_single_precision_numbers_are_told(reference, level):
    def change(key, values, number):
        scale = np.max(np.abs(values))
        wrong = values + smooth_error(reference, number, level * scale)
        return wrong.astype(np.float32).astype(np.float64)

    assert "single_precision" in names(told(made(reference, change), reference))


def test_few_digits_are_not_single_precision(reference):
    def change(key, values, number):
        return np.array([float(f"{x:.6g}") for x in values])

    results = replace(made(reference, change), significant_digits=6)
    assert "single_precision" not in names(told(results, reference))


def test_one_maneuver_alone_tells_no_order(equations, reference):
    results = equations.run(equations.explicit("rk4"), 0.01)
    alone = replace(results, maneuvers=results.maneuvers[:1])
    assert order(told(alone, reference)) is None


def test_there_are_as_many_differentials_as_rooted_trees(motion):
    """1, 1, 2, 4, 9: Cayley 1857; the sums with equal weights are derivatives of the motion."""
    for nodes, count in enumerate([1, 1, 2, 4, 9], start=1):
        assert len(differentials(motion.slope, motion.states, nodes)) == count
    time = np.linspace(0.0, 10.0, 1001)
    second = np.gradient(motion.slope(motion.states), time, axis=-1)[..., 5:-5]
    (found,) = differentials(motion.slope, motion.states, 2)
    assert np.max(np.abs(found[..., 5:-5] - second)) < 2e-2 * np.max(np.abs(second))


def test_the_outputs_of_the_motion_are_the_reference(motion, reference):
    found = motion.outputs(motion.states)
    for i, number in enumerate(reference):
        for j, name in enumerate(NAMES):
            exact = reference[number].rows[name]
            assert np.max(np.abs(found[j, i] - exact)) < 1e-12 * max(1.0, np.max(np.abs(exact)))


def test_the_bodies_have_the_kinetic_energy_of_the_reference(motion, reference):
    bodies = BodyCoordinates(motion)
    speeds = motion.states[list(variation.VELOCITIES)]
    energy = np.einsum("amn,mnab,bmn->mn", speeds, bodies._mass, speeds) / 2
    for i, number in enumerate(reference):
        exact = reference[number].rows["kinetic_energy"]
        assert np.max(np.abs(energy[i] - exact)) < 1e-11 * np.max(exact)


def test_codes_of_clean_files_are_only_those_of_score(reference):
    assert "step_size_error" not in codes(score(made(reference), reference))
