"""Column names determine the columns if all are known. Otherwise their order does, or the known
names."""

import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.names.heading import group_number, parse_heading
from heyoka_bike.scoring.reading.source import read_results

KEYS = BENCHMARK_COLUMNS


def written(tmp_path, names, separator=",", count=4):
    """Write a file with these column names; column j (from 0) of row i is 100 i + j + 0.5."""
    path = tmp_path / "results.csv"
    width = len(names) if isinstance(names, list) else names
    lines = [] if width is names else [separator.join(names)]
    lines += [separator.join(f"{100 * i + j}.5" for j in range(width)) for i in range(count)]
    path.write_text("\n".join(lines) + "\n")
    return path


def found(results):
    """Index of the file's column, from 0, by maneuver and key."""
    columns = {"time": int(results.maneuvers[0].time[0])}
    for rows in results.maneuvers:
        columns |= {(rows.maneuver, key): int(values[0]) for key, values in rows.values.items()}
    return columns


@pytest.mark.parametrize(
    ("name", "key", "number"),
    [
        ("time", "time", None), ("t", "time", None), ("Time [s]", "time", None),
        ("TIME(s)", "time", None), ("t / s", "time", None), ("time_1", None, None),
        ("roll", "roll_angle", None), ("Roll Angle [rad]", "roll_angle", None),
        ("roll-angle", "roll_angle", None), ("rollAngle", "roll_angle", None),
        ("ROLL_ANGLE (rad)", "roll_angle", None), ("phi", "roll_angle", None),
        ("roll rate [rad/s]", "roll_rate", None), ("roll angular velocity", "roll_rate", None),
        ("forward speed (m/s)", "forward_speed", None), ("speed", "forward_speed", None),
        ("v", "forward_speed", None), ("potential energy", "potential_energy", None),
        ("Epot", "potential_energy", None), ("E_kin", "kinetic_energy", None),
        ("total energy", "mechanical_energy", None), ("Mechanical", "mechanical_energy", None),
        ("steer", "steer_angle", None), ("steering angle", "steer_angle", None),
        ("delta", "steer_angle", None), ("steer rate", "steer_rate", None),
        ("delta_dot", "steer_rate", None), ("steer angular velocity", "steer_rate", None),
        ("m2_roll_angle", "roll_angle", 2), ("roll_angle_2", "roll_angle", 2),
        ("maneuver 2 roll angle", "roll_angle", 2), ("Manoeuvre 3: Steer Rate", "steer_rate", 3),
        ("roll_angle_m3", "roll_angle", 3), ("phi2", "roll_angle", 2),
        ("roll_angle[2]", "roll_angle", 2), ("roll angle (maneuver 2) [rad]", "roll_angle", 2),
        ("maneuver_1/roll_angle", "roll_angle", 1),
        ("speed.1", "forward_speed", 1), ("roll_angle_zyx", None, None), ("tilt", None, None),
        ("", None, None), ("2", None, None), ("x", None, None), ("roll_angle_lo", None, None),
        ("rol", None, None), ("٣", None, None), ("φ", "roll_angle", None),
        ("φ̇", "roll_rate", None), ("Δt", None, None), ("δ̇ [rad/s]", "steer_rate", None),
        (r"\phi", "roll_angle", None), (r"\dot\delta", "steer_rate", None),
        (r"$\varphi$", "roll_angle", None), (r"$\dot{\varphi}$ [rad/s]", "roll_rate", None),
        (r"\dot{\delta}", "steer_rate", None), (r"$\delta_{2}$", "steer_angle", 2),
        ("RollAngle_deg_", "roll_angle", None), ("RollRate_deg_s_", "roll_rate", None),
        ("Tilt_deg_", None, None),
    ],
)  # fmt: skip
def test_names_are_recognised(name, key, number):
    assert parse_heading(name).meaning == (None if key is None else (key, number))


@pytest.mark.parametrize(
    ("name", "key"),
    [
        # Names in Modelica
        ("bike.steer.phi", "steer_angle"), ("bike.steer.w", "steer_rate"),
        ("der(bike.steer.phi)", "steer_rate"), ('"revRoll.phi"', "roll_angle"),
        ("bicycle.rollAngle", "roll_angle"), ("bicycle.steeringRate", "steer_rate"),
        ("bike.roll.phi [deg]", "roll_angle"),
        # Names in Simscape
        ("Revolute_Roll.Rz.q", "roll_angle"), ("steer_joint.Rz.w", "steer_rate"),
        # Names in OpenSim
        ("/jointset/fork/steer_angle/value", "steer_angle"),
        ("/jointset/ground_frame/roll/speed", "roll_rate"),
        # Names of other parts, and names of accelerations
        ("rider.phi", None), ("rearWheel.w", None), ("rearWheel.speed", None), ("der(v)", None),
        ("rider.kineticEnergy", None), ("der(bike.steer.w)", None), ("der(der(steer.phi))", None),
        ("phi.roll", "roll_angle"), ("angle.phi", None),
    ],
)  # fmt: skip
def test_names_of_joints(name, key):
    assert parse_heading(name).meaning == (None if key is None else (key, None))


def test_joints_of_maneuvers_and_their_units(tmp_path):
    assert parse_heading("maneuver2.roll.phi").meaning == ("roll_angle", 2)
    assert parse_heading("field.bike.Steer_Joint.Rz.q_3").meaning == ("steer_angle", 3)
    # The name q3 is the third coordinate of a joint, which has no known meaning.
    assert parse_heading("Steer_Joint.Rz.q3").meaning is None
    names = ["time", "bike.roll.phi [deg]", "der(bike.steer.phi)"]
    assert found(read_results(written(tmp_path, names))) == {
        "time": 0,
        (None, "roll_angle"): 1,
        (None, "steer_rate"): 2,
    }


@pytest.mark.parametrize(
    ("name", "number"),
    [("maneuver_2", 2), ("Maneuver 12", 12), ("m1", 1), ("maneuver", None), ("m1_x", None)],
)  # fmt: skip
def test_groups_are_recognised(name, number):
    assert group_number(name) == number


def test_by_place(tmp_path):
    results = read_results(written(tmp_path, 25))
    assert results.findings == ()
    assert found(results) == {"time": 0} | {
        (m, key): 8 * m - 7 + k for m in (1, 2, 3) for k, key in enumerate(KEYS)
    }


@pytest.mark.parametrize(
    ("maneuver", "count", "number"), [(None, 3, None), (2, 3, 2), (None, 1, 1), (1, 1, 1)]
)
def test_nine_columns(maneuver, count, number, tmp_path):
    results = read_results(written(tmp_path, 9), maneuver=maneuver, count=count)
    assert found(results) == {"time": 0} | {(number, key): 1 + k for k, key in enumerate(KEYS)}


@pytest.mark.parametrize("count", [1, 2, 5])
def test_other_references_have_other_columns(count, tmp_path):
    results = read_results(written(tmp_path, 1 + 8 * count), count=count)
    assert [rows.maneuver for rows in results.maneuvers] == list(range(1, count + 1))
    assert found(results)[count, "steer_rate"] == 8 * count


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "   "])
def test_names_give_the_order(separator, tmp_path):
    names = ["steer_rate", *KEYS[:7][::-1], "time"]
    results = read_results(written(tmp_path, names, separator))
    assert results.findings == ()
    assert found(results) == {"time": 8} | {
        (None, key): j for j, key in enumerate(names) if key != "time"
    }


def test_names_with_blanks_and_units(tmp_path):
    names = ["Roll angle [rad]", "Time [s]", "Forward speed [m/s]"]
    expected = {"time": 1, (None, "roll_angle"): 0, (None, "forward_speed"): 2}
    for separator in (",", ";", "\t"):
        assert found(read_results(written(tmp_path, names, separator))) == expected
    path = written(tmp_path, ["a", "b", "c"], " ")
    for heading in (
        "Roll angle [rad]   Time [s]   Forward speed [m/s]",
        '"Roll angle" "Time" "Forward speed"',
        "roll [rad] time [s] speed [m/s]",
        "# roll [rad] time [s] speed [m/s]",
        "% roll, time, speed",
        "! roll;time;speed",
    ):
        path.write_text(path.read_text().replace(path.read_text().split("\n")[0], heading))
        assert found(read_results(path)) == expected


def test_names_of_maneuvers(tmp_path):
    names = ["m2_roll_angle", "time", "steer_rate_3", "roll_angle_1"]
    results = read_results(written(tmp_path, names))
    assert [rows.maneuver for rows in results.maneuvers] == [1, 2, 3]
    assert found(results) == {
        "time": 1, (2, "roll_angle"): 0, (3, "steer_rate"): 2, (1, "roll_angle"): 3
    }  # fmt: skip


@pytest.mark.parametrize(
    ("comments", "number"),
    [
        ("# maneuver 2 (v0 = 4.6 m/s)\n", 2),
        ("% written today\n% Manoeuvre: 3\n", 3),
        ("# maneuvers 1 and 2\n# maneuver 1, then maneuver 2\n", None),
        ("# max maneuver_speed 2\n", None),
        ("", None),
    ],
)
def test_a_comment_tells_the_maneuver_of_columns_that_do_not(comments, number, tmp_path):
    path = written(tmp_path, ["time", "roll_angle", "steer_angle"])
    path.write_text(comments + path.read_text())
    assert [rows.maneuver for rows in read_results(path).maneuvers] == [number]


def test_a_comment_does_not_tell_the_maneuver_of_columns_that_do(tmp_path):
    path = written(tmp_path, ["time", "m1_roll_angle", "m3_roll_angle"])
    path.write_text("# maneuver 2\n" + path.read_text())
    assert [rows.maneuver for rows in read_results(path).maneuvers] == [1, 3]


def test_the_last_heading_with_names_counts(tmp_path):
    path = written(tmp_path, ["roll", "time", "speed"])
    path.write_text(
        "speed,time,roll\n" + path.read_text().replace("\n0.5,", "\nrad,s,m/s\n0.5,", 1)
    )
    assert found(read_results(path)) == {
        "time": 1, (None, "roll_angle"): 0, (None, "forward_speed"): 2
    }  # fmt: skip


def test_names_once_for_each_maneuver(tmp_path):
    names = ["t", *KEYS[::-1], *KEYS, *KEYS]
    results = read_results(written(tmp_path, names))
    assert results.findings == ()
    assert found(results)[1, "steer_rate"] == 1
    assert found(results)[3, "steer_rate"] == 24
    assert len(found(results)) == 25


def test_capitals_of_energies(tmp_path):
    names = ["t", "phi", "phidot", "v", "T", "V", "E", "delta", "deltadot"]
    results = read_results(written(tmp_path, names))
    assert results.findings == ()
    columns = found(results)
    assert columns[None, "kinetic_energy"] == 4
    assert columns[None, "potential_energy"] == 5
    assert columns[None, "forward_speed"] == 3


def test_unknown_names_are_left_out(tmp_path):
    names = ["", "time", "roll_angle", "tilt", "tyre\x1b", *KEYS[1:]]
    results = read_results(written(tmp_path, names))
    (finding,) = results.findings
    assert (finding.code, finding.severity) == ("columns_left_out", "info")
    assert finding.evidence == {"names": ["", "tilt", "tyre\\x1b"], "count": 3}
    assert finding.message == "Columns with unknown names are left out: '', 'tilt', 'tyre\\x1b'"
    assert found(results)[None, "roll_rate"] == 5
    assert len(found(results)) == 9


def test_maneuvers_that_the_reference_does_not_have_are_left_out(tmp_path):
    results = read_results(written(tmp_path, ["time", "roll_1", "roll_4"]))
    assert found(results) == {"time": 0, (1, "roll_angle"): 1}
    assert results.findings[0].evidence["names"] == ["roll_4"]


def test_nine_columns_of_which_not_all_names_are_known(tmp_path):
    names = ["time", "phi", "p", "vx", "x1", "x2", "x3", "steer", "r"]
    results = read_results(written(tmp_path, names))
    assert results.findings == ()
    assert found(results)[None, "steer_rate"] == 8
    # If known names are in an unusual order, the names decide, and the unknown names are reported.
    names = ["time", "steer", "p", "vx", "x1", "x2", "x3", "roll", "r"]
    results = read_results(written(tmp_path, names))
    assert found(results) == {
        "time": 0, (None, "steer_angle"): 1, (None, "roll_rate"): 2, (None, "forward_speed"): 3,
        (None, "roll_angle"): 7,
    }  # fmt: skip
    (finding,) = results.findings
    assert finding.code == "columns_left_out"
    assert finding.evidence["names"] == ["x1", "x2", "x3", "r"]


def test_nine_names_of_which_the_time_is_not_known():
    def read(names):
        return read_results({name: [j + 0.5, 100.5 + j] for j, name in enumerate(names)})

    # The order of the columns decides, and a letter that contradicts it is reported.
    results = read(["i", "roll", "p", "x1", "x2", "x3", "u", "steer", "v"])
    assert found(results)[None, "roll_angle"] == 1
    (finding,) = results.findings
    assert (finding.code, finding.severity) == ("names_not_used", "warning")
    assert finding.evidence["columns"] == [7, 9]
    # The order of the columns does not override words.
    with pytest.raises(InputError, match="column names 'i', 'x1', 'x2', 'x3', 'r' not understood"):
        read(["i", "steer", "p", "vx", "x1", "x2", "x3", "roll", "r"])


def test_nine_names_without_a_time_are_not_used(tmp_path):
    assert found(read_results(written(tmp_path, ["i", *KEYS])))["time"] == 0


def test_many_names_make_a_short_message(tmp_path):
    names = ["time", "roll", *(f"signal {i} " + "x" * 100 for i in range(200))]
    (finding,) = read_results(written(tmp_path, names)).findings
    assert len(finding.message) < 700
    assert "and 192 more" in finding.message
    assert finding.evidence["count"] == 200
    assert len(finding.evidence["names"]) == 100


def test_a_name_twice_is_an_error(tmp_path):
    names = ["time", *KEYS[:7], "roll"]
    with pytest.raises(InputError, match=r":1: found 'roll_angle' and 'roll', expected one column"):
        read_results(written(tmp_path, names))
