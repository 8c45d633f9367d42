"""Linearised equations: no mistake, but not what the benchmark asks for.

Programs of these differ in how they compute the energies, if at all: each energy is taken in the
way that is nearest to the file.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, log

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.diagnosis.programs.linear import KINETIC, POTENTIAL
from heyoka_bike.scoring.diagnosis.programs.program import Mistake
from heyoka_bike.scoring.measures import rms

CODE = "linearised"

LINEARISED = Mistake(
    CODE,
    "the equations are linearised about the upright straight motion, at constant speed",
    "nothing if that is what you want: the benchmark asks for the nonlinear equations",
    "model",
    lambda p: replace(p, is_linear=True),
)

_CLEARLY = 2.0
# Of a speed that a program only repeats, or computes again.
_CONSTANT = 1e-14

Columns = Mapping[str, Array]


def has_constant_speed(parts: Sequence[Part]) -> bool:
    """Whether the forward speed is the same in every row of each maneuver."""
    for part in parts:
        speed = part.values.get("forward_speed", np.array([]))
        speed = speed[np.isfinite(speed)]
        if not len(speed) or np.ptp(speed) > _CONSTANT * np.max(np.abs(speed)):
            return False
    return True


def with_energies(
    motions: Sequence[Columns], written: Sequence[Columns], correct: Sequence[Columns]
) -> list[dict[str, Array]]:
    """Linear motions with the energies as the file has them.

    Parameters
    ----------
    motions
        Of each maneuver, from `linear_columns`.
    written, correct
        Columns of the file by key, as understood [SI], and those of the correct program by name, at
        the same rows. An energy that is in no known way, and not clearly nearer in one than in the
        correct motion, is NaN.
    """
    made = [dict(m) for m in motions]
    for key, ways in (("potential_energy", POTENTIAL), ("kinetic_energy", KINETIC)):
        left = {way: _left(key, written, [m[f"{key}_{way}"] for m in motions]) for way in ways}
        best = min(left, key=left.__getitem__)
        is_known = left[best] < _left(key, written, [c[key] for c in correct]) - log(_CLEARLY)
        for m in made:
            m[key] = m[f"{key}_{best}"] if is_known else np.full_like(m["roll_angle"], np.nan)
    for m in made:
        m["mechanical_energy"] = m["potential_energy"] + m["kinetic_energy"]
    return made


def _left(key: str, written: Sequence[Columns], expected: Sequence[Array]) -> float:
    """Mean logarithm of the errors over the maneuvers; infinite if there is nothing to compare.

    The potential energy may have any zero.
    """
    logs = []
    for w, e in zip(written, expected, strict=True):
        error = w[key] - e if key in w else np.array([])
        error = error[np.isfinite(error)]
        if len(error):
            zero = float(np.mean(error)) if key == "potential_energy" else 0.0
            logs.append(log(max(rms(error - zero), np.finfo(np.float64).tiny)))
    return float(np.mean(logs)) if logs else inf
