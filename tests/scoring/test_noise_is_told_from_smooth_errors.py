"""The part of an error that jumps from row to row is separated, with its size and whether it is
white."""

import numpy as np
import pytest

from heyoka_bike.scoring.noise import roughness

ROWS = np.arange(1001)


def noise(seed, size=1.0):
    return size * np.random.default_rng(seed).normal(size=len(ROWS))


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e200])
def test_white_noise_beside_a_smooth_error_has_its_size(size):
    smooth = 1e3 * size * np.sin(ROWS / 100)
    for seed in range(20):
        found = roughness(smooth + noise(seed, size))
        assert found.is_white
        assert found.size == pytest.approx(size, rel=0.1)


def test_a_smooth_error_leaves_next_to_nothing():
    found = roughness(np.sin(ROWS / 100))
    assert found.size < 1e-8
    assert not found.is_white


def test_what_alternates_is_not_white():
    alternating = roughness((-1.0) ** ROWS + 0.01 * noise(1))
    assert (alternating.at_one, alternating.at_two) == pytest.approx((-1.0, 1.0), abs=0.01)
    assert not alternating.is_white


def test_an_event_is_not_in_the_medians_of_several_parts():
    error = noise(3)
    error[:20] += 1e3 * (-1.0) ** ROWS[:20]
    assert roughness(error, parts=5).is_white
    assert not roughness(error).is_white
    assert not roughness(np.zeros(100)).is_white
