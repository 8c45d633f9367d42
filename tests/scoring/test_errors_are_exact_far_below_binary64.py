"""The error of a value is correct to several digits however small it is, and at any time."""

from fractions import Fraction

import numpy as np
import pytest

from generators.made_results import column, exact_columns, made, rows
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring import measures
from heyoka_bike.scoring.measures import MAX_EXACT_VALUES
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score


def test_errors_of_correctly_rounded_values_are_what_rounding_left(reference):
    # The `lo` of the published rows is the exact value minus hi.
    report = score(made(reference), reference)
    for number in reference:
        for key in BENCHMARK_COLUMNS:
            c = column(report, number, key)
            assert np.max(np.abs(c.trace.error + reference[number].rows.lo[key])) < (
                1e-30 * np.max(np.abs(reference[number].rows[key]))
            )


@pytest.mark.parametrize("size", [1e-18, 1e-22, 1e-26])
def test_errors_below_binary64_are_seen_in_columns_of_more_digits(reference, size):
    parts = []
    for number in reference:
        m = reference[number]
        values = exact_columns(m)
        scale = {key: np.max(np.abs(v)) for key, v in values.items()}
        lo = {key: m.rows.lo[key] + size * scale[key] * np.sin(m.time) for key in values}
        parts.append(rows(reference, number, values, lo=lo))
    report = score(Results("made", "array", tuple(parts)), reference)
    largest = np.max(np.abs(np.sin(reference[1].time)))
    for number in reference:
        for key in BENCHMARK_COLUMNS:
            m = column(report, number, key).as_understood.measures
            assert m.max_rel_error == pytest.approx(size * largest, rel=1e-4)
            assert m.scd == pytest.approx(-np.log10(size * largest), abs=1e-4)


@pytest.mark.parametrize("size", [1e-13, 1e-22, 1e-28])
def test_small_errors_are_seen_in_many_rows_too(reference, size, monkeypatch):
    """Each error is found with the fastest evaluation that is accurate enough for it."""
    monkeypatch.setattr(measures, "MAX_EXACT_VALUES", 0)
    m = reference[2]
    time = np.sort(np.random.default_rng(1).uniform(0.0, 10.0, 40))
    exact = m.evaluate(time, BENCHMARK_COLUMNS)
    errors = {key: size * m.scale(key) * np.sin(time) for key in BENCHMARK_COLUMNS}
    lo = {key: exact.lo[key] + error for key, error in errors.items()}
    values = {key: exact[key] for key in BENCHMARK_COLUMNS}
    written = Rows(2, time, np.zeros_like(time), values, lo, dict.fromkeys(lo, Quantum(2, 53)))
    report = score(Results("made", "array", (written,)), reference)
    for key, error in errors.items():
        assert np.max(np.abs(column(report, 2, key).trace.error - error)) < (
            max(1e-3 * size, 1e-30) * m.scale(key)
        )


def test_the_text_of_50_digits_has_32(reference, folder):
    report = score(read_results(folder / "uncontrolled-bicycle-50digits.txt"), reference)
    assert report.findings == ()
    for m in report.maneuvers:
        for c in m.columns:
            # The dense output is certified to 9.5e-31 of the scale.
            assert c.as_understood.measures.scd > 30


def test_uneven_times_are_taken_as_they_are(reference):
    random = np.random.default_rng(1)
    m = reference[2]
    time = np.sort(random.uniform(0.0, 10.0, 300))
    exact = m.evaluate(time, BENCHMARK_COLUMNS)
    table = np.column_stack([time, *(exact[key] for key in BENCHMARK_COLUMNS)])
    report = score(read_results(table, maneuver=2), reference)
    for c in report.maneuvers[0].columns:
        assert c.as_understood.measures.max_abs_error <= c.floor


def test_a_decimal_time_is_not_its_binary64(reference):
    """0.07 s in a text is exactly 7/100 s. The difference from the nearest binary64 shows at 9.97
    s."""
    m = reference[1]
    at = Fraction(997, 100)
    as_float = Fraction(float(at))
    key = "steer_rate"
    slope = float(m.evaluate(at + Fraction(1, 10**6), key)[key] - m.evaluate(at, key)[key]) * 1e6
    shift = slope * float(as_float - at)
    exact = m.evaluate(at, key)
    found = m.evaluate(float(at), key)
    moved = (found[key] - exact[key]) + (found.lo[key] - exact.lo[key])
    assert moved == pytest.approx(shift, rel=1e-3)
    assert abs(moved) > 1e-18


def test_many_rows_are_judged_like_few(reference):
    """With many rows, hi + lo is used only where the error is small enough to need it."""
    time = np.linspace(0.0, 10.0, MAX_EXACT_VALUES + 1)
    values = reference[2].approximate(time, BENCHMARK_COLUMNS)
    few = slice(None, None, 100)
    for size in (1e-6, 1e-13):
        table = np.column_stack([time, *(v * (1 + size * np.sin(time)) for v in values.values())])
        many = score(read_results(table, maneuver=2), reference)
        some = score(read_results(table[few], maneuver=2), reference)
        for a, b in zip(many.maneuvers[0].columns, some.maneuvers[0].columns, strict=True):
            found, expected = a.trace.error[few], b.trace.error
            scale = np.max(np.abs(b.trace.reference))
            assert np.max(np.abs(found - expected)) < max(1e-3 * size, 1e-20) * scale
