"""Compare a program's table of single states with the exact values, level by level.

The table contains the states and some of their quantities. The exact values of known states are
proved, see `proof.instants`. For a user's own states, they are computed in binary64.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.instant import Instant, quantities
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.instant_columns import COORDINATES, LEVELS, UNITS, WHERE, InstantLevel
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, Maneuver, read_bicycle
from heyoka_bike.errors import BicycleError, InputError, NothingScoredError, did_you_mean, quoted
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.double import ROUNDS_OF_NEWTON, SMALL_STEP, Array, with_usual_errors
from heyoka_bike.numbers.unit import factor
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.reference.proof.instants import BITS, known_states, linear_by_speed, of_known
from heyoka_bike.scoring.instants.checked import (
    CheckedColumn,
    CheckedLevel,
    CheckedTable,
    Explained,
)
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.source import read_columns
from heyoka_bike.scoring.reading.table import ReadTable
from heyoka_bike.system.resources import find_input

STATE_COLUMN = "state"
"""Name of the column of the states' numbers."""

_IN_BRACKETS = re.compile(r"(.*?)[\s/]*[\[(]([^\])]*)[\])]\s*")
_BREAKS_IN_NAMES = re.compile(r"[\s.-]+")


@dataclass(frozen=True, eq=False, slots=True)
class InstantTable:
    """A table of the quantities that a program computed in single states.

    Attributes
    ----------
    path
        Name of the file.
    numbers : ndarray of int, shape (n,), or None
        Number of the known state in each row, from 1; None if the states are the user's own.
    values : mapping of str to ndarray, shape (n,)
        Columns by name, SI units; NaN where there is no finite number.
    uncertain : mapping of str to ndarray, shape (n,)
        Largest rounding error of each value, from the digits with which it is written.
    vectors : ReadTable
        The table as it was read.
    left_out : tuple of str
        Names of unknown columns.
    """

    path: str
    numbers: Any
    values: Mapping[str, Array]
    uncertain: Mapping[str, Array]
    vectors: ReadTable
    left_out: tuple[str, ...]

    @property
    def rows(self) -> int:
        """Number of states."""
        return len(self.vectors.columns[0].values)

    def place(self, row: int) -> str:
        """Return the place of a row for messages, such as ``line 3``."""
        return "{} {}".format(*self.vectors.place(row))

    def error(self, row: int, message: str) -> InputError:
        """Return an error whose message begins with the place of a row."""
        return self.vectors.error(Request(self.path, 1), row, message)


def read_table(source: Any, states: Sequence[Maneuver], *, si: bool = False) -> InstantTable:
    """Read a table of instants.

    Parameters
    ----------
    source
        Any source of `read_results`, but without times.
    states
        The known states, in the order of their numbers from 1.
    si
        True if columns whose name has no unit are in SI units.

    Raises
    ------
    InputError
        There are no states, a state is unknown, or a column occurs twice, has no unit or has the
        unit of another quantity.
    """
    found = read_columns(source, lambda name: _meaning(name) is not None)
    path = str(source) if isinstance(source, str) or hasattr(source, "__fspath__") else "array"
    names = found.names or []
    meant = [_meaning(name) for name in names]
    values: dict[str, Array] = {}
    uncertain: dict[str, Array] = {}
    for name, meaning, column in zip(names, meant, found.columns, strict=False):
        if meaning is None:
            continue
        key, unit = meaning
        if key in values:
            raise InputError(
                f"found a second column of {key} ({quoted(name)}), expected one", file=path
            )
        size = 1.0 if key == STATE_COLUMN else _factor(name, key, unit, si, path)
        is_finite = np.isfinite(column.values)
        values[key] = np.where(is_finite, column.values * size, np.nan)
        # A written number may differ from the computed one by half a unit of its last digit.
        uncertain[key] = np.where(is_finite, column.quantum.at(column.values) * size / 2, 0.0)
    left_out = tuple(name for name, meaning in zip(names, meant, strict=True) if meaning is None)
    return _with_states(InstantTable(path, None, values, uncertain, found, left_out), states)


def _with_states(table: InstantTable, states: Sequence[Maneuver]) -> InstantTable:
    if not table.rows:
        raise InputError("found no rows, expected one for each state", file=table.path)
    if STATE_COLUMN in table.values:
        numbers = table.values[STATE_COLUMN]
        for i, x in enumerate(numbers):
            if not (x == np.rint(x) and 1 <= x <= len(states)):
                shown = f"{x:.15g}" if np.isfinite(x) else "no number"
                raise table.error(i, f"found state {shown}, expected 1 to {len(states)}")
        return replace(table, numbers=numbers.astype(int))
    missing = [key for key in COORDINATES if key not in table.values]
    if missing:
        hints = (did_you_mean(name, (STATE_COLUMN, *COORDINATES)) for name in table.left_out)
        hint = next(filter(None, hints), "")
        raise InputError(
            f"found no column {quoted(STATE_COLUMN)} and no {', '.join(missing)}, expected the "
            f"numbers of the states, or {', '.join(COORDINATES)} of your own states{hint}",
            file=table.path,
        )
    for key in COORDINATES:
        bad = np.flatnonzero(~np.isfinite(table.values[key]))
        if len(bad):
            raise table.error(
                int(bad[0]), f"found {key} without a finite number, expected a number"
            )
    return table


def _meaning(name: str) -> tuple[str, str | None] | None:
    """Return the key and unit in names like ``pitch [rad]`` or ``pitch_rad``; None if unknown."""
    match = _IN_BRACKETS.fullmatch(name)
    stem, unit = (match[1], match[2]) if match else (name, None)
    plain = _BREAKS_IN_NAMES.sub("_", stem.strip().strip("\"'")).lower()
    keys = {key.lower(): key for key in (STATE_COLUMN, *UNITS)}
    if plain in keys:
        return keys[plain], unit
    # MATLAB's names have no brackets. Find the longest key that begins the name so that the rest is
    # a unit.
    for key in sorted(keys, key=len, reverse=True):
        if plain.startswith(f"{key}_") and key != STATE_COLUMN:
            ending = plain[len(key) + 1 :].replace("_per_", "/").replace("_", " ")
            for text in (ending, "/".join(ending.split())):
                if factor(text, UNITS[keys[key]]) is not None:
                    return keys[key], text
    return None


def _factor(name: str, key: str, unit: str | None, si: bool, path: str) -> float:
    expected = UNITS[key]
    if unit is None:
        if si or expected == "1":
            return 1.0
        raise InputError(
            f"found the column {quoted(name)} without a unit, expected one such as "
            f"'{key} [{expected}]', or --si for SI units",
            file=path,
        )
    size = factor(unit, expected)
    if size is None:
        raise InputError(
            f"found the unit {quoted(unit)} of {key}, expected one such as {expected}", file=path
        )
    return float(size)


def quantities_of_states(
    bicycle: Bicycle, given: Mapping[str, Array], *, is_linear: bool = True
) -> dict[str, Array]:
    """Return the quantities of states by name, in binary64.

    Parameters
    ----------
    bicycle
        The parameters, which may be meaningless.
    given
        The `COORDINATES` of the states, and perhaps quantities of `WHERE` [SI].
    is_linear
        True to include the quantities of the linear bicycle.

    Returns
    -------
    dict of str to ndarray
        The quantities, and ``height``, that of the front wheel above the floor [m]. It is zero, up
        to rounding, if some pitch puts both wheels on the floor.
    """
    with np.errstate(all="ignore"):
        equations, state = binary64_states(bicycle, given)
        found = quantities(Instant.of(equations, state))
        found["height"] = front_contact_height(equations.k, equations.a, *state[:3])
    speed = given["forward_speed"]
    if is_linear:
        with working_bits(BITS):
            linear = linear_by_speed(bicycle)
            by_speed = {v: linear(Fraction(v)) for v in np.unique(speed)}
        for c in LEVELS[-1].columns:
            found[c.name] = np.array([float(by_speed[v][c.name].mid()) for v in speed])
    return {name: np.broadcast_to(np.asarray(x, float), speed.shape) for name, x in found.items()}


def binary64_states(bicycle: Bicycle, given: Mapping[str, Array]) -> tuple[Equations, list[Number]]:
    """Return the equations for arrays, and the variables of states in the order of `Instant`."""
    equations = Equations.binary64(bicycle)
    roll, steer, roll_rate, steer_rate, speed = (given[key] for key in COORDINATES)
    pitch = pitch_on_the_floor(equations.k, roll, 0 * roll, steer)
    where = [given.get(name, 0 * roll) for name in WHERE]
    return equations, [
        roll, pitch, steer, roll_rate, steer_rate, speed / equations.k.length, *where
    ]  # fmt: skip


STATE_TOLERANCE = 1e-9
"""Largest difference of a right value, divided by 1 + abs(expected), in SI units. Rounding in
binary64 causes 1e-13 with the equations here, and less than 1e-11 with other forms of them. A wrong
digit of any parameter causes more."""

# Minimum number of distinct wrong values that a parameter must explain. Any parameter that affects
# a single value can explain it, and repeating this value in many rows adds no evidence.
_MIN_WRONG_VALUES = 2
# Maximum distance of the front wheel from the floor that counts as contact [m]. If the distance is
# larger, no pitch puts the wheel on the floor.
_ON_THE_FLOOR = 1e-9

_Quantities = Mapping[str, Array]


@with_usual_errors
def check(
    source: Any,
    *,
    bicycle: Bicycle | None = None,
    tolerance: float = STATE_TOLERANCE,
    si: bool = False,
) -> CheckedTable:
    """Compare the values that a program computes in single states with the exact values.

    The values are compared level by level, from the geometry to the forces, as a program
    computes them before it integrates.

    Parameters
    ----------
    source : path, mapping of str to array-like, or data frame
        Columns by name with their units, such as ``pitch [rad]``. The states are given by a column
        ``state`` with the numbers of known states, or by the roll angle, the steer angle, their
        rates and the forward speed. All other columns are quantities of docs/check.md.
    bicycle : Bicycle
        By default the benchmark's.
    tolerance
        Largest difference of a right value, divided by 1 + abs(expected), in SI units.
    si
        True if columns whose name has no unit are in SI units.

    Returns
    -------
    CheckedTable
        Its ``failed`` is the first level that fails.

    Raises
    ------
    InputError
        The table cannot be read, contains no states or an unknown state, or has a column without a
        unit; or no pitch puts the bicycle on the floor in a state.
    NothingScoredError
        No column can be compared.
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
            f"{table.path}: found only states, without a quantity to check; add a column such as "
            "pitch"
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
    if len(told) < _MIN_WRONG_VALUES:
        return found
    given = {key: expected[key] for key in (*COORDINATES, *WHERE) if key in expected}
    values = {key: table.values[key] for key in names}
    return replace(found, explained=_explanations(chosen, given, values, expected, is_right))


def _of_own(bicycle: Bicycle, table: InstantTable) -> dict[str, Array]:
    given = {key: x for key, x in table.values.items() if key in (*COORDINATES, *WHERE)}
    expected = {**given, **quantities_of_states(bicycle, given)}
    off = np.flatnonzero(~(np.abs(expected["height"]) < _ON_THE_FLOOR))
    if len(off):
        i = int(off[0])
        raise table.error(
            i,
            f"found a state off the floor: at roll {given['roll_angle'][i]:.6g} rad and steer "
            f"{given['steer_angle'][i]:.6g} rad, no pitch puts both wheels on the floor. The front "
            f"wheel stays {expected['height'][i]:.3g} m above it",
        )
    return expected


def _refuse_others(table: InstantTable, expected: Mapping[str, Array], tolerance: float) -> None:
    """Raise an error if coordinates in the table differ from those of its numbered states."""
    for key in (*COORDINATES, *WHERE):
        if key in table.values:
            wrong = _is_wrong(table, key, expected[key], tolerance)[0]
            if wrong.any():
                i = int(np.argmax(wrong))
                found, right = table.values[key][i], expected[key][i]
                raise table.error(
                    i,
                    f"found {key} {found:.15g} {UNITS[key]} in state {table.numbers[i]}, expected "
                    f"{right:.15g} (the difference is {found - right:.3g}). If these are your own "
                    f"states, not the numbered ones, remove the column {quoted(STATE_COLUMN)}",
                )


def _is_wrong(
    table: InstantTable, key: str, expected: Array, tolerance: float
) -> tuple[NDArray[np.bool_], Array]:
    """Return which values are wrong, and their errors divided by 1 + |expected|.

    A missing value is not wrong.
    """
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
        # A large error may be only rounding, while a small value may be wrong in every digit. So
        # choose the largest error among the wrong values, if there are any.
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
    bicycle: Bicycle, given: _Quantities, values: _Quantities, expected: _Quantities,
    is_right: Callable[[_Quantities], bool],
) -> tuple[Explained, ...]:  # fmt: skip
    """Return single parameters whose wrong values explain the wrong columns of a table.

    Parameters
    ----------
    bicycle : Bicycle
    given
        Coordinates of the states.
    values, expected
        The columns of the table, and their exact values.
    is_right
        Returns True if quantities agree with the table within the tolerance.
    """
    is_linear = any(c.name in values for c in LEVELS[-1].columns)

    def made(symbol: str, change: float) -> _Quantities:
        x = bicycle[symbol]
        moved = replace(x, rational=x.rational + Fraction(change))
        # The parameters are not checked, because a program with a mistake may compute with values
        # that have no meaning.
        mistaken = Bicycle(bicycle.name, {**bicycle.values, symbol: moved})
        return quantities_of_states(mistaken, given, is_linear=is_linear)

    def apart(one: _Quantities, other: _Quantities) -> Array:
        # A missing value counts as right.
        return np.concatenate(
            [np.nan_to_num((one[k] - other[k]) / (1 + np.abs(expected[k]))) for k in values]
        )

    found = []
    with np.errstate(all="ignore"):
        right = made("g", 0.0)
        for symbol, parameter in PARAMETERS.items():
            # A bicycle with meaningless parameters, such as one without mass, has no linear
            # equations.
            with suppress(BicycleError, ArithmeticError, ValueError):
                change, now = 0.0, right
                for _ in range(ROUNDS_OF_NEWTON):
                    slope = apart(made(symbol, change + SMALL_STEP), now) / SMALL_STEP
                    left = apart(values, now)
                    # Skip parameters that hardly affect the largest difference between the table
                    # and the exact values. Most parameters are of this kind.
                    acts = abs(slope[np.argmax(np.abs(left))]) > SMALL_STEP * np.max(np.abs(slope))
                    if now is right and not acts:
                        break
                    change += float(slope @ left) / float(slope @ slope)
                    now = made(symbol, change)
                    if is_right(now):
                        x = float(bicycle[symbol])
                        found.append(Explained(symbol, parameter.unit, x + change, x))
                        break
    return tuple(found)
