"""Single parameters whose other values make a table of instants right."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from heyoka_bike.bicycle.instant_columns import LEVELS
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle
from heyoka_bike.errors import BicycleError
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.instants.checked import Explained
from heyoka_bike.scoring.instants.expected import of_own

# Newton's iteration for one unknown: quantities are nearly linear in most parameters.
_ROUNDS = 5
_SHIFT = 1e-6

Values = Mapping[str, Array]


def explanations(
    bicycle: Bicycle, given: Values, values: Values, expected: Values,
    is_right: Callable[[Values], bool],
) -> tuple[Explained, ...]:  # fmt: skip
    """Single parameters that explain columns.

    Parameters
    ----------
    bicycle : Bicycle
    given
        Coordinates of the states.
    values, expected
        The columns, and what they should be.
    is_right
        True if the columns are these, up to what a table may be off.
    """
    is_linear = any(c.name in values for c in LEVELS[-1].columns)

    def made(symbol: str, change: float) -> Values:
        x = bicycle[symbol]
        moved = replace(x, rational=x.rational + Fraction(change))
        # Not checked: what mistaken programs compute with need not make sense.
        mistaken = Bicycle(bicycle.name, {**bicycle.values, symbol: moved})
        return of_own(mistaken, given, is_linear=is_linear)

    def apart(one: Values, other: Values) -> Array:
        # Where the table has no number, nothing is to be explained.
        return np.concatenate(
            [np.nan_to_num((one[k] - other[k]) / (1 + np.abs(expected[k]))) for k in values]
        )

    found = []
    with np.errstate(all="ignore"):
        right = made("g", 0.0)
        for symbol, parameter in PARAMETERS.items():
            # A bicycle without mass, say, has no linear equations.
            with suppress(BicycleError, ArithmeticError, ValueError):
                change, now = 0.0, right
                for _ in range(_ROUNDS):
                    slope = apart(made(symbol, change + _SHIFT), now) / _SHIFT
                    left = apart(values, now)
                    # Most parameters do not act where the table is wrong.
                    if now is right and _is_elsewhere(slope, left):
                        break
                    change += float(slope @ left) / float(slope @ slope)
                    now = made(symbol, change)
                    if is_right(now):
                        x = float(bicycle[symbol])
                        found.append(Explained(symbol, parameter.unit, x + change, x))
                        break
    return tuple(found)


def _is_elsewhere(slope: Array, left: Array) -> bool:
    """True if a parameter leaves the largest of the differences as it is."""
    worst = int(np.argmax(np.abs(left)))
    return not abs(slope[worst]) > _SHIFT * np.max(np.abs(slope))
