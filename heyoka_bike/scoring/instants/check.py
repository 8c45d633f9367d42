"""A program's table of instants against what every quantity is, level by level."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import COORDINATES, LEVELS, UNITS, WHERE, InstantLevel
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, read_bicycle
from heyoka_bike.errors import BicycleError, InputError, NothingScoredError
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.proof.instants import known_states, of_known
from heyoka_bike.scoring.instants.checked import (
    CheckedColumn,
    CheckedLevel,
    CheckedTable,
    Explained,
)
from heyoka_bike.scoring.instants.expected import of_own
from heyoka_bike.scoring.instants.table import InstantTable, read_table
from heyoka_bike.system.resources import find_input

TOLERANCE = 1e-9
"""Of a difference over 1 + abs(expected), in SI units. Rounding in binary64 leaves 1e-13 of the
equations here, and of none a hundred times that; a wrong digit of any parameter is more."""

# Any parameter that acts on it explains one wrong value; the same one in many rows is no more.
_EVIDENCE = 2
# No pitch puts the front wheel nearer to the floor than this [m].
_ON_THE_FLOOR = 1e-9
# Newton's iteration for one unknown: quantities are nearly linear in most parameters.
_ROUNDS = 5
_SHIFT = 1e-6

_Values = Mapping[str, Array]


def check(
    source: Any, *, bicycle: Bicycle | None = None, tolerance: float = TOLERANCE, si: bool = False
) -> CheckedTable:
    """Compare what a program computes at single instants with what it is, before it integrates.

    Parameters
    ----------
    source : path, mapping of str to array-like, or data frame
        Columns by name with their units, ``pitch [rad]``: the number of the ``state``, or states of
        one's own by roll angle, steer angle, their rates, and forward speed; beside them any of the
        quantities of docs/check.md.
    bicycle : Bicycle
        By default the benchmark's.
    tolerance
        Of a difference over 1 + abs(expected), SI units.
    si
        True if columns whose name has no unit are in SI units.

    Returns
    -------
    CheckedTable
        Its ``failed`` is the first level that fails.

    Raises
    ------
    InputError
        A table that cannot be read, without states or with one that is not known, a column without
        a unit, a state that no pitch puts on the floor.
    NothingScoredError
        No column that can be compared.
    """
    if not 0 < tolerance < 1:
        raise InputError(f"tolerance: found {tolerance}, expected between 0 and 1")
    chosen = bicycle or read_bicycle(find_input("bicycles", "benchmark"))
    states = known_states()
    table = read_table(source, states, si=si)
    if table.numbers is None:
        expected = _of_own(chosen, table)
    else:
        asked = np.unique(table.numbers)
        known = of_known(chosen, [states[n - 1] for n in asked])
        expected = {key: x[np.searchsorted(asked, table.numbers)] for key, x in known.items()}
        _refuse_others(table, expected, tolerance)
    levels = tuple(
        CheckedLevel(level, _compared(level, table, expected, tolerance)) for level in LEVELS
    )
    if not any(level.columns for level in levels):
        raise NothingScoredError(
            f"{table.path}: found no quantity beside the states, expected one such as pitch"
        )
    found = CheckedTable(
        table.path, chosen.name, table.rows, table.numbers is None, tolerance, levels,
        table.left_out,
    )  # fmt: skip
    if found.failed is None:
        return found
    names = [c.key for x in levels[: levels.index(found.failed) + 1] for c in x.columns]

    def is_right(made: Mapping[str, Array]) -> bool:
        return not any(_is_wrong(table, key, made[key], tolerance)[0].any() for key in names)

    told = {
        (key, x)
        for key in names
        for x in expected[key][_is_wrong(table, key, expected[key], tolerance)[0]]
    }
    if len(told) < _EVIDENCE:
        return found
    given = {key: expected[key] for key in (*COORDINATES, *WHERE) if key in expected}
    values = {key: table.values[key] for key in names}
    return replace(found, explained=_explanations(chosen, given, values, expected, is_right))


def _of_own(bicycle: Bicycle, table: InstantTable) -> dict[str, Array]:
    given = {key: x for key, x in table.values.items() if key in (*COORDINATES, *WHERE)}
    expected = {**given, **of_own(bicycle, given)}
    off = np.flatnonzero(~(np.abs(expected["height"]) < _ON_THE_FLOOR))
    if len(off):
        i = int(off[0])
        raise table.error(
            i,
            f"found a state off the floor: at roll {given['roll_angle'][i]:.6g} rad and steer "
            f"{given['steer_angle'][i]:.6g} rad no pitch is found that puts both wheels on it, the "
            f"front wheel stays {expected['height'][i]:.3g} m above",
        )
    return expected


def _refuse_others(table: InstantTable, expected: Mapping[str, Array], tolerance: float) -> None:
    """Coordinates beside a state's number are those of the state."""
    for key in (*COORDINATES, *WHERE):
        if key in table.values:
            wrong = _is_wrong(table, key, expected[key], tolerance)[0]
            if wrong.any():
                i = int(np.argmax(wrong))
                found, right = table.values[key][i], expected[key][i]
                raise table.error(
                    i,
                    f"found {key} {found:.15g} {UNITS[key]} in state {table.numbers[i]}, expected "
                    f"{right:.15g}: off by {found - right:.3g}; without a column state the states "
                    "are your own",
                )


def _is_wrong(
    table: InstantTable, key: str, expected: Array, tolerance: float
) -> tuple[NDArray[np.bool_], Array]:
    """Find values that are off, and by how much over 1 + |expected|; a missing value is not."""
    unit = 1 + np.abs(expected)
    error = np.abs(table.values[key] - expected)
    return error > tolerance * unit + table.uncertain[key], np.nan_to_num(error / unit)


def _compared(
    level: InstantLevel, table: InstantTable, expected: Mapping[str, Array], tolerance: float
) -> tuple[CheckedColumn, ...]:
    found = []
    for c in level.columns:
        if c.name not in table.values:
            continue
        right = expected[c.name]
        values = np.where(np.isfinite(right), table.values[c.name], np.nan)
        if np.isnan(values).all():
            continue
        wrong, error = _is_wrong(table, c.name, right, tolerance)
        # A small value that is written with all digits may be wrong where a larger error is none.
        i = int(np.argmax(np.where(wrong, 1.0, 0.0) + error / (1 + error)))
        missing = int(np.isnan(values).sum())
        found.append(
            CheckedColumn(
                key=c.name,
                unit=c.unit,
                values=len(values) - missing,
                missing=missing,
                wrong=int(wrong.sum()),
                max_error=float(error[i]),
                state=None if table.numbers is None else int(table.numbers[i]),
                place=table.place(i),
                found=float(values[i]),
                expected=float(right[i]),
            )
        )
    return tuple(sorted(found, key=lambda x: (not x.wrong, -x.max_error)))


def _explanations(
    bicycle: Bicycle, given: _Values, values: _Values, expected: _Values,
    is_right: Callable[[_Values], bool],
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

    def made(symbol: str, change: float) -> _Values:
        x = bicycle[symbol]
        moved = replace(x, rational=x.rational + Fraction(change))
        # Not checked: what mistaken programs compute with need not make sense.
        mistaken = Bicycle(bicycle.name, {**bicycle.values, symbol: moved})
        return of_own(mistaken, given, is_linear=is_linear)

    def apart(one: _Values, other: _Values) -> Array:
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
