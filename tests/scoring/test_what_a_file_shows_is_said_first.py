"""Faults that a file shows without a simulation are found in files that are otherwise correct."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("heyoka")


from generators.correct_programs import fixed_step
from generators.fixed_steps import Equations as Discretised
from generators.made_results import made
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.scoring.diagnosis import visible_faults, wrong_columns
from heyoka_bike.scoring.diagnosis.diagnose import diagnose, diagnosed
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.rows.wrong_times import own_times as other_times
from heyoka_bike.scoring.score import score
from heyoka_bike.showing.formats.summary import diagnosis
from heyoka_bike.showing.wording import finding_text
from heyoka_bike.system.resources import data_folder


def shown(report):
    """The findings on faults that are visible at once."""
    return finding_text.findings(visible_faults.shown(report))


def columns_apart(report):
    seen = wrong_columns.columns_apart(report)
    return None if seen is None else seen.finding()


def report_of(reference, change, **more):
    return score(made(reference, change, **more), reference)


def test_a_right_file_shows_nothing(reference):
    report = report_of(reference, lambda key, values, m: values)
    assert shown(report) == ()
    assert columns_apart(report) is None


@pytest.mark.proof
def test_signs_that_contradict_each_other_are_not_called_right(reference):
    report = score(made(reference, lambda key, x, _: -x if key == "steer_rate" else x), reference)
    (said,) = diagnosed(report, reference).diagnosis
    assert said.code == "signs_disagree"
    assert "right by itself, but steer_angle and steer_rate have opposite signs" in said.message
    text = diagnosis(diagnosed(report, reference))
    assert " ".join(text.split()).count("steer_angle and steer_rate have opposite signs") == 1


@pytest.mark.proof
def test_a_bicycle_that_falls_over_is_told_so(reference):
    """A physics engine's default run, whose wheels have 32 corners."""
    file = data_folder() / "results" / "pybullet-default.txt.gz"
    results = read_results(file)
    report = score(results, reference)
    assert not [f for f in report.findings if f.code == "another_maneuver"]
    found, *_ = shown(report)
    table = np.loadtxt(file)
    for n in (1, 2, 3):
        fallen = table[np.abs(table[:, 8 * n - 7]) > np.pi / 2, 0]
        assert found.evidence["times"][str(n)] == pytest.approx(fallen[0], abs=0.2)
    said = diagnosed(report, reference).diagnosis
    assert [f.code for f in said] == ["falls_over"]


def test_degrees_do_not_fall_over(reference):
    def in_degrees(key, values, m):
        return 500.0 * values if key == "roll_angle" else values

    assert not shown(report_of(reference, in_degrees))


def test_rows_that_repeat_are_named_with_their_time(reference):
    def freeze(key, values, m):
        return np.where(np.arange(len(values)) > 500, values[500], values) if m == 3 else values

    (found,) = shown(report_of(reference, freeze))
    assert found.code == "rows_repeated"
    assert (found.evidence["maneuver"], found.evidence["time"]) == (3, 5.0)
    assert found.evidence["rows"] == 501


def test_some_columns_that_repeat_are_named_alone(reference):
    def freeze(key, values, m):
        late = (np.arange(len(values)) > 500) & (m == 2) & (key == "kinetic_energy")
        return np.where(late, values[500], values)

    (found,) = shown(report_of(reference, freeze))
    assert found.code == "rows_repeated"
    assert found.evidence["columns"] == ["kinetic_energy"]
    assert (found.evidence["time"], found.evidence["rows"]) == (5.0, 501)


DEPARTURES = {
    # For each case: the row that is written in each place, and the shift that this causes in the
    # times of all later rows [s].
    "a row is left out": (np.r_[:500, 501:1001, 1000], 0.01),
    "a row is written again": (np.r_[:500, 499:1000], -0.01),
}
ROWS_OF_OTHER_TIMES = {
    # For each case: the index of the row that is written in each place, and the earliest and the
    # latest of the exact times, relative to the written ones [s].
    "one row is not its own": (np.r_[:500, 499, 501:1001], (-0.01, -0.01)),
    "blocks are exchanged": (np.r_[:500, 520:540, 500:520, 540:1001], (-0.2, 0.2)),
    "a block repeats a row": (np.r_[:500, np.full(50, 500), 550:1001], (-0.467, -0.034)),
    "single rows repeat the row before": (
        np.where(
            np.isin(np.arange(1001), np.arange(7, 900, 23)), np.arange(-1, 1000), np.arange(1001)
        ),
        (-0.01, -0.01),
    ),
}


@pytest.mark.parametrize("what", DEPARTURES)
def test_a_motion_that_is_right_up_to_a_row_is_told_so(reference, what):
    rows, shift = DEPARTURES[what]

    def altered(key, values, m):
        return values[rows] if m == 2 else values

    report = report_of(reference, altered)
    (found,) = diagnosed(report, reference).diagnosis
    assert found.code == "departs"
    assert (found.evidence["maneuver"], found.evidence["time"]) == (2, 5.0)
    assert found.evidence["shift"] == pytest.approx(shift, rel=0.02)


@pytest.mark.parametrize("what", ROWS_OF_OTHER_TIMES)
def test_some_rows_of_other_times_are_counted(reference, what):
    rows, ahead = ROWS_OF_OTHER_TIMES[what]

    def altered(key, values, m):
        return values[rows] if m == 2 else values

    (found,) = diagnosed(report_of(reference, altered), reference).diagnosis
    assert found.code == "other_times"
    assert found.evidence["rows"] == {"2": int(np.sum(rows != np.arange(1001)))}
    assert found.evidence["ahead"]["2"] == pytest.approx(ahead, abs=0.002)
    assert f"{np.sum(rows != np.arange(1001))} of 1001 rows" in found.message


def test_rows_sorted_as_text_are_told_so(reference):
    rows = np.array(sorted(range(1001), key=str))
    (found,) = diagnosed(
        report_of(reference, lambda key, values, m: values[rows]), reference
    ).diagnosis
    assert found.code == "other_times"
    assert "not in the order of their times" in found.message


def test_the_example_of_unsorted_rows_is_from_an_unsorted_maneuver(reference):
    rows = np.array(sorted(range(1001), key=str))
    again = np.r_[:500, np.full(50, 500), 550:1001]
    report = report_of(
        reference, lambda key, values, m: values[{1: again, 3: rows}.get(m, slice(None))]
    )
    (found,) = diagnosed(report, reference).diagnosis
    assert "In maneuver 3, for example" in found.message


def test_many_rows_that_are_left_out_are_told_by_their_time(reference):
    rows = np.r_[:321, 358:1001]
    table = {"time": 0.01 * np.arange(len(rows))}
    table |= {f"{k}_{n}": reference[n][k][rows] for n in reference for k in BENCHMARK_COLUMNS}
    (found,) = diagnose(table, reference).diagnosis
    assert (found.code, found.evidence["maneuvers"]) == ("departs", [1, 2, 3])
    assert found.evidence["time"] == pytest.approx(3.21)
    assert found.evidence["shift"] == pytest.approx(0.37, abs=1e-6)
    assert found.message.startswith("Maneuvers 1, 2 and 3 are right until 3.2 s, but off by up to")


def test_a_departure_within_the_first_rows(reference):
    """For example, a limit is reached after 0.08 s: no smooth error grows as fast."""

    def altered(key, values, m):
        time = np.linspace(0.0, 10.0, len(values))
        other = 1e-2 * np.max(np.abs(values)) * np.cos(time)
        return np.where((time >= 0.08) & (m == 2), values + other, values)

    (found,) = diagnosed(report_of(reference, altered), reference).diagnosis
    assert (found.code, found.evidence["time"]) == ("departs", 0.08)


def test_nothing_is_simulated_where_all_that_is_wrong_departs(reference, caplog):
    def altered(key, values, m):
        return np.where(np.arange(len(values)) < 300, values, 1.01 * values)

    caplog.set_level("INFO", logger="heyoka_bike.scoring.diagnosis")
    (found,) = diagnosed(report_of(reference, altered), reference).diagnosis
    assert (found.code, found.evidence["maneuvers"]) == ("departs", [1, 2, 3])
    assert not any("start and output" in m for m in caplog.messages)


def test_a_motion_that_goes_on_from_rounded_numbers_is_told_so(reference):
    """From 5 s on the error behaves like a motion that grows or decays."""

    def altered(key, values, m):
        time = np.linspace(0.0, 10.0, len(values))
        other = 1e-5 * np.max(np.abs(values)) * np.exp(-0.5 * (time - 5.0)) * np.cos(time)
        return np.where((time >= 5.0) & (m == 1), values + other, values)

    (found,) = shown(report_of(reference, altered))
    assert (found.code, found.evidence["time"]) == ("departs", 5.0)
    assert found.evidence["shift"] is None


@pytest.mark.parametrize(
    ("ahead", "least", "most"),
    [
        (lambda row: 0.003 + 0.0 * row, 0.003, 0.003),
        # The times of the rows are rounded to fewer digits than the rows need.
        pytest.param(lambda row: 0.004 * (row % 3), 0.004, 0.008, marks=pytest.mark.proof),
    ],
)
def test_rows_at_other_times_are_told_so(reference, ahead, least, most):
    def altered(key, values, m):
        row = np.arange(len(values))
        meant = np.clip(row / 100 + ahead(row), 0.0, 10.0)
        return reference[m].approximate(meant, [key])[key]

    report = report_of(reference, altered)
    (found,) = diagnosed(report, reference).diagnosis
    if least == most:
        # If the shift is common to all rows, the finding is a shifted clock of all maneuvers.
        assert (found.code, found.evidence["maneuver"]) == ("other_clock", None)
        assert found.evidence["shift"] == pytest.approx(least, rel=1e-3)
        return
    assert found.code == "other_times"
    for bounds in found.evidence["ahead"].values():
        assert bounds == pytest.approx((least, most), abs=2e-4)


@pytest.mark.parametrize(("method", "step"), [("Heun", 0.01), ("explicit Euler", 0.001)])
def test_errors_of_phase_are_no_other_times(reference, method, step):
    """An integrator's rows are late, too, but each mode by another time."""
    run = fixed_step(Discretised(reference, is_regular=True), method, step)
    assert other_times(score(run, reference)) is None


def test_energies_alone_tell_no_other_times(reference):
    """If the sum of two energies is constant, they are one column, which cannot determine the
    times."""

    def altered(key, values, m):
        time = np.linspace(0.0, 10.0, len(values))
        return reference[m].approximate(np.clip(time + 0.01 * np.sin(time), 0, 10), [key])[key]

    results = made(reference, altered)
    keys = ("potential_energy", "kinetic_energy", "mechanical_energy")
    few = tuple(
        replace(rows, values={k: rows.values[k] for k in keys}) for rows in results.maneuvers
    )
    assert other_times(score(results, reference)) is not None
    assert other_times(score(replace(results, maneuvers=few), reference)) is None


def test_two_rows_at_one_time_are_diagnosed(reference):
    """Solvers write an event twice: before and after it."""
    results = made(reference, lambda key, values, m: 1.01 * values)
    twice = np.r_[:500, 499:1001]
    rows = [m.at(twice) for m in results.maneuvers]
    report = score(replace(results, maneuvers=tuple(rows)), reference)
    assert diagnosed(report, reference).diagnosis
    assert other_times(report) is None


def test_a_departure_is_seen_beside_a_column_of_unknown_definition(reference):
    def kicked(key, values, m):
        if key == "roll_angle":
            return values * 1.01
        time = reference[m].time
        return values + np.where(time > 5.0, 0.01 * np.max(np.abs(values)), 0.0)

    names = ("roll_angle", "steer_angle", "steer_rate")
    for found in shown(report_of(reference, kicked, names=names)):
        assert found.code == "departs"
        assert found.evidence["columns"] == ["steer_angle", "steer_rate"]
        assert found.evidence["time"] == pytest.approx(5.01)


def test_one_column_that_moves_tells_no_other_times(reference):
    """A single wrong column is always right at some other times. The energy must fit these times,
    too."""

    def wrong(key, values, m):
        time = reference[m].time
        return values * (1.0 + (0.05 if key == "roll_angle" else 1e-5) * np.sin(time))

    names = ("roll_angle", "forward_speed", "mechanical_energy")
    assert other_times(report_of(reference, wrong, names=names)) is None


def test_one_column_that_is_held_is_named_alone(reference):
    def held(key, values, _):
        return values[np.arange(len(values)) // 2 * 2] if key == "steer_rate" else values

    found = [f for f in shown(report_of(reference, held)) if f.code == "rows_between"]
    assert [f.evidence["maneuvers"] for f in found] == [[1, 2, 3]]
    assert all(f.evidence["columns"] == ["steer_rate"] for f in found)


@pytest.mark.parametrize("of", ["held at random", "interpolated"])
def test_a_column_of_few_that_repeats_is_named_alone(of, reference):
    """The other column is right, so the rows as a whole do not repeat."""
    row = np.arange(1001)
    is_stale = np.random.default_rng(1).random(1001) < 0.4
    rows = {
        "held at random": np.maximum.accumulate(np.where(is_stale, 0, row)),
        "interpolated": row,
    }[of]

    def altered(key, values, _):
        if key != "steer_rate":
            return values
        return np.interp(row, row[::5], values[::5]) if of == "interpolated" else values[rows]

    report = report_of(reference, altered, names=("roll_angle", "steer_rate"))
    (found,) = diagnosed(report, reference).diagnosis
    assert found.code == "rows_between"
    assert found.evidence["columns"] == ["steer_rate"]
    assert "of the values of steer_rate in maneuvers 1, 2 and 3" in found.message


def test_a_speed_that_settles_in_single_precision_is_not_held(reference, tmp_path):
    """The speed is constant over more and more rows, and in the end over all remaining rows."""
    time = np.linspace(0.0, 10.0, 10001)
    values = reference[3].approximate(time, list(BENCHMARK_COLUMNS))
    lines = (" ".join([f"{t:.3f}", *map(str, np.array(row, np.float32))])
             for t, *row in zip(time, *values.values(), strict=True))  # fmt: skip
    path = tmp_path / "r.txt"
    path.write_text("time " + " ".join(values) + "\n" + "\n".join(lines) + "\n")
    found = shown(score(path, reference, maneuver=3))
    assert "rows_repeated" not in [f.code for f in found]


@pytest.mark.parametrize("digits", [6, 9, 12])
def test_an_error_that_begins_later_and_grows_is_a_departure(reference, digits):
    """A force that starts at 5 s causes an error that grows with the square of the time since
    then."""

    def pushed(key, values, m):
        off = 0.3 * np.max(np.abs(values)) * np.maximum(reference[m].time - 5.0, 0.0) ** 2
        return np.array([float(f"{x:.{digits}g}") for x in values + off])

    (found,) = shown(report_of(reference, pushed))
    assert (found.code, found.evidence["maneuvers"]) == ("departs", [1, 2, 3])
    assert all(4.9 < t < 5.3 for t in found.evidence["times"].values())
    assert found.evidence["before"] < 10.0 ** (2 - digits)


def test_an_error_that_begins_small_is_no_departure(reference):
    """The error grows with a high power of the time, from the first row on."""

    def altered(key, values, m):
        return values + 1e-3 * np.max(np.abs(values)) * np.linspace(0.0, 1.0, len(values)) ** 8

    assert shown(report_of(reference, altered)) == ()


def test_columns_of_another_maneuver_are_named(reference):
    keys = ("steer_angle", "steer_rate")

    def copy(key, values, m):
        return reference[1][key] if key in keys and m == 3 else values

    (found,) = shown(report_of(reference, copy))
    assert found.code == "column_of_another_maneuver"
    assert found.evidence == {"maneuver": 3, "of": 1, "columns": list(keys)}


def test_the_start_of_another_definition_is_no_other_start(reference):
    """If the motion is wrong, the definition is undecided."""

    def other(key, values, m):
        if key != "forward_speed":
            return values
        norm = reference[m].approximate(reference[m].time, ["forward_speed_com_norm"])
        return norm["forward_speed_com_norm"] * (1.0 - 1e-3 * reference[m].time)

    assert shown(report_of(reference, other)) == ()


def test_another_start_is_named(reference):
    def faster(key, values, m):
        return values + 0.1 if key == "forward_speed" and m == 2 else values

    (found,) = shown(report_of(reference, faster))
    assert found.code == "another_start"
    assert found.evidence["maneuver"] == 2
    assert found.evidence["found"] == pytest.approx(4.7)
    assert found.evidence["unit"] is None


def test_equal_starts_of_several_maneuvers_are_one_finding(reference):
    def other(key, values, m):
        return np.where(np.arange(len(values)) < 1, 0.04, values) if key == "roll_rate" else values

    found = [f for f in shown(report_of(reference, other)) if f.code == "another_start"]
    assert [f.evidence["maneuvers"] for f in found] == [[1, 3], [2]]
    assert found[0].message.startswith("In the first row, roll_rate of maneuvers 1 and 3 is 0.04")


def test_a_unit_is_told_by_the_start_of_one_maneuver(reference):
    def fast(key, values, m):
        return 3.6 * values if (m, key) == (3, "forward_speed") else values

    (found,) = [f for f in shown(report_of(reference, fast)) if f.code == "another_start"]
    assert (found.evidence["maneuver"], found.evidence["unit"]) == (3, "km h-1")
    assert found.message.endswith("The ratio is 3.6, as if the value were in km/h")


@pytest.mark.parametrize("rest", [0.0, 1e-7])
@pytest.mark.parametrize("key", [k for k in BENCHMARK_COLUMNS if k != "mechanical_energy"])
def test_a_column_that_is_wrong_alone_is_named_alone(reference, key, rest):
    """The error is a hundredth of the column's own size, be it thousands of joules or a thousandth
    of a radian."""

    def bend(found, values, m):
        size, own = (np.max(np.abs(reference[m][k])) for k in (key, found))
        wave = np.sin(np.linspace(0.0, 7.0, len(values)))
        # An error of the potential or kinetic energy also enters their sum.
        is_sum = found == "mechanical_energy" and key in ("potential_energy", "kinetic_energy")
        return values + wave * (0.01 * size if found == key or is_sum else rest * own)

    found = columns_apart(report_of(reference, bend))
    assert found is not None
    assert found.evidence["columns"] == {key: [1, 2, 3]}
    assert found.evidence["max_rel_error_of_others"] == pytest.approx(rest, rel=0.1, abs=1e-12)


def test_a_right_potential_energy_shows_that_the_angles_are_written_wrongly(reference):
    def compressed(key, values, _):
        if not key.startswith(("roll", "steer")):
            return values
        coarse = values[::20]
        return np.interp(np.arange(len(values)), np.arange(len(coarse)) * 20, coarse**3)

    found = columns_apart(report_of(reference, compressed))
    assert {*found.evidence["columns"]} == {"roll_angle", "roll_rate", "steer_angle", "steer_rate"}


@pytest.mark.parametrize("is_noise", [True, False])
def test_noise_of_columns_that_are_wrong_alone_is_named(is_noise, reference):
    random = np.random.default_rng(5)

    def measured(key, values, _):
        if key not in LATERAL:
            return values
        wave = np.sin(np.linspace(0.0, 7.0, len(values)))
        off = random.normal(size=len(values)) if is_noise else wave
        return values + 0.005 * np.max(np.abs(values)) * off

    found = diagnosed(report_of(reference, measured), reference).diagnosis
    assert [f.code for f in found if f.code in ("columns_apart", "rough_error")] == (
        ["columns_apart", "rough_error"] if is_noise else ["columns_apart"]
    )
    rough = [f.message for f in found if f.code == "rough_error"]
    assert all("The error jumps from row to row like noise" in message for message in rough)


def test_two_right_columns_are_enough(reference):
    """The potential energy lacks all masses but the frame's, and so does the sum; lean and kinetic
    energy are right."""

    def lighter(key, values, m):
        lost = 0.1 * reference[m]["potential_energy"]
        return values - lost if key in ("potential_energy", "mechanical_energy") else values

    kept = ("roll_angle", "potential_energy", "kinetic_energy", "mechanical_energy")
    found = columns_apart(report_of(reference, lighter, names=kept))
    assert found.evidence["columns"] == {"potential_energy": [1, 2, 3]}
    assert found.evidence["factors"]["potential_energy"] == pytest.approx(0.9)


def test_where_the_motion_is_wrong_no_column_is_blamed(reference):
    """All columns have errors, some much smaller ones: such errors come from an integrator."""
    sizes = dict(
        zip(BENCHMARK_COLUMNS, (1e-3, 1e-3, 1e-5, 1e-5, 1e-5, 1e-6, 1e-3, 1e-2), strict=True)
    )

    def bend(key, values, m):
        size = np.max(np.abs(reference[m][key]))
        return values + sizes[key] * size * np.sin(np.linspace(0.0, 7.0, len(values)))

    assert columns_apart(report_of(reference, bend)) is None


@pytest.mark.parametrize(("order", "digits"), [(0, 17), (0, 7), (1, 17), (1, 12)])
def test_rows_between_those_of_an_integrator_are_named(reference, order, digits):
    """All angles and rates of one maneuver are held, or interpolated linearly, between some
    rows."""

    def between(key, values, m):
        if m != 2:
            return values
        rows = np.arange(len(values))
        few = np.interp(rows, rows[::8], values[::8]) if order else values[rows // 8 * 8]
        return np.array([float(f"{x:.{digits - 1}e}") for x in few])

    (found,) = shown(report_of(reference, between))
    assert found.code == "rows_between"
    assert found.evidence["maneuver"] == 2
    assert found.evidence["order"] == order


@pytest.mark.parametrize(
    "rounded",
    [
        lambda key, values, m: np.round(values, 3),
        lambda key, values, m: np.round(0.01 * values, 5),
        lambda key, values, m: np.array([float(f"{x:.3g}") for x in values]),
    ],
)
def test_rows_of_few_digits_are_not_between_others(reference, rounded):
    assert not [f for f in shown(report_of(reference, rounded)) if f.code == "rows_between"]
