"""Any axes and senses of a program give signs that agree; one column turned round does not."""

import numpy as np
import pytest
from support.game_files import MOTION
from support.honest_files import signs

from heyoka_bike.scoring.signs import CHOICES, contradictions

BEYOND = ("pitch", "yaw", "yaw_rate")
KEYS = ["roll_angle", "roll_rate", "forward_speed", "steer_angle", "steer_rate", *BEYOND, *MOTION]
# Turned round by a choice of their own.
FREE = ("forward_speed", "pitch", "steer_joint_force_z")
UNSIGNED = ("rear_friction", "front_friction")


@pytest.mark.parametrize("number", range(40))
def test_axes_turned_as_vectors_and_turns_are_agree(number):
    random = np.random.default_rng(number)
    # With quaternions in it, or with axes of the frames other than the ground's.
    keys = KEYS if number % 2 else [k for k in KEYS if "_frame_q" not in k]
    assert contradictions(signs(random, keys)) == []


def test_a_column_turned_round_alone_contradicts_the_others():
    agreeing = dict.fromkeys(KEYS, 1)
    told = {key: contradictions({**agreeing, key: -1}) for key in KEYS}
    # The sign of all of a quaternion is free, so q0 alone is seen by its parity.
    assert [key for key, found in told.items() if not found] == [k for k in KEYS if k in FREE]
    assert all(any(key in c for c in found) for key, found in told.items() if found)


def test_only_those_that_are_tied_are_named():
    agreeing = dict.fromkeys(KEYS, 1)
    assert contradictions({**agreeing, "roll_rate": -1}) == [("roll_angle", "roll_rate")]
    pair = ("rear_normal_force", "front_normal_force")
    assert contradictions({**agreeing, pair[1]: -1}) == [pair]
    assert contradictions({"rear_hub_x": 1, "com_z": -1}) == []


@pytest.mark.parametrize("turned", [(1,), (2,), (3,), (1, 2, 3)])
def test_a_reflection_is_no_rotation(turned):
    """An odd number of columns of a matrix turned round; two of them are axes of the frame."""
    matrix = [f"rear_frame_r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
    reflected = {key: -1 if int(key[-1]) in turned else 1 for key in matrix}
    assert contradictions(reflected) == [tuple(matrix)]
    two = {key: -1 if key[-1] in "12" else 1 for key in matrix}
    assert contradictions(two) == []


def test_every_column_with_a_sign_is_known():
    assert set(KEYS) - set(UNSIGNED) == set(CHOICES)
    assert contradictions({"rear_friction": -1}) == [("rear_friction",)]
