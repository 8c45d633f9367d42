"""The shipped runs of Exudyn and SciPy: definitions, errors and orders that were found otherwise.

Nothing here is what `score` said once: the definitions are those that the programs' output
variables have by their documentation, the order is that of the integrator, and the errors are
plain differences from the published rows.
"""

import numpy as np
import pytest
from made_results import codes, column

from heyoka_bike.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reading import read_results
from heyoka_bike.resources import data_folder
from heyoka_bike.runs_file import read_runs
from heyoka_bike.scoring import score
from heyoka_bike.series import score_series

PEERS = data_folder() / "peers"


def series_of(name, reference):
    runs = read_runs(PEERS / name)
    results = [read_results(r.file) for r in runs]
    steps = [r.step for r in runs]
    return score_series(
        results, reference, cpu=[r.cpu for r in runs], steps=None if None in steps else steps
    )


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
    """Rotation is Tait-Bryan xyz, AngularVelocityLocal is along the body's own axis."""
    for run in exudyn.runs[1:]:
        for m in run.report.maneuvers:
            found = {c.key: c.as_understood.definition for c in m.columns}
            assert found["roll_angle"] == "tait_bryan_xyz"
            assert found["roll_rate"] == "body_x"
            assert found["forward_speed"] == "hub_body_x"


def test_one_run_alone_does_not_tell_the_speed(fine):
    """hub_body_x and hub_heading are 2e-5 m/s apart, no more than the run's own error."""
    speed = column(fine, 1, "forward_speed")
    assert speed.as_understood.definition == "hub_heading"
    assert speed.indistinguishable == ("hub_body_x",)


def test_the_trapezoidal_rule_is_of_second_order(exudyn):
    for c in exudyn.convergence:
        assert c.orders == pytest.approx((2.0,), abs=0.05)
        # Extrapolation gains at least a digit on the finer run.
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
