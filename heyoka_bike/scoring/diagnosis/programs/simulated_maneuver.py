"""A maneuver of the reference whose columns are those of another motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields

import numpy as np

from heyoka_bike.numbers.double import Array, Double
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.values import Dense, Values

ColumnsAt = Callable[[Array], Mapping[str, Array]]
"""A function from times within the run [s], shape (n,), to columns by name [SI unit]."""


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedManeuver(ReferenceManeuver):
    """A maneuver with the columns of another motion, to compare the rows of a file with it.

    Attributes
    ----------
    columns_at : ColumnsAt
    """

    columns_at: ColumnsAt = field(kw_only=True)

    def _gathered(
        self, evaluate: Callable[[Dense, Double, Sequence[str]], Values], t: Double,
        names: Sequence[str],
    ) -> Values:  # fmt: skip
        """Return columns at some times; a time just beyond the end counts as the end."""
        columns = self.columns_at(np.minimum(t[0], float(self.duration)))
        return _values({name: columns[name] for name in names})


def with_columns(maneuver: ReferenceManeuver, columns_at: ColumnsAt) -> SimulatedManeuver:
    """Return a maneuver with the columns of another motion, which may not be finite."""
    columns = columns_at(maneuver.time)
    rows = _values({name: columns[name] for name in maneuver.at_any_time & columns.keys()})
    same = {f.name: getattr(maneuver, f.name) for f in fields(maneuver)}
    return SimulatedManeuver(**{**same, "rows": rows}, columns_at=columns_at)


def _values(columns: Mapping[str, Array]) -> Values:
    return Values(columns, {name: np.zeros_like(x) for name, x in columns.items()})
