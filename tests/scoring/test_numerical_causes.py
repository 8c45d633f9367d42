"""Numerical causes are distinguished: wide steps, numerical damping, noise, interpolation."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.fixed_steps import SPACING, Equations
from generators.made_results import codes, made, smooth_error
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.numerical import causes
from heyoka_bike.scoring.reading.results import Quantum
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.showing.wording import finding_text
from heyoka_bike.system.resources import data_folder

pytestmark = pytest.mark.proof

PEERS = data_folder() / "peers"
ANGLES = ("roll_angle", "steer_angle")
RATES = ("roll_rate", "steer_rate")


@pytest.fixture(scope="module")
def equations(reference):
    return Equations(reference)


def told(results, reference):
    return finding_text.findings(causes(score(results, reference)))


# Findings about the motion as a whole. In these tests, errors are added to the columns and do not
# come from a motion, so these findings are ignored.
OF_MOTION = {"begins_as", "energy_varies", "energy_kept"}


def names(found):
    return [f.code for f in found if f.code not in OF_MOTION]


def with_errors(reference, level, more):
    """Return the reference with a smooth error, relative to `level`, and the error `more`."""

    def change(key, values, number):
        scale = np.max(np.abs(reference[number].rows[key]))
        return values + smooth_error(reference, number, level * scale) + more(key, values, number)

    return made(reference, change)


def test_a_lean_that_is_many_times_too_large_is_no_motion_that_blows_up(reference):
    """Maneuver 3 leans by 0.013 rad. A lean of 0.2 rad is wrong, but a bicycle can do it."""

    def change(key, values, number):
        return 16 * values if (key, number) == ("roll_angle", 3) else values

    assert "blown_up" not in names(told(made(reference, change), reference))

    def burst(key, values, number):
        grown = 1e3 * np.linspace(0.0, 1.0, len(values)) ** 40
        return values + grown if (key, number) == ("roll_angle", 3) else values

    assert names(told(made(reference, burst), reference)) == ["blown_up"]


def test_steps_chosen_by_a_tolerance_are_no_noise(reference):
    for tolerance in ("1e-4", "1e-7", "1e-10"):
        found = told(read_results(PEERS / f"scipy-rtol{tolerance}.txt"), reference)
        assert names(found) == ["smooth_error"]


@pytest.mark.parametrize("level", [1e-8, 1e-3])
def test_a_smooth_error_of_no_method_is_called_smooth(reference, level):
    found = told(with_errors(reference, level, lambda *_: 0.0), reference)
    assert names(found) == ["smooth_error"]


@pytest.mark.parametrize("rate", [1e-7, 1e-5])
@pytest.mark.parametrize(("sign", "code"), [(-1, "numerical_damping"), (1, "energy_grows")])
def test_energy_that_falls_or_grows_in_every_maneuver_is_told(reference, rate, sign, code):
    def changed(key, values, number):
        lost = {"kinetic_energy": rate, "mechanical_energy": rate}.get(key, 0.0)
        # The energy loss grows slowly at first, as it does with a numerical method. A force would
        # do work at once.
        return sign * lost * reference[number].time ** 2 / 10.0 * values

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


def test_noise_of_one_column_beside_a_smooth_error_is_named(reference):
    random = np.random.default_rng(3)

    def noise(key, values, number):
        return 1e-4 * random.standard_normal(len(values)) if key == "steer_angle" else 0.0

    found = told(with_errors(reference, 1e-2, noise), reference)[-1]
    assert found.code == "rough_error"
    # The finding names the columns in which the noise exceeds a thousandth of the largest value.
    assert {*found.evidence["columns"]} == {
        f"{n}.steer_angle"
        for n in reference
        if 1e-3 * np.max(np.abs(reference[n]["steer_angle"])) < 1e-4
    }
    assert found.message.startswith("A part of the error of")


@pytest.mark.parametrize("level", [1e-6, 1e-4])
def test_noise_of_velocities_is_that_of_iterations(reference, level):
    """The noise of an angle is the integral of that of its rate, a hundredth as large from row to
    row."""
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
    """In the last rows of maneuver 3, the error of the steer rate alternates visibly."""
    rate = np.loadtxt(PEERS / "exudyn-h0.01.txt")[-200:, 24]
    error = rate - reference[3].rows["steer_rate"][-200:]
    differences = np.diff(error, 4)
    assert np.mean(differences[1:] * differences[:-1] < 0) > 0.9
    found = told(read_results(PEERS / "exudyn-h0.01.txt"), reference)
    assert "step_ringing" in names(found)


@pytest.mark.parametrize("level", [1e-8, 1e-4])
def test_single_precision_numbers_are_told(reference, level):
    def change(key, values, number):
        scale = np.max(np.abs(values))
        wrong = values + smooth_error(reference, number, level * scale)
        return wrong.astype(np.float32).astype(np.float64)

    assert "single_precision" in names(told(made(reference, change), reference))


def test_single_precision_numbers_are_named_once(reference):
    """The row check finds the numbers, and the last answer compares the error with them."""

    def change(key, values, number):
        wrong = values + smooth_error(reference, number, 1e-4 * np.max(np.abs(values)))
        return wrong.astype(np.float32).astype(np.float64)

    found = [f.code for f in diagnose(made(reference, change), reference).diagnosis]
    assert found.count("single_precision") == 1


def test_few_digits_are_not_single_precision(reference):
    def change(key, values, number):
        return np.array([float(f"{x:.6g}") for x in values])

    results = replace(made(reference, change), significant_digits=6)
    assert "single_precision" not in names(told(results, reference))


def test_the_rounding_of_seven_digits_beside_an_integrators_error_is_no_single_precision(reference):
    def change(key, values, number):
        wrong = values + smooth_error(reference, number, 2e-5 * np.max(np.abs(values)))
        return np.array([float(f"{x:.7g}") for x in wrong])

    results = replace(made(reference, change), significant_digits=7)
    maneuvers = tuple(
        replace(rows, quantum=dict.fromkeys(rows.values, Quantum(base=10, digits=7)))
        for rows in results.maneuvers
    )
    found = names(told(replace(results, maneuvers=maneuvers), reference))
    assert "single_precision" not in found


def test_codes_of_clean_files_are_only_those_of_score(reference):
    assert "smooth_error" not in codes(score(made(reference), reference))
