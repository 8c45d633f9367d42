"""Linearised equations: no mistake, but not what the benchmark asks for.

Programs of these differ in how they compute the energies, if at all. The ways that fit the file are
chosen first, each energy by itself; then the program is judged as all others are.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf, log

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.programs.linear import KINETIC, POTENTIAL, LinearWay
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, Program
from heyoka_bike.scoring.measures import rms

CODE = "linearised"

_CLEARLY = 2.0

Columns = Mapping[str, Array]


def linearised(
    written: Sequence[Columns],
    correct: Sequence[Columns],
    motions: Callable[[Program], Sequence[Columns]],
    program: Program,
) -> Mistake:
    """Linearised equations, with energies as the file has them.

    Parameters
    ----------
    written, correct
        Of each maneuver: columns of the file by key, as understood [SI], and those of the correct
        program by name, at the same rows.
    motions
        What a program makes at these rows.
    program : Program
        The correct one.
    """

    def nearest(key: str, ways: Sequence[LinearWay]) -> LinearWay | None:
        """The way that leaves least, if it is clearly nearer than the correct motion."""
        left = [_left(key, written, motions(replace(program, linear=way))) for way in ways]
        best = min(range(len(ways)), key=left.__getitem__)
        return ways[best] if left[best] < _left(key, written, correct) - log(_CLEARLY) else None

    potential = nearest("potential_energy", [LinearWay(potential=x) for x in POTENTIAL])
    kinetic = nearest("kinetic_energy", [LinearWay(kinetic=x) for x in KINETIC])
    way = LinearWay(
        potential=potential.potential if potential else None,
        kinetic=kinetic.kinetic if kinetic else None,
    )
    return Mistake(
        CODE,
        "the equations are linearised about the upright straight motion, at constant speed",
        "nothing if that is what you want: the benchmark asks for the nonlinear equations",
        "model",
        lambda p: replace(p, linear=way),
    )


def _left(key: str, written: Sequence[Columns], expected: Sequence[Columns]) -> float:
    """Mean logarithm of the errors over the maneuvers; infinite if there is nothing to compare.

    The potential energy may have any zero.
    """
    logs = []
    for w, e in zip(written, expected, strict=True):
        error = w[key] - e[key] if key in w else np.array([])
        error = error[np.isfinite(error)]
        if len(error):
            zero = float(np.mean(error)) if key == "potential_energy" else 0.0
            logs.append(log(max(rms(error - zero), np.finfo(np.float64).tiny)))
    return float(np.mean(logs)) if logs else inf
