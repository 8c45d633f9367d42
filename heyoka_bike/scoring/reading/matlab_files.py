"""MATLAB's and Simulink's files: variables, structures, and what blocks log."""

from collections.abc import Mapping
from math import prod
from typing import Any, BinaryIO

import numpy as np

from heyoka_bike.scoring.reading.array_columns import MOST_BYTES, read_array
from heyoka_bike.scoring.reading.array_tables import DEEPEST, tables
from heyoka_bike.scoring.reading.column_names import recognise
from heyoka_bike.scoring.reading.damage import any_damage
from heyoka_bike.scoring.reading.expected import Expected
from heyoka_bike.scoring.reading.matlab_bytes import matlab_variables
from heyoka_bike.scoring.reading.own_arrays import OwnFile
from heyoka_bike.scoring.reading.written import WrittenTable


def read_mat(stream: BinaryIO, path: str, expected: Expected) -> list[WrittenTable]:
    """The tables in a MATLAB file before version 7.3; see `array_files.read_npy`."""
    with any_damage("a MATLAB file", path):
        found = matlab_variables(stream.read(), MOST_BYTES)
    return tables(without_signals(found, path), path, expected, is_ordered=False)


def variables(group: Any, own: OwnFile, depth: int = 0) -> dict[str, Any]:
    """The variables in a group of a file of version 7.3, which is HDF5, as others are given.

    They keep the order of their axes, the other way round.
    """
    import h5py

    found: dict[str, Any] = {}
    for name, x in own.members(group):
        if isinstance(x, h5py.Group) and depth < DEEPEST and not name.startswith("#"):
            fields = {n: y for n, y in own.members(x) if isinstance(y, h5py.Dataset)}
            if fields and all(map(_has_references, fields.values())):
                each = {n: own.array(y)[()].ravel() for n, y in fields.items()}
                found[name] = [
                    {n: _referred(x.file, y[i], own) for n, y in each.items()}
                    for i in range(min(map(len, each.values())))
                ]
            else:
                found[name] = variables(x, own, depth + 1)
        elif isinstance(x, h5py.Dataset) and (value := _value(x, own)) is not None:
            found[name] = value
    return found


def without_signals(members: Mapping[str, Any], path: str) -> dict[str, Any]:
    """Variables with what Simulink logs, time and signals, as a time and columns."""
    found: dict[str, Any] = {}
    for name, x in members.items():
        if isinstance(x, Mapping) and "signals" in x:
            signals = x["signals"] if isinstance(x["signals"], list) else [x["signals"]]
            times = {n: y for n, y in x.items() if n == "time" and prod(y.shape)}
            found[name] = times | _columns([s for s in signals if isinstance(s, Mapping)], path)
        elif isinstance(x, Mapping):
            found[name] = without_signals(x, path)
        elif isinstance(x, list):
            each = [y for y in x if isinstance(y, Mapping)]
            parts = {f"maneuver_{i}": y for i, y in enumerate(each, 1)}
            found[name] = without_signals(parts, path)
        else:
            found[name] = x
    # The time of the simulation is that of what was logged without one.
    logged = [x for x in found.values() if isinstance(x, dict)]
    if len(logged) == 1 and "tout" in found and "time" not in logged[0]:
        logged[0]["time"] = found["tout"]
    return found


def _columns(signals: list[Mapping[str, Any]], path: str) -> dict[str, Any]:
    values = {
        i: np.squeeze(read_array(s["values"], path, "signals: "))
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


def _has_references(dataset: Any) -> bool:
    import h5py

    return bool(h5py.check_ref_dtype(dataset.dtype) is h5py.Reference)


def _referred(file: Any, reference: Any, own: OwnFile) -> Any:
    import h5py

    x = file[reference] if reference else None
    if isinstance(x, h5py.Group):
        return variables(x, own, DEEPEST)
    return _value(x, own) if isinstance(x, h5py.Dataset) else None


def _value(dataset: Any, own: OwnFile) -> Any:
    """An array or a text; None if it is empty."""
    if dataset.shape is None or "MATLAB_empty" in dataset.attrs:
        return None
    array = own.array(dataset)
    if dataset.attrs.get("MATLAB_class") == b"char":
        return np.array("".join(map(chr, array[()].T.ravel())))
    return array
