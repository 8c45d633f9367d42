"""Only rows within the reference count, rows left out are reported, and maneuvers are
recognised."""

import numpy as np
import pytest

from generators.made_results import codes, exact_columns, made, rows
from heyoka_bike.errors import InputError, NothingScoredError
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows
from heyoka_bike.scoring.score import score


def one(reference, number, *, told=None, keep=slice(None), change=lambda k, v: v, shift=0.0):
    m = reference[number]
    values = {k: change(k, v)[keep] for k, v in exact_columns(m).items()}
    part = Rows(told, m.time[keep] + shift, m.time_lo[keep], values)
    return Results("one.txt", "text", (part,))


def test_rows_outside_the_run_are_left_out_and_counted(reference):
    m = reference[1]
    time = np.concatenate([[-0.01], m.time, [10.01, 10.02]])
    values = {k: np.concatenate([[9.0], v, [9.0, 9.0]]) for k, v in exact_columns(m).items()}
    lo = np.concatenate([[0.0], m.time_lo, [0.0, 0.0]])
    report = score(Results("x", "text", (Rows(1, time, lo, values),)), reference)
    assert codes(report) == ["time_outside"]
    assert report.findings[0].evidence == {"rows": 3, "t_first": -0.01, "t_last": 10.02}
    assert report.maneuvers[0].rows == 1001
    assert report.file.rows == 1004
    assert report.maneuvers[0].columns[0].as_understood.measures.scd > 15


def test_the_end_is_inside_and_what_is_beyond_is_outside(reference):
    m = reference[1]
    values = {k: v[-1:] for k, v in exact_columns(m).items()}
    inside = Rows(1, np.array([10.0]), np.array([0.0]), values)
    assert score(Results("x", "text", (inside,)), reference).maneuvers[0].rows == 1
    beyond = Rows(1, np.array([10.002]), np.array([0.0]), values)
    with pytest.raises(NothingScoredError):
        score(Results("x", "text", (beyond,)), reference)


@pytest.mark.parametrize(("keep", "t_start", "t_end"), [
    (slice(200, None), 2.0, 10.0), (slice(None, 501), 0.0, 5.0), (slice(5, 6), 0.05, 0.05),
])  # fmt: skip
def test_coverage_is_said(reference, keep, t_start, t_end):
    report = score(made(reference, keep=keep), reference)
    assert codes(report) == ["coverage"]
    for m in report.maneuvers:
        assert (m.t_start, m.t_end) == (t_start, t_end)
        assert m.coverage == pytest.approx((t_end - t_start) / 10)


def test_starting_one_step_late_is_no_finding(reference):
    assert codes(score(made(reference, keep=slice(1, None)), reference)) == []


@pytest.mark.parametrize("number", [1, 2, 3])
@pytest.mark.parametrize(
    "change",
    [
        lambda k, v: v,
        lambda k, v: -v if "roll" in k or "steer" in k else v,
        lambda k, v: np.rad2deg(v) if "roll" in k or "steer" in k else v,
        lambda k, v: v - 800.0 if k in ("potential_energy", "mechanical_energy") else v,
        lambda k, v: v * 1.05,
    ],
    ids=["exact", "flipped", "degrees", "offset", "wrong by 5 %"],
)
def test_the_maneuver_of_9_columns_is_recognised(reference, number, change):
    report = score(one(reference, number, change=change), reference)
    assert [m.maneuver for m in report.maneuvers] == [number]
    assert codes(report)[0] == "maneuver_recognised"


@pytest.mark.parametrize("number", [1, 2, 3])
def test_one_row_is_enough_to_recognise_it(reference, number):
    report = score(one(reference, number, keep=slice(0, 1)), reference)
    assert report.maneuvers[0].maneuver == number


@pytest.mark.parametrize("number", [1, 2, 3])
def test_what_is_told_is_believed(reference, number):
    report = score(one(reference, 2, told=number), reference)
    assert [m.maneuver for m in report.maneuvers] == [number]


def test_columns_of_no_maneuver_are_not_scored(reference):
    random = np.random.default_rng(3)
    results = one(reference, 1, change=lambda k, v: random.standard_normal(len(v)))
    with pytest.raises(NothingScoredError, match="to choose it, use --maneuver N") as raised:
        score(results, reference)
    assert raised.value.exit_code == 2


def test_nothing_in_the_run_is_not_scored(reference):
    with pytest.raises(NothingScoredError, match="found times from 20 to 30 s"):
        score(one(reference, 1, told=1, shift=20.0), reference)
    milliseconds = rows(reference, 1, exact_columns(reference[1]), keep=slice(20, None))
    late = Rows(1, 1000 * milliseconds.time, milliseconds.time_lo, milliseconds.values)
    with pytest.raises(NothingScoredError, match="are the times in milliseconds"):
        score(Results("x", "text", (late,)), reference)
    nan = one(reference, 1, told=1, change=lambda k, v: v * np.nan)
    with pytest.raises(NothingScoredError, match="no finite value"):
        score(nan, reference)


def test_a_maneuver_twice_or_unknown_is_refused(reference):
    part = one(reference, 1, told=1).maneuvers[0]
    with pytest.raises(InputError, match="maneuver 1 twice"):
        score(Results("x", "text", (part, part)), reference)
    with pytest.raises(InputError, match="found maneuver 4, expected 1 to 3"):
        score(Results("x", "text", (Rows(4, part.time, part.time_lo, part.values),)), reference)


def test_repeated_times_are_compared_like_others(reference):
    twice = np.repeat(np.arange(1001), 2)
    assert codes(score(made(reference, keep=twice), reference)) == []


def test_values_that_are_no_numbers_are_counted_not_compared(reference):
    def change(key, values, number):
        if (number, key) == (1, "roll_rate"):
            values[10:13] = np.nan, np.inf, 1e200
        return values

    report = score(made(reference, change), reference)
    c = report.maneuvers[0].columns[1]
    assert (c.values, c.missing) == (998, 3)
    assert c.as_understood.measures.max_abs_error <= c.floor


@pytest.mark.parametrize("step", [0.01, 0.005, 0.0025, 0.1 / 3])
def test_summed_times_cover_the_whole_run(reference, step):
    """Repeated t += h ends a little before or after 10 s."""
    m = reference[2]
    time = np.cumsum(np.full(round(10 / step), step))
    time = np.insert(time, 0, 0.0)
    assert time[-1] != 10.0
    exact = m.continued((time, np.zeros_like(time)), [*exact_columns(m)])
    results = Results("x", "text", (Rows(2, time, np.zeros_like(time), dict(exact.hi)),))
    report = score(results, reference, ["coverage >= 1", "scd >= 14"])
    assert report.passed
    assert codes(report) == []
    assert report.maneuvers[0].rows == len(time)


@pytest.mark.parametrize(
    ("times", "unit"),
    [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"), (1e5, None)],
)
def test_smaller_units_of_time_are_asked_about(times, unit, reference):
    m = reference[1]
    rows = slice(0, 1 + int(0.7 * len(m.time)))
    columns = {key: x[rows] for key, x in exact_columns(m).items()}
    part = Rows(1, times * m.time[rows], m.time_lo[rows], columns)
    asked = f"; are the times in {unit}?" if unit else "is not extrapolated"
    report = score(Results("x", "text", (part,)), reference)
    assert report.findings[0].message.endswith(asked)
    unknown = Rows(None, part.time, part.time_lo, part.values)
    with pytest.raises(NothingScoredError) as raised:
        score(Results("x", "text", (unknown,)), reference)
    assert str(raised.value).endswith(asked if unit else "to choose it, use --maneuver N")


def test_maneuvers_in_each_others_place_are_told(reference):
    parts = [Rows(n, reference[n].time, reference[n].time_lo, exact_columns(reference[other]))
             for n, other in ((1, 3), (2, 2), (3, 1))]  # fmt: skip
    report = score(Results("x", "text", tuple(parts)), reference)
    told = [f.evidence for f in report.findings if f.code == "another_maneuver"]
    assert told == [{"maneuver": 1, "nearest": 3}, {"maneuver": 3, "nearest": 1}]


def test_values_too_large_to_mean_anything_are_told(reference):
    def change(key, values, number):
        if (number, key) == (2, "roll_angle"):
            values[600:] = 1e200
        return values

    report = score(made(reference, change), reference)
    assert "too_large" in codes(report)
    assert report.findings[0].evidence == {"maneuver": 2, "column": "roll_angle", "values": 401}


def test_a_maneuver_that_is_wholly_outside_is_not_dropped_in_silence(reference):
    parts = [rows(reference, n, exact_columns(reference[n])) for n in (1, 2)]
    late = Rows(2, parts[1].time + 20.0, parts[1].time_lo, parts[1].values)
    with pytest.raises(NothingScoredError, match="no row of maneuver 2 within its run"):
        score(Results("x", "text", (parts[0], late)), reference)


def test_the_same_results_twice_or_none_are_refused(reference):
    results = made(reference)
    with pytest.raises(InputError, match="twice"):
        score([results, results], reference)
    with pytest.raises(InputError, match="no results"):
        score([], reference)


def test_exact_decimal_times_leave_the_floor_alone(reference):
    """Rows at 0.005, 0.015, ... and at the end are as exact as rows at the published times."""
    m = reference[2]
    time = np.append(np.arange(1000) / 100 + 0.005, 10.0)
    values = dict(m.evaluate(time, [*exact_columns(m)]).hi)
    quantum = {"time": Quantum(10, places=3), **dict.fromkeys(values, Quantum(2, 53))}
    part = Rows(2, time, np.zeros_like(time), values, quantum=quantum)
    report = score(Results("x", "text", (part,)), reference)
    assert all(c.floor < 1e-12 for c in report.maneuvers[0].columns)
