"""Layout of the HDF5 files of a set: declared once, to be written and to be verified.

A group of a set that lacks some columns is declared with the columns that it has. Lengths that
neither the inputs nor the format fix are those of what is stored: arrays, or an open file.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from heyoka_bike.bicycle.columns import (
    BENCHMARK_COLUMNS,
    COLUMNS,
    MOTION_COLUMNS,
    QUANTITIES,
    Column,
)
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.description.facts import CONVENTIONS, attributes_of
from heyoka_bike.reference.hdf5 import BOUND, INDEX, LOW, Dataset, Group
from heyoka_bike.reference.layout import CANDIDATE, HDF5, MOTION, NODES, SENSITIVITIES, STATES_HDF5
from heyoka_bike.reference.sensitivities import ROWS_APART, UNKNOWNS, Sensitivity
from heyoka_bike.reference.values import Dense, Values

STATED = ("states", "form", "grid", "taylor_order", "precision", "precision_bits")
"""Attributes of a trajectory in candidate.h5, beside the inputs."""

COLUMNS_OF: Mapping[str, Sequence[Column]] = {
    HDF5: COLUMNS,
    MOTION: MOTION_COLUMNS,
    SENSITIVITIES: COLUMNS,
}
"""The columns of each HDF5 file of the maneuvers that this version makes."""

Data = dict[str, Any]
"""Arrays by the names of their datasets, in groups by name."""

_COMMENTS = {
    HDF5: "Each value is the correctly rounded exact one; <name>_lo is the exact value "
    "minus it, so <name> + <name>_lo has 32 digits. Axes: x forward, y right, z down.",
    MOTION: "Each value is the correctly rounded exact one, or zero where an enclosure as "
    "narrow as its bound holds zero; <name>_lo is the exact value minus it, so <name> + "
    "<name>_lo has 32 digits. Ground frame: x along the initial heading, y right, z down, "
    "origin where the rear wheel touches the floor at t = 0. Wheel angles are zero at t = 0.",
    SENSITIVITIES: "On the piece [a, b] of breaks the derivative of a column with respect to "
    "unknown u is sum_k c[piece, k, u] T_k(x), c_0 not halved, x = 2 (t - a) / (b - a) - 1; a "
    "break belongs to the piece on its right. The pitch at the start follows from roll and "
    "steer. <name>_bound[piece, u] is the certified distance from the exact derivative. NaN "
    "where a column does not depend smoothly on an unknown.",
    CANDIDATE: "On the piece [a, b] of breaks a state variable is sum_k n_k 2^-grid s^k, "
    "s = (t - a) / (b - a); coefficients[piece, state, k] holds n_k as a little-endian "
    "two's complement integer. Angles in rad, rates in rad/s.",
    STATES_HDF5: "Each value is the binary64 nearest to the exact one, in the state whose "
    "coordinates are the shortest decimals of the binary64 stored here; NaN where a quantity "
    "is not defined. Axes: x forward along the heading, y right, z down, origin where the rear "
    "wheel touches the floor.",
}
"""Of the whole files."""


def about(
    name: str, inputs: Mapping[str, Any], version: str, content: str | None = None
) -> dict[str, str]:
    """Attributes of a whole HDF5 file.

    Parameters
    ----------
    name
    inputs
        As in the manifest.
    version
        Of the dataset, when the file was last changed.
    content
        Hash of its numbers, where it has one.
    """
    bicycle = inputs["bicycle"]
    comment = {"comment": _COMMENTS[name]}
    hashed = {} if content is None else {"content_sha256": content}
    hashed |= {"bicycle": bicycle["name"], "parameters": json.dumps(bicycle["parameters"])}
    if name in (HDF5, MOTION):
        own = {"Conventions": CONVENTIONS}
        own |= {"dataset_version": version} if name == HDF5 else {}
        return attributes_of(name, version) | own | hashed | comment
    own = {}
    if name == SENSITIVITIES:
        own["unknowns"] = json.dumps(list(UNKNOWNS))
        own["unknown_units"] = json.dumps(list(UNKNOWNS.values()))
    return attributes_of(name, version) | comment | hashed | own


def states(inputs: Mapping[str, Any], version: str, count: int) -> Group:
    """states.h5: so many single instants; `inputs` as in the manifest."""
    said = _described("1", "number of the state", "from 1, as in states.csv")
    number = Dataset("state", (count,), said, is_scale=True, kind="<i8")
    columns = (
        Dataset(c.name, (count,), _described(c.unit, c.long_name, c.meaning), ("state",),
                is_column=True, has_nan=True)
        for c in QUANTITIES.values()
    )  # fmt: skip
    return Group(about(STATES_HDF5, inputs, version), (number, *columns))


def of_columns(
    name: str, inputs: Mapping[str, str], columns: Sequence[Column], stored: Mapping[str, Any]
) -> Group:
    """The group of a maneuver in a file of columns; `inputs` are those of the maneuver."""
    build = _sensitivity if name == SENSITIVITIES else _table
    return build(inputs, columns, stored, Maneuver.parse(inputs["name"], inputs).rows)


def _table(
    inputs: Mapping[str, str], columns: Sequence[Column], stored: Mapping[str, Any], rows: int
) -> Group:
    """Rows and dense output."""
    comment = (
        "Piecewise Chebyshev: on the piece [a, b] of breaks the column is sum_k c_k T_k(x), "
        "c_0 not halved, x = 2 (t - a) / (b - a) - 1, c = <name> + <name>_lo; "
        "a break belongs to the piece on its right, the end to the last."
    )
    pieces = _pieces(stored.get("dense", {}))
    dense = Group({"comment": comment}, tuple(_dense(columns, pieces)))
    return Group(inputs, tuple(_rows(columns, rows)), {"dense": dense})


def _sensitivity(
    inputs: Mapping[str, str], columns: Sequence[Column], stored: Mapping[str, Any], rows: int
) -> Group:
    """Derivatives of the columns along a maneuver, and of the benchmark's columns at some rows."""
    count, pieces, rows = len(UNKNOWNS), _pieces(stored), len(range(0, rows, ROWS_APART))
    first = stored.get(columns[0].name)
    orders = 0 if first is None else first.shape[1]
    dense = [Dataset("breaks", (pieces + 1,), _BREAKS)]
    certified = "certified: largest distance of the piece from the exact derivative"
    for c in columns:
        dense += _derivatives(c, (pieces, orders, count), c.meaning, (pieces, count), certified)
    said = "nearest binary64 to the time of the row"
    at_rows = [Dataset("time", (rows,), _described("s", "time", said))]
    certified = "certified: abs(exact derivative - value) <= this"
    for c in (c for c in columns if c.name in BENCHMARK_COLUMNS):
        at_rows += _derivatives(c, (rows, count), c.meaning, (rows, count), certified)
    comment = (
        "Derivatives at every tenth row, the exact ones rounded to the nearest binary64; zero "
        "where an enclosure as narrow as the bound holds zero."
    )
    return Group(inputs, tuple(dense), {"rows": Group({"comment": comment}, tuple(at_rows))})


def _derivatives(
    c: Column, shape: tuple[int, ...], meaning: str, of_bounds: tuple[int, ...], certified: str
) -> Iterator[Dataset]:
    unit = f"{c.unit} per unit of the unknown"
    said = _described(unit, f"{c.long_name}, derivatives", meaning)
    yield Dataset(c.name, shape, said, is_column=True, has_nan=True)
    said = _described(unit, f"{c.long_name}, certified bound", certified)
    yield Dataset(f"{c.name}_bound", of_bounds, said, is_column=True, has_nan=True)


def trajectory(
    inputs: Mapping[str, str], stated: Mapping[str, Any], stored: Mapping[str, Any]
) -> Group:
    """A candidate: what it says of itself by `STATED`, and integers of some bytes."""
    pieces, integers = _pieces(stored), stored.get("coefficients")
    width = 0 if integers is None else integers.shape[-1]
    shape = (pieces, 7, int(stated["taylor_order"]) + 1, width)
    said = "by piece, state, power and byte: little-endian two's complement integers"
    said_of = _described("1", "coefficients of the states", said)
    breaks = Dataset("breaks", (pieces + 1,), _BREAKS, is_column=True)
    coefficients = Dataset("coefficients", shape, said_of, is_column=True, kind="u1")
    return Group({**inputs, **stated}, (breaks, coefficients))


def numbers_of_table(time: Array, time_lo: Array, rows: Values, dense: Dense) -> Data:
    """The arrays of a group of rows and dense output."""
    return {
        "time": time,
        "time_lo": time_lo,
        **with_tags(rows),
        "dense": {"breaks": dense.breaks, **with_tags(dense)},
    }


def numbers_of_derivatives(x: Sensitivity) -> Data:
    """The arrays of a group of derivatives."""
    return {
        "breaks": x.breaks,
        **with_tags(Values(x.coefficients, {}, x.bound)),
        "rows": {"time": x.time, **with_tags(Values(x.values, {}, x.values_bound))},
    }


def with_tags(values: Values) -> Data:
    """Values, low parts and bounds by the names of their datasets."""
    parts = (("", values.hi), (LOW, values.lo), (BOUND, values.bound))
    return {name + tag: x for tag, part in parts for name, x in part.items()}


def _pieces(stored: Mapping[str, Any]) -> int:
    """Pieces between the breaks of a group, at least one."""
    breaks = stored.get("breaks")
    return 1 if breaks is None else max(breaks.size - 1, 1)


def _described(unit: str, long_name: str, definition: str) -> dict[str, str]:
    return {"units": unit, "long_name": long_name, "definition": definition}


_BREAKS = _described("s", "ends of the pieces", "exact")


def _rows(columns: Sequence[Column], rows: int) -> Iterator[Dataset]:
    said = _described("s", "time", "standard time of the rows, a multiple of the spacing")
    yield Dataset("time", (rows,), said, is_scale=True)
    said = _described("s", "time, low part", "exact time minus time")
    yield Dataset("time_lo", (rows,), said, ("time",))
    for c in columns:
        said = _described(c.unit, c.long_name, c.meaning)
        if c in COLUMNS:
            said["definition_name"] = c.definition
        if c.positive:
            said["positive"] = c.positive
        low = f"exact value minus {c.name}, rounded"
        bound = f"certified: abs(exact value - {c.name} - {c.name}_lo) <= this"
        for tag, attributes in (
            ("", said),
            ("_lo", _described(c.unit, f"{c.long_name}, low part", low)),
            ("_bound", _described(c.unit, f"{c.long_name}, certified bound", bound)),
        ):
            yield Dataset(c.name + tag, (rows,), attributes, ("time",), is_column=True)


def _dense(columns: Sequence[Column], pieces: int) -> Iterator[Dataset]:
    yield Dataset("breaks", (pieces + 1,), _BREAKS, is_scale=True)
    for name, length, counted in (
        ("piece", pieces, "number of the piece"),
        ("order", NODES, "degree of the Chebyshev polynomial"),
    ):
        said = _described("1", counted, "from 0")
        yield Dataset(name, (length,), said, is_scale=True, kind=INDEX)
    for c in columns:
        if not c.is_dense:
            continue
        for tag, low in (("", ""), ("_lo", ", low part")):
            said = _described(c.unit, f"{c.long_name}, Chebyshev coefficients{low}", c.meaning)
            yield Dataset(c.name + tag, (pieces, NODES), said, ("piece", "order"), is_column=True)
        bound = "certified: largest distance of the piece from the exact column"
        said = _described(c.unit, f"{c.long_name}, certified bound", bound)
        yield Dataset(f"{c.name}_bound", (pieces,), said, ("piece",), is_column=True)
