"""NumPy's steps give the motions that heyoka's give, of right and of wrong bicycles."""

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.programs.program import Program, apply
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion
from heyoka_bike.scoring.diagnosis.programs.start import Start, initial_state
from heyoka_bike.scoring.diagnosis.programs.stepping import Stepping

pytestmark = pytest.mark.proof

TIME = np.concatenate([np.arange(0.0, 9.0, 0.37), [9.1234, 9.1234, 10.0]])
STARTS = {1: Start(4.0, 0.05), 2: Start(4.6, 0.5), 3: Start(8.0, 0.05)}
NAMES = [c.name for c in COLUMNS]


def motions(bicycle, codes):
    found = []
    known = {m.code: m for m in MISTAKES}
    for code in codes:
        program = apply(Program(bicycle, STARTS), (known[code],) if code else ())
        values = {s: float(x) for s, x in program.bicycle.values.items()}
        found += [
            AskedMotion(program.bicycle, initial_state(values, start), TIME)
            for start in program.starts.values()
        ]
    return found


def test_motions_agree(bicycle, simulator):
    """Their own errors, 3e-12 at the most, fall by 2^8 with half the step."""
    asked = motions(bicycle, ("", "trail_normal", "sign_IHxz", "no_IHxz", "printed_p2"))
    for a, b in zip(simulator.run_all(asked), Stepping().run_all(asked), strict=True):
        assert a.keys() == b.keys()
        for name in NAMES:
            assert np.max(np.abs(a[name] - b[name])) <= 1e-11 * np.max(np.abs(a[name]))


def test_a_motion_that_ends_is_told(bicycle, simulator):
    """The same fall, and not a number after it: some steps sooner, as polynomials look ahead."""
    asked = motions(bicycle, ("trail_sign", "tilt_zero"))
    for a, b in zip(simulator.run_all(asked), Stepping().run_all(asked), strict=True):
        there = np.isfinite(b["roll_angle"])
        assert 0 < there.sum() < len(TIME)
        assert 0 <= np.isfinite(a["roll_angle"]).sum() - there.sum() <= 1
        assert np.all(np.diff(there.astype(int)) <= 0)
        assert np.max(np.abs((a["roll_angle"] - b["roll_angle"])[there])) <= 1e-6


def test_altered_equations_have_no_motion(bicycle):
    (asked, *_) = motions(bicycle, ("",))
    (found,) = Stepping().run_all(
        [AskedMotion(asked.bicycle, asked.start, TIME, {"wheels_weight": 1.0})]
    )
    assert np.all(np.isnan(found["roll_angle"]))
