"""Layout of the HDF5 files of a dataset, declared once for writing and for verifying.

If a dataset lacks some columns, its groups are declared with the columns that it has. Lengths that
neither the inputs nor the format determine are taken from the stored arrays or the open file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.instant_columns import QUANTITIES
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.bicycle.parameters import PARAMETERS, START, STATE_INPUTS, Maneuver
from heyoka_bike.reference.hdf5 import (
    BOUND,
    INDEX,
    LOW,
    ROW_NUMBER,
    UNDECIDED,
    Dataset,
    Group,
    by_maneuver,
)
from heyoka_bike.reference.layout import CANDIDATE, HDF5, MOTION, NODES, SENSITIVITIES

UNKNOWNS: Mapping[str, str] = {
    **{symbol: p.unit for symbol, p in PARAMETERS.items()},
    **{f"initial_{key}": STATE_INPUTS[key].unit for key in START},
}
"""Unit of each unknown by name: the parameters, then the initial conditions."""


ROWS_APART = 10
"""Number of rows of the maneuver from one row of derivatives to the next."""

STATED = ("states", "form", "grid", "taylor_order", "precision", "precision_bits")
"""Attributes of a trajectory in candidate.h5, in addition to the inputs."""

COLUMNS_OF: Mapping[str, Sequence[Column]] = {
    HDF5: COLUMNS,
    MOTION: MOTION_COLUMNS,
    SENSITIVITIES: COLUMNS,
}
"""The columns of each HDF5 file of maneuvers that this version makes."""


def of_file(
    name: str, about: Mapping[str, Any], inputs: Mapping[str, Any],
    stored: Iterable[Mapping[str, Any]],
) -> Group:  # fmt: skip
    """Declare a whole HDF5 file with a group for each maneuver; `inputs` as in the manifest."""
    groups = (
        of_maneuver(name, own, COLUMNS_OF.get(name, ()), data)
        for own, data in zip(inputs["maneuvers"], stored, strict=True)
    )
    return Group(about, (), by_maneuver(groups))


def states(about: Mapping[str, Any], count: int) -> Group:
    """Declare states.h5 with this many single states and these attributes of the file."""
    said = _described("1", "number of the state", "from 1, as in states.csv")
    number = Dataset("state", (count,), said, is_scale=True, kind="<i8")
    columns = (
        _column(c, {"": ("", c.meaning, (count,))}, ("state",), has_nan=True)
        for c in QUANTITIES.values()
    )
    return Group(about, (number, *chain(*columns)))


def of_maneuver(
    name: str, inputs: Mapping[str, str], columns: Sequence[Column], stored: Mapping[str, Any]
) -> Group:
    """Declare the group of a maneuver in a file.

    Parameters
    ----------
    name
        Name of the file.
    inputs
        Inputs of the maneuver.
    columns
        Columns that the file has.
    stored
        Arrays of the group, or an open group; for a candidate also the attributes in `STATED`.
    """
    build = {SENSITIVITIES: _sensitivity, CANDIDATE: _trajectory}.get(name, _table)
    return build(inputs, columns, stored)


def _table(
    inputs: Mapping[str, str], columns: Sequence[Column], stored: Mapping[str, Any]
) -> Group:
    """Declare the datasets of rows and dense output in a group."""
    comment = (
        "Piecewise Chebyshev: on the piece [a, b] of breaks the column is sum_k c_k T_k(x), "
        "c_0 not halved, x = 2 (t - a) / (b - a) - 1, c = <name> + <name>_lo; "
        "a break belongs to the piece on its right, the end to the last."
    )
    dense = Group({"comment": comment}, tuple(_dense(columns, _pieces(stored.get("dense", {})))))
    return Group(inputs, tuple(_rows(columns, _count(inputs), stored)), {"dense": dense})


def _rows(columns: Sequence[Column], rows: int, stored: Mapping[str, Any]) -> Iterator[Dataset]:
    said = _described("s", "time", "standard time of the rows, a multiple of the spacing")
    yield Dataset("time", (rows,), said, is_scale=True)
    said = _described("s", "time, low part", "exact time minus time")
    yield Dataset("time_lo", (rows,), said, ("time",))
    for c in columns:
        more = {"definition_name": c.definition} if c in COLUMNS else {}
        more |= {"positive": c.positive} if c.positive else {}
        bound = f"certified: abs(exact value - {c.name} - {c.name}_lo) <= this"
        parts = {
            "": ("", c.meaning, (rows,)),
            LOW: (", low part", f"exact value minus {c.name}, rounded", (rows,)),
            BOUND: (_CERTIFIED, bound, (rows,)),
        }
        # An entry without an enclosure is NaN and undecided, so only a column with undecided
        # entries may contain NaN.
        has_nan = c.name + UNDECIDED in stored
        yield from _column(c, parts, ("time",), more, has_nan=has_nan)
    for c in columns:
        if (numbers := stored.get(c.name + UNDECIDED)) is not None:
            said = _described("1", f"{c.long_name}, rows that are not decided", _UNDECIDED_ROWS)
            yield Dataset(c.name + UNDECIDED, numbers.shape, said, kind=ROW_NUMBER)


def _dense(columns: Sequence[Column], pieces: int) -> Iterator[Dataset]:
    yield Dataset("breaks", (pieces + 1,), _ABOUT_BREAKS, is_scale=True)
    for name, length, counted in (
        ("piece", pieces, "number of the piece"),
        ("order", NODES, "degree of the Chebyshev polynomial"),
    ):
        said = _described("1", counted, "from 0")
        yield Dataset(name, (length,), said, is_scale=True, kind=INDEX)
    bound = "certified: largest distance of the piece from the exact column"
    for c in (c for c in columns if c.is_dense):
        parts = {
            "": (", Chebyshev coefficients", c.meaning, (pieces, NODES)),
            LOW: (", Chebyshev coefficients, low part", c.meaning, (pieces, NODES)),
            BOUND: (_CERTIFIED, bound, (pieces,)),
        }
        yield from _column(c, parts, ("piece", "order"))


def _sensitivity(
    inputs: Mapping[str, str], columns: Sequence[Column], stored: Mapping[str, Any]
) -> Group:
    """Declare the derivatives of all columns, and at some rows those of the benchmark's columns."""
    count, pieces = len(UNKNOWNS), _pieces(stored)
    rows = len(range(0, _count(inputs), ROWS_APART))
    first = stored.get(columns[0].name)
    shape = (pieces, 0 if first is None else first.shape[1], count)

    def derivatives(c: Column, shape: tuple[int, ...], certified: str) -> Iterator[Dataset]:
        parts = {
            "": (", derivatives", c.meaning, shape),
            BOUND: (_CERTIFIED, certified, (shape[0], count)),
        }
        return _column(c, parts, unit=f"{c.unit} per unit of the unknown", has_nan=True)

    certified = "certified: largest distance of the piece from the exact derivative"
    dense = chain(*(derivatives(c, shape, certified) for c in columns))
    said = "nearest binary64 to the time of the row"
    time = Dataset("time", (rows,), _described("s", "time", said))
    certified = "certified: abs(exact derivative - value) <= this"
    named = (c for c in columns if c.name in BENCHMARK_COLUMNS)
    at_rows = chain(*(derivatives(c, (rows, count), certified) for c in named))
    comment = (
        "Derivatives at every tenth row, the exact ones rounded to the nearest binary64; zero "
        "where an enclosure as narrow as the bound holds zero."
    )
    breaks = Dataset("breaks", (pieces + 1,), _ABOUT_BREAKS)
    return Group(inputs, (breaks, *dense), {"rows": Group({"comment": comment}, (time, *at_rows))})


def _trajectory(
    inputs: Mapping[str, str], columns: Sequence[Column], stored: Mapping[str, Any]
) -> Group:
    """Declare a candidate: the attributes in `STATED`, and its integers as bytes."""
    pieces, integers = _pieces(stored), stored.get("coefficients")
    width = 0 if integers is None else integers.shape[-1]
    shape = (pieces, 7, int(stored["taylor_order"]) + 1, width)
    said = "by piece, state, power and byte: little-endian two's complement integers"
    said_of = _described("1", "coefficients of the states", said)
    breaks = Dataset("breaks", (pieces + 1,), _ABOUT_BREAKS, is_column=True)
    coefficients = Dataset("coefficients", shape, said_of, is_column=True, kind="u1")
    return Group({**inputs, **{x: stored[x] for x in STATED}}, (breaks, coefficients))


def _column(
    c: Column, parts: Mapping[str, tuple[str, str, tuple[int, ...]]], scales: tuple[str, ...] = (),
    more: Mapping[str, str] | None = None, *, unit: str | None = None, has_nan: bool = False,
) -> Iterator[Dataset]:  # fmt: skip
    """Declare the datasets that store the parts of a column.

    Parameters
    ----------
    parts
        By suffix of the name: text after the column's long name, meaning, and shape.
    scales
        Dimension scales of the first axes.
    more
        Additional attributes of the values.
    unit
        Unit; by default that of the column.
    """
    for tag, (what, meaning, shape) in parts.items():
        said = _described(c.unit if unit is None else unit, c.long_name + what, meaning)
        said |= (more or {}) if tag == "" else {}
        axes = scales[: len(shape)]
        yield Dataset(c.name + tag, shape, said, axes, is_column=True, has_nan=has_nan)


def _count(inputs: Mapping[str, str]) -> int:
    """Return the number of rows of a maneuver."""
    return Maneuver.parse(inputs["name"], inputs).rows


def _pieces(stored: Mapping[str, Any]) -> int:
    """Return the number of pieces between the breaks of a group, at least one."""
    breaks = stored.get("breaks")
    return 1 if breaks is None else max(breaks.size - 1, 1)


def _described(unit: str, long_name: str, definition: str) -> dict[str, str]:
    return {"units": unit, "long_name": long_name, "definition": definition}


_ABOUT_BREAKS = _described("s", "ends of the pieces", "exact")
_CERTIFIED = ", certified bound"
_UNDECIDED_ROWS = (
    "numbers of the rows, from 0, in which the proof does not decide what is nearest to the exact "
    "value, or to the rest; what stands there is within its bound"
)
