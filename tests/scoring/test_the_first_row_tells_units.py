"""The first row contains the given initial conditions: it shows the unit, sign, order and maneuver
even of a wrong motion."""

from math import pi

import numpy as np
import pytest

from heyoka_bike.scoring.evidence.as_compared import ManeuverGuessed, OtherOrder
from heyoka_bike.scoring.evidence.column_meaning import UnitContradicted
from heyoka_bike.scoring.score import score

DEGREES = 180 / pi
ANGLES = ("roll_angle", "steer_angle")
RATES = ("roll_rate", "steer_rate")


def wrong(reference, number=2):
    """A motion with correct initial conditions that is entirely wrong afterwards."""
    m = reference[number]
    turned = np.cos(1.5 * m.time)
    held = {key: turned * m.rows[key] for key in (*ANGLES, *RATES)}
    energies = ("forward_speed", "potential_energy", "kinetic_energy", "mechanical_energy")
    held |= {key: m.rows[key] * (1 + m.time / 5) for key in energies}
    return {"time": m.time, **held}


def lateral(columns, factor=1.0):
    return {key: factor * columns[key] for key in (*ANGLES, *RATES)}


def taken(report, number=2):
    return {c.key: (c.as_understood.unit, c.as_understood.sign) for c in report[number].columns}


def errors(report, number=2):
    return [c.max_rel_error for c in report[number].columns]


@pytest.fixture(scope="module")
def in_radians(reference):
    columns = wrong(reference)
    return errors(score({"time": columns["time"], **lateral(columns)}, reference, maneuver=2))


@pytest.mark.parametrize("units", [("", ""), (" [deg]", " [deg/s]"), (" [rad]", " [rad/s]")])
def test_a_wrong_motion_in_degrees_is_as_wrong_as_in_radians(units, in_radians, reference):
    columns = wrong(reference)
    names = {key: key + units[key in RATES] for key in (*ANGLES, *RATES)}
    named = {names[key]: x for key, x in lateral(columns, DEGREES).items()}
    report = score({"time": columns["time"], **named}, reference, maneuver=2)
    assert {*taken(report).values()} == {("degree", 1), ("degree s-1", 1)}
    assert errors(report) == pytest.approx(in_radians, rel=1e-9)
    assert min(in_radians) > 0.5
    # For each column the report states the contradiction between its heading and its values.
    told = {x.key for x in report.seen if isinstance(x, UnitContradicted)}
    assert told == ({*names} if "rad" in units[0] else set())


def test_the_units_of_other_columns_are_no_more_than_likely(reference):
    columns = wrong(reference)
    mixed = {key: columns[key] * (DEGREES if key in RATES else 1) for key in (*ANGLES, *RATES)}
    found = taken(score({"time": columns["time"], **mixed}, reference, maneuver=2))
    assert found["roll_rate"][0] == found["steer_rate"][0] == "degree s-1"
    assert found["roll_angle"][0] == found["steer_angle"][0] == "rad"


@pytest.mark.parametrize("units", [("", ""), (" [rad]", " [deg/s]")])
@pytest.mark.parametrize("number", [1, 3])
def test_an_angle_has_the_unit_in_which_its_rate_is_its_slope(number, units, reference):
    """The rates show degrees in their first row. The angles are so far off that they would fit
    better in degrees, too, but then the rates would not be their slopes."""
    m = reference[number]
    named = {}
    for angle, rate in zip(ANGLES, RATES, strict=True):
        size = 10 * m.scale(angle)
        named[angle + units[0]] = m.rows[angle] + size * (1 - np.cos(m.time / 2))
        named[rate + units[1]] = DEGREES * (m.rows[rate] + size / 2 * np.sin(m.time / 2))
    report = score({"time": m.time, **named}, reference, maneuver=number)
    found = taken(report, number)
    assert {found[key] for key in ANGLES} == {("rad", 1)}
    assert {found[key] for key in RATES} == {("degree s-1", 1)}
    assert not [x for x in report.seen if isinstance(x, UnitContradicted)]


def test_a_motion_that_grows_beyond_all_bounds_stays_in_its_unit(reference):
    m = reference[2]
    grown = {key: m.rows[key] * np.exp(m.time) for key in (*ANGLES, *RATES)}
    found = taken(score({"time": m.time, **grown}, reference, maneuver=2))
    assert {*found.values()} == {("rad", 1), ("rad s-1", 1)}


@pytest.mark.parametrize(
    ("key", "factor", "unit"),
    [
        ("roll_rate", 30 / pi, "revolution min-1"),
        ("forward_speed", 3.6, "km h-1"),
        ("forward_speed", 1e3, "mm s-1"),
        ("kinetic_energy", 1e-3, "kJ"),
        ("mechanical_energy", 1e3, "mJ"),
    ],
)
def test_each_unit(key, factor, unit, reference):
    columns = wrong(reference)
    report = score({"time": columns["time"], key: factor * columns[key]}, reference, maneuver=2)
    assert taken(report) == {key: (unit, 1)}


def test_a_start_that_is_nearly_given_in_another_unit_tells_none(reference):
    columns = wrong(reference)
    roll_rate = 1.01 * DEGREES * columns["roll_rate"]
    report = score({"time": columns["time"], "roll_rate": roll_rate}, reference, maneuver=2)
    assert taken(report) == {"roll_rate": ("rad s-1", 1)}


def test_an_angle_has_the_sign_of_its_rate(reference):
    columns = wrong(reference)
    to_the_left = {key: -columns[key] for key in ("roll_angle", "roll_rate")}
    rest = {key: columns[key] for key in ("steer_angle", "steer_rate")}
    given = {"time": columns["time"], **to_the_left, **rest}
    found = taken(score(given, reference, maneuver=2))
    assert found["roll_angle"] == ("rad", -1)
    assert found["roll_rate"] == ("rad s-1", -1)
    assert found["steer_angle"] == ("rad", 1)


def test_an_exchange(reference):
    columns = wrong(reference)
    pair = ("potential_energy", "kinetic_energy")
    moved = columns | dict(zip(pair, (columns[key] for key in reversed(pair)), strict=True))
    (found,) = (x for x in score(moved, reference, maneuver=2).seen if isinstance(x, OtherOrder))
    expected = ["kinetic_energy" if k == pair[0] else pair[0] if k == pair[1] else k
                for k in columns if k != "time"]  # fmt: skip
    assert [*found.keys] == expected
    assert not any(isinstance(x, OtherOrder) for x in score(columns, reference, maneuver=2).seen)


def test_the_maneuver(reference):
    columns = wrong(reference)
    given = {"time": columns["time"], **lateral(columns, DEGREES)}
    assert [*score(given, reference)] == [2]
    # Two maneuvers start with the same roll rate. Only the speed excludes one of them.
    columns = wrong(reference, 3)
    given = {"time": columns["time"], **lateral(columns)}
    guessed = score(given, reference)
    assert [*guessed] == [3]
    assert [x.may_be for x in guessed.seen if isinstance(x, ManeuverGuessed)] == [(1,)]
    speed = {"forward_speed": columns["forward_speed"]}
    told = score(given | speed, reference)
    assert [*told] == [3]
    assert not any(isinstance(x, ManeuverGuessed) for x in told.seen)


@pytest.mark.parametrize(("said", "unit"), [("yes", "degree"), ("no", "rad"), ("Yes", "degree")])
def test_angles_of_opensim_are_in_the_unit_that_the_file_says(said, unit, reference, tmp_path):
    columns = wrong(reference)
    # Without the first row, the file does not show the unit.
    some = lateral(columns, DEGREES)
    steer = {key: some[key][1:] for key in ("steer_angle", "steer_rate")}
    path = tmp_path / "states.sto"
    above = ["bicycle", "version=1", f"nRows={len(columns['time']) - 1}", "nColumns=3"]
    names = "\t".join(["time", *(f"/jointset/fork/steer_angle/{x}" for x in ("value", "speed"))])
    np.savetxt(
        path,
        np.column_stack([columns["time"][1:], *steer.values()]),
        delimiter="\t",
        header="\n".join([*above, f"inDegrees={said}", "endheader", names]),
        comments="",
    )
    assert taken(score(path, reference, maneuver=2))["steer_angle"][0] == unit
