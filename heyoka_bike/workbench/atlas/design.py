"""The design of an atlas: its grid, and how the grid is cut into chunks."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, sqrt
from typing import Any

import numpy as np

from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.machine import versions
from heyoka_bike.workbench.atlas.data import GridAxis
from heyoka_bike.workbench.atlas.fates import LONGEST
from heyoka_bike.workbench.atlas.runs import PLANS

ACCURACY, EDGE_ACCURACY = 1e-10, "roundoff"
"""Accuracy of the motions of the grid, and of those at the basin boundary; see `PLANS`."""

Chunk = tuple[int, int]
"""Position of a chunk along both axes."""

_MOST_POINTS = 10**9
_CHUNKS = 100  # approximate number of chunks, if none of them becomes too large
_SIDES_OF_CHUNK = (4, 128)


@dataclass(frozen=True)
class Design:
    """The grid of an atlas, and the bicycle and initial values at its points.

    Attributes
    ----------
    bicycle : Bicycle
    axes : tuple of GridAxis
        The two axes.
    start : mapping
        Initial values that are not on an axis [SI], by the names of `START`.
    longest
        A motion is followed for at most this time [s].
    """

    bicycle: Bicycle
    axes: tuple[GridAxis, GridAxis]
    start: Mapping[str, float]
    longest: float = LONGEST

    @property
    def shape(self) -> tuple[int, int]:
        """The numbers of grid points along the two axes."""
        return len(self.axes[0].values), len(self.axes[1].values)

    @property
    def side(self) -> int:
        """Number of points of a chunk along each axis, which the shape of the grid determines."""
        least, most = _SIDES_OF_CHUNK
        return min(max(ceil(sqrt(self.shape[0] * self.shape[1] / _CHUNKS)), least), most)

    def chunks(self) -> Iterator[Chunk]:
        """Yield all chunks, in the order in which they are computed."""
        rows, columns = (ceil(n / self.side) for n in self.shape)
        return ((i, j) for i in range(rows) for j in range(columns))

    def slices(self, chunk: Chunk) -> tuple[slice, slice]:
        """Return the slices of the two axes that a chunk covers."""
        side = self.side
        first, second = (
            slice(i * side, min((i + 1) * side, n)) for i, n in zip(chunk, self.shape, strict=True)
        )
        return first, second

    def points(self, first: Array, second: Array) -> tuple[list[Bicycle], Array, Any]:
        """Return the bicycles, the initial values, and the index of the bicycle of each point.

        The initial values are in the order of `START`.

        Parameters
        ----------
        first, second : ndarray, shape (points,)
            Values on the two axes.
        """
        starts = np.tile([self.start[name] for name in START], (len(first), 1))
        changes: dict[str, Array] = {}
        for axis, values in zip(self.axes, (first, second), strict=True):
            if axis.name in START:
                starts[:, START.index(axis.name)] = values
            else:
                changes[axis.name] = values
        if not changes:
            return [self.bicycle], starts, np.zeros(len(first), dtype=int)
        table, which = np.unique(
            np.column_stack(list(changes.values())), axis=0, return_inverse=True
        )
        bicycles = [
            self.bicycle.replace(
                **{s: Exact(Fraction(float(x))) for s, x in zip(changes, row, strict=True)}
            )
            for row in table
        ]
        # If all bicycles were the same, their constants would be compiled into the code. With a
        # second bicycle, the code reads the constants at run time, so all chunks use the same code.
        return [*bicycles, self.bicycle], starts, which.reshape(-1)

    def provenance(self) -> dict[str, str]:
        """Return inputs, method and versions, on which the numbers of the atlas depend, as text."""
        from heyoka_bike.motion import heyoka_adapter

        inputs = {
            "bicycle": {s: str(self.bicycle[s]) for s in PARAMETERS},
            "axes": {a.name: [x.hex() for x in map(float, a.values)] for a in self.axes},
            "start": {name: x.hex() for name, x in self.start.items()},
        }
        plan, edge = PLANS[ACCURACY], PLANS[EDGE_ACCURACY]
        return {
            "inputs": json.dumps(inputs, sort_keys=True),
            "longest": f"{self.longest:g} s",
            "method": f"Taylor steps of order {plan.order}, at the edge {edge.order}, binary64",
            "heyoka_bike": versions()["heyoka_bike"],
            "heyoka": heyoka_adapter.version(),
            "chunk": f"{self.side} x {self.side} points",
        }


def axis(text: str, name: str) -> GridAxis:
    """Parse an axis ``FROM:TO:N`` of the grid; `name` is in `START`, or a parameter.

    Raises
    ------
    InputError
        The text has another form, or the model does not allow the values.
    """
    option = "--" + name.replace("_", "-") if name in START else f"--axis {name}"
    parts = text.split(":")
    if len(parts) != 3:
        raise InputError(f"{option}: found {quoted(text)}, expected FROM:TO:N, such as 3:8:200")
    begin, end = (_number(option, part) for part in parts[:2])
    if not parts[2].isdecimal() or not 2 <= int(parts[2]) <= _MOST_POINTS:
        raise InputError(f"{option}: found {quoted(parts[2])} points, expected 2 or more")
    count = int(parts[2])
    if begin >= end:
        raise InputError(f"{option}: found {quoted(text)}, expected FROM below TO")
    step = (end - begin) / (count - 1)
    return GridAxis(name, np.array([float(begin + i * step) for i in range(count)]))


def design(
    bicycle: Bicycle, axes: Sequence[GridAxis], start: Mapping[str, float] | None = None,
    longest: float = LONGEST,
) -> Design:  # fmt: skip
    """Return the design of an atlas, after checks; initial values that are not given are zero.

    Raises
    ------
    InputError
        The axes are not two different ones, or the model does not allow the values.
    """
    names = [a.name for a in axes]
    if len(names) != 2 or names[0] == names[1]:
        raise InputError(f"found axes {', '.join(names) or 'none'}, expected two different axes")
    whole = {**dict.fromkeys(START, 0.0), **(start or {})}
    first, second = axes
    made = Design(bicycle, (first, second), whole, longest)
    if made.shape[0] * made.shape[1] > _MOST_POINTS:
        raise InputError(f"found more than {_MOST_POINTS:.0e} points, expected fewer")
    # Check that motions at the ends of the axes are possible before anything is computed.
    corners = [(x, y) for x in (0, -1) for y in (0, -1)]
    made.points(
        np.array([first.values[i] for i, _ in corners]),
        np.array([second.values[j] for _, j in corners]),
    )
    return made


def _number(option: str, text: str) -> Fraction:
    x = Exact.read(option, text)
    return x.rational if x.is_rational else Fraction(float(x))
