"""A result file moves as its own state determines, from the initial position of the reference."""

from dataclasses import fields

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import NothingScoredError
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.replay.motion_3d import Motion3D
from heyoka_bike.workbench.replay.scenes import replay

NAMES = [f.name for f in fields(Motion3D)]
ROLL, ROLL_RATE, SPEED, STEER, STEER_RATE = 0, 1, 2, 6, 7


@pytest.fixture(scope="module")
def table(reference):
    """The reference's text as numbers: time, then 8 columns of each maneuver."""
    return np.loadtxt(reference.folder / "uncontrolled-bicycle.txt")


@pytest.fixture
def shown(reference, tmp_path):
    """Returns the scenes of a table written to a file."""

    def scenes(table, **options):
        path = tmp_path / "result.txt"
        np.savetxt(path, table, fmt="%.17g")
        found = replay(reference, read_results(path, count=3), **options)
        return {s.number: s for s in found.scenes}

    return scenes


def said(scene):
    return " ".join(scene.notes if scene.result is None else scene.result.notes)


def test_the_reference_as_a_file_coincides(reference):
    path = reference.folder / "uncontrolled-bicycle.txt"
    for scene in replay(reference, read_results(path, count=3)).scenes:
        assert scene.result.first == 0
        for name in NAMES:
            one, other = (getattr(x.motion, name) for x in (scene.reference, scene.result))
            np.testing.assert_allclose(other, one, rtol=0, atol=1e-9)
        assert set(scene.result.columns) == set(BENCHMARK_COLUMNS)
        assert "of the reference are used" not in said(scene)


def test_a_perturbed_file_differs_as_it_should(table, shown):
    # The speed is higher by a thousandth, so the position is ahead by a thousandth of the distance.
    other = table.copy()
    other[:, 1 + 8 + SPEED] *= 1.001
    scenes = shown(other)
    plain, faster = scenes[2].reference.motion, scenes[2].result.motion
    ratio = faster.rear_track[1:] / plain.rear_track[1:]
    np.testing.assert_allclose(ratio, 1.001, rtol=2e-6)
    assert np.abs(faster.yaw - plain.yaw).max() > 1e-4
    np.testing.assert_allclose(faster.roll, plain.roll, rtol=0, atol=1e-12)
    for number in (1, 3):
        a, b = scenes[number].reference.motion, scenes[number].result.motion
        np.testing.assert_allclose(a.rear_contact, b.rear_contact, rtol=0, atol=1e-9)


def test_both_wheels_of_a_result_are_on_the_floor(table, shown):
    other = table.copy()
    other[:, 1 + ROLL] *= 1.3
    other[:, 1 + STEER] *= 0.7
    motion = shown(other)[1].result.motion
    assert np.abs(motion.front_contact[:, 2]).max() < 1e-9
    assert np.abs(motion.roll - 1.3 * shown(table)[1].reference.motion.roll).max() < 1e-9
    assert motion.pitch.max() > 0


def test_a_circle_is_a_circle(table, shown):
    # With constant roll and steer the rear wheel moves on a circle, with the yaw rate that its
    # steer angle determines. The test uses only the positions.
    other = table.copy()
    other[:, 1 + 16 + ROLL], other[:, 1 + 16 + STEER] = 0.2, 0.3
    other[:, 1 + 16 + ROLL_RATE] = other[:, 1 + 16 + STEER_RATE] = 0.0
    other[:, 1 + 16 + SPEED] = 3.0
    m = shown(other)[3].result.motion
    steps = np.gradient(m.rear_contact, m.time, axis=0)[2:-2]
    curvature = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
    assert curvature.mean() > 0
    # The tolerance is the accuracy of linear interpolation of the difference from the moving
    # reference.
    np.testing.assert_allclose(curvature, curvature.mean(), rtol=5e-5)
    # Both contact points move on circles with a common centre, as in rolling without slip.
    turn = curvature.mean() / (m.time[1] - m.time[0])
    radius = np.linalg.norm(steps, axis=1).mean() / turn
    left = np.stack([-np.sin(m.yaw), np.cos(m.yaw), 0 * m.yaw], axis=1)
    centre = (m.rear_contact + radius * left).mean(axis=0)
    for contact in (m.rear_contact, m.front_contact):
        away = np.linalg.norm(contact - centre, axis=1)
        assert np.ptp(away) < 1e-3
    # The front wheel is ahead of the rear wheel, so its circle is larger.
    assert np.linalg.norm(m.front_contact - centre, axis=1).mean() > radius


def test_another_definition_is_brought_to_the_default_one(reference):
    # Exudyn's roll angle includes part of the yaw, which is up to 0.3 rad in this run.
    path = data_folder() / "peers" / "exudyn-h0.001.txt"
    for scene in replay(reference, read_results(path, count=3)).scenes:
        assert "roll angle taken as tait_bryan_xyz" in said(scene)
        error = scene.result.motion.roll - scene.reference.motion.roll
        assert np.abs(error).max() < 5e-4


def test_rows_that_end_or_begin_elsewhere(table, shown):
    scenes = shown(table[100:401])
    motion = scenes[2].result.motion
    assert scenes[2].result.first == 50
    assert motion.time[[0, -1]] == pytest.approx([1.0, 4.0])
    beside = scenes[2].reference.motion.rear_contact[50:201]
    np.testing.assert_allclose(motion.rear_contact, beside, rtol=0, atol=1e-9)
    assert "begin at 1 s" in said(scenes[2])
    assert "rows of the file end at 4 s" in said(scenes[2])


def test_a_missing_number_ends_the_replay(table, shown):
    other = table.copy()
    other[500, 1 + 8 + STEER] = np.nan
    scenes = shown(other)
    assert scenes[2].result.motion.time[-1] == pytest.approx(4.98)
    assert "no usable number" in said(scenes[2])
    assert len(scenes[1].result.motion.time) == len(scenes[3].result.motion.time) == 501


def test_missing_columns_are_said(reference, tmp_path):
    names = ["time", "roll_angle", "steer_angle"]
    maneuver = reference[2]
    columns = [maneuver.time, maneuver.rows["roll_angle"] * 1.01, maneuver.rows["steer_angle"]]
    path = tmp_path / "some.csv"
    np.savetxt(path, np.column_stack(columns), header=",".join(names), comments="", delimiter=",")
    scenes = replay(reference, read_results(path, maneuver=2, count=3)).scenes
    assert "no usable roll rate, steer rate and forward speed: the values of the ref" in said(
        scenes[1]
    )
    assert set(scenes[1].result.columns) == {"roll_angle", "steer_angle"}
    assert "does not contain maneuver 1" in said(scenes[0])
    motion = scenes[1].result.motion
    np.testing.assert_allclose(
        motion.roll, 1.01 * scenes[1].reference.motion.roll, rtol=0, atol=1e-9
    )


def test_a_bicycle_that_falls_is_shown_until_then(table, shown):
    other = table.copy()
    other[:, 1 + ROLL] += 0.02 * other[:, 0] ** 2 * np.sign(other[:, 0])
    scene = shown(other)[1]
    motion = scene.result.motion
    assert 5 < motion.time[-1] < 9.5
    assert 1.2 < np.abs(motion.roll).max() < 1.41
    assert "its bicycle has fallen" in said(scene)
    assert all(np.isfinite(getattr(motion, name)).all() for name in NAMES)


def test_a_bicycle_that_leaves_is_shown_until_then(table, shown):
    other = table.copy()
    other[:, 1 + SPEED] *= np.exp(other[:, 0])
    scene = shown(other)[1]
    assert 3 < scene.result.motion.time[-1] < 9.5
    assert "has left the scene" in said(scene)


def test_few_rows_add_no_error_of_their_own(table, shown):
    # The file has a row every half second, with five digits. The reference provides the values in
    # between.
    other = np.array([[float(f"{x:.5g}") for x in row] for row in table[::50]])
    for scene in shown(other).values():
        a, b = scene.reference.motion, scene.result.motion
        assert np.abs(a.rear_contact - b.rear_contact).max() < 5e-3
        assert np.abs(a.roll - b.roll).max() < 1e-5


def test_nothing_to_show_is_said(reference, table, tmp_path):
    path = tmp_path / "energies.csv"
    rows = reference[2].rows
    columns = [reference[2].time, rows["potential_energy"], rows["kinetic_energy"]]
    head = "time,potential_energy,kinetic_energy"
    np.savetxt(path, np.column_stack(columns), header=head, comments="", delimiter=",")
    results = read_results(path, maneuver=2, count=3)
    with pytest.raises(NothingScoredError, match="no usable column of the motion in maneuver 2"):
        replay(reference, results)


def test_long_runs_have_fewer_frames(reference):
    assert [len(s.reference.motion.time) for s in replay(reference).scenes] == [501] * 3
    (one,) = replay(reference, maneuver=3, rate=1000).scenes
    assert len(one.reference.motion.time) == 6001
