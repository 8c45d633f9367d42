"""Equations that lack a term give the motions of a Newton-Euler program that lacks the same
term."""

import numpy as np
import pytest

from corpus.writing import Runs
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, TENSORS
from heyoka_bike.scoring.diagnosis.programs.program import (
    Motion,
    Program,
    Start,
    apply,
    initial_state,
)

MADE = {
    "no_gyroscopic": "newton-no-gyroscopic",
    "no_gyroscopic_wheels": "newton-no-gyroscopic-wheels",
    "tensors_do_not_turn": "newton-tensor-in-global-axes",
    "wheels_weightless": "newton-wheels-weightless",
}
"""Stored runs of an independent program, by mistake."""
STARTS = {1: Start(4.0, 0.05), 2: Start(4.6, 0.5), 3: Start(8.0, 0.05)}
KEYS = {"roll": "roll_angle", "roll_rate": "roll_rate", "speed": "forward_speed",
        "steer": "steer_angle", "steer_rate": "steer_rate"}  # fmt: skip


def farthest(simulator, bicycle, run, missing):
    """Largest distance from a run of another program, relative to the size of each column."""
    runs, found = Runs(), []
    for n, start in STARTS.items():
        block = runs.block(run, n)
        # Compare the motions only until the bicycle falls. After that, their difference grows
        # without bound.
        upright = np.cumprod(np.abs(np.nan_to_num(block["roll"], nan=9.0)) < 0.5) == 1
        time = block["time"][upright]
        made = simulator.run(bicycle, initial_state(bicycle, start), time, dict(missing))
        for name, key in KEYS.items():
            there = block[name][upright]
            found.append(np.max(np.abs(made[key] - there)) / np.max(np.abs(there)))
    return max(found)


@pytest.mark.proof
@pytest.mark.parametrize(("code", "run"), MADE.items())
def test_they_move_as_in_a_program_of_another_hand(simulator, bicycle, code, run):
    (mistake,) = (m for m in EQUATION_MISTAKES if m.code == code)
    missing = apply(Program(Motion(bicycle, STARTS)), (mistake,)).motion.amounts
    # Both programs integrate to about 1e-12. Motions that fall multiply this error by a thousand or
    # more.
    assert farthest(simulator, bicycle, run, missing) < 1e-7
    assert farthest(simulator, bicycle, run, ()) > 1e-3


def test_every_mistake_is_of_a_known_term(bicycle):
    program = Program(Motion(bicycle, STARTS))
    amounts = [dict(apply(program, (m,)).motion.amounts) for m in EQUATION_MISTAKES]
    assert set().union(*amounts) <= {*FORCES, *TENSORS}
