"""The replay's positions of the bicycle follow from rolling without slip."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.workbench.replay.motion_3d import Place, motion_3d, reference_state

MANEUVERS = [1, 2, 3]


@pytest.fixture(scope="module")
def equations(bicycle):
    return Equations.binary64(bicycle)


@pytest.fixture(scope="module")
def motions(reference, equations):
    time = np.linspace(0.0, 10.0, 501)
    return {n: motion_3d(equations, reference_state(reference[n]), time) for n in MANEUVERS}


def rates(equations, reference, number, times, h=2e-3):
    """Return central differences of eighth order of all motions at some times, by name."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    state = reference_state(reference[number])
    found = []
    for t in times:
        grid = np.concatenate(([0.0], t + h * np.arange(-4, 5)))
        m = motion_3d(equations, state, grid)
        found.append(
            {
                name: sum(w * (x[5 + i] - x[5 - i]) for i, w in weights.items()) / h
                for name, x in ((n, getattr(m, n)) for n in m.__slots__)
            }
        )
    return {name: np.array([row[name] for row in found]) for name in found[0]}


TIMES = np.linspace(0.31, 9.7, 13)


@pytest.fixture(scope="module", params=MANEUVERS)
def moving(request, reference, equations):
    """A maneuver: its motion at some times, and the rates of the motion."""
    state = reference_state(reference[request.param])
    at = motion_3d(equations, state, np.concatenate(([0.0], TIMES)))
    here = {name: getattr(at, name)[1:] for name in at.__slots__}
    return here, rates(equations, reference, request.param, TIMES)


def test_the_start_is_the_upright_straight_bicycle(motions):
    for m in motions.values():
        np.testing.assert_allclose(m.rear_contact[0], (0, 0, 0), rtol=0, atol=1e-15)
        np.testing.assert_allclose(m.front_contact[0], (1.02, 0, 0), rtol=0, atol=1e-15)
        assert m.rear_wheel[0] == m.front_wheel[0] == m.rear_track[0] == 0


def test_both_wheels_are_on_the_floor(motions):
    for m in motions.values():
        for contact in (m.rear_contact, m.front_contact):
            assert np.abs(contact[:, 2]).max() < 1e-9


@pytest.mark.parametrize("number", MANEUVERS)
def test_yaw_is_that_of_the_reference(motions, reference, number):
    expected = reference[number].approximate(motions[number].time, ["yaw"])["yaw"]
    np.testing.assert_allclose(motions[number].yaw, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("number", MANEUVERS)
def test_places_do_not_depend_on_how_many_are_asked_for(motions, reference, equations, number):
    few, state = motions[number], reference_state(reference[number])
    many = motion_3d(equations, state, np.linspace(0.0, 10.0, 4001))
    for name in ("rear_contact", "front_contact", "rear_wheel", "front_wheel", "rear_track"):
        np.testing.assert_allclose(getattr(few, name), getattr(many, name)[::8], rtol=0, atol=1e-12)


@pytest.mark.parametrize("number", MANEUVERS)
def test_the_rear_track_is_the_integral_of_the_published_speed(motions, reference, number):
    # The speed of the contact point is a column of the reference. It is integrated by Simpson's
    # rule with steps of 0.5 ms.
    t = np.linspace(0.0, 10.0, 20001)
    found = reference[number].approximate(t, ["forward_speed_contact", "yaw"])
    speed, yaw = found["forward_speed_contact"], found["yaw"]
    for rate, expected in (
        (speed, motions[number].rear_track[-1]),
        (speed * np.cos(yaw), motions[number].rear_contact[-1, 0]),
        (speed * np.sin(yaw), motions[number].rear_contact[-1, 1]),
    ):
        simpson = (rate[0] + rate[-1] + 4 * rate[1::2].sum() + 2 * rate[2:-1:2].sum()) * 5e-4 / 3
        assert simpson == pytest.approx(expected, rel=0, abs=1e-10)


def test_contact_points_move_along_their_wheels_heading(moving, equations):
    here, rate = moving
    # Compute the front wheel's axle from the frame's attitude: yaw, roll, pitch and steer.
    tilt = equations.k.tilt
    yaw, roll, pitch, steer = (here[name] for name in ("yaw", "roll", "pitch", "steer"))
    leaning = Rotation.from_euler("ZXY", np.stack([yaw, roll, pitch + tilt], axis=1))
    turns = leaning * Rotation.from_euler("Z", steer[:, None])
    front = np.cross(turns.apply([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0])
    front /= np.linalg.norm(front, axis=1, keepdims=True)
    rear = np.stack([np.cos(yaw), np.sin(yaw), 0 * yaw], axis=1)
    for name, ahead in (("rear", rear), ("front", front)):
        velocity = rate[f"{name}_contact"]
        aside = np.linalg.norm(np.cross(velocity, ahead), axis=1)
        assert aside.max() < 1e-9
        assert np.sum(velocity * ahead, axis=1).min() > 3.9
    forward = np.sum(rate["rear_contact"] * rear, axis=1)
    np.testing.assert_allclose(forward, rate["rear_track"], rtol=0, atol=1e-9)


def test_a_start_elsewhere_moves_and_turns_everything(reference, equations):
    time = np.linspace(2.0, 5.0, 151)
    state = reference_state(reference[2])
    plain = motion_3d(equations, state, time)
    other = motion_3d(equations, state, time, Place(3.0, -1.0, 0.7))
    s, c = np.sin(0.7), np.cos(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for name in ("rear_contact", "front_contact"):
        expected = getattr(plain, name) @ turn.T + (3.0, -1.0, 0.0)
        np.testing.assert_allclose(getattr(other, name), expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.yaw, plain.yaw + 0.7, rtol=0, atol=1e-13)
    np.testing.assert_allclose(other.rear_track, plain.rear_track, rtol=0, atol=1e-12)
