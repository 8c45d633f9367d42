"""Motions that are simulated together equal the motions simulated alone, even if one ends early."""

from dataclasses import replace

import numpy as np
import pytest

from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.programs.simulator import MotionRequest

TIME = np.linspace(0.0, 10.0, 101)
# Initial state of a motion that ends at once.
ENDING = (1.5, 0.0, 0.0, 5.0, 0.0, 4.0)
# Initial state of a motion that ends after a few tenths of a second.
FALLING = (0.0, 0.0, 0.0, 1.0, 0.0, 1.0)
STARTS = [(0.0, 0.0, 0.0, rate, 0.0, speed) for rate, speed in
          ((0.05, 4.0), (0.5, 4.6), (0.05, 8.0), (0.05, 5.0), (0.02, 6.0))]  # fmt: skip


def check(simulator, motions):
    together = simulator.run_all(motions)
    for motion, made in zip(motions, together, strict=True):
        alone = simulator.run(motion.bicycle, motion.start, motion.time, motion.amounts)
        for name, x in alone.items():
            good = np.isfinite(x)
            assert np.array_equal(good, np.isfinite(made[name])), name
            # Newton's iterations stop at the same time for all motions, which causes small
            # differences from motions simulated alone.
            size = np.max(np.abs(x[good]), initial=1e-3)
            assert np.max(np.abs(made[name] - x)[good], initial=0.0) <= 1e-12 * size, name
    return together


def test_motions_on_several_grids_and_in_more_than_one_vector(simulator, bicycle):
    times = [TIME, TIME[:11], 0.9 * TIME]
    check(simulator, [MotionRequest(bicycle, start, time) for time in times for start in STARTS])


def test_motions_beside_one_that_ends_are_unchanged(simulator, bicycle):
    motions = [MotionRequest(bicycle, start, TIME) for start in (STARTS[0], ENDING, *STARTS[1:])]
    found = check(simulator, motions)
    assert [int(np.isfinite(x["roll_angle"]).sum()) == len(TIME) for x in found] == [
        start is not ENDING for start in (STARTS[0], ENDING, *STARTS[1:])
    ]


@pytest.mark.proof
def test_with_forces_and_without_terms(simulator, bicycle):
    amounts = (
        {},
        {"air_drag": 0.1},
        {"wheels_weight": 1.0},
        {"wheels_weight": 1.0, "air_drag": 0.1},
    )
    motions = [MotionRequest(bicycle, start, TIME[:31], a) for a in amounts for start in STARTS[:2]]
    found = check(simulator, motions)
    ends = [x["roll_angle"][-1] for x in found[::2]]
    assert len(set(ends)) == len(amounts)


@pytest.mark.parametrize("amounts", [{}, {"air_drag": 0.1}])
def test_motions_near_one_are_those_alone_to_first_order(simulator, bicycle, amounts):
    """A parameter, a force and an initial value each differ by very little."""
    heavier = replace(bicycle, values={**bicycle.values, "mB": Exact.parse("85.0001")})
    start = list(STARTS[0])
    start[2] = 1e-6
    one = MotionRequest(bicycle, STARTS[0], TIME, amounts)
    others = [
        MotionRequest(heavier, STARTS[0], TIME, amounts),
        MotionRequest(bicycle, STARTS[0], TIME, {**amounts, "steer_damping": 1e-6}),
        MotionRequest(bicycle, start, TIME, amounts),
    ]
    ((here, *near),) = simulator.run_near([[one, *others]])
    _, *exact = simulator.run_all([one, *others])
    for found, made in zip(near, exact, strict=True):
        for name in ("roll_angle", "steer_rate", "forward_speed", "kinetic_energy"):
            change = np.max(np.abs(made[name] - here[name]))
            assert change > 1e-10, name
            assert np.max(np.abs(found[name] - made[name])) < 1e-3 * change, name


def test_motions_near_one_that_ends_end_as_well(simulator, bicycle):
    one = MotionRequest(bicycle, FALLING, TIME)
    ((here, near),) = simulator.run_near([[one, replace(one, amounts={"air_drag": 1e-6})]])
    good = np.isfinite(here["roll_angle"])
    assert 0 < good.sum() < len(TIME)
    assert np.array_equal(np.isfinite(near["roll_angle"]), good)
