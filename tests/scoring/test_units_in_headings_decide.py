"""A unit in a heading, or in the line below it, decides what a name alone leaves open."""

import numpy as np
import pytest

from generators.numbered_columns import found, written
from heyoka_bike.scoring.reading.names.heading import parse_heading
from heyoka_bike.scoring.reading.source import read_results


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("v [m/s]", "forward_speed"),
        ("V [J]", "potential_energy"),
        ("V [m/s]", "forward_speed"),
        ("T [J]", "kinetic_energy"),
        ("T [s]", "time"),
        ("t (ms)", "time"),
        ("E [kJ]", "mechanical_energy"),
        ("u [m/s]", "forward_speed"),
        ("U [J]", "potential_energy"),
        ("v [furlong]", "forward_speed"),
        ("roll [rad]", "roll_angle"),
        ("roll [rad/s]", "roll_rate"),
        ("phi (deg s^-1)", "roll_rate"),
        ("delta [°/s]", "steer_rate"),
        ("delta / rad", "steer_angle"),
        ("v / (m/s)", "forward_speed"),
        ("v in km/h", "forward_speed"),
        ("speed_mps", "forward_speed"),
        ("speed_m_per_s", "forward_speed"),
        ("roll_angle_rad", "roll_angle"),
        ("roll_deg", "roll_angle"),
        ("steer_rate_rad_s", "steer_rate"),
        ("roll rate [rad s⁻¹]", "roll_rate"),
        ("steer [rad·s^-1]", "steer_rate"),
        ("time_s", "time"),
        ("kinetic energy [N m]", "kinetic_energy"),
        ("yaw [deg/s]", "yaw_rate"),
        # MATLAB, Octave and R replace some characters with underscores or points.
        ("E_pot__N_m", "potential_energy"),
        ("dphi__rad_s_1", "roll_rate"),
        ("velocity_m_s__1", "forward_speed"),
        ("velocity in m_s", "forward_speed"),
        ("roll_angle___degrees", "roll_angle"),
        ("steer_angle_in_degrees", "steer_angle"),
        ("vx..m.s..1.", "forward_speed"),
        ("roll_angle_in", None),
        ("v [N]", None),
        ("roll_angle [m]", "roll_angle"),
        ("roll_s", None),
        ("roll_angle_m", None),
    ],
)
def test_units_decide(name, key):
    assert parse_heading(name).meaning == (None if key is None else (key, None))


@pytest.mark.parametrize(
    ("name", "key"),
    [("M2_E_in_N_m", "mechanical_energy"), ("potential_energy_2_Nm", "potential_energy"),
     ("m2_steer_rate__deg_s__1", "steer_rate")],
)  # fmt: skip
def test_units_beside_a_maneuver(name, key):
    assert parse_heading(name).meaning == (key, 2)


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        (["t [s],v [m/s],V [J]"], {"forward_speed": 1, "potential_energy": 2}),
        (["t [s],T [J],V [J]"], {"kinetic_energy": 1, "potential_energy": 2}),
        (["t,roll [rad],roll [rad/s]"], {"roll_angle": 1, "roll_rate": 2}),
        (["t,phi,phi", "s,rad,rad/s"], {"roll_angle": 1, "roll_rate": 2}),
        (["# t,v,V", "# [s],[m/s],[J]"], {"forward_speed": 1, "potential_energy": 2}),
        (["t,T,u", "(s),(J),(m/s)"], {"kinetic_energy": 1, "forward_speed": 2}),
        (["t,v,x", "s,m/s,"], {"forward_speed": 1}),
        (["t,phi,phi", "(s),(deg),(deg/s)"], {"roll_angle": 1, "roll_rate": 2}),
        (["t,phi,phi", "{s},{deg},{deg/s}"], {"roll_angle": 1, "roll_rate": 2}),
        (["t,phi,phi", "<s>,<deg>,<deg/s>"], {"roll_angle": 1, "roll_rate": 2}),
        (['"t","phi","phi"', '"[s]","[°]","[°/s]"'], {"roll_angle": 1, "roll_rate": 2}),
        (["t,phi,phi", "s,°,°/s"], {"roll_angle": 1, "roll_rate": 2}),
        (["t,delta,delta", "Units:,degrees,degrees/sec"], {"steer_angle": 1, "steer_rate": 2}),
        (["(s),(deg),(deg/s)", "t,phi,phi"], {"roll_angle": 1, "roll_rate": 2}),
        (["t,phi,phi", "", "s,deg,deg/s"], {"roll_angle": 1, "roll_rate": 2}),
        (["t,v,V", "sec,meter/sec,newton-meter"], {"forward_speed": 1, "potential_energy": 2}),
        (["t,T,V", "s,kg*m^2/s^2,N-m"], {"kinetic_energy": 1, "potential_energy": 2}),
        (["t,v,V", "-----,-----,-----", "s,m/s,J"], {"forward_speed": 1, "potential_energy": 2}),
        (["t,roll_deg,roll_rad"], {"roll_angle": 2}),
        (["t,roll_angle,roll_angle_rad"], {"roll_angle": 1}),
    ],
)
def test_units_tell_columns_apart(heading, expected, tmp_path):
    results = read_results(written(tmp_path, *heading))
    assert found(results) == {"time": 0} | {(None, key): j for key, j in expected.items()}


def test_a_unit_with_a_blank_is_one_in_a_line_of_units(tmp_path):
    path = tmp_path / "r.txt"
    path.write_text("t roll v\n[s] [mrad] [m s^-1]\n0 1 4\n1 2 4\n2 3 4\n")
    (rows,) = read_results(path).maneuvers
    assert rows.units["roll_angle"] == "mrad"


@pytest.mark.parametrize(
    "heading", [["t [ms],roll,v"], ["t,roll,v", "ms,rad,m/s"], ["time_ms,roll,v"]]
)
def test_times_in_milliseconds_are_exact(heading, tmp_path):
    path = tmp_path / "r.csv"
    rows = [f"{i * 10},{i}.5,{i}.25" for i in range(20)]
    path.write_text("\n".join([*heading, *rows]))
    (rows,) = read_results(path).maneuvers
    seconds = tmp_path / "s.csv"
    seconds.write_text("t,roll,v\n" + "\n".join(f"{i / 100:.2f},{i}.5,{i}.25" for i in range(20)))
    (expected,) = read_results(seconds).maneuvers
    assert np.array_equal(rows.time, expected.time)
    assert np.allclose(rows.time_lo, expected.time_lo, rtol=0, atol=1e-32)
    assert np.any(rows.time_lo)
