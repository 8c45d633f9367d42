"""Names that are paths are understood, and determine the columns whatever their order.

Eight exact names with the prefix ``bike.``, in an unusual order, were once read by position. A
correct file then had an error of 5,900 times its scale.
"""

import json
import pickle

import h5py
import numpy as np
import pytest

from generators.made_results import is_right_in_part
from generators.published_columns import published_table
from heyoka_bike import read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.names.heading import parse_heading, with_unit
from heyoka_bike.scoring.reading.names.paths import without_paths

ORDER = ("forward_speed", "steer_rate", "roll_angle", "mechanical_energy", "roll_rate",
         "potential_energy", "kinetic_energy", "steer_angle")  # fmt: skip
PATHS = ["bike.{}", "field.{}", "/bike/state/{}", "model.bike.{}", "a::b::{}", "bike|{}",
         "/robot/{}/data", "('bike', '{}')", "bike:{}", "bike\\{}"]  # fmt: skip


def written(path, names, columns, separator=","):
    rows = zip(*(x.tolist() for x in columns), strict=True)
    quoted = [f'"{n}"' if "," in n else n for n in names]
    lines = [separator.join(quoted), *(separator.join(map(repr, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("form", PATHS)
@pytest.mark.parametrize("keys", [ORDER, ORDER[:5]])
def test_a_path_is_its_last_step(form, keys, reference, tmp_path):
    m = reference[2]
    path = written(tmp_path / "r.csv", ["time", *map(form.format, keys)],
                   [m.time, *(m[k] for k in keys)])  # fmt: skip
    report = score(path, reference, maneuver=2)
    assert is_right_in_part(report)
    assert {c.key for c in report[2].columns} == {*keys}
    # Read the same columns from arrays in memory.
    arrays = {form.format(k): m[k] for k in keys}
    assert is_right_in_part(score({"time": m.time, **arrays}, reference, maneuver=2))


@pytest.mark.parametrize("form", PATHS)
def test_a_wrong_column_under_a_path_is_wrong(form, reference, tmp_path):
    m = reference[2]
    keys = ("roll_angle", "forward_speed", "steer_angle")
    columns = [m.time, m["roll_angle"], 1.1 * m["forward_speed"], m["steer_angle"]]
    path = written(tmp_path / "r.csv", ["time", *map(form.format, keys)], columns)
    report = score(path, reference, "scd >= 6", maneuver=2)
    assert not report.is_right
    assert not report.passed


@pytest.mark.parametrize(
    ("names", "found"),
    [
        # If the file contains only one name with a path, it may be the name of a part.
        (["time", "roll_angle", "wheel.forward_speed"], None),
        # Words and letters in the path of a part do not refer to the bicycle.
        (["time", "roll_angle", "wheel.speed", "wheel.phi"], None),
        # A set point is named after the quantity that it prescribes.
        (["time", "roll_angle", "steer_angle", "ref.roll_angle", "ref.steer_angle"], None),
        # If the file contains two bicycles, neither takes precedence.
        (["time", "a.roll_angle", "a.roll_rate", "b.roll_angle", "b.roll_rate"], None),
        (["t", "a.roll_angle", "a.roll_rate"], ["t", "roll_angle", "roll_rate"]),
        (["a.time", "a.roll_angle [deg/s]", "a.v [m/s]"],
         ["time", "roll_angle [deg/s]", "v [m/s]"]),
        (["time [s]", "bike.roll_angle [rad]", "bike.roll_rate [rad/s]"],
         ["time [s]", "roll_angle [rad]", "roll_rate [rad/s]"]),
        (["('', 'time')", "('m1', 'roll_angle')", "('m2', 'roll_angle')"],
         ["time", "m1.roll_angle", "m2.roll_angle"]),
    ],
)  # fmt: skip
def test_names_that_are_recognised_and_names_that_are_left_out(names, found):
    assert without_paths(names) == (names if found is None else found)


def test_two_bicycles_are_refused_by_their_names(reference, tmp_path):
    m = reference[2]
    names = ["time", *(f"{x}.{k}" for x in "ab" for k in ("roll_angle", "roll_rate"))]
    path = written(tmp_path / "r.csv", names, [m.time, *2 * [m["roll_angle"], m["roll_rate"]]])
    with pytest.raises(InputError, match=r"'a\.roll_angle'"):
        read_results(path)


def test_a_joint_of_that_name_beside_the_column_is_refused_by_name(reference, tmp_path):
    m = reference[2]
    names = ["time", "roll_angle", "roll_rate", "ref.roll_angle", "ref.roll_rate"]
    path = written(tmp_path / "r.csv", names,
                   [m.time, *2 * [m["roll_angle"], m["roll_rate"]]])  # fmt: skip
    with pytest.raises(InputError, match=r"'roll_angle' and 'ref\.roll_angle'"):
        read_results(path)


@pytest.mark.parametrize("degree", ["°", "º", "˚", "Â°", "\ufffd"])
def test_degree_signs_of_any_keyboard_and_encoding(degree, reference, tmp_path):
    assert parse_heading(f"roll_rate [{degree}/s]").meaning == ("roll_rate", None)
    m = reference[2]
    keys = ("roll_angle", "roll_rate", "steer_angle", "steer_rate")
    names = [f"{k} [{degree}{'/s' if 'rate' in k else ''}]" for k in keys]
    columns = [180 / np.pi * m[k] * (1.5 if "rate" in k else 1.0) for k in keys]
    path = written(tmp_path / "r.csv", ["time", *names], [m.time, *columns])
    report = score(path, reference, "scd >= 6", maneuver=2)
    assert not report.passed
    assert {c.key for c in report[2].columns} == {*keys}
    assert ": wrong" in report.verdict


def test_columns_that_pandas_indexes_are_read(tmp_path):
    """The layout ``table`` with ``data_columns``, which are stored apart from the block of the
    others."""
    kinds = [("index", "i8"), ("values_block_0", "f8", (2,)), ("time", "f8"), ("vx", "f8")]
    rows = np.zeros(5, kinds)
    rows["index"], rows["time"], rows["vx"] = np.arange(5), np.arange(5) / 10, 4.0
    rows["values_block_0"] = [[0.1, 0.2]] * 5
    with h5py.File(tmp_path / "r.h5", "w") as f:
        frame = f.create_group("bike")
        frame.attrs["pandas_type"] = np.bytes_("frame_table")
        frame["table"] = rows
        names = pickle.dumps(["roll_angle", "steer_angle"], 0)
        frame["table"].attrs["values_block_0_kind"] = np.bytes_(names)
    (read,) = read_results(tmp_path / "r.h5").maneuvers
    assert {key: x[0] for key, x in read.values.items()} == {
        "roll_angle": 0.1, "steer_angle": 0.2, "forward_speed": 4.0,
    }  # fmt: skip
    assert list(read.time) == [0.0, 0.1, 0.2, 0.3, 0.4]


def test_an_attribute_tells_the_unit_of_a_path():
    assert with_unit("bike:roll_angle", {"units": "mrad"}) == "bike:roll_angle [mrad]"
    assert with_unit("bike.roll_angle.data", {"unit": "deg"}) == "bike.roll_angle.data [deg]"


def test_derivatives_of_dymola(reference):
    assert parse_heading("field.der(bike.roll.phi)").meaning == ("roll_rate", None)
    assert (
        parse_heading("der(bike.roll,1)").meaning
        == parse_heading("der(bike.roll)").meaning
        == ("roll_rate", None)
    )


def test_an_index_without_a_name_is_none(reference, tmp_path):
    """R's write.table and pandas' to_string write an index without a name."""
    m = reference[2]
    keys = BENCHMARK_COLUMNS
    rows = [f"{i}  " + "  ".join(repr(float(x)) for x in row)
            for i, row in enumerate(zip(m.time, *(m[k] for k in keys), strict=True))]  # fmt: skip
    path = tmp_path / "r.txt"
    path.write_text("\n".join(["   ".join(["time", *keys]), *rows]) + "\n")
    assert score(path, reference, maneuver=2).is_right
    # A first column that does not count the rows is not read as an index.
    path.write_text(path.read_text().replace("\n7  ", "\n77  "))
    with pytest.raises(InputError, match="found 10 columns"):
        read_results(path)


@pytest.mark.parametrize("mark", ["%", "# ", "%% "])
def test_a_heading_behind_a_comment_sign_beside_words(mark, reference, tmp_path):
    m = reference[2]
    keys = ("roll_angle", "roll_rate", "steer_angle")
    lines = [mark + ",".join(["time", "frame_id", *keys])]
    lines += [f"{t!r},bike," + ",".join(map(repr, row)) for t, *row in
              zip(*(x.tolist() for x in (m.time, *(m[k] for k in keys))), strict=True)]  # fmt: skip
    path = tmp_path / "r.csv"
    path.write_text("\n".join(lines) + "\n")
    assert is_right_in_part(score(path, reference, maneuver=2))


@pytest.mark.parametrize("filled", [500, 999])
def test_an_array_that_was_filled_in_part_is_refused_where_it_ends(filled, reference):
    table = published_table(reference, (2,))
    table[filled:] = 0
    with pytest.raises(InputError, match=f"row {filled + 1}: found {1001 - filled} rows of zeros"):
        read_results(table)
    assert read_results(table[:filled]).maneuvers[0].time.size == filled


def test_the_times_may_stand_above_the_columns(reference, tmp_path):
    m = reference[2]
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as f:
        f["run/time"] = m.time
        for key in ORDER:
            f[f"run/state/{key}"] = m[key]
    assert score(path, reference, maneuver=2).is_right
    state = {k: m[k].tolist() for k in ORDER}
    path = tmp_path / "r.json"
    path.write_text(json.dumps({"run": {"time": m.time.tolist(), "state": state}}))
    assert score(path, reference, maneuver=2).is_right
    rows = zip(*state.values(), strict=True)
    records = [{"time": t, "bike": dict(zip(ORDER, row, strict=True))}
               for t, row in zip(m.time.tolist(), rows, strict=True)]  # fmt: skip
    path.write_text(json.dumps(records))
    assert score(path, reference, maneuver=2).is_right


@pytest.mark.parametrize("attribute", ["units", "unit"])
def test_attributes_tell_the_unit(attribute, reference, tmp_path):
    """Roll, in degrees, is 50 % too large. Read as radians, its error would be 85 times its
    scale."""
    m = reference[2]
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as f:
        f["time"] = 1000 * m.time
        f["time"].attrs[attribute] = "ms"
        for key in ("roll_angle", "roll_rate", "steer_angle"):
            f[key] = 180 / np.pi * m[key] * (1.5 if key == "roll_angle" else 1.0)
            f[key].attrs[attribute] = "deg/s" if "rate" in key else "deg"
    report = score(path, reference, maneuver=2)
    found = {c.key: (c.as_understood.unit, c.max_rel_error) for c in report[2].columns}
    assert found["roll_angle"] == ("degree", pytest.approx(0.5, abs=0.02))
    assert found["roll_rate"][0] == "degree s-1"
    assert found["steer_angle"][1] < 1e-12
