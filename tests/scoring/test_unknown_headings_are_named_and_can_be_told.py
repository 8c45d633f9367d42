"""Headings that are not understood are named, with similar known names; `--columns` overrides
them."""

import io

import numpy as np
import pytest

from generators.numbered_columns import COUNT, found, written
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.names.suggestions import nearest
from heyoka_bike.scoring.reading.source import read_results


@pytest.mark.parametrize(
    ("heading", "fragment"),
    [
        ("t,q4,q7", "r.csv:1: found column names 'q4', 'q7' not understood, expected 9 or 25"),
        ("Zeit,Rollwinkel,x", "'Zeit', 'Rollwinkel' (roll_angle?), 'x' not understood"),
        ("zeit,roll_angle,steer_angle", "found column names 'zeit' not understood"),
        (
            "roll,lean rate,speed",
            "found column names 'roll', 'lean rate', 'speed' without their times",
        ),
        ("# my program\n# t,q4,q7", "r.csv:2: found column names 'q4', 'q7'"),
        ("t [s],q4 [rad],q7 [rad]", "'q4 [rad]', 'q7 [rad]' not understood"),
        ("t,q4,q7\ns,rad,rad", "r.csv:1: found column names 'q4', 'q7'"),
        ("1e5,#", "found 3 columns, expected 9 or 25"),
    ],
)
def test_a_heading_that_is_not_understood(heading, fragment, tmp_path):
    with pytest.raises(InputError) as caught:
        read_results(written(tmp_path, heading))
    assert fragment in str(caught.value)
    assert len(str(caught.value)) < 400
    if "names" in fragment:
        assert str(caught.value).endswith("to name the columns, use --columns time,roll_angle,...")


def test_arrays_that_are_not_understood(tmp_path):
    np.savez(tmp_path / "r.npz", t=np.arange(3.0), stearing_angel=np.arange(3.0))
    with pytest.raises(
        InputError,
        match=r"found column names 'stearing_angel' \(steer_angle\?\) not understood, expected",
    ):
        read_results(tmp_path / "r.npz")


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("stear_angle", "steer_angle"), ("rol rate", "roll_rate"), ("rollwinkel", "roll_angle"),
        ("Kinetische Energie [J]", "kinetic_energy"), ("m2_foward_speed", "forward_speed"),
        ("q4", None), ("", None), ("tyre", None), ("error", None),
    ],
)  # fmt: skip
def test_what_a_name_is_like(name, key):
    assert nearest(name) == key


def test_a_misspelt_column_is_left_out_with_what_it_is_like(tmp_path):
    (finding,) = read_results(written(tmp_path, "time,roll_angle,stear_angle")).findings
    said = "Columns with unknown names are left out: 'stear_angle' (steer_angle?)"
    assert finding.message == said


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ("t,roll_angle,delta", {"time": 0, (None, "roll_angle"): 1, (None, "steer_angle"): 2}),
        ("-,t,roll", {"time": 1, (None, "roll_angle"): 2}),
        ("skip, v , time", {"time": 2, (None, "forward_speed"): 1}),
        ("m2_roll_angle,time,m1_yaw", {"time": 1, (2, "roll_angle"): 0, (1, "yaw"): 2}),
        ("V [J],time,v [m/s]",
         {"time": 1, (None, "potential_energy"): 0, (None, "forward_speed"): 2}),
    ],
)  # fmt: skip
@pytest.mark.parametrize("heading", ["t,q4,q7", "steer_angle,roll_angle,time", "# nothing"])
def test_columns_are_told(columns, expected, heading, tmp_path):
    results = read_results(written(tmp_path, heading), columns=columns.split(","))
    assert found(results) == expected
    assert results.findings == ()


def test_units_are_told_with_the_columns(tmp_path):
    results = read_results(written(tmp_path, "Zeit,a,b"), columns=["t", "roll_deg", "steer [mrad]"])
    assert results.maneuvers[0].units == {"roll_angle": "degree", "steer_angle": "mrad"}


def test_columns_of_arrays_are_told(tmp_path):
    table = 100.0 * np.arange(COUNT)[:, None] + np.arange(3)
    told = ["time", "roll_angle", "steer_angle"]
    expected = {"time": 0, (None, "roll_angle"): 1, (None, "steer_angle"): 2}
    for source in (table, table.T, dict(zip("abc", table.T, strict=True)), {"x": table}):
        assert found(read_results(source, columns=told)) == expected
    buffer = io.BytesIO()
    np.savez(buffer, steer_angle=table[:, 0], time=table[:, 1], q=table[:, 2])
    (tmp_path / "r.npz").write_bytes(buffer.getvalue())
    assert found(read_results(tmp_path / "r.npz", columns=told)) == expected


@pytest.mark.parametrize(
    ("columns", "fragment"),
    [
        ("t,rol_angle,-", "--columns: found 'rol_angle', expected time, roll_angle"),
        ("t,rol_angle,-", "did you mean roll_angle?"),
        ("roll_angle,-,-", "--columns: expected the time and at least one more column"),
        ("t,-,-", "--columns: expected the time and at least one more column"),
        ("t,roll", "r.csv:2: found 3 columns, expected 2 columns as in --columns"),
        ("t,roll,v,yaw", "r.csv:2: found 3 columns, expected 4 columns as in --columns"),
        ("t,roll,lean", "found 'roll' and 'lean', expected one column of roll angle"),
        ("t,\x1b,-", "found '\\x1b'"),
    ],
)
def test_columns_that_are_wrongly_told(columns, fragment, tmp_path):
    with pytest.raises(InputError) as caught:
        read_results(written(tmp_path, "t,q4,q7"), columns=columns.split(","))
    assert fragment in str(caught.value)


def test_the_commands_take_columns(tmp_path, folder, capsys):
    rows = [line.split() for line in (folder / "uncontrolled-bicycle.txt").read_text().splitlines()]
    path = tmp_path / "q.csv"
    path.write_text("t,q4,q7\n" + "\n".join(",".join((r[0], r[1], r[7])) for r in rows))
    assert main(["score", str(path)]) == 1
    assert "'q4', 'q7' not understood" in capsys.readouterr().err
    told = ["--columns", "t,roll_angle,steer_angle"]
    enough = ["--require", "scd >= 15", "--require", "columns >= 2"]
    assert main(["score", str(path), *told, *enough]) == 0
    assert main(["score", str(path), "--columns", "t,roll_angle"]) == 1
