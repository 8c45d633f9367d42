"""The segments of a motion join without gaps, from 0 to the requested end and not beyond it."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import pytest

from heyoka_bike.motion.integrate import integrate


@pytest.fixture(scope="module", params=[Fraction(1, 7), Fraction(3, 10), Fraction(2)])
def made(request, bicycle, maneuvers):
    told = []
    maneuver = replace(maneuvers[1], duration=request.param)
    return integrate(bicycle, maneuver, progress=told.append), told, request.param


def test_the_last_piece_ends_at_the_first_grid_time_from_the_end_on(made):
    """The end is a multiple of 2^-20 s, so that a break is a number of any precision."""
    motion, _, duration = made
    assert motion.breaks[0] == 0
    assert motion.breaks[-1] == Fraction(-((-duration * 2**20) // 1), 2**20)
    assert duration <= motion.breaks[-1] < duration + Fraction(1, 2**20)
    assert all(a < b for a, b in pairwise(motion.breaks))


def test_each_piece_ends_where_the_next_one_begins(made):
    motion, _, _ = made
    assert len(motion.pieces) == len(motion.breaks) - 1
    for before, after in pairwise(motion.pieces):
        assert [sum(x) for x in before] == [x[0] for x in after]


def test_the_time_reached_is_told_after_each_piece(made):
    motion, told, duration = made
    assert told == [float(min(t, duration)) for t in motion.breaks[1:]]
