"""What is published of the derivatives: coefficients and rows rounded, each with its bound."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import groupby
from math import frexp

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.ball_matrices import largest, total
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.rounding import Enclosure, Value, few_bits, upward_ball
from heyoka_bike.reference.proof.derivatives import COLUMN_BITS, ORDERS, ColumnDerivatives, Fitted
from heyoka_bike.reference.proof.first_row import exact_derivatives
from heyoka_bike.reference.proof.rows import distance
from heyoka_bike.reference.proof.unknowns import COUNT, Unknowns, slope
from heyoka_bike.reference.proof.variation import BITS, Variation, variations
from heyoka_bike.reference.sensitivities import ROWS_APART, Sensitivity

_TOGETHER = 5
"""Pieces of the candidate in a published one."""

_GRID_BITS = 50
"""Coefficients are multiples of 2^-50 of the largest value over the run: what decays takes no
space."""

_GUARD_BITS = 20
"""They are multiples of at least 2^20 times what is not known of them, which decides them."""

_NAMES = [c.name for c in COLUMNS]
_ENERGY = "mechanical_energy"


def differentiate(
    run: Trajectory, certificate: Certificate, progress: Callable[[float], None] = lambda _: None
) -> Sensitivity:
    """Derivatives of all columns along a certified candidate, rounded, with their bounds.

    From a piece on over which they are not bounded (about to fall, say) there is NaN.

    Raises
    ------
    NotCertifiedError
        The derivatives of the energy are not those of its initial value.
    """
    equations = Equations.of(run.bicycle, Balls(BITS), is_regular=run.is_regular)
    unknowns = Unknowns.of(run, equations)
    start = _at_start(run, equations, unknowns)
    times = [run.maneuver.time(i) for i in range(0, run.maneuver.rows, ROWS_APART)]
    pieces: list[Fitted] = []
    rows: list[list[flint.arb]] = []
    parts = _bounded(variations(run, certificate, unknowns))
    with flint.ctx.workprec(COLUMN_BITS):
        for _, group in groupby(parts, lambda part: part[0] // _TOGETHER):
            along = ColumnDerivatives.along([v for _, v in group], unknowns, equations)
            pieces += Fitted.resolved(along)
            for part in along:
                end = part.t0 + part.h
                left = times[len(rows) :]
                inside = [t for t in left if t < end or t == end == run.breaks[-1]]
                if inside:
                    rows += part.at([exact_ball(t) for t in inside]).tolist()
            progress(float(pieces[-1].t1))
        return _Rounding(run, unknowns, start).sensitivity(pieces, times, rows)


def _bounded(parts: Iterator[tuple[int, Variation]]) -> Iterator[tuple[int, Variation]]:
    """As far as there are bounds."""
    with suppress(NotCertifiedError):
        yield from parts


def _at_start(
    run: Trajectory, equations: Equations, unknowns: Unknowns
) -> Mapping[str, Sequence[Value]]:
    """Derivatives of all columns at t = 0 by the smooth unknowns, exact where that is seen."""
    exact = exact_derivatives(run.bicycle, run.maneuver)
    with equations.precision():
        columns = unknowns.varied.columns(equations)
        nothing = [None] * COUNT
        return {
            name: [
                flint.arb(slope(columns[name], i)) if x is None else x
                for i, x in enumerate(exact.get(name, nothing))
                if i in unknowns.smooth
            ]
            for name in _NAMES
        }


class _Rounding:
    """From rows of enclosures, by column and then by unknown, to arrays."""

    def __init__(
        self, run: Trajectory, unknowns: Unknowns, start: Mapping[str, Sequence[Value]]
    ) -> None:
        self.run, self.unknowns, self.start = run, unknowns, start
        self.ambiguous = 0
        self.units = [flint.arb(2) ** -e for e in unknowns.units]

    def sensitivity(
        self,
        pieces: Sequence[Fitted],
        times: Sequence[Fraction],
        rows: Sequence[Sequence[flint.arb]],
    ) -> Sensitivity:
        breaks = [Fraction(0), *(p.t1 for p in pieces)]
        if breaks[-1] < self.run.breaks[-1]:
            breaks.append(self.run.breaks[-1])
        coefficients, bounds = {}, {}
        for i, name in enumerate(_NAMES):
            coefficients[name], bounds[name] = self._column(i, name, pieces, len(breaks) - 1)
        values, value_bounds = {}, {}
        for name in BENCHMARK_COLUMNS:
            values[name], value_bounds[name] = self._rows(name, rows, len(times))
        return Sensitivity(
            breaks=np.array([float(t) for t in breaks]),
            coefficients=coefficients,
            bound=bounds,
            time=np.array([t.numerator / t.denominator for t in times]),
            values=values,
            values_bound=value_bounds,
            ambiguous=self.ambiguous,
        )

    def _column(
        self, i: int, name: str, pieces: Sequence[Fitted], count: int
    ) -> tuple[Array, Array]:
        """Coefficients and bounds of a column, of shapes (P, N, U) and (P, U)."""
        table = np.full((count, ORDERS, COUNT), np.nan)
        bound = np.full((count, COUNT), np.nan)
        for u, unknown in enumerate(self.unknowns.smooth):
            j, unit = i * len(self.unknowns.smooth) + u, self.units[u]
            found = [[p.coefficients[k, j] * unit for k in range(ORDERS)] for p in pieces]
            left_out = [p.left_out[j] * unit for p in pieces]
            if name == _ENERGY:
                found = [self._constant(row, self.start[name][u], name) for row in found]
                left_out = [flint.arb(0)] * len(pieces)
            grid = _grid(found)
            for p, row in enumerate(found):
                numbers, apart = self._rounded(row, grid)
                table[p, :, unknown] = numbers
                bound[p, unknown] = few_bits(upward_ball(apart + left_out[p]))
        return table, bound

    def _constant(self, row: Sequence[flint.arb], constant: Value, name: str) -> list[flint.arb]:
        """A row that is a constant; what is known of it otherwise has to agree."""
        x = exact_ball(constant) if isinstance(constant, Fraction) else constant
        expected = [x, *[flint.arb(0)] * (len(row) - 1)]
        if not all(a.overlaps(b) for a, b in zip(row, expected, strict=True)):
            raise NotCertifiedError(
                f"{self.run.maneuver.name}: the derivative of {name} is not the constant that it is"
            )
        return expected

    def _rounded(self, row: Sequence[flint.arb], grid: int) -> tuple[list[float], flint.arb]:
        """Multiples of 2^-grid, and a bound on the sum of their distances."""
        unit = flint.arb(2) ** -grid
        numbers, apart = [], []
        for x in row:
            scaled = x / unit
            n = (scaled + flint.arb(0.5)).floor()
            if n.unique_fmpz() is None:
                self.ambiguous += 1
                n = (scaled.mid() + flint.arb(0.5)).floor().mid()
            numbers.append(float(n * unit) + 0.0)
            apart.append(abs(x - n * unit))
        return numbers, total(apart)

    def _rows(
        self, name: str, rows: Sequence[Sequence[flint.arb]], count: int
    ) -> tuple[Array, Array]:
        """Values of a column, rounded to binary64, and their bounds, of shape (rows, U)."""
        values, bound = (np.full((count, COUNT), np.nan) for _ in range(2))
        for u, unknown in enumerate(self.unknowns.smooth):
            j = _NAMES.index(name) * len(self.unknowns.smooth) + u
            for r, row in enumerate(rows):
                found = row[j] * self.units[u]
                x: Value = found
                if r == 0 or name == _ENERGY:
                    x = self.start[name][u]
                    if not found.overlaps(exact_ball(x) if isinstance(x, Fraction) else x):
                        raise NotCertifiedError(
                            f"{self.run.maneuver.name}: the derivative of {name}, row {r}, is not "
                            "what the start says"
                        )
                values[r, unknown], bound[r, unknown] = self._nearest(x)
        return values, bound

    def _nearest(self, x: Value) -> tuple[float, float]:
        """The nearest binary64; zero where the enclosure holds zero."""
        if isinstance(x, Fraction):
            nearest = x.numerator / x.denominator
            return nearest + 0.0, few_bits(distance(x, nearest, 0.0))
        enclosed = Enclosure.of(x)
        found = 0.0 if x.contains(0) else enclosed.binary64()
        if found is None:
            self.ambiguous += 1
            found = float(x.mid())
        return found, few_bits(distance(enclosed, found, 0.0))


def _grid(rows: Sequence[Sequence[flint.arb]]) -> int:
    """Of coefficients over the run: bits after the point of a multiple."""
    size = largest(abs(x.mid()) for row in rows for x in row)
    unknown = largest(x.rad() for row in rows for x in row)
    exponents = [
        frexp(float(x))[1] + bits
        for x, bits in ((size, -_GRID_BITS), (unknown, _GUARD_BITS))
        if x > 0
    ]
    return -max(exponents, default=0)
