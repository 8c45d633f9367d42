"""Edits: changes that a program makes to the rows of a motion when it writes them.

An edit changes the times of the rows, or the columns. The edits of a program are made in fixed
stages, whatever their order in a list: first times, then columns that are computed from others,
then single columns, and at last the order of columns. So columns are exchanged only after all of
them have been computed.

Simulated programs make edits (`write`, `meant`), and row checks undo them (`undo`). Write a class
only for an edit that both use, or whose `undo` restores the rows to their last digits. A moving
average, for example, has an inverse that magnifies the rounding of the rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import TypeVar

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS, LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part

T = TypeVar("T")

# Roundoff of a difference of two times in binary64, relative to the last time.
_ROUNDED = 1e-15

Columns = Mapping[str, Array]
"""Columns by name."""

Change = Callable[[Columns, Array], Columns]
"""A function of the right columns and the written times that returns the written columns."""


class Stage(IntEnum):
    """The order in which edits are made."""

    TIMES = 0
    FROM_COLUMNS = 1
    SINGLE = 2
    PLACES = 3


class Edit:
    """A change that a program makes to the rows that it writes; this base class changes nothing.

    Attributes
    ----------
    stage : Stage
        The stage in which the edit is made.
    """

    __slots__ = ()
    stage: Stage

    def meant(self, time: Array, step: float) -> Array:
        """Return the times of the motion in rows with the written times `time`.

        `step` is the usual distance of the written times.
        """
        return time

    def write(self, columns: Columns, time: Array) -> Columns:
        """Return the columns that the program writes instead of the given columns."""
        return columns


@dataclass(frozen=True, slots=True)
class Clock(Edit):
    """A scale and a shift of the times: motion time = scale * written time + shift.

    Attributes
    ----------
    scale
    shift
        In `meant` it is in rows (steps), in `undo` in seconds.
    """

    scale: float = 1.0
    shift: float = 0.0
    stage = Stage.TIMES

    def meant(self, time: Array, step: float) -> Array:
        """Return the times of the motion by this clock."""
        found: Array = self.scale * time + self.shift * step
        return found

    def undo(self, part: Part) -> Part:
        """Return the rows at the times of the motion; the shift is in seconds here."""
        return replace(
            part, time=part.time * self.scale + self.shift, time_lo=part.time_lo * self.scale
        )


@dataclass(frozen=True, slots=True)
class Rewritten(Edit):
    """An edit of the way in which some columns are computed.

    Attributes
    ----------
    change : callable
        Returns all columns, including the changed ones.
    stage : Stage
    """

    change: Change
    stage: Stage = Stage.FROM_COLUMNS

    def write(self, columns: Columns, time: Array) -> Columns:
        """Return all columns, including the changed ones."""
        return self.change(columns, time)


@dataclass(frozen=True, slots=True)
class Reversed(Edit):
    """An edit that reverses the order of the rows, and keeps their times ascending."""

    stage = Stage.TIMES

    def meant(self, time: Array, step: float) -> Array:
        """Return the times of the motion, which fall from the last time to the first."""
        found: Array = time[0] + time[-1] - time
        return found

    def undo(self, part: Part) -> Part:
        """Return the rows in the order of the motion."""
        time, lo = (part.time[0] + part.time[-1] - part.time)[::-1], -part.time_lo[::-1]
        if np.allclose(time, part.time, rtol=0.0, atol=_ROUNDED * part.time[-1]):
            # Evenly spaced times are the same in reverse. Keep the written times, because they have
            # no roundoff.
            time, lo = part.time, part.time_lo
        return replace(
            part,
            time=time,
            time_lo=lo,
            values={key: x[::-1] for key, x in part.values.items()},
            lo={key: x[::-1] for key, x in part.lo.items()},
        )


@dataclass(frozen=True, slots=True)
class Mirrored(Edit):
    """An edit that flips the sign of all columns of roll and steer."""

    stage = Stage.SINGLE

    def write(self, columns: Columns, time: Array) -> Columns:
        """Return the columns with the signs of roll and steer flipped."""
        names = {c.name for key in LATERAL for c in DEFINITIONS[key]}
        return {name: -x if name in names else x for name, x in columns.items()}

    def undo(self, part: Part) -> Part:
        """Return the rows with the signs of roll and steer flipped back."""

        def flipped(columns: Columns) -> dict[str, Array]:
            return {key: -x if key in LATERAL else x for key, x in columns.items()}

        return replace(part, values=flipped(part.values), lo=flipped(part.lo))


@dataclass(frozen=True, slots=True)
class Exchanged(Edit):
    """An edit that permutes columns.

    Attributes
    ----------
    meant_as : mapping of str to str
        For the key of each place, the key of the column that is written there; a permutation.
    """

    meant_as: Mapping[str, str]
    stage = Stage.PLACES

    def write(self, columns: Columns, time: Array) -> Columns:
        """Return the columns in their exchanged places."""
        return {**columns, **{place: columns[key] for place, key in self.meant_as.items()}}

    def undo(self, part: Part) -> Part:
        """Return the rows with each column in its own place."""

        def own(columns: Mapping[str, T]) -> dict[str, T]:
            return {self.meant_as.get(key, key): x for key, x in columns.items()}

        return replace(part, values=own(part.values), lo=own(part.lo), quantum=own(part.quantum))


def in_stages(edits: Iterable[Edit]) -> list[Edit]:
    """Sort edits by stage; within a stage they keep their order."""
    return sorted(edits, key=lambda edit: edit.stage)


def meant_times(edits: Iterable[Edit], time: Array, step: float) -> Array:
    """Return the times of the motion for written times usually `step` apart; at least 0 [s]."""
    for edit in reversed(in_stages(edits)):
        time = edit.meant(time, step)
    found: Array = np.maximum(time, 0.0)
    return found


def written(edits: Iterable[Edit], columns: Columns, time: Array) -> Columns:
    """Return the columns that a program with these edits writes at some written times."""
    for edit in in_stages(edits):
        columns = edit.write(columns, time)
    return columns
