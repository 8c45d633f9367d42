"""Long tables: a row for each value, with its time and the name of what it is a value of."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from heyoka_bike.scoring.reading.names.columns import TIME, is_maneuver, recognise
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
        if recognise(name) == (TIME, None):
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
    groups: dict[Any, dict[str, dict[Any, Any]]] = {}
    maneuvers = cells.get("maneuver", [""] * len(cells["time"]))
    for at, name, x, m in zip(
        cells["time"], cells["variable"], cells["value"], maneuvers, strict=True
    ):
        column = groups.setdefault(m, {}).setdefault(_word(name), {})
        if at in column:
            raise request.error(f"found {_word(name)} at the time {at} twice, expected one value")
        column[at] = x
    found = {}
    for m, columns in groups.items():
        times = list(dict.fromkeys(at for column in columns.values() for at in column))
        wide = {name: [column.get(at) for at in times] for name, column in columns.items()}
        group = {n: np.array(x, object) for n, x in {TIME: times, **wide}.items()}
        found[
            _word(m) if str(m)[:1].isalpha() else f"maneuver_{float(m):.0f}" if m != "" else ""
        ] = group
    return found


def _word(x: Any) -> str:
    return x.decode("utf-8", "replace") if isinstance(x, bytes) else str(x)
