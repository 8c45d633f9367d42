"""Times in minutes, milliseconds or nanoseconds, and times of a clock, are read with their unit."""

import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

from generators.made_results import is_right_in_part
from generators.published_columns import published_columns
from heyoka_bike import diagnose, score
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.evidence.as_compared import TimesInLargerUnit
from heyoka_bike.scoring.evidence.as_read import TimesFromFirst, TimeUnitContradicted

KEYS = ("roll_angle", "roll_rate", "forward_speed", "steer_angle", "steer_rate")
PER_SECOND = {
    "ms": Fraction(1000), "us": Fraction(10**6), "ns": Fraction(10**9), "min": Fraction(1, 60),
    "h": Fraction(1, 3600), "s": Fraction(1),
}  # fmt: skip


def table(reference, heading, times, number=2):
    m = reference[number]
    return {heading: times, **{k: m[k] for k in KEYS}}


@pytest.mark.parametrize("unit", PER_SECOND)
@pytest.mark.parametrize("form", ["time [{}]", "t ({})", "time_{}"])
def test_the_unit_of_the_heading_is_that_of_the_times(unit, form, reference, tmp_path):
    m = reference[2]
    exact = [Fraction(i, 100) * PER_SECOND[unit] for i in range(1001)]
    lines = [",".join([form.format(unit), *KEYS])]
    lines += [
        ",".join([repr(float(t)), *(repr(float(m[k][i])) for k in KEYS)])
        for i, t in enumerate(exact)
    ]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(lines) + "\n")
    report = score(path, reference)
    assert is_right_in_part(report)
    assert [x.maneuver for x in report.maneuvers] == [2]
    assert report.worst.scd > 13


@pytest.mark.parametrize("unit", ["ms", "us", "min", "h"])
def test_a_heading_that_the_times_contradict_is_a_warning(unit, reference):
    report = score(table(reference, f"time [{unit}]", reference[2].time), reference)
    (found,) = [x for x in report.seen if isinstance(x, TimeUnitContradicted)]
    assert (found.named, found.span) == (unit, pytest.approx(10, rel=1e-12))
    assert is_right_in_part(report)
    assert [m.maneuver for m in report.maneuvers] == [2]
    assert "time_unit_contradicted" in [f.code for f in report.findings]


@pytest.mark.parametrize("first", [1.7e9, 1764300000.25])
def test_times_of_a_clock_count_from_the_first(first, reference):
    times = first + reference[2].time
    report = score(table(reference, "time", times), reference)
    (found,) = [x for x in report.seen if isinstance(x, TimesFromFirst)]
    assert found.first == times[0]
    # Seconds since 1970, stored in binary64, have seven digits after the decimal point.
    assert report.worst.scd > 4
    assert [m.maneuver for m in report.maneuvers] == [2]


def test_a_run_that_begins_late_is_no_clock(reference):
    m = reference[2]
    late = {"time": m.time[500:], **{k: m[k][500:] for k in KEYS}}
    report = score(late, reference)
    assert not any(isinstance(x, TimesFromFirst) for x in report.seen)
    assert np.isclose(report[2].coverage, 0.5)


@pytest.mark.parametrize(("unit", "per_second"), [("ns", 10**9), ("us", 10**6), ("ms", 1000)])
def test_a_clock_may_count_smaller_units(unit, per_second, reference):
    first = 1764300000 * per_second
    times = np.array([first + i * per_second // 100 for i in range(1001)], dtype=np.int64)
    report = score(table(reference, "time", times), reference)
    (found,) = [x for x in report.seen if isinstance(x, TimesFromFirst)]
    assert found.unit == unit
    assert [m.maneuver for m in report.maneuvers] == [2]
    assert report[2].coverage > 0.99
    assert report.worst.scd > 4


@pytest.mark.parametrize(
    ("seconds", "nanoseconds"),
    [
        ("secs", "nsecs"),
        ("sec", "nanosec"),
        ("field.header.stamp.secs", "field.header.stamp.nsecs"),
    ],
)
def test_seconds_and_nanoseconds_beside_each_other(seconds, nanoseconds, reference, tmp_path):
    m = reference[2]
    lines = [",".join([seconds, nanoseconds, *KEYS])]
    lines += [
        ",".join([str(i // 100), str(i % 100 * 10**7), *(repr(float(m[k][i])) for k in KEYS)])
        for i in range(1001)
    ]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(lines) + "\n")
    report = score(path, reference)
    assert is_right_in_part(report)
    assert report.worst.scd > 13
    assert not [f for f in report.findings if f.code == "columns_left_out"]


def test_time_differences_are_times(reference, tmp_path):
    m = reference[2]
    times = np.array([i * 10_000_000 for i in range(1001)], dtype="m8[ns]")
    assert score(table(reference, "time", times), reference).worst.scd > 13
    lines = [",".join(["time", *KEYS])]
    lines += [
        f"0 days 00:00:{i / 100:09.6f}," + ",".join(repr(float(m[k][i])) for k in KEYS)
        for i in range(1001)
    ]
    path = tmp_path / "r.csv"
    path.write_text("\n".join(lines) + "\n")
    assert score(path, reference).worst.scd > 13


def test_a_file_that_is_open_elsewhere_is_called_so(tmp_path):
    path = tmp_path / "r.h5"
    code = (
        "import h5py, sys; f = h5py.File(sys.argv[1], 'w'); f['x'] = 1.0; f.flush(); "
        "print('ready', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as writer:
        assert writer.stdout.readline() == b"ready\n"
        with pytest.raises(InputError, match="another program has open") as caught:
            score(path)
        assert "\n" not in str(caught.value)
        writer.communicate(b"")


def larger_units(report):
    return [x.unit for x in report.seen if isinstance(x, TimesInLargerUnit)]


@pytest.mark.parametrize(("unit", "seconds"), [("minutes", 60), ("hours", 3600)])
@pytest.mark.parametrize("every", [1, 20, 140])
@pytest.mark.parametrize("factor", [1.0, 1.5])
def test_larger_units_are_asked_about_where_angles_are_too_fast(
    unit, seconds, every, factor, reference
):
    """Read in seconds, angles change much faster than their rates, whether the motion is right or
    wrong."""
    few = slice(None, None, every)
    for number in reference:
        m = reference[number]
        angles = {k: factor * m[k][few] for k in KEYS}
        report = score({"time": m.time[few] / seconds, **angles}, reference, maneuver=number)
        assert larger_units(report) == [unit]
        (finding,) = [f for f in report.findings if f.code == "time_in_larger_unit"]
        assert f"Are the times in {unit}?" in finding.message


@pytest.mark.parametrize("end", [0.02, 0.1, 0.17])
@pytest.mark.parametrize("degrees", [(), ("angle",), ("rate",), ("angle", "rate")])
def test_a_short_run_is_in_seconds(end, degrees, reference):
    """Angles change as their rates require; only the unit degrees makes them look faster."""
    m = reference[2]
    times = np.linspace(0.0, end, 30)
    columns = {k: np.asarray(m.evaluate(times, [k])[k]) for k in KEYS}
    for key in columns:
        if key.endswith(degrees):
            columns[key] = np.degrees(columns[key])
    report = score({"time": times, **columns}, reference, maneuver=2)
    assert not larger_units(report)


def test_what_remains_of_a_run_in_minutes_is_diagnosed(reference):
    table = published_columns(reference, keys=KEYS) | {"time": reference[2].time / 60}
    report = diagnose(table, reference, maneuver=2)
    first, *others = [f.code for f in report.diagnosis]
    assert first == "time_in_larger_unit"
    # After conversion to seconds, the rows are correct up to the rounding of the times.
    assert {*others} <= {"no_mistake_found", "limited_by_rounding"}


def test_a_diagnosis_begins_with_the_unit_of_times(reference):
    table = published_columns(reference, keys=KEYS) | {"time": reference[2].time * 1000}
    report = diagnose(table, reference, maneuver=2)
    assert [f.code for f in report.diagnosis] == ["time_outside"]
    assert report.diagnosis[0].message.endswith("are the times in milliseconds?")
