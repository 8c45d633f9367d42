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
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, Terms
from heyoka_bike.scoring.measures import rms

CODE = "linearised"

LINEARISED = Mistake(
    CODE,
    "the equations are linearised about the upright straight motion, at constant speed",
    "nothing if that is what you want: the benchmark asks for the nonlinear equations",
    "model",
    lambda p: replace(p, linear=Terms()),
)


def _with(code: str, says: str, terms: Terms) -> Mistake:
    return Mistake(
        f"{CODE}_{code}",
        f"the equations are linearised, at constant speed, and {says}",
        "the equations M q'' + v C1 q' + (g K0 + v^2 K2) q = 0",
        "model",
        lambda p: replace(p, linear=terms),
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
"""The right one, and usual slips in these equations, in no particular order."""

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
