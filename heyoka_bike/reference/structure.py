"""How the HDF5 files of a set are built: declared once, to be written and to be verified.

A group of a set that lacks some columns is declared with the columns that it has.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.instant_columns import QUANTITIES
from heyoka_bike.reference.description.facts import CONVENTIONS, attributes_of
from heyoka_bike.reference.hdf5 import INDEX, Dataset, Group
from heyoka_bike.reference.layout import CANDIDATE, HDF5, MOTION, NODES, SENSITIVITIES, STATES_HDF5
from heyoka_bike.reference.sensitivities import UNKNOWNS

STATED = ("states", "form", "grid", "taylor_order", "precision", "precision_bits")
"""What candidate.h5 says of a trajectory, beside the inputs."""


def about_reference(inputs: Mapping[str, Any], version: str, content: str) -> dict[str, str]:
    """Attributes of uncontrolled-bicycle.h5; `inputs` here and below as in the manifest."""
    return {
        **attributes_of(HDF5, version),
        "Conventions": CONVENTIONS,
        "dataset_version": version,
        "content_sha256": content,
        **_bicycle(inputs),
        "comment": "Each value is the correctly rounded exact one; <name>_lo is the exact value "
        "minus it, so <name> + <name>_lo has 32 digits. Axes: x forward, y right, z down.",
    }


def about_motion(inputs: Mapping[str, Any], version: str, content: str) -> dict[str, str]:
    """Attributes of motion.h5."""
    return {
        **attributes_of(MOTION, version),
        "Conventions": CONVENTIONS,
        "content_sha256": content,
        **_bicycle(inputs),
        "comment": "Each value is the correctly rounded exact one, or zero where an enclosure as "
        "narrow as its bound holds zero; <name>_lo is the exact value minus it, so <name> + "
        "<name>_lo has 32 digits. Ground frame: x along the initial heading, y right, z down, "
        "origin where the rear wheel touches the floor at t = 0. Wheel angles are zero at t = 0.",
    }


def about_sensitivities(inputs: Mapping[str, Any], version: str, content: str) -> dict[str, str]:
    """Attributes of sensitivities.h5."""
    return {
        **attributes_of(SENSITIVITIES, version),
        "comment": "On the piece [a, b] of breaks the derivative of a column with respect to "
        "unknown u is sum_k c[piece, k, u] T_k(x), c_0 not halved, x = 2 (t - a) / (b - a) - 1; a "
        "break belongs to the piece on its right. The pitch at the start follows from roll and "
        "steer. <name>_bound[piece, u] is the certified distance from the exact derivative. NaN "
        "where a column does not depend smoothly on an unknown.",
        "content_sha256": content,
        **_bicycle(inputs),
        "unknowns": json.dumps(list(UNKNOWNS)),
        "unknown_units": json.dumps(list(UNKNOWNS.values())),
    }


def about_candidate(inputs: Mapping[str, Any], version: str) -> dict[str, str]:
    """Attributes of candidate.h5."""
    return {
        **attributes_of(CANDIDATE, version),
        "comment": "On the piece [a, b] of breaks a state variable is sum_k n_k 2^-grid s^k, "
        "s = (t - a) / (b - a); coefficients[piece, state, k] holds n_k as a little-endian "
        "two's complement integer. Angles in rad, rates in rad/s.",
        **_bicycle(inputs),
    }


def states(inputs: Mapping[str, Any], version: str, count: int) -> Group:
    """states.h5: so many single instants."""
    about = {
        **attributes_of(STATES_HDF5, version),
        "comment": "Each value is the binary64 nearest to the exact one, in the state whose "
        "coordinates are the shortest decimals of the binary64 stored here; NaN where a quantity "
        "is not defined. Axes: x forward along the heading, y right, z down, origin where the rear "
        "wheel touches the floor.",
        **_bicycle(inputs),
    }
    said = _described("1", "number of the state", "from 1, as in states.csv")
    number = Dataset("state", (count,), said, is_scale=True, kind="<i8")
    columns = (
        Dataset(c.name, (count,), _described(c.unit, c.long_name, c.meaning), ("state",),
                is_column=True, has_nan=True)
        for c in QUANTITIES.values()
    )  # fmt: skip
    return Group(about, (number, *columns))


def table(inputs: Mapping[str, str], columns: Sequence[Column], rows: int, pieces: int) -> Group:
    """Rows and dense output of a maneuver; `inputs` here and below of the maneuver."""
    comment = (
        "Piecewise Chebyshev: on the piece [a, b] of breaks the column is sum_k c_k T_k(x), "
        "c_0 not halved, x = 2 (t - a) / (b - a) - 1, c = <name> + <name>_lo; "
        "a break belongs to the piece on its right, the end to the last."
    )
    dense = Group({"comment": comment}, tuple(_dense(columns, pieces)))
    return Group(inputs, tuple(_rows(columns, rows)), {"dense": dense})


def sensitivity(
    inputs: Mapping[str, str], columns: Sequence[Column], pieces: int, orders: int, rows: int
) -> Group:
    """Derivatives of the columns along a maneuver, and of the benchmark's columns at some rows."""
    count = len(UNKNOWNS)
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
    about = _described(unit, f"{c.long_name}, derivatives", meaning)
    yield Dataset(c.name, shape, about, is_column=True, has_nan=True)
    about = _described(unit, f"{c.long_name}, certified bound", certified)
    yield Dataset(f"{c.name}_bound", of_bounds, about, is_column=True, has_nan=True)


def trajectory(
    inputs: Mapping[str, str], stated: Mapping[str, Any], pieces: int, width: int
) -> Group:
    """A candidate: what it says of itself by `STATED`, and integers of so many bytes."""
    shape = (pieces, 7, int(stated["taylor_order"]) + 1, width)
    said = "by piece, state, power and byte: little-endian two's complement integers"
    about = _described("1", "coefficients of the states", said)
    breaks = Dataset("breaks", (pieces + 1,), _BREAKS, is_column=True)
    coefficients = Dataset("coefficients", shape, about, is_column=True, kind="u1")
    return Group({**inputs, **stated}, (breaks, coefficients))


def _bicycle(inputs: Mapping[str, Any]) -> dict[str, str]:
    bicycle = inputs["bicycle"]
    return {"bicycle": bicycle["name"], "parameters": json.dumps(bicycle["parameters"])}


def _described(unit: str, long_name: str, definition: str) -> dict[str, str]:
    return {"units": unit, "long_name": long_name, "definition": definition}


_BREAKS = _described("s", "ends of the pieces", "exact")


def _rows(columns: Sequence[Column], rows: int) -> Iterator[Dataset]:
    said = "standard time of the rows, a multiple of the spacing"
    yield Dataset("time", (rows,), _described("s", "time", said), is_scale=True)
    about = _described("s", "time, low part", "exact time minus time")
    yield Dataset("time_lo", (rows,), about, ("time",))
    for c in columns:
        about = _described(c.unit, c.long_name, c.meaning)
        if c in COLUMNS:
            about["definition_name"] = c.definition
        if c.positive:
            about["positive"] = c.positive
        low = f"exact value minus {c.name}, rounded"
        bound = f"certified: abs(exact value - {c.name} - {c.name}_lo) <= this"
        for tag, attributes in (
            ("", about),
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
        about = _described("1", counted, "from 0")
        yield Dataset(name, (length,), about, is_scale=True, kind=INDEX)
    for c in columns:
        if not c.is_dense:
            continue
        for tag, low in (("", ""), ("_lo", ", low part")):
            about = _described(c.unit, f"{c.long_name}, Chebyshev coefficients{low}", c.meaning)
            yield Dataset(c.name + tag, (pieces, NODES), about, ("piece", "order"), is_column=True)
        bound = "certified: largest distance of the piece from the exact column"
        about = _described(c.unit, f"{c.long_name}, certified bound", bound)
        yield Dataset(f"{c.name}_bound", (pieces,), about, ("piece",), is_column=True)
