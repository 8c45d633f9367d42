"""Edits: what a program does to the rows of a motion when it writes them.

An edit changes the times of the rows, or the columns. The edits of a program are made in fixed
stages, whatever their order in a list: first the times, then columns that are computed from others,
then single columns, and at last the places of columns. So a column that is in another's place still
is the one that was computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

import numpy as np

from heyoka_bike.numbers.double import Array

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
    """A change of the rows."""

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
