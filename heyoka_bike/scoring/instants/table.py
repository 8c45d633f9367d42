"""A table of single instants, as a program wrote it: which states, and which quantities of them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COORDINATES, UNITS
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.errors import InputError, did_you_mean, quoted
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.unit import factor
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.source import read_columns
from heyoka_bike.scoring.reading.vectors import Vectors

STATE = "state"
"""Name of the column of the states' numbers."""

_IN_BRACKETS = re.compile(r"(.*?)[\s/]*[\[(]([^\])]*)[\])]\s*")
_BREAKS = re.compile(r"[\s.-]+")


@dataclass(frozen=True, eq=False, slots=True)
class InstantTable:
    """The quantities that a program wrote of some states.

    Attributes
    ----------
    path
        Name of the file.
    numbers : ndarray of int, shape (n,), or None
        Of the known state in each row, from 1; None where the table has its own.
    values : mapping of str to ndarray, shape (n,)
        Columns by name, SI units; NaN where there is no finite number.
    uncertain : mapping of str to ndarray, shape (n,)
        By how much a value may be off as it was written with so many digits.
    vectors : Vectors
        As they were read.
    left_out : tuple of str
        Names of columns that are not known.
    """

    path: str
    numbers: Any
    values: Mapping[str, Array]
    uncertain: Mapping[str, Array]
    vectors: Vectors
    left_out: tuple[str, ...]

    @property
    def rows(self) -> int:
        """Number of states."""
        return len(self.vectors.columns[0].values)

    def place(self, row: int) -> str:
        """Where a row is, for people."""
        return "{} {}".format(*self.vectors.place(row))

    def error(self, row: int, message: str) -> InputError:
        """The error that says where, what was found and what was expected."""
        return self.vectors.error(Request(self.path, 1), row, message)


def read_table(source: Any, states: Sequence[Maneuver], *, si: bool = False) -> InstantTable:
    """Read a table of instants.

    Parameters
    ----------
    source
        As `read_results` takes it, without times.
    states
        Those that are known, by number from 1.
    si
        True if columns whose name has no unit are in SI units.

    Raises
    ------
    InputError
        No states, one that is not known, a column twice, without unit or in one of something else.
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
            raise InputError(f"found a second column of {key} ({quoted(name)})", file=path)
        size = 1.0 if key == STATE else _factor(name, key, unit, si, path)
        is_finite = np.isfinite(column.values)
        values[key] = np.where(is_finite, column.values * size, np.nan)
        # Half a step either way.
        uncertain[key] = np.where(is_finite, column.quantum.at(column.values) * size / 2, 0.0)
    left_out = tuple(name for name, meaning in zip(names, meant, strict=True) if meaning is None)
    return _with_states(InstantTable(path, None, values, uncertain, found, left_out), states)


def _with_states(table: InstantTable, states: Sequence[Maneuver]) -> InstantTable:
    if not table.rows:
        raise InputError("found no rows, expected one for each state", file=table.path)
    if STATE in table.values:
        numbers = table.values[STATE]
        for i, x in enumerate(numbers):
            if not (x == np.rint(x) and 1 <= x <= len(states)):
                shown = f"{x:.15g}" if np.isfinite(x) else "no number"
                raise table.error(i, f"found state {shown}, expected 1 to {len(states)}")
        return replace(table, numbers=numbers.astype(int))
    missing = [key for key in COORDINATES if key not in table.values]
    if missing:
        names = ", ".join(missing)
        raise InputError(
            f"found no column {quoted(STATE)} and no {names}, expected the numbers of states, or "
            f"states of your own by {', '.join(COORDINATES)}{_hint(table.left_out)}",
            file=table.path,
        )
    for key in COORDINATES:
        bad = np.flatnonzero(~np.isfinite(table.values[key]))
        if len(bad):
            raise table.error(int(bad[0]), f"found no finite number as {key} of the state")
    return table


def _hint(names: Sequence[str]) -> str:
    hints = (did_you_mean(name, (STATE, *COORDINATES)) for name in names)
    return next((hint for hint in hints if hint), "")


def _meaning(name: str) -> tuple[str, str | None] | None:
    """Key and unit of a column by its name, ``pitch [rad]`` or ``pitch_rad``; None if unknown."""
    match = _IN_BRACKETS.fullmatch(name)
    stem, unit = (match[1], match[2]) if match else (name, None)
    plain = _BREAKS.sub("_", stem.strip().strip("\"'")).lower()
    keys = {key.lower(): key for key in (STATE, *UNITS)}
    if plain in keys:
        return keys[plain], unit
    # MATLAB's names have no brackets: the longest key that leaves a unit.
    for key in sorted(keys, key=len, reverse=True):
        if plain.startswith(f"{key}_") and key != STATE:
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
