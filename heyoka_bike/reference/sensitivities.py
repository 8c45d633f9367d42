"""Sensitivities of the reference: d column / d unknown over time, and the file that holds them.

The unknowns are the 26 parameters of the bicycle and the five numbers of a start. How they are
computed and proved is in `variation`; reading and evaluating needs NumPy and h5py only.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from heyoka_bike.bicycle.parameters import PARAMETERS, START, STATE_INPUTS
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.chebyshev import locate
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.hdf5 import BOUND, of_maneuvers, on_demand, opened
from heyoka_bike.reference.layout import SENSITIVITIES
from heyoka_bike.reference.values import Numbered

UNKNOWNS: Mapping[str, str] = {
    **{symbol: p.unit for symbol, p in PARAMETERS.items()},
    **{f"initial_{key}": STATE_INPUTS[key].unit for key in START},
}
"""Unit of each unknown by name: the parameters, then the start."""


ROWS_APART = 10
"""Rows of the maneuver from one row of derivatives to the next."""


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity:
    """Derivatives of the columns of a maneuver, as piecewise Chebyshev polynomials.

    Attributes
    ----------
    breaks : ndarray, shape (P + 1,)
        Ends of the pieces [s], exact.
    coefficients : mapping of str to ndarray, shape (P, N, U)
        Of T_0 .. T_(N-1) in x = 2 (t - a) / (b - a) - 1 on the piece [a, b], c_0 not halved, by
        column; the unknowns in the order of `UNKNOWNS`. Unit of the column over that of the
        unknown. NaN, here and below, where a column does not depend smoothly on an unknown.
    bound : mapping of str to ndarray, shape (P, U)
        Certified bound on the distance of a piece from the exact derivative, by column.
    time : ndarray, shape (R,)
        Every tenth row of the maneuver [s].
    values, values_bound : mapping of str to ndarray, shape (R, U)
        Derivatives of the benchmark's columns at these, correctly rounded to binary64, and the
        certified bound on their distance from the exact ones.
    ambiguous : int
        Coefficients and values whose rounding the proof does not decide.
    """

    breaks: Array
    coefficients: Mapping[str, Array]
    bound: Mapping[str, Array] = field(default_factory=dict)
    time: Array = field(default_factory=lambda: np.empty(0))
    values: Mapping[str, Array] = field(default_factory=dict)
    values_bound: Mapping[str, Array] = field(default_factory=dict)
    ambiguous: int = 0

    def __repr__(self) -> str:
        return f"<derivatives of {len(self.coefficients)} columns, {len(self.breaks) - 1} pieces>"

    @property
    def orders(self) -> int:
        """Coefficients of a piece."""
        return int(next(iter(self.coefficients.values())).shape[1])

    def evaluate(self, times: ArrayLike, names: Sequence[str] | None = None) -> Mapping[str, Array]:
        """Derivatives at some times.

        Parameters
        ----------
        times : array_like, shape (n,)
            [s], within the run.
        names
            Columns; by default all.

        Returns
        -------
        mapping of str to ndarray, shape (n, U)

        Raises
        ------
        InputError
            A time outside the run.
        """
        t = np.asarray(times, dtype=np.float64).ravel()
        if len(t) and not (t.min() >= self.breaks[0] and t.max() <= self.breaks[-1]):
            raise InputError(
                f"time: found {t.min():g} to {t.max():g} s, expected 0 to {self.breaks[-1]:g} s"
            )
        piece = locate(self.breaks, (t, np.zeros_like(t)))
        a, b = self.breaks[piece], self.breaks[piece + 1]
        x = 2.0 * (t - a) / (b - a) - 1.0
        basis = np.polynomial.chebyshev.chebvander(x, self.orders - 1)
        found = {}
        for name in self.coefficients if names is None else names:
            coefficients = self.coefficients[name]
            found[name] = np.empty((len(t), coefficients.shape[2]))
            for p in np.unique(piece):
                found[name][piece == p] = basis[piece == p] @ coefficients[p]
        return found


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Numbered[Sensitivity]):
    """Of all maneuvers of a set; ``sensitivities[2]`` is maneuver 2.

    Attributes
    ----------
    maneuvers : tuple of Sensitivity
    """

    maneuvers: tuple[Sensitivity, ...]

    def __repr__(self) -> str:
        return f"<derivatives of {len(self)} maneuvers>"


def load_sensitivities(folder: str | Path | None = None) -> Sensitivities:
    """Load the sensitivities of a reference set, by default of the published one.

    Parameters
    ----------
    folder : path, optional
        Folder of the set.

    Returns
    -------
    Sensitivities

    Raises
    ------
    DatasetError
        The set has none, or the file is damaged.
    """
    where, manifest, raw = manifest_file.load_file(folder, SENSITIVITIES)
    with manifest_file.reading(where / SENSITIVITIES, "a file of sensitivities"), opened(raw) as f:
        if tuple(json.loads(f.attrs["unknowns"])) != tuple(UNKNOWNS):
            raise ValueError("other unknowns than this version has")
        groups = of_maneuvers(f, len(manifest.inputs["maneuvers"]))
        return Sensitivities(tuple(map(read_group, groups)))


def read_group(group: Any) -> Sensitivity:
    """A maneuver from an open file; sets before 1.4.0 have no bounds and no rows."""
    breaks = group["breaks"][:]
    if "rows" not in group:
        (coefficients,) = on_demand(group, ("",))
        return Sensitivity(breaks, dict(coefficients))
    coefficients, bound = map(dict, on_demand(group, ("", BOUND)))
    values, values_bound = map(dict, on_demand(group["rows"], ("", BOUND)))
    return Sensitivity(breaks, coefficients, bound, group["rows/time"][:], values, values_bound)
