"""Where the replay puts the bicycle is where rolling without slip puts it."""

import numpy as np
import pytest

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.showing.replay.motion_3d import Place, motion_3d, reference_state

MANEUVERS = [1, 2, 3]


@pytest.fixture(scope="module")
def k(bicycle):
    return Equations.binary64(bicycle).k


@pytest.fixture(scope="module")
def motions(reference, k):
    time = np.linspace(0.0, 10.0, 501)
    return {n: motion_3d(k, reference_state(reference[n]), time) for n in MANEUVERS}


def rates(k, reference, number, times, h=2e-3):
    """Central differences of eighth order of all motions at some times, by name."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    state = reference_state(reference[number])
    found = []
    for t in times:
        grid = np.concatenate(([0.0], t + h * np.arange(-4, 5)))
        m = motion_3d(k, state, grid)
        found.append(
            {
                name: sum(w * (x[5 + i] - x[5 - i]) for i, w in weights.items()) / h
                for name, x in ((n, getattr(m, n)) for n in m.__slots__)
            }
        )
    return {name: np.array([row[name] for row in found]) for name in found[0]}


TIMES = np.linspace(0.31, 9.7, 13)


@pytest.fixture(scope="module", params=MANEUVERS)
def moving(request, reference, k):
    """A maneuver: its motion at some times, and the rates of it there."""
    state = reference_state(reference[request.param])
    at = motion_3d(k, state, np.concatenate(([0.0], TIMES)))
    here = {name: getattr(at, name)[1:] for name in at.__slots__}
    return here, rates(k, reference, request.param, TIMES)


@pytest.mark.parametrize("number", MANEUVERS)
def test_both_wheels_touch_the_floor_and_no_more(motions, number):
    m = motions[number]
    for hub, contact, frame, radius in (
        (m.rear_hub, m.rear_contact, m.rear_frame, 0.3),
        (m.front_hub, m.front_contact, m.front_frame, 0.35),
    ):
        assert np.abs(contact[:, 2]).max() < 1e-9
        # The lowest of all points of the rim, not the one that the code says is.
        angles = np.linspace(0, 2 * np.pi, 20001)
        for i in (0, 30, 250, 500):
            rim = hub[i] + radius * (
                np.cos(angles)[:, None] * frame[i][:, 0] + np.sin(angles)[:, None] * frame[i][:, 2]
            )
            lowest = rim[np.argmax(rim[:, 2])]
            assert abs(lowest[2]) < 2e-8  # how far apart the points are
            assert np.linalg.norm(lowest - contact[i]) < 1e-4


def test_the_start_is_the_upright_straight_bicycle(motions):
    for m in motions.values():
        tilt = np.pi / 10
        for found, expected in (
            (m.rear_contact, (0, 0, 0)), (m.front_contact, (1.02, 0, 0)),
            (m.rear_hub, (0, 0, -0.3)), (m.front_hub, (1.02, 0, -0.35)),
            (m.steer_axis, (np.sin(tilt), 0, np.cos(tilt))),
        ):  # fmt: skip
            np.testing.assert_allclose(found[0], expected, rtol=0, atol=1e-15)
        np.testing.assert_allclose(m.rear_frame[0], np.eye(3), rtol=0, atol=1e-15)
        np.testing.assert_allclose(m.front_frame[0], np.eye(3), rtol=0, atol=1e-15)
        assert m.rear_wheel[0] == m.front_wheel[0] == m.rear_track[0] == m.front_track[0] == 0


@pytest.mark.parametrize("number", MANEUVERS)
def test_frame_and_fork_are_rigid_and_joined_along_the_steer_axis(motions, number):
    m = motions[number]
    for frame in (m.rear_frame, m.front_frame):
        product = np.swapaxes(frame, 1, 2) @ frame
        np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), product.shape), atol=1e-14)
        np.testing.assert_allclose(np.linalg.det(frame), 1.0, rtol=1e-14)
    # Two points of the axis, given in the upright bicycle, are the same seen from either side.
    tilt = np.pi / 10
    for up in (0.0, 0.9):
        p = np.array([1.1 - up * np.sin(tilt), 0.0, -up * np.cos(tilt)])
        of_rear = m.rear_hub + m.rear_frame @ (p - (0, 0, -0.3))
        of_front = m.front_hub + m.front_frame @ (p - (1.02, 0, -0.35))
        np.testing.assert_allclose(of_rear, of_front, rtol=0, atol=1e-13)
    # The angle about it is the steer angle.
    turn = np.swapaxes(m.rear_frame, 1, 2) @ m.front_frame
    angle = np.arccos(np.clip((np.trace(turn, axis1=1, axis2=2) - 1) / 2, -1, 1))
    np.testing.assert_allclose(angle, np.abs(m.steer), rtol=0, atol=1e-7)


@pytest.mark.parametrize("number", MANEUVERS)
def test_the_wheel_base_is_constant_between_points_of_the_axis(motions, number):
    m = motions[number]
    # From the rear hub to the steer axis, square to it, nothing stretches; nor to the front hub.
    along = np.sum((m.front_hub - m.rear_hub) * m.steer_axis, axis=1)
    upright = 1.02 * np.sin(np.pi / 10) - 0.05 * np.cos(np.pi / 10)
    np.testing.assert_allclose(along, upright, rtol=0, atol=1e-13)
    straight = np.abs(m.steer) < 1e-3
    base = np.linalg.norm(m.front_hub - m.rear_hub, axis=1)
    np.testing.assert_allclose(base[straight], np.hypot(1.02, 0.05), rtol=0, atol=1e-6)


@pytest.mark.parametrize("number", MANEUVERS)
def test_yaw_is_that_of_the_reference(motions, reference, number):
    expected = reference[number].approximate(motions[number].time, ["yaw"])["yaw"]
    np.testing.assert_allclose(motions[number].yaw, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("number", MANEUVERS)
def test_places_do_not_depend_on_how_many_are_asked_for(motions, reference, k, number):
    few, state = motions[number], reference_state(reference[number])
    many = motion_3d(k, state, np.linspace(0.0, 10.0, 4001))
    for name in ("rear_contact", "front_contact", "rear_wheel", "front_wheel", "front_track"):
        np.testing.assert_allclose(getattr(few, name), getattr(many, name)[::8], rtol=0, atol=1e-12)


@pytest.mark.parametrize("number", MANEUVERS)
def test_the_rear_track_is_the_integral_of_the_published_speed(motions, reference, number):
    # Of the contact point, which has a column of its own; Simpson's rule with 0.5 ms.
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


@pytest.mark.parametrize("number", MANEUVERS)
def test_the_arc_of_each_wheel_is_the_length_of_its_track(motions, number):
    m = motions[number]
    heading = np.stack([np.cos(m.yaw), np.sin(m.yaw), 0 * m.yaw], axis=1)
    front_heading = np.cross(m.front_frame[:, :, 1], [0.0, 0.0, 1.0])
    front_heading /= np.linalg.norm(front_heading, axis=1, keepdims=True)
    for wheel, frame, ahead, radius, track in (
        (m.rear_wheel, m.rear_frame, heading, 0.3, m.rear_track),
        (m.front_wheel, m.front_frame, front_heading, 0.35, m.front_track),
    ):
        # How far the frame's x axis is turned from the wheel's heading, about the axle.
        pitch = np.arctan2(
            np.sum(frame[:, :, 2] * ahead, axis=1), np.sum(frame[:, :, 0] * ahead, axis=1)
        )
        arc = -radius * (wheel + pitch - pitch[0])
        np.testing.assert_allclose(arc, track, rtol=0, atol=1e-9)


def test_contact_points_move_along_their_wheels_heading(moving):
    here, rate = moving
    front = np.cross(here["front_frame"][:, :, 1], [0.0, 0.0, 1.0])
    front /= np.linalg.norm(front, axis=1, keepdims=True)
    rear = np.stack([np.cos(here["yaw"]), np.sin(here["yaw"]), 0 * here["yaw"]], axis=1)
    for name, ahead in (("rear", rear), ("front", front)):
        velocity = rate[f"{name}_contact"]
        aside = np.linalg.norm(np.cross(velocity, ahead), axis=1)
        assert aside.max() < 1e-9
        forward = np.sum(velocity * ahead, axis=1)
        assert forward.min() > 3.9
        np.testing.assert_allclose(forward, rate[f"{name}_track"], rtol=0, atol=1e-9)


def test_the_material_point_at_the_floor_stands_still(moving):
    # Rolling without slip itself: the velocity of the hub and the absolute rate of the wheel, both
    # by differences of places and attitudes.
    here, rate = moving
    for name, contact in (("rear", "rear_contact"), ("front", "front_contact")):
        frame, frame_rate = here[f"{name}_frame"], rate[f"{name}_frame"]
        skew = frame_rate @ np.swapaxes(frame, 1, 2)
        turn = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
        turn = turn + rate[f"{name}_wheel"][:, None] * frame[:, :, 1]
        arm = here[contact] - here[f"{name}_hub"]
        slip = rate[f"{name}_hub"] + np.cross(turn, arm)
        assert np.abs(slip).max() < 1e-8


def test_a_start_elsewhere_moves_and_turns_everything(reference, k):
    time = np.linspace(2.0, 5.0, 151)
    state = reference_state(reference[2])
    plain = motion_3d(k, state, time)
    other = motion_3d(k, state, time, Place(3.0, -1.0, 0.7))
    s, c = np.sin(0.7), np.cos(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for name in ("rear_contact", "front_contact", "rear_hub", "front_hub"):
        expected = getattr(plain, name) @ turn.T + (3.0, -1.0, 0.0)
        np.testing.assert_allclose(getattr(other, name), expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.front_frame, turn @ plain.front_frame, rtol=0, atol=1e-13)
    np.testing.assert_allclose(other.rear_track, plain.rear_track, rtol=0, atol=1e-12)
