"""Long tables: a row for each value, with its time and the name of what it is a value of."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.arrays.columns import read_maneuvers
from heyoka_bike.scoring.reading.names.columns import TIME, is_maneuver, is_time
from heyoka_bike.scoring.reading.request import Request

# As pandas, R and others call the column of names and that of values.
_VARIABLE = frozenset({"variable", "name", "quantity", "signal", "column", "key", "measure"})
_VALUE = frozenset({"value", "values", "val"})


def is_long(names: Iterable[str]) -> bool:
    """Whether these are names of the columns of a long table."""
    return _kinds(names).keys() >= {"time", "variable", "value"}


def _kinds(names: Iterable[str]) -> dict[str, str]:
    """The columns of a long table by what they have."""
    found = {}
    for name in names:
        word = name.strip().lower()
        if is_time(name):
            found["time"] = name
        elif word in _VARIABLE or word in _VALUE:
            found["variable" if word in _VARIABLE else "value"] = name
        elif is_maneuver(name):
            found["maneuver"] = name
    return found


def pivoted(members: Mapping[str, Any], request: Request) -> Mapping[str, Any]:
    """The columns of a long table, by maneuver if it has one; other members as they are.

    Raises
    ------
    InputError
        A value is there twice.
    """
    kinds = _kinds(members)
    if not is_long(members) or any(isinstance(members[n], Mapping) for n in kinds.values()):
        return members
    cells = {kind: np.ravel(members[name][()]).tolist() for kind, name in kinds.items()}
    maneuvers: list[int | None] = [None] * len(cells["time"])
    if "maneuver" in kinds:
        numbers = read_maneuvers(members[kinds["maneuver"]], request)
        maneuvers = [int(n) if np.isfinite(n) else None for n in numbers]
    groups: dict[int | None, dict[str, dict[Any, Any]]] = {}
    for number, at, x, word in zip(
        maneuvers, cells["time"], cells["value"], cells["variable"], strict=True
    ):
        name = word.decode("utf-8", "replace") if isinstance(word, bytes) else str(word)
        column = groups.setdefault(number, {}).setdefault(name, {})
        if at in column:
            raise request.error(f"found {name} at the time {at} twice, expected one value")
        column[at] = x
    if None in groups:
        return _wide(groups[None])
    return {f"maneuver_{number}": _wide(columns) for number, columns in groups.items()}


def _wide(columns: Mapping[str, Mapping[Any, Any]]) -> dict[str, Any]:
    """Columns by the times of their values as columns beside all times."""
    times = list(dict.fromkeys(at for column in columns.values() for at in column))
    wide = {name: [column.get(at) for at in times] for name, column in columns.items()}
    return {name: np.array(x, object) for name, x in {TIME: times, **wide}.items()}
