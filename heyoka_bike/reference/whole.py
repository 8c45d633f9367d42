"""A reference together with its motion.h5: every column that results are compared in.

Columns with dense output are known at any time, the others at the rows of the reference only.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.numbers.double import Array, Double
from heyoka_bike.reference.layout import MOTION
from heyoka_bike.reference.load import Reference, ReferenceManeuver, Values
from heyoka_bike.reference.manifest import read_manifest
from heyoka_bike.reference.motion import MotionManeuver, load_motion

AT_ROWS: frozenset[str] = frozenset(c.name for c in MOTION_COLUMNS) - frozenset(DENSE_COLUMNS)
"""Columns that the reference knows at its rows only."""

SUMMED = 1e-10
"""Of the duration: how late a million steps summed in binary64 may be.

A time so near to a row means it, and the reference is continued over so short a time.
"""

# Rows 0.01 s apart, and a motion whose fastest part decays with 20 /s: a slope is right to 1e-6.
_NEIGHBOURS = 9

_Evaluate = Callable[[Double, Sequence[str]], Values]


@dataclass(frozen=True, eq=False, repr=False)
class WholeManeuver(ReferenceManeuver):
    """The reference of one maneuver with the columns of its motion.h5; else as its base class.

    Attributes
    ----------
    motion : MotionManeuver
        Of the same rows; its dense pieces have other breaks.
    """

    motion: MotionManeuver

    @classmethod
    def of(cls, core: ReferenceManeuver, motion: MotionManeuver) -> WholeManeuver:
        """Both files of a maneuver as one."""
        own = {f.name: getattr(core, f.name) for f in fields(core)}
        # Datasets are read when they are asked for: a chain reads none.
        rows = Values(
            *(
                ChainMap(getattr(core.rows, part), getattr(motion.rows, part))
                for part in ("hi", "lo", "bound")
            )
        )
        units = {**motion.units, **core.units}
        return cls(**{**own, "rows": rows, "units": units}, motion=motion)

    def continued(self, times: Double, names: Sequence[str]) -> Values:
        """`ReferenceManeuver.continued`; NaN between the rows for a column of `AT_ROWS`."""
        return self._gathered(super().continued, self.motion.continued, times, names)

    def evaluate_many(self, t: Double, columns: Sequence[str]) -> Values:
        """`ReferenceManeuver.evaluate_many`; NaN between the rows for a column of `AT_ROWS`."""
        return self._gathered(super().evaluate_many, self.motion.evaluate_many, t, columns)

    def approximate(self, t: Array, columns: Sequence[str]) -> dict[str, Array]:
        """`ReferenceManeuver.approximate`; NaN between the rows for a column of `AT_ROWS`."""
        core, dense, at_rows = self._by_source(columns)
        return {
            **super().approximate(t, core),
            **self.motion.approximate(t, dense),
            **self._at_rows((t, np.zeros_like(t)), at_rows).hi,
        }

    def near_rows(self, t: Array) -> NDArray[np.intp]:
        """Indices of those of some sorted times that are times of rows."""
        return np.flatnonzero(self._nearest(t)[1])

    def _by_source(self, names: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
        """The names in uncontrolled-bicycle.h5, with dense output in motion.h5, and the others."""
        core = [name for name in names if name in self.dense.hi]
        dense = [name for name in names if name in self.motion.dense.hi]
        return core, dense, [name for name in names if name in AT_ROWS]

    def _gathered(
        self, core: _Evaluate, dense: _Evaluate, times: Double, names: Sequence[str]
    ) -> Values:
        """Columns of each source, by the routines for the pieces of the two files."""
        of_core, of_dense, at_rows = self._by_source(names)
        parts = core(times, of_core), dense(times, of_dense), self._at_rows(times, at_rows)
        return Values(
            {name: x for v in parts for name, x in v.hi.items()},
            {name: x for v in parts for name, x in v.lo.items()},
        )

    def _at_rows(self, t: Double, names: Sequence[str]) -> Values:
        row, is_near = self._nearest(t[0])
        late = (t[0] - self.time[row]) + (t[1] - self.time_lo[row])
        hi, lo = {}, {}
        for name in names:
            values, rest = self.rows.hi[name], self.rows.lo[name]
            slope = _slopes(values, self.time)[row] if late.any() else 0.0
            hi[name] = np.where(is_near, values[row], np.nan)
            lo[name] = rest[row] + slope * np.where(is_near, late, 0.0)
        return Values(hi, lo)

    def _nearest(self, t: Array) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """For each time the nearest row, and whether it means that."""
        middles = (self.time[1:] + self.time[:-1]) / 2
        row = np.searchsorted(middles, t)
        return row, np.abs(t - self.time[row]) <= SUMMED * float(self.duration)


def with_motion(reference: Reference) -> Reference | None:
    """A reference with its motion.h5; None if its set has none.

    Raises
    ------
    DatasetError
        The manifest or the file is missing or damaged.
    """
    if MOTION not in read_manifest(reference.folder).files:
        return None
    motion = load_motion(reference.folder)
    maneuvers = tuple(WholeManeuver.of(reference[n], motion[n]) for n in reference)
    return replace(reference, maneuvers=maneuvers)


def _slopes(values: Array, time: Array) -> Array:
    """Derivatives of a column at evenly spaced rows, by polynomials through neighbouring ones."""
    n = min(_NEIGHBOURS, len(values))
    nodes = np.arange(n, dtype=np.float64)
    powers = np.vander(nodes, increasing=True)
    weights = (powers[:, :-1] * nodes[1:]) @ np.linalg.inv(powers)[1:]
    first = np.clip(np.arange(len(values)) - n // 2, 0, len(values) - n)
    own = weights[np.arange(len(values)) - first]
    slopes: Array = np.sum(own * values[first[:, None] + np.arange(n)], axis=1)
    slopes /= time[1] - time[0]
    return slopes
