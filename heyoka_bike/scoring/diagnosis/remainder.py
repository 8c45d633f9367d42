"""Whether what an explanation leaves can be an integrator's error: an explanation explains.

The size of that error is read off the file in two ways. The benchmark's bicycle conserves energy,
and so do most mistaken ones: an integrator moves potential plus kinetic energy about as much, of
their exchange, as roll and steer of their scales. And it leaves errors of about one size in roll,
steer and their rates, in all maneuvers.
"""

from collections.abc import Mapping, Sequence
from math import log

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.definitions import Understanding
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.units import factor

# Of forty-six correct runs (tests/support/correct_programs.py) the worst of these columns is wrong
# by at most 38 times the change of the energy over its exchange, the largest of three maneuvers; of
# one maneuver alone by 1300 times (implicit midpoint, which all but conserves it).
_OF_ENERGY = 100.0
_OF_ENERGY_ALONE = 4000.0
# ... and by at most 150 times what the best of these is, or 8500 where coarse dense output is all
# the error (DOP853 with a tolerance of 1e-3, linear equations).
_OF_BEST = 2e4
# What is left of a speed or an energy, in scales, of the largest error of these columns: at most a
# fifth in correct runs.
_OF_MOTION = 10.0
# ... or a hundredth of what is to be explained.
_MOSTLY = 100.0
# Our own simulations are not to be trusted below this part of a motion.
_RESOLVED = 1e-9
# An error of so many floors may be that of the digits written.
_AT_FLOOR = 4.0

# What is left below this part of a motion, or at the floor, needs no second explanation.
_NOTHING = 1e-8

Place = tuple[int, str]
"""A maneuver's number and a column's key."""


def energy_level(parts: Sequence[Part], understood: Mapping[str, Understanding]) -> float | None:
    """Change of potential plus kinetic energy, of their exchange; None if the file does not tell.

    The largest of the maneuvers; not below what the digits can tell.
    """
    levels = [_level(part, understood) for part in parts]
    known = [x for x in levels if x is not None]
    return max(known) if len(known) == len(levels) else None


def _level(part: Part, understood: Mapping[str, Understanding]) -> float | None:
    keys = ("potential_energy", "kinetic_energy")
    if any(key not in understood or key not in part.values for key in keys):
        return None
    written = [factor(understood[key].unit)[0] * part.values[key] for key in keys]
    good = np.isfinite(written[0]) & np.isfinite(written[1])
    if good.sum() < 2:
        return None
    potential, kinetic = (x[good] for x in written)
    # Columns that were never filled in conserve their sum, too.
    if not np.ptp(potential) or not np.ptp(kinetic):
        return None
    exchanged = part.reference.approximate(part.time[good], keys[:1])[keys[0]]
    size = max(float(np.std(exchanged)), float(np.std(potential)))
    total = potential + kinetic
    digits = sum(_written(part, key) * factor(understood[key].unit)[0] for key in keys)
    return max(rms(total - total[0]), digits, 1e-15 * float(np.max(np.abs(total)))) / size


def _written(part: Part, key: str) -> float:
    quantum = part.quantum.get(key)
    values = part.values[key]
    good = np.isfinite(values)
    return 0.0 if quantum is None else float(np.median(quantum.at(values[good]))) / 2


def too_large(
    left: Mapping[Place, float], floors: Mapping[Place, float], level: float | None
) -> Place | None:
    """The column that keeps more than an integrator leaves, if any.

    Parameters
    ----------
    left, floors : mapping of (int, str) to float
        Typical error that is left of each maneuver and column, and what its digits cannot tell, of
        the size of its motion.
    level : float or None
        From `energy_level`.
    """
    lateral = {k: max(x, _RESOLVED) for k, x in left.items() if k[1] in LATERAL}
    shown = {k: x for k, x in lateral.items() if x > _AT_FLOOR * floors.get(k, 0.0)}
    if not shown:
        return None
    worst = max(shown, key=shown.__getitem__)
    limits = [_OF_BEST * min(lateral.values())]
    if level is not None:
        is_alone = len({number for number, _ in left}) == 1
        limits.append((_OF_ENERGY_ALONE if is_alone else _OF_ENERGY) * level)
    return worst if shown[worst] > max(min(limits), _RESOLVED) else None


def written_wrongly(
    changed: Mapping[Place, float], left: Mapping[Place, float], floors: Mapping[Place, float]
) -> Place | None:
    """The speed or energy that is changed as it is written, and yet keeps too much of its error.

    An integrator's errors of speed and energies are smaller parts of their scales than those of
    roll and steer. Programs may leave out a little more or less than we do of an energy.

    Parameters
    ----------
    changed : mapping of (int, str) to float
        The columns, and the logarithm of the factor by which the error falls.
    left, floors
        As of `too_large`.
    """
    lateral = [max(x, _RESOLVED) for (_, key), x in left.items() if key in LATERAL]
    if not lateral:
        return None
    limit = _OF_MOTION * max(lateral)
    for k, fall in changed.items():
        is_large = left[k] > max(limit, _AT_FLOOR * floors.get(k, 0.0))
        if k[1] not in LATERAL and is_large and fall < log(_MOSTLY):
            return k
    return None


def is_nothing(left: Mapping[Place, float], floors: Mapping[Place, float]) -> bool:
    """Whether next to nothing is left, see `too_large`."""
    return all(x <= max(_NOTHING, _AT_FLOOR * floors.get(k, 0.0)) for k, x in left.items())
