"""Equations of motion without one of their terms, as those are written who start from each body."""

from heyoka_bike.scoring.diagnosis.programs.forces import TENSORS_TURNING
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, missing_term

_EULER = "Euler's equations of each body: I w' + w x (I w)"
_SPIN = "the moment equation: the spin's angular momentum I_yy w turns with the frame"
_WHEELS = (("R", "rear"), ("F", "front"))

EQUATION_MISTAKES: tuple[Mistake, ...] = (
    missing_term(
        "no_gyroscopic",
        "the gyroscopic torque w x (I w) of all bodies is missing",
        _EULER,
        "frames_gyroscopic",
        "wheels_gyroscopic",
    ),
    missing_term(
        "no_gyroscopic_wheels",
        "the gyroscopic torque w x (I w) of the wheels is missing",
        _EULER,
        "wheels_gyroscopic",
    ),
    missing_term(
        "no_gyroscopic_frames",
        "the gyroscopic torque w x (I w) of rear frame and fork is missing",
        _EULER,
        "frames_gyroscopic",
    ),
    missing_term(
        "tensors_do_not_turn",
        "the inertia of rear frame and fork does not turn with "
        "them, but stays as it is at the start",
        "the inertia in ground axes: R I R^T",
        TENSORS_TURNING,
    ),
    *(
        missing_term(
            f"no_gyroscopic_{wheel}",
            f"the gyroscopic torque w x (I w) of the {name} wheel is missing",
            _EULER,
            f"gyroscopic_{wheel}",
        )
        for wheel, name in _WHEELS
    ),
    missing_term(
        "no_spin_moment",
        "the gyroscopic moment of the wheels' spin is missing",
        _SPIN,
        "no_spin_moment",
    ),
    *(
        missing_term(
            f"no_spin_moment_{wheel}",
            f"the gyroscopic moment of the {name} wheel's spin is missing",
            _SPIN,
            f"no_spin_moment_{wheel}",
        )
        for wheel, name in _WHEELS
    ),
    missing_term(
        "wheels_weightless",
        "gravity does not act on the wheels: their weight is missing",
        "gravity on every body",
        "wheels_weight",
    ),
)
"""In no particular order."""
