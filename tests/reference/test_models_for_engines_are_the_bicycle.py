"""URDF, SDFormat and MJCF, read by an independent reader, match the package's bicycle."""

import re
from fractions import Fraction
from xml.etree import ElementTree

import mpmath
import numpy as np
import pytest

from heyoka_bike.bicycle.parameters import read_bicycle, read_inputs, read_maneuvers
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.exports.models import MODELS, THINNEST, render
from heyoka_bike.system.resources import collection, find_input
from support.model_files import matrix_of, model_of, numbers, posed

STATES = read_maneuvers(find_input("maneuvers", "states"))[5:105:5]
ROUNDOFF = 1e-13
# The limit is half a unit of the seventeenth digit. The files are evaluated at 40 digits.
SEVENTEEN = Fraction(1, 2 * 10**16)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("other", ["benchmark", "browser", "pista-jason"])
def test_mass_matrix_and_energy_are_exact(name, other):
    bicycle = read_bicycle(find_input("bicycles", other))
    model = model_of(name, bicycle)
    assert [hinge[0] for hinge in model.hinges.values()] == [
        "rear_axle",
        "steer_axis",
        "front_axle",
    ]
    for state in STATES:
        try:
            there = posed(bicycle, state)
        except ValueError:  # this bicycle has no such posture
            continue
        matrix = there.per_rate.T @ model.mass_matrix(there.place, there.axes, there.angles)
        found, expected = matrix @ there.per_rate, there.expected()
        assert np.abs(found - expected).max() < ROUNDOFF * np.abs(expected).max()
        centres = model.centres_of_mass(there.place, there.axes, there.angles)
        height = sum(model.masses[x] * centre[2] for x, centre in centres.items())
        g = float(bicycle["g"])
        energies = there.equations.energies([*there.q[4:7], 0, 0, 0])
        assert g * height == pytest.approx(energies.potential, rel=ROUNDOFF)


@pytest.mark.parametrize("name", MODELS)
def test_wheels_stand_and_roll_at_each_start(name, bicycle):
    text = render(name, bicycle, STATES).decode()
    model = model_of(name, bicycle)
    table = text.partition("Starts:")[2].partition("-->")[0]
    blocks = re.split(r"^start_\d+: .*$", table, flags=re.MULTILINE)[1:]
    assert len(blocks) == len(STATES)
    for block, state in zip(blocks, STATES, strict=True):
        found = np.array([float(x) for x in re.findall(r"[-+]?\d[-+.e\d]*", block)])
        place, attitude, angles, velocities = np.split(found, [3, 7, 10])
        axes = matrix_of(attitude)
        assert np.abs(model.floor(place, axes, angles, velocities)).max() < ROUNDOFF
        roll, steer = float(state.roll), float(state.steer)
        assert np.arcsin(axes[2, 1]) == pytest.approx(roll, abs=ROUNDOFF)
        assert angles.tolist() == pytest.approx([0, steer, 0], abs=ROUNDOFF)
        ahead = np.cross(axes[:, 1], [0, 0, 1]) / np.cos(roll)
        rear = model.bodies(place, axes, angles)["R"][2] @ velocities
        assert ahead @ rear[:3] == pytest.approx(float(state.speed), abs=ROUNDOFF)
        assert ahead @ velocities[3:6] == pytest.approx(float(state.roll_rate), abs=ROUNDOFF)
        assert velocities[7] == pytest.approx(float(state.steer_rate), abs=ROUNDOFF)


def test_keyframes_are_the_starts(bicycle):
    text = render("mjcf", bicycle, STATES).decode()
    keys = ElementTree.fromstring(text).findall("keyframe/key")
    assert [key.get("name") for key in keys] == [f"start_{n + 1}" for n in range(len(STATES))]
    for key, block in zip(
        keys, re.split(r"^start_\d+: .*$", text, flags=re.MULTILINE)[1:], strict=True
    ):
        found = [float(x) for x in re.findall(r"[-+]?\d[-+.e\d]*", block.partition("-->")[0])]
        assert numbers(key.get("qpos")).tolist() == found[:10]
        velocities = numbers(key.get("qvel"))
        # MuJoCo expresses the angular velocity of a free body in the body's own axes.
        velocities[3:6] = matrix_of(found[3:7]) @ velocities[3:6]
        assert velocities.tolist() == pytest.approx(found[10:], abs=ROUNDOFF)


def test_benchmark_starts_as_printed(bicycle, maneuvers):
    keys = ElementTree.fromstring(render("mjcf", bicycle, maneuvers)).findall("keyframe/key")
    assert {key.get("qpos") for key in keys} == {"0 0 0 1 0 0 0 0 0 0"}
    assert keys[2].get("qvel") == "8 0 0 0.05 0 0 26.666666666666667 0 22.857142857142857"


@pytest.mark.parametrize("name", MODELS)
def test_numbers_have_seventeen_digits(name, bicycle):
    mp = mpmath.mp.clone()
    mp.dps = 40
    tilt, rear, pivot = mp.pi / 10, mp.mpf(3) / 10, mp.mpf(11) / 10
    across = pivot * mp.cos(tilt) - rear * mp.sin(tilt)
    place = (across * mp.cos(tilt), rear + across * mp.sin(tilt))
    wanted = [mp.sin(tilt), -mp.cos(tilt), *place, mp.mpf("0.00756"), mp.mpf("0.0603"), 85]
    if name != "sdf":  # in SDFormat all positions are relative to the ground
        wanted += [mp.mpf("1.02") - place[0], mp.mpf("0.35") - place[1]]
    text = render(name, bicycle, ()).decode().partition("-->")[2]
    words = {Fraction(x) for x in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", text)}
    for x in wanted:
        exact = Fraction(int(mp.floor(x * 10**38)), 10**38)
        assert min(abs(word - exact) for word in words) <= SEVENTEEN * abs(exact)


@pytest.mark.parametrize("name", MODELS)
def test_every_bicycle_is_well_formed(name):
    for other in collection("bicycles"):
        bicycle, maneuvers = read_inputs(other, None)
        text = render(name, bicycle, maneuvers)
        root = ElementTree.fromstring(text)
        assert root.tag == {"urdf": "robot", "sdf": "sdf", "mjcf": "mujoco"}[name]
        assert b"e-0 " not in text
        assert max(map(len, text.splitlines())) < 300


@pytest.mark.parametrize("name", MODELS)
def test_a_name_can_be_anything(name, bicycle, maneuvers):
    odd = type(bicycle)('a --> "b" & <c> \N{BICYCLE} ---', bicycle.values)
    ElementTree.fromstring(render(name, odd, maneuvers))


@pytest.mark.parametrize("name", MODELS)
def test_wheels_are_as_wide_as_told(name, bicycle):
    for width, written in ((Fraction(0), THINNEST), (Fraction(1, 20), Fraction(1, 20))):
        root = ElementTree.fromstring(render(name, bicycle, (), width))
        if name == "mjcf":
            shapes = [g for g in root.iter("geom") if g.get("name") in ("R", "F")]
            found = [2 * Fraction(g.get("size").split()[1]) for g in shapes]
        else:
            shapes = [x for y in root.iter("collision") for x in y.iter("cylinder")]
            found = [Fraction(x.get("length") or x.findtext("length")) for x in shapes]
        assert len(found) == 2
        assert set(found) == {written}


def test_gravity_is_the_bicycles(bicycle):
    light = bicycle.replace(g=Exact.parse("1.62"))
    assert 'gravity="0 0 -1.62"' in render("mjcf", light, ()).decode()
    root = ElementTree.fromstring(render("sdf", light, ()))
    # DART reads gravity only from this element, which version 1.5 of SDFormat allows.
    assert root.findtext("world/physics/gravity") == "0 0 -1.62"
    assert (root.get("version"), root.find("world/gravity")) == ("1.5", None)


def test_every_link_of_sdf_has_mass(bicycle):
    """DART reports a link without mass on standard output, where it would spoil a table."""
    root = ElementTree.fromstring(render("sdf", bicycle, ()))
    assert all(link.find("inertial/inertia/ixx") is not None for link in root.iter("link"))
