"""Equations of motion without one of their terms, as those are written who start from each body."""

from heyoka_bike.scoring.diagnosis.programs.incomplete import (
    FRAMES_GYROSCOPIC,
    TENSORS_TURNING,
    WHEELS_GYROSCOPIC,
    WHEELS_WEIGHT,
)
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, missing_term

_EULER = "Euler's equations of each body: I w' + w x (I w)"

EQUATION_MISTAKES: tuple[Mistake, ...] = (
    missing_term(
        "no_gyroscopic",
        "the gyroscopic torque w x (I w) of all bodies is missing",
        _EULER,
        FRAMES_GYROSCOPIC,
        WHEELS_GYROSCOPIC,
    ),
    missing_term(
        "no_gyroscopic_wheels",
        "the gyroscopic torque w x (I w) of the wheels is missing",
        _EULER,
        WHEELS_GYROSCOPIC,
    ),
    missing_term(
        "no_gyroscopic_frames",
        "the gyroscopic torque w x (I w) of rear frame and fork is missing",
        _EULER,
        FRAMES_GYROSCOPIC,
    ),
    missing_term(
        "tensors_do_not_turn",
        "the inertia of rear frame and fork does not turn with "
        "them, but stays as it is at the start",
        "the inertia in ground axes: R I R^T",
        TENSORS_TURNING,
    ),
    missing_term(
        "wheels_weightless",
        "gravity does not act on the wheels: their weight is missing",
        "gravity on every body",
        WHEELS_WEIGHT,
    ),
)
"""In no particular order."""
