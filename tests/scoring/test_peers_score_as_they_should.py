"""The shipped runs of Exudyn and SciPy have definitions, errors and orders that are known
independently.

No expected value was computed by `score`: the definitions are from the documentation of the
programs' output variables, the order is the integrator's, and the errors are plain differences from
the published rows.
"""

import numpy as np
import pytest

from generators.made_results import codes, column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.load import load_motion
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.series import read_runs, score_series
from heyoka_bike.system.resources import data_folder

PEERS = data_folder() / "peers"


def series_of(name, reference):
    files, told = read_runs(PEERS / name)
    steps = None if None in told["step"] else told["step"]
    results = [read_results(file) for file in files]
    return score_series(results, reference, cpu=told["cpu"], steps=steps)


@pytest.fixture(scope="module")
def exudyn(reference):
    return series_of("exudyn.toml", reference)


@pytest.fixture(scope="module")
def fine(reference):
    return score(read_results(PEERS / "exudyn-h0.001.txt"), reference)


def test_errors_are_plain_differences_from_the_published_rows(reference, fine):
    table = np.loadtxt(PEERS / "exudyn-h0.001.txt")
    for number in reference:
        rows = reference[number].rows
        for j, key in enumerate(BENCHMARK_COLUMNS):
            c = column(fine, number, key)
            by_definition = {d.definition: d.name for d in DEFINITIONS[key]}
            name = by_definition[c.as_understood.definition]
            plain = table[:, 1 + 8 * (number - 1) + j] - rows[name]
            assert c.as_understood.measures.max_abs_error == pytest.approx(
                np.max(np.abs(plain)), rel=1e-5
            )


def test_the_definitions_of_exudyn_are_found(exudyn):
    """Exudyn's Rotation is Tait-Bryan xyz, and AngularVelocityLocal is about the body's own
    axis."""
    for run in exudyn.runs[1:]:
        for m in run.report.maneuvers:
            found = {c.key: c.as_understood.definition for c in m.columns}
            assert found["roll_angle"] == "tait_bryan_xyz"
            assert found["roll_rate"] == "body_x"
            assert found["forward_speed"] == "hub_body_x"


def test_one_run_alone_does_not_tell_the_speed(fine):
    """hub_body_x and hub_heading differ by 2e-5 m/s, which is no more than the run's own error."""
    speed = column(fine, 1, "forward_speed")
    assert {speed.definition, *speed.indistinguishable} == {"hub_heading", "hub_body_x"}


def test_a_definition_is_found_although_one_maneuver_says_the_contrary(reference):
    """In maneuver 3 the iteration error is half the difference between the definitions."""
    found = score(read_results(PEERS / "exudyn-loose-newton.txt"), reference)
    for m, limit in zip(found.maneuvers, (3e-4, 5e-5, 5e-5), strict=True):
        roll, rate = m.columns[:2]
        assert roll.as_understood.definition == "tait_bryan_xyz"
        assert rate.as_understood.definition == "body_x"
        assert roll.as_understood.measures.max_abs_error < limit


@pytest.mark.parametrize(
    ("name", "definition"),
    # The scripts write the angular velocity of the body about its own axis, or about the heading.
    [("ode-best", "body_x"), ("mujoco-best", "body_x"), ("simbody-default", "lean_rate")],
)
def test_the_roll_rate_of_coarse_runs_is_the_likeliest(reference, name, definition):
    found = score(read_results(data_folder() / "results" / f"{name}.txt.gz"), reference)
    rates = [column(found, n, "roll_rate").as_understood for n in reference]
    assert {x.definition for x in rates} == {definition}


def test_the_trapezoidal_rule_is_of_second_order(exudyn):
    for c in exudyn.convergence:
        assert c.orders == pytest.approx((2.0,), abs=0.05)
        # Extrapolation gains at least one digit compared with the finer run.
        assert c.richardson_error < c.errors[1] / 10
    assert [f.code for f in exudyn.findings] == ["order"]


def test_the_benchmarks_measure_passes_both_runs_though_one_is_visibly_wrong(exudyn, fine):
    coarse = exudyn.runs[0].report
    for report in (coarse, fine):
        judged = report.maneuvers[1]
        assert judged.performance_limit == 1e-3
        assert judged.performance < 1e-3
        energy = column(report, 2, "mechanical_energy").trace.value
        assert judged.performance == pytest.approx(100 * np.ptp(energy) / energy[0], rel=1e-9)
    assert "energy_hides_error" in codes(coarse)
    assert "energy_hides_error" not in codes(fine)


def test_scipy_gains_digits_with_its_tolerance(reference):
    scipy = series_of("scipy.toml", reference)
    worst = [
        min(c.as_understood.measures.scd for m in run.report.maneuvers for c in m.columns)
        for run in scipy.runs
    ]
    assert worst == sorted(worst)
    assert worst[1] - worst[0] > 2
    assert worst[2] - worst[1] > 2
    for run in scipy.runs[1:]:
        for m in run.report.maneuvers:
            for c in m.columns:
                assert c.as_understood.definition == DEFINITIONS[c.key][0].definition


# In Exudyn's axes, y points to the left and z points up. The lateral force of its sensor is
# positive to the left. The forces on the axles are resolved in the axes of the frames.
TURNED = {
    "rear_contact_y", "front_contact_y", "com_y", "com_z", "rear_frame_omega_y",
    "rear_frame_omega_z", "rear_lateral_force", "front_lateral_force", "rear_axle_force_x",
    "front_axle_force_x",
}  # fmt: skip
# Largest error of a second-order method with steps of 0.001 s, relative to the largest value: (h
# 20/s)^2, because the fastest mode decays at a rate of 20/s. The largest measured error is 8e-5.
SECOND_ORDER = 4e-4
FORGOTTEN = 0.1  # [s] after this time (100 steps) an error of the initial state has decayed


@pytest.fixture(scope="module")
def forces(reference):
    return {
        name: score(read_results(PEERS / f"exudyn-forces-{name}.txt"), reference)
        for name in ("trapezoidal", "alpha")
    }


@pytest.mark.parametrize("name", ["trapezoidal", "alpha"])
def test_forces_are_compared_with_the_published_rows(forces, name):
    (m,) = forces[name].maneuvers
    assert m.maneuver == 2
    table = np.loadtxt(PEERS / f"exudyn-forces-{name}.txt", skiprows=1)
    heads = (PEERS / f"exudyn-forces-{name}.txt").read_text().split("\n", 1)[0].split()
    motion = load_motion()[2]
    assert {c.key for c in m.columns} == set(heads[1:])
    for c in m.columns:
        assert (c.as_understood.sign == -1) == (c.key in TURNED)
        plain = c.as_understood.sign * table[:, heads.index(c.key)] - motion[c.key]
        found = c.as_understood.measures.max_abs_error
        assert found == pytest.approx(np.max(np.abs(plain)), rel=1e-6)


def test_the_forces_of_another_program_are_these(forces):
    (m,) = forces["alpha"].maneuvers
    for c in m.columns:
        late = np.abs(c.trace.error[c.trace.time >= FORGOTTEN])
        assert np.max(late) < SECOND_ORDER * np.max(np.abs(c.trace.reference)), c.key


def test_the_trapezoidal_rule_never_forgets_its_first_forces(forces):
    (m,) = forces["trapezoidal"].maneuvers
    for c in m.columns:
        relative = c.as_understood.measures.max_rel_error
        if c.key.endswith("normal_force"):
            # Each row comes after ten more steps, an even number. So the alternating error has the
            # same sign in every row.
            error = c.trace.error
            assert error[0] > 0.005 * np.max(c.trace.reference)
            assert np.all(np.abs(error - error[0]) < 0.15 * error[0])
        elif "force" not in c.key:
            assert relative < SECOND_ORDER, c.key
