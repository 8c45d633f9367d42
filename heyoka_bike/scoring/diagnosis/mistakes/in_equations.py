"""Mistakes in the equations of motion: a missing term, or an inertia that does not turn."""

from heyoka_bike.scoring.diagnosis.programs.forces import FORCES
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, changed

_EULER = "Euler's equations of each body: I w' + w x (I w)"
_WHICH_SPIN_TERM = "the moment equation: the spin's angular momentum I_yy w turns with the frame"
_MISSING = {
    "no_gyroscopic": ("gyroscopic", _EULER),
    "no_gyroscopic_wheels": ("wheels_gyroscopic", _EULER),
    "no_gyroscopic_frames": ("frames_gyroscopic", _EULER),
    "no_gyroscopic_R": ("gyroscopic_R", _EULER),
    "no_gyroscopic_F": ("gyroscopic_F", _EULER),
    "no_spin_moment": ("no_spin_moment", _WHICH_SPIN_TERM),
    "no_spin_moment_R": ("no_spin_moment_R", _WHICH_SPIN_TERM),
    "no_spin_moment_F": ("no_spin_moment_F", _WHICH_SPIN_TERM),
    "wheels_weightless": ("wheels_weight", "gravity on every body"),
}
_STAYS = "but stays as it is at the start"
_UNTURNED = {
    "tensors_do_not_turn": (
        "tensors_turning",
        f"the inertia of rear frame and fork does not turn with them, {_STAYS}",
    ),
    "tensor_B_does_not_turn": (
        "tensor_turning_B",
        f"the inertia of the rear frame does not turn with it, {_STAYS}",
    ),
    "tensor_H_does_not_turn": (
        "tensor_turning_H",
        f"the inertia of the fork does not turn with it, {_STAYS}",
    ),
    "tensor_H_does_not_steer": (
        "tensor_steering_H",
        "the inertia of the fork turns with the rear frame, not with the steering",
    ),
}

OF_TENSORS = frozenset(_UNTURNED)
"""Codes of the mistakes that leave an inertia in other axes. Programs with these mistakes compute
the energy with either tensor."""


def _missing(code: str, says: str, check: str, term: str) -> Mistake:
    return Mistake(code, says, check, "model", lambda p: changed(p, {term: 1.0}))


EQUATION_MISTAKES: tuple[Mistake, ...] = (
    *(
        _missing(code, says, "the inertia in ground axes: R I R^T", term)
        for code, (term, says) in _UNTURNED.items()
    ),
    *(
        _missing(code, f"the {FORCES[term].says} is missing", check, term)
        for code, (term, check) in _MISSING.items()
    ),
)
"""Mistakes in the equations of motion, in no particular order."""
