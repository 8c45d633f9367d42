"""Programs with linearised equations, which are no mistake but are not the benchmark's."""

from collections.abc import Sequence

import numpy as np

from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, Terms

LINEARISED_CODE = "linearised"

LINEARISED = Mistake(
    LINEARISED_CODE,
    "the equations are linearised about the upright straight motion, at constant speed",
    "the equations of your program: the benchmark asks for the nonlinear ones",
    "model",
    lambda p: p.moving(linear=Terms()),
)


def _with(code: str, says: str, terms: Terms) -> Mistake:
    return Mistake(
        f"{LINEARISED_CODE}_{code}",
        f"the equations are linearised, at constant speed, and {says}",
        "the equations M q'' + v C1 q' + (g K0 + v^2 K2) q = 0",
        "model",
        lambda p: p.moving(linear=terms),
    )


LINEAR_PROGRAMS = (
    LINEARISED,
    _with("c1_without_v", "C1 is not multiplied by the speed", Terms(c1=0)),
    _with("no_c1", "the term with C1 is missing", Terms(c1=None)),
    _with("k2_times_v", "K2 is multiplied by the speed, not by its square", Terms(k2=1)),
    _with("k2_without_v", "K2 is not multiplied by the square of the speed", Terms(k2=0)),
    _with("no_k2", "the term with K2 is missing", Terms(k2=None)),
    _with("k0_without_g", "K0 is not multiplied by gravity", Terms(k0=0)),
    _with("no_k0", "the term with K0 is missing", Terms(k0=None)),
)
"""The program without mistakes, and usual mistakes in these equations, in no particular order."""

# Largest relative variation of a speed that counts as constant. A program that computes the speed
# again in each row may vary it by roundoff.
_PART_OF_CONSTANT_SPEED = 1e-14


def has_constant_speed(parts: Sequence[Part]) -> bool:
    """True if the forward speed is the same in every row of each maneuver, or not in the file."""
    for part in parts:
        speed = part.values.get("forward_speed", np.array([]))
        speed = speed[np.isfinite(speed)]
        if len(speed) and np.ptp(speed) > _PART_OF_CONSTANT_SPEED * np.max(np.abs(speed)):
            return False
    return True
