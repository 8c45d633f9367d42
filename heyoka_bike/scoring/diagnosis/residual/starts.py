"""The start that a file's motion has, where its equations are right: a wrong one leaves nothing.

The start of each maneuver is changed until its motion is the file's. Then as few of roll, steer,
their rates and the speed as will do are set free, the others as they are given.
"""

from collections.abc import Mapping

import numpy as np

from heyoka_bike.bicycle.parameters import START
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.programs.program import Found
from heyoka_bike.scoring.diagnosis.residual.linear_fits import best_subsets, blocks
from heyoka_bike.scoring.diagnosis.residual.observed import STATE, Observed
from heyoka_bike.scoring.diagnosis.residual.shooting import Errors, shoot, size_of, uncertain

# Relief that the start of one maneuver must have, and each further part of it: errors of correct
# programs are explained by a factor of up to 9 by one, and 30 by three.
_LEAST, _FURTHER = 25.0, 3.0
_MOST = 3
# Below this part of a column nothing is left to see.
_NOTHING = 1e-15


def find_start(motion: Observed, given: Mapping[str, float], errors: Errors) -> list[Found]:
    """What differs in the start of a maneuver from what is given; empty if nothing shows.

    Parameters
    ----------
    motion : Observed
    given
        The start, by the names of `parameters.START`.
    errors
        Of changes of it, in that order.
    """
    first = _at_zero(motion)
    if first is None:
        return []
    right = np.array([given[name] for name in START])
    x, left, slopes = shoot(errors, first - right, np.ones(len(START)))
    (before,) = errors([np.zeros(len(START))])
    if not size_of(before) > _LEAST * size_of(left):
        return []
    # To first order around the start that was found.
    rest = left - slopes @ x
    normal = blocks(list(rest), [-j for j in slopes], [_NOTHING] * len(rest))
    known, found = 0.0, []
    for size in range(1, _MOST + 1):
        best = best_subsets(normal, size, 1)
        if best.gains[0] > (_FURTHER * known if known else _LEAST):
            known, members = float(best.gains[0]), best.members[0]
            part = slopes[:, :, members]
            off = uncertain(rest + part @ best.changes[0], part)
            values = zip(members, best.changes[0], off, strict=True)
            found = [_found(motion.number, START[i], given, dx, u) for i, dx, u in values]
    return found


def _found(number: int, name: str, given: Mapping[str, float], change: float, off: float) -> Found:
    value = given[name] + float(change)
    return Found(f"initial_{name}", number, value, given[name], float(off))


def _at_zero(motion: Observed) -> Array | None:
    """The state at t = 0 by a cubic through the rows after the first, which may be as given."""
    time = motion.time
    if time[0] > 2 * (time[1] - time[0]):
        return None
    rows = slice(1, 5)
    weights = np.linalg.solve(np.vander(time[rows], increasing=True).T, np.eye(4)[0])
    return np.array([weights @ motion.state[key][rows] for key in STATE])
