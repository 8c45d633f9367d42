"""Sinking into the soft floor of an engine is distinguished from a wrong roll angle."""

import numpy as np
import pytest

from generators.published_columns import published_table
from heyoka_bike import score
from heyoka_bike.scoring.diagnosis.energies import of_contact

# [s] time constant of the contact. After ten time constants the bicycle is at rest.
STIFFNESS_TIME = 0.005
WEIGHT = 94 * 9.81
DEPTH = 0.58e-3  # [m] depth to which the wheels sink at rest with MuJoCo's contact


@pytest.fixture
def table(reference):
    return published_table(reference)


def found(table, reference):
    return list(of_contact(score(table, reference=reference)))


def test_sinking_is_seen_with_its_energy(table, reference):
    """The bicycle sinks into a critically damped contact; the roll rates are too large by a
    tenth."""
    t = table[:, 0] / STIFFNESS_TIME
    fall = -DEPTH * WEIGHT * (1 - (1 + t) * np.exp(-t))
    for n in range(3):
        table[:, 4 + 8 * n] += fall
        table[:, 6 + 8 * n] += fall
        table[:, 2 + 8 * n] *= 1.1
    (sinks,) = found(table, reference)
    assert sinks.energy == pytest.approx(DEPTH * WEIGHT, rel=1e-3)
    # The turning wheels add to the moving mass, which changes the time constant by a twentieth.
    assert sinks.constant == pytest.approx((DEPTH / 9.81) ** 0.5, rel=0.05)


def test_a_right_file_does_not_sink(table, reference):
    assert found(table, reference) == []


def test_an_energy_from_another_height_is_no_sinking(table, reference):
    for n in range(3):
        table[:, [4 + 8 * n, 6 + 8 * n]] -= 0.5
    assert found(table, reference) == []


def test_a_wrong_roll_angle_is_no_sinking(table, reference):
    """The potential energy belongs to a roll angle that is larger by a tenth."""
    for n in range(3):
        roll = table[:, 1 + 8 * n]
        change = -WEIGHT * 0.86 * (np.cos(roll) - np.cos(1.1 * roll))
        table[:, 1 + 8 * n] *= 1.1
        table[:, 4 + 8 * n] += change
        table[:, 6 + 8 * n] += change
    assert found(table, reference) == []


def test_one_maneuver_alone_says_nothing(table, reference):
    table[:, 4] -= 0.5 * (table[:, 0] > 0)
    assert list(of_contact(score(table[:, :9], reference=reference, maneuver=1))) == []
