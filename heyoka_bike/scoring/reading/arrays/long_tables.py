"""Long tables: one row per value, with its time and the name of its quantity.

Source of the term: Wickham, Tidy Data, Journal of Statistical Software 59 (2014),
doi:10.18637/jss.v059.i10.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.arrays.array_columns import read_maneuvers
from heyoka_bike.scoring.reading.arrays.groups import ArrayGroup
from heyoka_bike.scoring.reading.names.heading import is_maneuver, is_time

# Names that pandas, R and other programs give to the column of names and to the column of values.
_NAMES_OF_VARIABLE = ("variable", "name", "quantity", "signal", "column", "key", "measure")
_KINDS_OF_COLUMNS = {
    **dict.fromkeys(_NAMES_OF_VARIABLE, "variable"),
    **dict.fromkeys(("value", "values", "val"), "value"),
}


def long_columns(names: Iterable[str]) -> dict[str, str]:
    """Return the names of the columns of a long table by their contents; empty for other tables."""
    found = {}
    for name in names:
        kind = "maneuver" if is_maneuver(name) else _KINDS_OF_COLUMNS.get(name.strip().lower())
        if kind := "time" if is_time(name) else kind:
            found[kind] = name
    return found if found.keys() >= {"time", "variable", "value"} else {}


def pivoted(group: ArrayGroup) -> ArrayGroup:
    """Return a group with the columns of a long table, by maneuver; other groups are unchanged.

    Raises
    ------
    InputError
        A quantity has two values at one time.
    """
    kinds = long_columns(group.names)
    if not kinds or not group.groups.keys().isdisjoint(kinds.values()):
        return group
    # The time column keeps its name, because the name may contain a unit.
    time = kinds["time"]
    cells = {kind: np.ravel(group.arrays[name][()]).tolist() for kind, name in kinds.items()}
    numbers = np.full(len(cells["time"]), np.nan)
    if "maneuver" in kinds:
        numbers = read_maneuvers(group.arrays[kinds["maneuver"]], group.request)
    found: dict[str, dict[str, dict[Any, Any]]] = {}
    for number, at, x, word in zip(
        numbers, cells["time"], cells["value"], cells["variable"], strict=True
    ):
        name = word.decode("utf-8", "replace") if isinstance(word, bytes) else str(word)
        maneuver = f"maneuver_{int(number)}" if np.isfinite(number) else ""
        column = found.setdefault(maneuver, {}).setdefault(name, {})
        if at in column:
            raise group.request.error(f"found {name} at the time {at} twice, expected one value")
        column[at] = x
    wide: dict[str, dict[str, Any]] = {}
    for maneuver, columns in found.items():
        times = list(dict.fromkeys(at for column in columns.values() for at in column))
        cells = {name: [column.get(at) for at in times] for name, column in columns.items()}
        cells = {time: times, **cells}
        wide[maneuver] = {name: np.array(x, object) for name, x in cells.items()}
    return ArrayGroup(wide.get("", wide), group.request)
