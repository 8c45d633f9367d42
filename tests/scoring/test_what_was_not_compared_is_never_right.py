"""A column that was not compared keeps a result from being correct, whatever its name is.

All eight columns are required, so no name, position, number, unit or neighbour of a wrong column
can hide it. A second column of a compared quantity with other values is not ignored either. Columns
with a meaning of their own, in addition to all eight, do not matter.
"""

import json
from functools import cache
from itertools import product

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generators.published_columns import published_columns, write_csv
from heyoka_bike import load_reference, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.cli import main
from heyoka_bike.errors import BicycleError, InputError
from heyoka_bike.scoring.evidence.as_read import NotCompared
from heyoka_bike.scoring.reading.names.heading import parse_heading

LONG = "(rear frame, measured about its x axis)"


@cache
def right(number=2):
    return published_columns(load_reference(), number, every=10)


def wrong(key, number=2):
    return 1.3 * right(number)[key] + 0.01


def renamed(names, columns):
    return {names.get(key, key): x for key, x in columns.items()}


def few(number=2):
    """Too few columns to be recognised by their order alone."""
    return {key: x for key, x in right(number).items() if key != "mechanical_energy"}


def judged(path, *required):
    return score(path, require=["scd >= 6", *required])


def assert_not_whole(report, name):
    assert not report.is_whole
    assert not report.is_right
    assert not any(r.met for r in report.requirements)
    left_out = (x for e in report.seen if isinstance(e, NotCompared) for x in e.columns)
    assert name in {x.name for x in (*left_out, *report.not_compared)}
    said = report.verdict.partition(": ")[2]
    assert not said.startswith("right") or said.startswith("right, compared only in part")


@pytest.mark.parametrize("name", [
    "roll_angle 2", f"roll_angle [rad] {LONG} 2", f"roll_angle [rad] ({'very ' * 200}long) 2",
    "roll_angle_17", "Roll Angle (deg) 2",
])  # fmt: skip
def test_a_second_column_of_a_quantity(name, tmp_path):
    columns = {**right(), name: wrong("roll_angle")}
    report = judged(write_csv(tmp_path / "a.csv", columns), "roll_angle.scd >= 6")
    assert_not_whole(report, name)


@pytest.mark.parametrize("behind", [
    "_2", " 2", ".1", " (2)", "#2", "*", ":1", " 2nd", "_m2_2",
    f" [rad] {LONG} 2", f" [rad] ({'very ' * 200}long) 2",
])  # fmt: skip
def test_a_second_column_of_a_maneuver(behind, tmp_path):
    """pandas writes a second column of the same name with `.1`."""
    columns = {f"m2_{key}" if key != "time" else key: x for key, x in right().items()}
    name = f"m2_roll_angle{behind}"
    report = judged(write_csv(tmp_path / "a.csv", {**columns, name: wrong("roll_angle")}))
    assert_not_whole(report, name)


@pytest.mark.parametrize("heading", ["m2_{}", "{}"])
@pytest.mark.parametrize(("second", "factor"), [
    ("roll_angle [deg]", np.rad2deg(1.0)), ("roll_angle_rad", 1.0), ("lean_deg", np.rad2deg(1.0)),
    ("roll_angle [mrad]", 1000.0),
])  # fmt: skip
def test_a_second_column_in_another_unit_is_held_against_the_first(
    heading, second, factor, tmp_path
):
    columns = {heading.format(key) if key != "time" else key: x for key, x in right().items()}
    second = heading.format(second)
    twice = factor * right()["roll_angle"]
    same = write_csv(tmp_path / "same.csv", {**columns, second: twice})
    assert judged(same).is_right
    # The second column has the same values, rounded like a program's output. In the next file, one
    # of its values is different.
    rounded = {**columns, second: np.round(twice, 4)}
    np.savetxt(
        tmp_path / "rounded.csv", np.column_stack(list(rounded.values())), delimiter=",",
        header=",".join(rounded), comments="", fmt=["%.17g"] * 9 + ["%.4f"],
    )  # fmt: skip
    assert judged(tmp_path / "rounded.csv").is_right
    twice[40] *= 1.001
    report = judged(write_csv(tmp_path / "other.csv", {**columns, second: twice}))
    assert_not_whole(report, second)
    assert "has different values" in next(
        f.message for f in report.findings if f.code == "known_columns_left_out"
    )


@pytest.mark.filterwarnings("error")
def test_infinite_values_hide_no_other_value(tmp_path):
    """An infinite value once made every difference look small, and NumPy warned of it."""
    roll = right()["roll_angle"].copy()
    roll[70] = np.inf
    columns = {**right(), "roll_angle": roll, "roll_angle [deg]": np.rad2deg(roll)}
    same = judged(write_csv(tmp_path / "same.csv", columns))
    assert "roll_angle [deg]" not in {x.name for x in same.not_compared}
    columns["roll_angle [deg]"][40] *= 1.001
    other = judged(write_csv(tmp_path / "other.csv", columns))
    assert "roll_angle [deg]" in {x.name for x in other.not_compared}


@pytest.mark.parametrize("count", [1, 100, 10_000])
def test_among_any_number_of_others(count, tmp_path):
    others = {f"sensor {i} of the frame": np.zeros(3) for i in range(count)}
    first = {key: x[:3] for key, x in right().items()}
    name = f"roll_angle {LONG} 2"
    report = judged(
        write_csv(tmp_path / "a.csv", {**first, **others, name: first["roll_angle"] + 1})
    )
    assert_not_whole(report, name)


@pytest.mark.parametrize("name", ["m1_steer_angle_2", "m4_steer_angle"])
def test_a_quantity_that_is_numbered_for_no_maneuver(name, tmp_path, capsys):
    columns = {"time": right(1)["time"]}
    columns |= {f"m1_{key}": x for key, x in few(1).items() if key not in ("time", "steer_angle")}
    path = write_csv(tmp_path / "a.csv", {**columns, name: wrong("steer_angle", 1)})
    assert_not_whole(judged(path), name)
    assert main(["score", str(path), "--require", "scd >= 6"]) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "right, compared only in part (6 of 8 columns" in said
    assert f"{name} is not compared" in said


@pytest.mark.parametrize("name", [
    "field.forward_speed", "bike state.Forward Speed", "x_forward_speed_raw", "chassis.speed",
])  # fmt: skip
def test_a_known_name_that_is_not_understood(name, tmp_path):
    assert parse_heading(name).meaning is None
    columns = renamed({"forward_speed": name}, {**few(), "forward_speed": wrong("forward_speed")})
    report = judged(write_csv(tmp_path / "a.csv", columns))
    assert_not_whole(report, name)
    (finding,) = (f for f in report.findings if f.code == "columns_not_understood")
    assert finding.evidence["columns"] == ["forward_speed"]


def test_a_unit_that_is_none_leaves_the_name_as_it_is(tmp_path):
    columns = renamed(
        {"forward_speed": "forward_speed [\u2603/s]"},
        {**few(), "forward_speed": wrong("forward_speed")},
    )
    report = judged(write_csv(tmp_path / "a.csv", columns))
    assert not report.is_right
    assert "unit_unknown" in [f.code for f in report.findings]


def test_one_maneuver_of_several(tmp_path):
    columns = {"time": right(1)["time"]}
    for n, key in product((1, 2, 3), [key for key in few() if key != "time"]):
        is_odd = (n, key) == (2, "roll_rate")
        name = "m2_x_roll_rate_raw" if is_odd else f"m{n}_{key}"
        columns[name] = wrong(key, n) if is_odd else right(n)[key]
    path = write_csv(tmp_path / "a.csv", columns)
    assert_not_whole(judged(path), "m2_x_roll_rate_raw")
    # The result of the other maneuver does not change.
    enough = ["1.columns >= 7", "2.columns >= 7"]
    met = {n: score(path, require=[f"{n}.scd >= 6", *enough]).requirements for n in (1, 2)}
    assert [[r.met for r in met[n]] for n in (1, 2)] == [[True, True, False], [True, True, False]]


def test_columns_beside_a_table_that_has_all(tmp_path):
    table = np.column_stack(list(right().values()))
    np.savez(tmp_path / "a.npz", run=table, roll_angle=wrong("roll_angle"))
    assert_not_whole(score(tmp_path / "a.npz", require="scd >= 6", maneuver=2), "roll_angle")
    np.savez(tmp_path / "b.npz", run=table, speed=4.6)
    assert score(tmp_path / "b.npz", require="scd >= 6", maneuver=2).is_right


def test_columns_beside_groups_of_maneuvers(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as f:
        for number in (1, 2):
            for key, x in right(number).items():
                f[f"maneuver_{number}/{key}"] = x
        f["steer_angle"] = wrong("steer_angle")
    assert_not_whole(judged(tmp_path / "a.h5"), "steer_angle")


@pytest.mark.parametrize("name", ["maneuver_2_old", "copy/maneuver_2", "debug/state", "tried"])
@pytest.mark.parametrize("is_table", [False, True])
def test_tables_beside_groups_of_maneuvers(name, is_table, tmp_path):
    """These tables once were not even named."""
    with h5py.File(tmp_path / "a.h5", "w") as f:
        for key, x in right().items():
            f[f"maneuver_2/{key}"] = x
        f["notes/made"] = 2026
    assert judged(tmp_path / "a.h5").is_right
    with h5py.File(tmp_path / "a.h5", "a") as f:
        if is_table and "/" not in name:
            f[name] = np.column_stack(list(right().values())) * 1.3
            lost = name
        else:
            f[f"{name}/steer_rate"] = wrong("steer_rate")
            lost = f"{name.replace('/', '.')}.steer_rate"
    assert_not_whole(judged(tmp_path / "a.h5"), lost)


@pytest.mark.parametrize("title", ["maneuver_2_old", "Sheet1"])
def test_sheets_beside_those_of_maneuvers(title, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "notes"
    book.active.append(["made by", "a program"])
    for name in ("maneuver_2", title):
        sheet = book.create_sheet(name)
        sheet.append([*right()])
        factor = 1.3 if name == title else 1.0
        for row in np.column_stack(list(right().values())) * ([1.0] + [factor] * len(KEYS)):
            sheet.append(row.tolist())
    book.save(tmp_path / "b.xlsx")
    assert_not_whole(judged(tmp_path / "b.xlsx"), title)
    del book[title]
    book.save(tmp_path / "a.xlsx")
    assert judged(tmp_path / "a.xlsx").is_right


def test_a_maneuver_that_the_reference_does_not_have(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as f:
        for number in (1, 2, 4):
            for key, x in right(min(number, 3)).items():
                f[f"maneuver_{number}/{key}"] = x
    report = score(tmp_path / "a.h5", require=["scd >= 6", "1.scd >= 6"])
    assert not report.is_whole
    assert [r.met for r in report.requirements] == [False, True]


@pytest.mark.parametrize(
    "name", ["bike.Steer_Joint.Rz.q#12", "model.steer.phi.0", "Bicycle_Steer_Joint_Rz_q__unit"]
)
def test_an_angle_of_a_joint_whose_index_means_nothing(name, tmp_path):
    columns = renamed({"steer_angle": name}, {**few(), "steer_angle": wrong("steer_angle")})
    assert_not_whole(judged(write_csv(tmp_path / "a.csv", columns)), name)
    # If the file also contains the steer angle itself, the column with the odd name may be
    # anything.
    columns = {**right(), name: wrong("steer_angle")}
    assert judged(write_csv(tmp_path / "b.csv", columns)).is_right


def test_a_torque_of_a_joint_is_no_column_of_the_result(tmp_path):
    others = {name: wrong("steer_angle") for name in ("bike.Steer_Joint.Rz.t#1", "rider_lean")}
    columns = {key: x for key, x in {**few(), **others}.items() if key != "roll_angle"}
    assert judged(write_csv(tmp_path / "a.csv", columns), "columns >= 6").passed


@pytest.mark.parametrize("style", ["field.{}_m2", "maneuver_2.{}", "m2_{}", "bike.{}_m2"])
def test_short_names_with_a_maneuver_and_a_path(style, tmp_path):
    short = {"potential_energy": "V", "kinetic_energy": "T", "forward_speed": "velocity"}
    columns = renamed({key: style.format(x) for key, x in short.items()}, few())
    columns = {**columns, style.format("T"): wrong("kinetic_energy")}
    report = judged(write_csv(tmp_path / "a.csv", columns))
    assert not report.is_right
    assert not report.passed


def test_columns_are_not_taken_by_place_against_what_their_names_hold(tmp_path):
    keys = ["time", *reversed(KEYS)]
    columns = {f"my_{key}_value": right()[key] for key in keys}
    with pytest.raises(BicycleError, match=r"column names 'my_time_value', .* not understood"):
        score(write_csv(tmp_path / "a.csv", columns))
    # If all columns are in the standard order, their names do not matter.
    columns = {f"my_{key}_value": right()[key] for key in ("time", *KEYS)}
    assert score(write_csv(tmp_path / "b.csv", columns), maneuver=2).is_right


@pytest.mark.parametrize("name", [
    "roll_angle_setpoint", "steer_angle_error", "wheel speed front", "roll_angle.filtered", "u1",
    "wheel_speed", "q7", "torque", "roll_angle^2", "|roll_angle|", "roll_angle\u00b2",
    "roll_angle_of_the_rider",
])  # fmt: skip
def test_a_column_with_a_meaning_of_its_own(name, tmp_path):
    report = judged(write_csv(tmp_path / "a.csv", {**right(), name: wrong("roll_angle")}))
    if name == "u1":
        # The file already contains a potential energy, so u1 may be another potential energy.
        assert not report.is_right
        return
    assert report.is_right
    assert report.passed


words = st.text("bcdfghjklmnqrswxyz", min_size=3, max_size=60)
around = st.one_of(
    words.map(lambda word: f"{word}.{{}}"),
    words.map(lambda word: f"{word}_{{}}"),
    words.map(lambda word: f"{{}}_{word}"),
    words.map(lambda word: f"{{}} [{word}]"),
)


@settings(max_examples=60)
@given(st.sampled_from(KEYS), around, st.integers(0, 30))
def test_names_drawn_at_random(tmp_path_factory, key, around, others):
    columns = renamed({key: around.format(key)}, {**right(), key: wrong(key)})
    columns |= {f"sensor {i}": np.zeros(101) for i in range(others)}
    path = write_csv(tmp_path_factory.mktemp("drawn") / "a.csv", columns)
    try:
        report = judged(path)
    except BicycleError:
        return
    assert not report.is_right
    assert not report.passed


@pytest.mark.parametrize("suffix", [".h5", ".npz", ".json"])
@pytest.mark.parametrize("shape", [(-1, 2), (2, -1, 1), (1, -1, 3)])
def test_a_known_name_of_what_is_no_column(suffix, shape, tmp_path):
    """The name belongs to an array of more than one axis; all other columns are correct."""
    columns = {key: x for key, x in right().items() if key != "roll_angle"}
    path = tmp_path / f"a{suffix}"
    no_column = np.arange(len(columns["time"]) // 6 * 6.0).reshape(shape)
    if suffix == ".h5":
        with h5py.File(path, "w") as file:
            file.update(columns | {"roll_angle": no_column})
    elif suffix == ".npz":
        np.savez(path, **columns, roll_angle=no_column)
    else:
        every = {key: x.tolist() for key, x in columns.items()}
        path.write_text(json.dumps(every | {"roll_angle": no_column.tolist()}))
    report = judged(path)
    assert_not_whole(report, "roll_angle")
    (found,) = [f for f in report.findings if f.code == "known_columns_left_out"]
    assert found.message.endswith("more than one axis: write one value for each time")


@pytest.mark.parametrize("found", [[0.1, [0.2]], [[], []], [None, {"x": 1}]])
def test_a_list_of_json_that_is_no_column_is_refused(found, tmp_path):
    every = {key: x.tolist() for key, x in right().items()}
    path = tmp_path / "a.json"
    path.write_text(json.dumps(every | {"roll_angle": found}))
    with pytest.raises(InputError, match="roll_angle: found a list that is not a column, expected"):
        judged(path)


@pytest.mark.parametrize("said", [None, [], 0.05, "see above", {}, True])
def test_what_json_says_once_of_a_quantity_is_no_column(said, tmp_path):
    """The single value is a number, a word, or nothing."""
    every = {key: x.tolist() for key, x in right().items()}
    path = tmp_path / "a.json"
    path.write_text(json.dumps(every | {"roll_rate": said}))
    report = judged(path, "columns >= 7")
    assert report.passed
    assert "roll_rate" not in {c.key for m in report.maneuvers for c in m.columns}
