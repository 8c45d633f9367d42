"""MATLAB's and Simulink's files: variables, structures, and what blocks log."""

from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.reading.arrays.columns import MOST_BYTES, read_array
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.formats import hdf5, is_hdf5_of_matlab
from heyoka_bike.scoring.reading.formats.matlab_bytes import OfClass, matlab_variables
from heyoka_bike.scoring.reading.names.headings import recognise
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.vectors import Vectors

# What writes an object of a class so that it is read.
_WRITTEN = {
    "table": "writetable({0}, 'results.csv')",
    "timetable": "writetimetable({0}, 'results.csv')",
    "timeseries": "results = [{0}.Time {0}.Data]; save results.mat results",
}
_SAVED = "save results.mat with its times and values as arrays"


def read(file: ResultFile) -> list[Vectors]:
    """The tables in the variables; those of version 7.3 are in HDF5.

    Raises
    ------
    InputError
        Kept in other files, or not columns of real numbers.
    """
    request = file.request
    if is_hdf5_of_matlab(file.head):
        with request.damage("HDF5"):
            found = hdf5.read(file, is_turned=True)
    else:
        found = matlab_variables(file.stream().read(), MOST_BYTES)
    objects = [(name, x.name) for name, x in found.items() if isinstance(x, OfClass)]
    try:
        return tables(_plain(found, request), request)
    except InputError:
        if not objects:
            raise
        name, kind = objects[0]
        raise request.error(
            f"found {quoted(name)}, a {kind}, which MATLAB saves in a form of its own, expected "
            f"arrays; in MATLAB: {_WRITTEN.get(kind, _SAVED).format(name)}"
        ) from None


def _plain(members: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """Variables with cells, solutions of ode45 and what Simulink logs as columns and their time."""
    found: dict[str, Any] = {}
    for name, x in _without_cells(members).items():
        if isinstance(x, list):
            each = [y for y in x if isinstance(y, Mapping)]
            x = {f"maneuver_{i}": y for i, y in enumerate(each, 1)}
        if isinstance(x, Mapping):
            found[name] = _structure(name, x, request)
        elif not isinstance(x, OfClass):
            found[name] = x
    # The time of the simulation is that of what was logged without one.
    logged = [x for x in found.values() if isinstance(x, dict)]
    if len(logged) == 1 and "tout" in found and "time" not in logged[0]:
        logged[0]["time"] = found["tout"]
    return found


def _structure(name: str, x: Mapping[str, Any], request: Request) -> dict[str, Any]:
    """A structure, of which some programs have their own kinds, as its columns."""
    if "signals" in x:
        signals = x["signals"] if isinstance(x["signals"], list) else [x["signals"]]
        columns = _columns([s for s in signals if isinstance(s, Mapping)], request)
        has_time = "time" in x and prod(x["time"].shape)
        return {"time": x["time"], **columns} if has_time else columns
    if not x.keys() >= {"solver", "x", "y"}:
        return _plain(x, request)
    if request.names is None and 1 + x["y"].shape[0] not in request.widths:
        raise request.error(
            f"found {quoted(name)}, a solution of {_word(x['solver']) or 'ode45'} with "
            f"{x['y'].shape[0]} states, and not which they are; {request.how_to_tell}"
        )
    return {"time": x["x"], "y": x["y"]}


def _without_cells(members: Mapping[str, Any]) -> dict[str, Any]:
    """Cell arrays as what is in them: one thing, columns below their names, or maneuvers."""
    found = {n: x for n, x in members.items() if not _is_cell(x)}
    for name, x in members.items():
        if not _is_cell(x):
            continue
        if x.size == 1:
            found[name] = x.item()
        elif x.ndim == 2 and len(x) > 1 and all(map(_word, x[0])):
            found[name] = {_word(y[0]): np.array([*map(np.ravel, y[1:])]).ravel() for y in x.T}
        elif not all(hasattr(y, "shape") and prod(y.shape) > 1 for y in x.flat):
            found[name] = x
        else:
            for i, y in enumerate(x.ravel(order="F"), 1):
                found.setdefault(f"maneuver_{i}", {})[name] = y
    return found


def _is_cell(x: Any) -> bool:
    return isinstance(x, np.ndarray) and x.dtype.kind == "O" and x.size > 0


def _columns(signals: list[Mapping[str, Any]], request: Request) -> dict[str, Any]:
    values = {
        i: np.squeeze(read_array(s["values"], request.within("signals")))
        for i, s in enumerate(signals)
        if "values" in s
    }
    labels = {i: _word(signals[i].get("label")) for i in values}
    if all(recognise(label) for label in labels.values()) or len(values) == 1:
        return {labels[i] or "values": x for i, x in values.items()}
    # Blocks in the order of the benchmark, or a matrix of each.
    rows = max((max(x.shape, default=0) for x in values.values()), default=0)
    upright = [x if x.shape[:1] == (rows,) else x.T for x in values.values()]
    if any(x.shape[:1] != (rows,) for x in upright):
        return {}
    return {"values": np.column_stack(upright)}


def _word(x: Any) -> str:
    """A text of MATLAB, empty if it is none."""
    if not isinstance(x, np.ndarray) or not x.size or x.dtype.kind not in "US":
        return ""
    return str(x.ravel()[0]).strip()
