"""Runs at several step sizes show the order, the extrapolated error, and the definitions."""

import numpy as np
import pytest

from generators.made_results import codes, column, exact_columns, made, rows
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.series import score_files, score_series


def run_of_order(reference, step, order, *, higher=0.0, keep=slice(None), numbers=None):
    """Rows with the error c1 h^p + c2 h^(p+1), where c1 and c2 are smooth functions of time."""
    parts = []
    for number in numbers or reference:
        m = reference[number]
        error = 50.0 * m.time * np.cos(2.0 * m.time) * step**order
        error += higher * np.sin(m.time) * step ** (order + 1)
        values = {k: v * (1 + error) for k, v in exact_columns(m).items()}
        parts.append(rows(reference, number, values, keep=keep))
    return Results(f"h{step:g}.txt", "text", tuple(parts), 16)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_order_is_that_of_the_error(reference, order):
    steps = [1e-2, 5e-3, 2.5e-3]
    runs = [run_of_order(reference, h, order) for h in steps]
    series = score_series(runs, reference, steps=steps)
    assert len(series.convergence) == 24
    for c in series.convergence:
        assert c.orders == pytest.approx((order, order), abs=1e-6)
        # The whole error is proportional to one power of h. Extrapolation removes it, and only
        # rounding remains.
        assert c.richardson_error < 20 * c.floor
    (finding,) = series.findings
    assert finding.code == "order"
    assert finding.evidence["order"] == pytest.approx(order, abs=1e-6)


def test_extrapolation_leaves_the_next_power(reference):
    steps = [1e-2, 5e-3]
    runs = [run_of_order(reference, h, 2, higher=40.0) for h in steps]
    series = score_series(runs, reference, steps=steps)
    c = next(c for c in series.convergence if (c.maneuver, c.key) == (1, "roll_angle"))
    m = reference[1]
    # The extrapolation f2 + (f2 - f1) / 3 leaves h2^3 - (h1^3 - h2^3) / 3 of the cubic term.
    left = 40.0 * (steps[1] ** 3 - (steps[0] ** 3 - steps[1] ** 3) / 3)
    expected = np.max(np.abs(left * np.sin(m.time) * m.rows["roll_angle"]))
    assert c.richardson_error == pytest.approx(expected, rel=1e-6)
    assert c.richardson_error < c.errors[1]


def test_runs_are_put_in_order_and_the_rows_tell_the_step(reference):
    fine = run_of_order(reference, 1e-2, 2)
    coarse = run_of_order(reference, 2e-2, 2, keep=slice(None, None, 2))
    series = score_series([fine, coarse], reference)
    assert [r.step for r in series.runs] == pytest.approx([2e-2, 1e-2])
    assert series.runs[0].report.file.path == "h0.02.txt"
    assert all(c.orders == pytest.approx((2.0,), abs=1e-2) for c in series.convergence)


def test_steps_that_cannot_be_known_are_asked_for(reference):
    runs = [run_of_order(reference, h, 2) for h in (1e-2, 1e-3)]
    series = score_series(runs, reference)
    assert [f.code for f in series.findings] == ["steps_unknown"]
    assert all(c.orders == (None,) and c.richardson_error is None for c in series.convergence)


def test_an_error_at_its_floor_has_no_order(reference):
    runs = [made(reference), made(reference)]
    series = score_series(runs, reference, steps=[1e-2, 1e-3])
    assert all(c.orders == (None,) for c in series.convergence)
    assert series.findings == ()


def test_an_order_that_changes_is_said(reference):
    steps = [4e-2, 2e-2, 1e-2]
    runs = [run_of_order(reference, h, 2, higher=1e4) for h in steps]
    series = score_series(runs, reference, steps=steps)
    assert "order_not_settled" in [f.code for f in series.findings]


def test_extrapolation_tells_definitions_that_the_error_hides(reference):
    """hub_body_x differs from hub_heading by 2e-5 m/s; the error of each run is larger."""
    runs = []
    for step in (1e-2, 5e-3):
        parts = []
        for number in reference:
            names = ["forward_speed_hub_body_x" if k == "forward_speed" else k
                     for k in BENCHMARK_COLUMNS]  # fmt: skip
            m = reference[number]
            values = exact_columns(m, names)
            error = 0.5 * np.sin(3 * m.time) * step**2
            parts.append(rows(reference, number, {k: v + error for k, v in values.items()}))
        runs.append(Results(f"h{step}", "text", tuple(parts)))
    alone = score_files(runs[1:], reference)
    assert isinstance(alone, Report)
    speed = column(alone, 1, "forward_speed")
    assert speed.as_understood.definition == "hub_heading"
    assert "hub_body_x" in speed.indistinguishable
    series = score_series(runs, reference, steps=[1e-2, 5e-3])
    for run in series.runs:
        speed = column(run.report, 1, "forward_speed")
        assert speed.as_understood.definition == "hub_body_x"


def test_files_of_different_programs_are_not_taken_for_one(reference):
    names = ["roll_angle_tait_bryan_xyz", *BENCHMARK_COLUMNS[1:]]
    series = score_series([made(reference), made(reference, names=names)], reference)
    assert "definitions_differ" in [f.code for f in series.findings]
    first, second = (column(r.report, 1, "roll_angle") for r in series.runs)
    assert first.as_understood.definition == "lean"
    assert second.as_understood.definition == "tait_bryan_xyz"


def test_files_of_different_maneuvers_are_one_run(reference):
    files = [run_of_order(reference, 1e-2, 2, numbers=[n]) for n in (2, 3, 1)]
    report = score_files(files, reference)
    assert isinstance(report, Report)
    assert [m.maneuver for m in report.maneuvers] == [1, 2, 3]
    assert report.file.path == "h0.01.txt, h0.01.txt, h0.01.txt"


def test_files_of_maneuvers_and_steps_are_sorted_into_runs(reference):
    files = [run_of_order(reference, h, 2, numbers=[n]) for n in (1, 2) for h in (5e-3, 1e-2)]
    series = score_files(files, reference, steps=[5e-3, 1e-2] * 2, cpu=[2.0, 1.0, 3.0, 1.5])
    assert isinstance(series, Series)
    assert [(r.step, r.cpu, len(r.report.maneuvers)) for r in series.runs] == [
        (1e-2, 2.5, 2), (5e-3, 5.0, 2),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"steps": [0.01]}, "step: found 1 value for 2 files"),
        ({"cpu": [1.0, 2.0, 3.0]}, "cpu: found 3 values for 2 files"),
        ({"steps": [0.01, -0.01]}, "expected positive"),
        ({"cpu": [float("nan"), 1.0]}, "expected positive"),
    ],
)
def test_steps_and_times_must_fit(reference, given, says):
    with pytest.raises(InputError, match=says):
        score_series([made(reference)] * 2, reference, **given)


def test_coverage_is_said_for_each_maneuver(reference):
    late = run_of_order(reference, 1e-2, 2, keep=slice(300, None), numbers=[1])
    early = run_of_order(reference, 1e-2, 2, keep=slice(None, 600), numbers=[2])
    report = score_files([late, early], reference)
    assert codes(report)[:2] == ["coverage", "coverage"]
    assert [f.evidence["maneuvers"] for f in report.findings[:2]] == [[1], [2]]
