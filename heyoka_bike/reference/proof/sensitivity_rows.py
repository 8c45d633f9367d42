"""Derivatives of the columns with respect to the unknowns: sensitivities.h5, with certified bounds.

The derivative of a column C is ``C_x S + C_k k'``, with S from `variation`. Over each piece of the
candidate it is an analytic function of u, -1 <= u <= 1, up to a bound from the same proof. It is
computed at Chebyshev nodes and interpolated in between.

Several consecutive pieces make a published one, whose coefficients follow from values at its
Chebyshev nodes. The published coefficients are rounded, so their error is that of the rounding and
that of the interpolation. The interpolation error is bounded over each piece of the candidate by
its values at nodes there, the Lebesgue constant, and the error of interpolating a function that is
analytic in an ellipse.

Coefficients and rows are rounded, each with its bound.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import groupby, islice
from math import ceil, frexp, log2

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.numbers.analytic import AtPoints, array
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.ball_chebyshev import Nodes, basis, ellipse
from heyoka_bike.numbers.ball_matrices import BallVector, largest, total
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.rounding import Enclosure, Value, few_bits, upward_ball
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.reference.proof.cauchy import SIZE
from heyoka_bike.reference.proof.rows import distance, exact_derivatives
from heyoka_bike.reference.proof.variation import (
    BITS,
    COUNT,
    Unknowns,
    Variation,
    slope,
    variations,
)
from heyoka_bike.reference.structure import ROWS_APART
from heyoka_bike.reference.values import Sensitivity

COLUMN_BITS = 128
"""Precision of the columns' derivatives with respect to state and constants. It can be modest, as
nothing is carried on from them."""

ORDERS = 24
"""Chebyshev coefficients of a published piece."""

_NODE_BITS = 160
"""Interpolation at the nodes omits less than 2^-160 of the largest value on the ellipse."""

_SMALLEST_KEPT = 2.0**-44
"""Largest interpolation error on a published piece, relative to the largest value on it. Only the
largest value of the run matters; on the first pieces, which start at zero, the relative error is a
hundred times larger."""

_CONSTANT_COLUMN = [c.name for c in COLUMNS].index("mechanical_energy")
"""Derivatives of the energy do not change, and are not taken from the polynomials."""


class ColumnDerivatives:
    """The derivatives of all columns over a part of the motion, as functions of u.

    The derivatives at one time form a row, ordered by column and then by unknown.

    Attributes
    ----------
    t0, h : Fraction
        u = (t - t0) / h.
    nodes : Nodes
        Sufficiently many nodes on -1 <= u <= 1.
    values : arb_mat
        Derivatives at the nodes.
    rest : list of arb
        Bound on the error of the derivatives, by column, valid for every unknown.
    between : list of arb
        Bound on the error of interpolation at the nodes, by column, valid for every unknown.
    """

    @classmethod
    def along(
        cls, variations: Sequence[Variation], unknowns: Unknowns, equations: Equations
    ) -> list[ColumnDerivatives]:
        """Return the derivatives over several parts of the motion, computed together.

        `equations` are in balls.
        """
        a = AtPoints(COLUMN_BITS)
        with a.precision():
            nodes = [_nodes(v.radius) for v in variations]
            states = [v.piece.at(n.x) for v, n in zip(variations, nodes, strict=True)]
            state = [np.concatenate(x) for x in zip(*states, strict=True)]
            table = unknowns.gradients(Equations.every_column, equations, a, state)
            everywhere = array([flint.arb(1)] * len(state[0]))
            by_entry = (x * everywhere for row in table for x in row)
            by_point = map(list, zip(*by_entry, strict=True))
            return [
                cls(v, unknowns, n, list(islice(by_point, len(n.x))))
                for v, n in zip(variations, nodes, strict=True)
            ]

    def __init__(
        self, variation: Variation, unknowns: Unknowns, nodes: Nodes, slopes: Sequence[BallVector]
    ) -> None:
        v = variation
        self.t0, self.h, self.nodes = v.piece.t0, v.piece.h, nodes
        columns, inner = len(COLUMNS), SIZE + len(unknowns.constants)
        self._unknowns = len(unknowns.smooth)
        states, by_constant = flint.arb_mat([m.entries() for m in v.q]), unknowns.by_constant
        powers = flint.arb_mat([_powers(x, len(v.q)) for x in nodes.x])
        values = []
        for row, state in zip(slopes, (powers * states).tolist(), strict=True):
            by_unknown = flint.arb_mat(inner, self._unknowns, [*state, *by_constant.entries()])
            values.append((flint.arb_mat(columns, inner, row) * by_unknown).entries())
        self.values = flint.arb_mat(values)
        left_out, lebesgue = nodes.left_out(v.radius), nodes.lebesgue
        # Bounds on the derivatives of the state relative to rho: on the interval -1 <= u <= 1, and
        # on the circle.
        sizes = flint.arb_mat([list(map(abs, m.entries())) for m in v.q])
        powers = flint.arb_mat([_powers(flint.arb(r), len(v.q)) for r in (1, v.radius)])
        near, rim = (
            total(
                largest(row[i * self._unknowns : (i + 1) * self._unknowns]) / x
                for i, x in enumerate(v.rho)
            )
            for row in (powers * sizes).tolist()
        )
        self.rest, self.between = [], []
        for i, size in enumerate(v.sizes):
            steepest = [
                largest(abs(row[i * inner + j]) for row in slopes) * lebesgue
                + size * (left_out + v.off) / x
                for j, x in enumerate(v.rho)
            ]
            apart = total(x * y for x, y in zip(steepest, v.bound, strict=True))
            self.rest.append((apart + size * v.off * (near + v.pull)).upper())
            self.between.append((size * left_out * (rim + v.pull)).upper())

    def at(self, times: Sequence[flint.arb]) -> flint.arb_mat:
        """Return enclosures of the derivatives at times within the part, one row per time."""
        u = [(t - exact_ball(self.t0)) / exact_ball(self.h) for t in times]
        if not all(abs(x) <= 1 for x in u):
            raise ValueError("a time outside the part of the motion")
        off = [x + y for x, y in zip(self.rest, self.between, strict=True)]
        wide = [flint.arb(0, x.upper()) for x in off for _ in range(self._unknowns)]
        rows = (basis(u, len(self.nodes.x)) * self.nodes.transform * self.values).tolist()
        return flint.arb_mat([[x + w for x, w in zip(row, wide, strict=True)] for row in rows])


@cache
def _nodes(radius: int) -> Nodes:
    """Return enough nodes to interpolate functions that are analytic inside a circle."""
    with working_bits(COLUMN_BITS):
        return Nodes(1 + ceil(_NODE_BITS / log2(float(ellipse(radius).mid()))))


def _powers(x: flint.arb, count: int) -> BallVector:
    powers = [flint.arb(1)]
    while len(powers) < count:
        powers.append(powers[-1] * x)
    return powers


@dataclass(frozen=True)
class Fitted:
    """A Chebyshev piece of the derivatives, to be published.

    Attributes
    ----------
    t0, t1 : Fraction
        Ends of the piece [s].
    coefficients : arb_mat
        Coefficients by order, in rows as in `ColumnDerivatives`.
    left_out : list of arb
        Bound on the distance of the polynomial from the derivatives, along a row.
    """

    t0: Fraction
    t1: Fraction
    coefficients: flint.arb_mat
    left_out: BallVector

    @classmethod
    def resolved(cls, parts: Sequence[ColumnDerivatives]) -> Iterator[Fitted]:
        """Yield pieces that cover consecutive parts of the motion: one piece if it is accurate."""
        found = cls.of(parts)
        if len(parts) == 1 or found.is_resolved:
            yield found
            return
        half = len(parts) // 2
        yield from cls.resolved(parts[:half])
        yield from cls.resolved(parts[half:])

    @property
    def is_resolved(self) -> bool:
        """True if the interpolation error is negligible, or at most the values' uncertainty."""
        unknowns = len(self.left_out) // len(COLUMNS)
        columns = zip(*self.coefficients.tolist(), strict=True)
        return all(
            e <= _SMALLEST_KEPT * largest(abs(x) for x in column)
            or e <= 2 * ORDERS * largest(x.rad() for x in column)
            for i, (e, column) in enumerate(zip(self.left_out, columns, strict=True))
            if i // unknowns != _CONSTANT_COLUMN
        )

    @classmethod
    def of(cls, parts: Sequence[ColumnDerivatives]) -> Fitted:
        """Fit one piece to consecutive parts of the motion."""
        t0, t1 = parts[0].t0 - parts[0].h, parts[-1].t0 + parts[-1].h
        middle, half = exact_ball((t0 + t1) / 2), exact_ball((t1 - t0) / 2)
        nodes = Nodes(ORDERS)
        times = [middle + half * x for x in reversed(nodes.x)]
        rows: list[BallVector] = []
        for part, inside in groupby(times, lambda t: _holding(parts, t)):
            rows += part.at(list(inside)).tolist()
        coefficients = nodes.transform * flint.arb_mat(rows[::-1])
        found: BallVector = [flint.arb(0)] * coefficients.ncols()
        for part in parts:
            there = [exact_ball(part.t0) + exact_ball(part.h) * u for u in part.nodes.x]
            x = [(t - middle) / half for t in there]
            difference = (basis(x, ORDERS) * coefficients - part.values).transpose().tolist()
            unknowns = len(found) // len(part.rest)
            for i, column in enumerate(difference):
                # `rest` bounds the error of the derivatives at the nodes and between them.
                lebesgue, rest = part.nodes.lebesgue, part.rest[i // unknowns]
                bound = (largest(abs(e) for e in column) + rest) * lebesgue + rest
                bound += part.between[i // unknowns]
                found[i] = found[i].max(bound)
        return cls(t0, t1, coefficients, [x.upper() for x in found])


def _holding(parts: Sequence[ColumnDerivatives], t: flint.arb) -> ColumnDerivatives:
    """Return that part of the motion which contains a time."""
    return next(p for p in parts if t <= exact_ball(p.t0 + p.h) or p is parts[-1])


_PIECES_AT_ONCE = 5
"""Maximum number of pieces of the candidate in a published piece."""

_BITS_OF_GRID = 50
"""Coefficients are multiples of 2^-50 of the largest value over the run, so that decayed values
take no space."""

_BITS_OF_GUARD = 20
"""Coefficients are multiples of at least 2^20 times their uncertainty, which decides the
rounding."""

_NAMES_OF_ROWS = [c.name for c in COLUMNS]
_ENERGY_NAME = "mechanical_energy"


def differentiate(
    run: Trajectory, certificate: Certificate, progress: Callable[[float], None] = lambda _: None
) -> Sensitivity:
    """Return derivatives of all columns along a certified candidate, rounded, with their bounds.

    They are NaN from the first piece on over which there is no bound (before a fall, for example).

    Raises
    ------
    NotCertifiedError
        The derivatives of the energy differ from those of its initial value.
    """
    equations = run.equations(Balls(BITS))
    unknowns = Unknowns.of(run, equations)
    start = _at_start(run, equations, unknowns)
    times = [run.maneuver.time(i) for i in range(0, run.maneuver.rows, ROWS_APART)]
    pieces: list[Fitted] = []
    rows: list[list[flint.arb]] = []
    parts = _bounded(variations(run, certificate, unknowns))
    with working_bits(COLUMN_BITS):
        for _, group in groupby(parts, lambda part: part.piece.step // _PIECES_AT_ONCE):
            along = ColumnDerivatives.along(list(group), unknowns, equations)
            pieces += Fitted.resolved(along)
            for part in along:
                end = part.t0 + part.h
                left = times[len(rows) :]
                inside = [t for t in left if t < end or t == end == run.breaks[-1]]
                if inside:
                    rows += part.at([exact_ball(t) for t in inside]).tolist()
            progress(float(pieces[-1].t1))
        return _Rounding(run, unknowns, start).sensitivity(pieces, times, rows)


def _bounded(parts: Iterator[Variation]) -> Iterator[Variation]:
    """Yield the parts of the motion before the first one that cannot be bounded."""
    with suppress(NotCertifiedError):
        yield from parts


def _at_start(
    run: Trajectory, equations: Equations, unknowns: Unknowns
) -> Mapping[str, Sequence[Value]]:
    """Return the derivatives at t = 0 with respect to the smooth unknowns, exact if recognised."""
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
            for name in _NAMES_OF_ROWS
        }


class _Rounding:
    """Rounds rows of enclosures, ordered by column and then by unknown, to arrays."""

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
        for i, name in enumerate(_NAMES_OF_ROWS):
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
        """Return coefficients and bounds of a column, of shapes (P, N, U) and (P, U)."""
        table = np.full((count, ORDERS, COUNT), np.nan)
        bound = np.full((count, COUNT), np.nan)
        for u, unknown in enumerate(self.unknowns.smooth):
            j, unit = i * len(self.unknowns.smooth) + u, self.units[u]
            found = [[p.coefficients[k, j] * unit for k in range(ORDERS)] for p in pieces]
            left_out = [p.left_out[j] * unit for p in pieces]
            if name == _ENERGY_NAME:
                found = [self._constant(row, self.start[name][u], name) for row in found]
                left_out = [flint.arb(0)] * len(pieces)
            grid = _grid(found)
            for p, row in enumerate(found):
                numbers, apart = self._rounded(row, grid)
                table[p, :, unknown] = numbers
                bound[p, unknown] = few_bits(upward_ball(apart + left_out[p]))
        return table, bound

    def _constant(self, row: Sequence[flint.arb], constant: Value, name: str) -> list[flint.arb]:
        """Return the row of a constant column, after checking the enclosures against it."""
        x = exact_ball(constant) if isinstance(constant, Fraction) else constant
        expected = [x, *[flint.arb(0)] * (len(row) - 1)]
        if not all(a.overlaps(b) for a, b in zip(row, expected, strict=True)):
            raise NotCertifiedError(
                f"{self.run.maneuver.name}: the derivative of {name} varies, expected a constant"
            )
        return expected

    def _rounded(self, row: Sequence[flint.arb], grid: int) -> tuple[list[float], flint.arb]:
        """Round a row to multiples of 2^-grid; also return a bound on the sum of the errors."""
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
        """Return the rounded values of a column and their bounds, both of shape (rows, U)."""
        values, bound = (np.full((count, COUNT), np.nan) for _ in range(2))
        for u, unknown in enumerate(self.unknowns.smooth):
            j = _NAMES_OF_ROWS.index(name) * len(self.unknowns.smooth) + u
            for r, row in enumerate(rows):
                found = row[j] * self.units[u]
                x: Value = found
                if r == 0 or name == _ENERGY_NAME:
                    x = self.start[name][u]
                    if not found.overlaps(exact_ball(x) if isinstance(x, Fraction) else x):
                        raise NotCertifiedError(
                            f"{self.run.maneuver.name}: the derivative of {name} in row {r} does "
                            "not agree with that of the exact initial value"
                        )
                values[r, unknown], bound[r, unknown] = self._nearest(x)
        return values, bound

    def _nearest(self, x: Value) -> tuple[float, float]:
        """Return the nearest binary64 (zero if the enclosure contains zero) and its error bound."""
        enclosed = Enclosure.of(x)
        found = 0.0 if enclosed.holds_zero else enclosed.binary64()
        if found is None:
            self.ambiguous += 1
            found = float((enclosed.low + enclosed.high) / 2)
        return found, few_bits(distance(enclosed, found, 0.0))


def _grid(rows: Sequence[Sequence[flint.arb]]) -> int:
    """Return the binary places to which coefficients are rounded, the same for the whole run."""
    size = largest(abs(x.mid()) for row in rows for x in row)
    unknown = largest(x.rad() for row in rows for x in row)
    exponents = [
        frexp(float(x))[1] + bits
        for x, bits in ((size, -_BITS_OF_GRID), (unknown, _BITS_OF_GUARD))
        if x > 0
    ]
    return -max(exponents, default=0)
