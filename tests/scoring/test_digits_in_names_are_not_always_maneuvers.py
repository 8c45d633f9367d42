"""A digit at the end of a name is a maneuver number unless something contradicts it."""

import numpy as np
import pytest

from generators.numbered_columns import found, written
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score


@pytest.mark.parametrize(
    ("heading", "expected", "aside"),
    [
        ("t,phi,delta,u1,u2", {(None, "roll_angle"): 1, (None, "steer_angle"): 2}, ["u1", "u2"]),
        ("t,phi,delta,u4,u7", {(None, "roll_angle"): 1, (None, "steer_angle"): 2}, ["u4", "u7"]),
        ("t,roll,steer,v1", {(None, "roll_angle"): 1, (None, "steer_angle"): 2}, ["v1"]),
        ("t,roll,steer,T2,V2", {(None, "roll_angle"): 1, (None, "steer_angle"): 2}, ["V2"]),
        ("t,roll,steer,V2 [J]", {(None, "roll_angle"): 1, (None, "steer_angle"): 2}, ["V2 [J]"]),
        ("t,roll,roll.1,steer", {(None, "roll_angle"): 1, (None, "steer_angle"): 3}, ["roll.1"]),
        ("t,roll,speed1,speed2", {(None, "roll_angle"): 1}, ["speed1", "speed2"]),
        ("t,q1,q2,u,phi", {(None, "roll_angle"): 4}, ["u"]),
        ("t,roll_1,roll_2,roll_3,speed", {(1, "roll_angle"): 1, (2, "roll_angle"): 2,
         (3, "roll_angle"): 3}, ["speed"]),
        ("t,roll_m2,speed", {(2, "roll_angle"): 1}, ["speed"]),
        ("t,roll_1,roll_4", {(1, "roll_angle"): 1}, ["roll_4"]),
    ],
)  # fmt: skip
def test_known_columns_are_left_out_with_a_warning(heading, expected, aside, tmp_path):
    results = read_results(written(tmp_path, heading, width=heading.count(",") + 1))
    assert found(results) == {"time": 0} | expected
    finding = results.findings[0]
    assert (finding.code, finding.severity) == ("known_columns_left_out", "warning")
    assert finding.evidence["names"] == aside
    assert "--columns" in finding.message


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        ("t,v1,v2,v3", {(n, "forward_speed"): n for n in (1, 2, 3)}),
        ("t,phi1,v1,phi2,v2", {(1, "roll_angle"): 1, (1, "forward_speed"): 2,
         (2, "roll_angle"): 3, (2, "forward_speed"): 4}),
        ("t,phi2,delta2", {(2, "roll_angle"): 1, (2, "steer_angle"): 2}),
        ("t,phi1,v1,V1,T1,E1", {(1, "roll_angle"): 1, (1, "forward_speed"): 2,
         (1, "potential_energy"): 3, (1, "kinetic_energy"): 4, (1, "mechanical_energy"): 5}),
        ("t,man1_droll,man1_kin,man2_dsteer", {(1, "roll_rate"): 1, (1, "kinetic_energy"): 2,
         (2, "steer_rate"): 3}),
        ("t,u_m2,v_m2,phi_m2", {(2, "potential_energy"): 1, (2, "forward_speed"): 2,
         (2, "roll_angle"): 3}),
        ("t,q [J],u [J],phi", {(None, "potential_energy"): 2, (None, "roll_angle"): 3}),
        ("t,phi,u", {(None, "roll_angle"): 1, (None, "potential_energy"): 2}),
    ],
)  # fmt: skip
def test_numbers_of_maneuvers_are_kept(heading, expected, tmp_path):
    results = read_results(written(tmp_path, heading, width=heading.count(",") + 1))
    assert found(results) == {"time": 0} | expected
    assert all(f.severity == "info" for f in results.findings)


@pytest.mark.parametrize("heading", ["t,q1,q2,u1,u2", "t,Q1,Q2,U1,U2", "t,q1,q2,q3,u1,u2,u3"])
def test_coordinates_and_speeds_are_no_energies(heading, tmp_path):
    names = heading.split(",")
    with pytest.raises(InputError, match="not understood") as caught:
        read_results(written(tmp_path, heading, width=len(names)))
    assert all(f"'{name}'" in str(caught.value) for name in names[1:])
    assert "--columns" in str(caught.value)
    with pytest.raises(InputError, match="not understood, expected 9 or 25"):
        read_results({name: np.arange(5.0) for name in names})


def test_the_verdict_is_that_of_the_columns_known(reference):
    m = reference[2]
    roll, steer = (m.rows[key] for key in ("roll_angle", "steer_angle"))
    rates = {"u1": m.rows["roll_rate"], "u2": m.rows["steer_rate"]}
    report = score({"t": m.time, "phi": roll, "delta": steer, **rates}, reference)
    (scored,) = report.maneuvers
    assert (scored.maneuver, [c.key for c in scored.columns]) == (2, ["roll_angle", "steer_angle"])
    assert report.verdict.startswith("array: right")
    assert "known_columns_left_out" in [f.code for f in report.findings]
