"""Times of day, rows with names in front, and quaternions in another order are read as meant."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from generators.published_columns import published_columns
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score

NAMES = ("time", *KEYS)
COUNT = 101


@pytest.fixture
def table(reference):
    """Every tenth row of maneuver 2, by column name."""
    return published_columns(reference, every=10)


def clock(start, form):
    """Times of the rows, as times of day from `start` on, formatted with `form`."""
    return [form(start + timedelta(milliseconds=100 * i)) for i in range(COUNT)]


START = datetime(2024, 1, 5, 12, 0, 3)
LATE = datetime(2024, 1, 5, 23, 59, 55)
CLOCKS = {
    "ISO 8601": lambda t: t.isoformat(timespec="milliseconds"),
    "ISO 8601 in UTC": lambda t: t.isoformat(timespec="microseconds") + "Z",
    "with an offset": lambda t: t.isoformat(timespec="milliseconds") + "+01:00",
    "with a blank": lambda t: t.isoformat(" ", "milliseconds"),
    "the time alone": lambda t: t.strftime("%H:%M:%S.%f"),
    "MATLAB": lambda t: t.strftime("%d-%b-%Y %H:%M:%S.%f")[:-3],
    "day first": lambda t: t.strftime("%d.%m.%Y %H:%M:%S.%f"),
    "America": lambda t: t.strftime("%m/%d/%Y %I:%M:%S.%f %p"),
}


def text(table, times, separator=","):
    columns = [times, *([f"{x:.17g}" for x in table[key]] for key in KEYS)]
    rows = [separator.join(row) for row in zip(*columns, strict=True)]
    return "\n".join([separator.join(NAMES), *rows]) + "\n"


@pytest.mark.parametrize("start", [START, LATE])
@pytest.mark.parametrize("form", CLOCKS)
def test_times_of_day_count_from_the_first_row(table, tmp_path, reference, start, form):
    path = tmp_path / "r.csv"
    times = clock(start, CLOCKS[form])
    path.write_text(text(table, times))
    (rows,) = read_results(path).maneuvers
    assert rows.time.tolist() == [i / 10 for i in range(COUNT)]
    report = score(path, reference)
    assert report.is_right
    (said,) = [f for f in report.findings if f.code == "times_of_day"]
    assert times[0][:20] in said.message


def test_decimal_commas_in_times_of_day(table, tmp_path):
    path = tmp_path / "r.csv"
    path.write_text(text(table, clock(START, CLOCKS["ISO 8601"]), ";").replace(".", ","))
    (rows,) = read_results(path).maneuvers
    assert rows.time.tolist() == [i / 10 for i in range(COUNT)]


@pytest.mark.parametrize("kind", ["NumPy", "Python"])
def test_dates_in_arrays_count_from_the_first(table, kind):
    times = clock(START, lambda t: t)
    given = np.array(times, "M8[ms]") if kind == "NumPy" else times
    (rows,) = read_results(table | {"time": given}, maneuver=2).maneuvers
    assert rows.time.tolist() == [i / 10 for i in range(COUNT)]


def test_durations_of_a_few_seconds_are_no_times_of_day(table, tmp_path):
    path = tmp_path / "r.csv"
    times = [f"00:00:{1 + i / 20:09.6f}" for i in range(COUNT)]
    path.write_text(text(table, times))
    (rows,) = read_results(path).maneuvers
    assert rows.time.tolist() == [1 + i / 20 for i in range(COUNT)]


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("unit", ["", "[rad]"])
def test_rows_with_their_names_in_front_are_columns(table, tmp_path, reference, separator, unit):
    path = tmp_path / "r.csv"
    lines = []
    for name in ("time", "steer_angle", "roll_angle"):
        beside = [unit.replace("rad", "s") if name == "time" else unit] if unit else []
        lines.append(separator.join([name, *beside, *(f"{x:.17g}" for x in table[name])]))
    path.write_text("\n".join(lines) + "\n")
    report = score(path, reference, maneuver=2)
    assert {c.key for c in report[2].columns} == {"roll_angle", "steer_angle"}
    assert min(c.scd for c in report[2].columns) > 15
    assert "transposed" in [f.code for f in report.findings]


@pytest.mark.parametrize("signs", [(1, 1, 1, 1), (1, -1, -1, 1), (-1, -1, -1, -1)])
@pytest.mark.parametrize("end", ["rear", "front"])
def test_a_quaternion_with_its_scalar_last_is_right(reference, signs, end):
    whole = reference.with_motion()
    keys = [f"{end}_frame_q{i}" for i in range(4)]
    parts = [s * whole[2].rows[k][::10] for s, k in zip(signs, keys, strict=True)]
    moved = dict(zip(keys, [*parts[1:], parts[0]], strict=True))
    report = score({"time": whole[2].time[::10]} | moved, whole)
    assert {*report.grades} == {Grade.RIGHT}
    assert min(c.scd for c in report[2].columns) > 14
    assert "scalar_last" in [f.code for f in report.findings]
    by_letter = dict(zip((f"{end}_frame_q{x}" for x in "wxyz"), parts, strict=True))
    report = score({"time": whole[2].time[::10]} | by_letter, whole)
    assert min(c.scd for c in report[2].columns) > 14
    assert "scalar_last" not in [f.code for f in report.findings]
