"""Times of a result file are the decimals that it writes or means, checked with exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from heyoka_bike.scoring.evidence.as_read import TimesRepeated, TimesUnsorted
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.results import Quantum
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.reading.table import ReadColumn, ReadTable
from heyoka_bike.scoring.reading.text import rows as text_rows
from heyoka_bike.scoring.reading.text.blocks import rest
from heyoka_bike.scoring.reading.times import as_multiples, settle


def written(tmp_path, times, header=""):
    path = tmp_path / "results.txt"
    path.write_text(header + "".join(f"{t} 1 2 3 4 5 6 7 {i}.5\n" for i, t in enumerate(times)))
    return path


def assert_exact(rows, exact):
    """Check that hi is the nearest binary64, and lo the nearest to the remainder."""
    assert rows.time.tolist() == [float(t) for t in exact]
    assert rows.time_lo.tolist() == [float(t - Fraction(float(t))) for t in exact]


def codes(results):
    return [finding.code for finding in results.findings]


DECIMALS = [
    [f"{i / 100:g}" for i in range(101)],
    [f"{i / 100:.6f}" for i in range(101)],
    [f"{i / 100:.2e}" for i in range(101)],
    ["0", "0.0123456789", "0.0387", "0.1", "1.25", "9.9999999999"],
    ["0", "1e-12", "2E-12", "0.5"],
    ["0", "0.1234567890123456", "0.2", "0.7000000000000001"],
    ["0", "0.12345678901234567890123456789", "0.3333333333333333333333", "2"],
    ["1.00000000000000000000000000001", "2", "3.7"],
    ["-1", "-0.37", "0.1"],
    ["1e-400", "4.9e-324", "1e-30", "1e-23", "1e-22", "0.3"],
    ["0", "123456789012345678", "1e22", "1e23", "123456789012345678901234567890", "1e300"],
    ["0.1", "0.2"],
    ["0." + "1" * 2000, "0." + "2" * 2000, "0." + "3" * 2000],
    ["00000.1", "+0.2", ".3", "4."],
]


@pytest.mark.parametrize("reader", ["quick", "careful"])
@pytest.mark.parametrize("times", DECIMALS, ids=lambda times: times[1][:20])
def test_decimals_are_kept(times, reader, tmp_path, monkeypatch):
    if reader == "careful":
        monkeypatch.setattr(text_rows, "parse_block", lambda *_: None)
    results = read_results(written(tmp_path, times))
    assert codes(results) == []
    assert_exact(results.maneuvers[0], [Fraction(t) for t in times])


@pytest.mark.parametrize("reader", ["quick", "careful"])
@pytest.mark.parametrize("exponent", ["-999999999", "-99999999999999999999", "-0" + "0" * 999])
def test_absurd_exponents_do_no_harm(exponent, reader, tmp_path, monkeypatch):
    if reader == "careful":
        monkeypatch.setattr(text_rows, "parse_block", lambda *_: None)
    results = read_results(written(tmp_path, ["0", f"1e{exponent}", "2.3"]))
    (rows,) = results.maneuvers
    assert rows.time.tolist() == [0, float(f"1e{exponent}"), 2.3]
    assert rows.time_lo[2] == float(Fraction("2.3") - Fraction(2.3))


STEPS = [(1001, 2), (11, 0), (51, 1), (2001, 3), (1500, 5), (9, 12), (3, 2)]


@pytest.mark.parametrize(("count", "places"), STEPS)
@pytest.mark.parametrize("form", [".17g", ".18e", ".17e", ".20f", "r"])
def test_text_of_binary64_multiples(count, places, form, tmp_path):
    exact = [Fraction(i, 10**places) for i in range(count)]
    times = [repr(float(t)) if form == "r" else format(float(t), form) for t in exact]
    results = read_results(written(tmp_path, times))
    assert_exact(results.maneuvers[0], exact)
    changed = sum(Fraction(t) != e for t, e in zip(times, exact, strict=True))
    if form == "r":
        assert changed == 0
    if not changed:
        assert codes(results) == []
    else:
        assert codes(results) == ["times_read_as_multiples"]
        assert results.findings[0].severity == "info"
        assert results.findings[0].evidence == {"places": places, "changed": changed}


def table(times, dtype=None):
    rows = np.zeros((len(times), 9), dtype=dtype or np.asarray(times).dtype)
    rows[:, 0] = times
    return rows


@pytest.mark.parametrize("dtype", ["f8", ">f8", "f4", "g"])
@pytest.mark.parametrize(("count", "places"), STEPS)
def test_binary_multiples(count, places, dtype):
    exact = [Fraction(i, 10**places) for i in range(count)]
    hi = np.array([float(t) for t in exact])
    results = read_results(table(hi, dtype))
    assert_exact(results.maneuvers[0], exact)
    assert codes(results) == ([] if places == 0 else ["times_read_as_multiples"])


@pytest.mark.parametrize("form", [".9g", ".8e", ".17g", "f4"])
@pytest.mark.parametrize(("count", "places"), [(1001, 2), (2001, 3), (101, 1)])
def test_text_of_single_precision_multiples(count, places, form, tmp_path):
    exact = [Fraction(i, 10**places) for i in range(count)]
    single = np.array([float(t) for t in exact], dtype=np.float32)
    times = [str(x) if form == "f4" else format(float(x), form) for x in single]
    results = read_results(written(tmp_path, times))
    assert_exact(results.maneuvers[0], exact)


def test_binary_times_that_are_no_multiples_mean_what_they_are():
    for times in (
        np.cumsum(np.full(1001, 0.01)),
        np.arange(1001) * 0.01,
        np.sort(np.random.default_rng(1).random(1000)),
        np.random.default_rng(2).random(100).astype(np.float32).cumsum(dtype=np.float32),
        np.array([0, 0.1]),
        np.array([0.0, 0.1, np.nextafter(0.2, 1)]),
        np.arange(100) / 3,
    ):
        rows = read_results(table(times)).maneuvers[0]
        assert np.array_equal(rows.time, times)
        assert not rows.time_lo.any()


def test_large_times_could_be_multiples_by_chance():
    """Above 4500 s every binary64 is the nearest one to some whole number of picoseconds."""
    times = 8000 + np.sort(np.random.default_rng(3).random(100))
    assert as_multiples(times) is None
    assert as_multiples(np.round(times, 3)) is not None
    single = (1 + np.random.default_rng(4).random(100)).astype(np.float32).astype(float)
    assert as_multiples(single) is None
    assert as_multiples(np.array([0.0, 1e300, 2e300])) is None


def test_stored_times_of_two_parts_are_taken_as_they_are():
    exact = [Fraction(i, 7) for i in range(20)]
    hi = np.array([float(t) for t in exact])
    lo = np.array([float(t - Fraction(float(t))) for t in exact])
    results = read_results({"time": hi, "time_lo": lo, "roll": hi})
    assert_exact(results.maneuvers[0], exact)
    # If the low part of a time is given, the time is not guessed: 0.01 is the binary64 number here.
    hundredths = np.arange(100) / 100
    results = read_results({"t": hundredths, "t_lo": np.zeros(100), "roll": hundredths})
    assert not results.maneuvers[0].time_lo.any()
    assert codes(results) == []


def test_long_double_times():
    times = np.arange(50, dtype=np.longdouble) / 7
    if np.finfo(np.longdouble).nmant < 63:
        pytest.skip("long double is binary64 here")
    rows = read_results(table(times)).maneuvers[0]
    assert np.array_equal(rows.time.astype("g") + rows.time_lo, times)
    assert rows.time_lo.any()


@settings(max_examples=300, deadline=None)
@given(
    k=st.lists(st.integers(-(10**13), 10**13), min_size=3, max_size=8),
    d=st.integers(0, 12),
)
@example(k=[0, 1, 2], d=12)
def test_multiples_are_exact_for_any_step(k, d):
    exact = [Fraction(i, 10**d) for i in k]
    found = as_multiples(np.array([float(t) for t in exact]))
    if found is None:
        # No result is correct in two cases: the multiples are too large to exclude chance, or too
        # few of them differ from zero.
        assert max(k) - min(k) > 10**12 or len(set(k) - {0}) < 3
        return
    places, hi, lo = found
    assert places <= d
    assert hi.tolist() == [float(t) for t in exact]
    assert lo.tolist() == [float(t - Fraction(float(t))) for t in exact]


@settings(max_examples=300, deadline=None)
@given(st.decimals(allow_nan=False, allow_infinity=False))
def test_the_rest_of_a_decimal_is_correctly_rounded(number):
    hi = float(number)
    if hi in (0.0, float("inf"), float("-inf")):
        assert rest(str(number), hi) == 0.0
    else:
        assert rest(str(number), hi) == float(Fraction(number) - Fraction(hi))


UNSORTED = ["0", "0.3", "0.1", "0.1", "0.2", "0.2000000000000000000001", "0.20", "0.05"]


def test_rows_are_sorted_by_time(tmp_path):
    results = read_results(written(tmp_path, UNSORTED, "# one line\n"))
    order = sorted(range(len(UNSORTED)), key=lambda i: Fraction(UNSORTED[i]))
    (rows,) = results.maneuvers
    assert_exact(rows, [Fraction(UNSORTED[i]) for i in order])
    assert rows.values["steer_rate"].tolist() == [i + 0.5 for i in order]
    unsorted, repeated = results.findings
    assert (unsorted.code, unsorted.severity) == ("times_unsorted", "warning")
    assert unsorted.evidence == {"line": 4, "count": 3}
    assert "line 4" in unsorted.message
    assert (repeated.code, repeated.severity) == ("times_repeated", "warning")
    assert repeated.evidence == {"count": 4, "identical": False}


def test_the_parts_of_values_are_sorted_alike():
    time = np.array([2.0, 1.0, 0.0])
    results = read_results({"time": time, "roll": time / 3, "roll_lo": time * 1e-20})
    (rows,) = results.maneuvers
    assert rows.time.tolist() == [0, 1, 2]
    assert rows.values["roll_angle"].tolist() == [0, 1 / 3, 2 / 3]
    assert rows.lo["roll_angle"].tolist() == [0, 1e-20, 2e-20]
    assert results.findings[0].evidence == {"line": 2, "count": 2}
    assert "row 2" in results.findings[0].message


def test_repeated_times_are_kept(tmp_path):
    results = read_results(written(tmp_path, ["0", "1", "1", "1", "2"]))
    assert results.maneuvers[0].time.tolist() == [0, 1, 1, 1, 2]
    (finding,) = results.findings
    assert finding.code == "times_repeated"
    assert finding.evidence == {"count": 3, "identical": False}
    said = "3 rows repeat the time of another row: the time column has too few digits"
    assert finding.message == said


def test_rows_that_are_written_twice_are_no_warning():
    time = np.array([0.0, 1.0, 1.0, 3.0, 2.0, 2.0])
    results = read_results({"time": time, "roll": np.where(time == 3.0, np.nan, time)})
    (repeated,) = [f for f in results.findings if f.code == "times_repeated"]
    assert repeated.severity == "info"
    assert repeated.evidence == {"count": 4, "identical": True}


def test_huge_times_are_compared_without_overflow():
    column = ReadColumn(np.array([-1.7e308, 1.7e308, -1.7e308]), None, Quantum(2, digits=53), 17)
    times = settle(ReadTable([column]), 0, Request("times", 1))
    assert times.hi.tolist() == [-1.7e308, -1.7e308, 1.7e308]
    assert [type(x) for x in times.seen] == [TimesUnsorted, TimesRepeated]
