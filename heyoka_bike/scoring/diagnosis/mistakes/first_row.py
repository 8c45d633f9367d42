"""No mistake stands that the file's own first row contradicts: start, speed, energies."""

from collections.abc import Mapping

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.numbers.double import Array

# A start contradicts a first row from which it is so many times farther than the right one is, and
# than the digits can tell.
_CLEARLY = 10.0
# ... unless the second row is so many times nearer to it than the first.
_NEARER = 3.0

Columns = Mapping[str, Array]


def contradicted(
    time: Array, written: Columns, right: Columns, wrong: Columns, floors: Mapping[str, float]
) -> str | None:
    """The column whose first row has the correct start, and not that of a mistaken program.

    Where the second row has what that program makes, the first is only what it was told: a start
    that rolling does not allow.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Of the file [s]; a first row later than 0 says nothing.
    written
        Columns of the file by key, as understood beside the correct program [SI].
    right, wrong
        What the correct and the mistaken program make, every definition by name.
    floors : mapping of str to float
        What the digits cannot tell of the columns that count [SI].
    """
    if len(time) < 2 or time[0] != 0.0:
        return None
    for key, floor in floors.items():
        known, _ = _nearest(key, written[key], right)
        first, second = _nearest(key, written[key], wrong)
        if first > _CLEARLY * max(known, floor) and second > first / _NEARER:
            return key
    return None


def _nearest(key: str, values: Array, expected: Columns) -> tuple[float, float]:
    """Errors of the first two rows, each in the definition that fits it best; NaN if unknown."""
    names = [c.name for c in DEFINITIONS[key] if c.name in expected]
    errors = np.array([np.abs(values[:2] - expected[name][:2]) for name in names])
    first, second = np.fmin.reduce(errors)
    return float(first), float(second)
