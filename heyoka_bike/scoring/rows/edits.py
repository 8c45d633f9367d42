"""Edits: what a program does to the rows of a motion when it writes them.

An edit changes the times of the rows, or the columns. The edits of a program are made in fixed
stages, whatever their order in a list: first the times, then columns that are computed from others,
then single columns, and at last the places of columns. So a column that is in another's place still
is the one that was computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Protocol, TypeVar

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS, LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part

T = TypeVar("T")

# Of the last time: what differences of times in binary64 are off by.
_ROUNDED = 1e-15

Columns = Mapping[str, Array]
"""Columns by name."""

Change = Callable[[Columns, Array], Columns]
"""From the right columns at the times written to those that are written."""


class Stage(IntEnum):
    """The order in which edits are made."""

    TIMES = 0
    FROM_COLUMNS = 1
    SINGLE = 2
    PLACES = 3


class Edit(Protocol):
    """A change of the rows, as a program makes it."""

    @property
    def stage(self) -> Stage:
        """When it is made."""

    def meant(self, time: Array, step: float) -> Array:
        """The times of the motion in rows of some written times, with a usual distance [s]."""

    def write(self, columns: Columns, time: Array) -> Columns:
        """The columns that are written."""


@dataclass(frozen=True, slots=True)
class Clock:
    """Times on another scale, or shifted.

    Attributes
    ----------
    scale
        Of the times of the motion against those written.
    shift
        Of the times of the motion, in usual distances of the rows.
    """

    scale: float = 1.0
    shift: float = 0.0

    @property
    def stage(self) -> Stage:
        """Before all columns."""
        return Stage.TIMES

    def meant(self, time: Array, step: float) -> Array:
        """Another time in each row."""
        found: Array = self.scale * time + self.shift * step
        return found

    def write(self, columns: Columns, time: Array) -> Columns:
        """No column is changed."""
        return columns

    def undo(self, part: Part) -> Part:
        """The rows at the times that are meant; a shift is one of [s] here."""
        return replace(
            part, time=part.time * self.scale + self.shift, time_lo=part.time_lo * self.scale
        )


@dataclass(frozen=True, slots=True)
class Rewritten:
    """Columns that are computed otherwise.

    Attributes
    ----------
    change : callable
        From all columns to those written.
    at : Stage
    """

    change: Change
    at: Stage = Stage.FROM_COLUMNS

    @property
    def stage(self) -> Stage:
        """After the times."""
        return self.at

    def meant(self, time: Array, step: float) -> Array:
        """The times are as they are written."""
        return time

    def write(self, columns: Columns, time: Array) -> Columns:
        """The columns that are computed otherwise, beside all others."""
        return self.change(columns, time)


@dataclass(frozen=True, slots=True)
class Reversed:
    """Rows from the last to the first, at ascending times."""

    @property
    def stage(self) -> Stage:
        """With the times."""
        return Stage.TIMES

    def meant(self, time: Array, step: float) -> Array:
        """The times counted from the end."""
        found: Array = time[0] + time[-1] - time
        return found

    def write(self, columns: Columns, time: Array) -> Columns:
        """No column is changed beside the times of its rows."""
        return columns

    def undo(self, part: Part) -> Part:
        """The rows in the order of the motion."""
        time, lo = (part.time[0] + part.time[-1] - part.time)[::-1], -part.time_lo[::-1]
        if np.allclose(time, part.time, rtol=0.0, atol=_ROUNDED * part.time[-1]):
            # Evenly spaced rows have the times of those that they are exchanged with.
            time, lo = part.time, part.time_lo
        return replace(
            part,
            time=time,
            time_lo=lo,
            values={key: x[::-1] for key, x in part.values.items()},
            lo={key: x[::-1] for key, x in part.lo.items()},
        )


@dataclass(frozen=True, slots=True)
class Mirrored:
    """The other sign in the columns of roll and steer."""

    @property
    def stage(self) -> Stage:
        """After columns that are computed from others."""
        return Stage.SINGLE

    def meant(self, time: Array, step: float) -> Array:
        """The times are as they are written."""
        return time

    def write(self, columns: Columns, time: Array) -> Columns:
        """The columns of a motion to the other side."""
        names = {c.name for key in LATERAL for c in DEFINITIONS[key]}
        return {name: -x if name in names else x for name, x in columns.items()}

    def undo(self, part: Part) -> Part:
        """The rows of the motion to this side."""

        def turned(columns: Columns) -> dict[str, Array]:
            return {key: -x if key in LATERAL else x for key, x in columns.items()}

        return replace(part, values=turned(part.values), lo=turned(part.lo))


@dataclass(frozen=True, slots=True)
class Exchanged:
    """Columns in the places of others.

    Attributes
    ----------
    meant_as : mapping of str to str
        By the key of a place, the key of the column that is written there; a permutation.
    """

    meant_as: Mapping[str, str]

    @property
    def stage(self) -> Stage:
        """After all columns are computed."""
        return Stage.PLACES

    def meant(self, time: Array, step: float) -> Array:
        """The times are as they are written."""
        return time

    def write(self, columns: Columns, time: Array) -> Columns:
        """The columns in the places of others."""
        return {**columns, **{place: columns[key] for place, key in self.meant_as.items()}}

    def undo(self, part: Part) -> Part:
        """The rows with each column in its own place."""

        def own(columns: Mapping[str, T]) -> dict[str, T]:
            return {self.meant_as.get(key, key): x for key, x in columns.items()}

        return replace(part, values=own(part.values), lo=own(part.lo), quantum=own(part.quantum))


def in_stages(edits: Iterable[Edit]) -> list[Edit]:
    """Edits in the order in which they are made; in one stage as they are listed."""
    return sorted(edits, key=lambda edit: edit.stage)


def meant_times(edits: Iterable[Edit], time: Array, step: float) -> Array:
    """The times of the motion in rows of some written times, not before 0 [s]."""
    for edit in reversed(in_stages(edits)):
        time = edit.meant(time, step)
    found: Array = np.maximum(time, 0.0)
    return found


def written(edits: Iterable[Edit], columns: Columns, time: Array) -> Columns:
    """The columns that are written of a motion at some written times."""
    for edit in in_stages(edits):
        columns = edit.write(columns, time)
    return columns
