"""Derivatives of the columns by the unknowns: sensitivities.h5, with certified bounds.

The derivative of a column C is ``C_x S + C_k k'``, with S from `variation`. Over each piece of the
candidate it is an analytic function of u, -1 <= u <= 1, up to a bound from the same proof: known at
Chebyshev nodes, and in between by interpolation.

Some pieces in a row make a published one: values at its Chebyshev nodes give its coefficients. What
is published, these coefficients rounded, is off by what the rounding adds and by what interpolation
leaves out. The latter is bounded over each piece of the candidate by its values at nodes there, the
Lebesgue constant, and the error of interpolating a function that is analytic in an ellipse.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import groupby, islice
from math import ceil, log2

import flint
import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import exact_ball
from heyoka_bike.numbers.ball_chebyshev import Nodes, basis, ellipse
from heyoka_bike.numbers.ball_matrices import Vector, largest, total
from heyoka_bike.numbers.samples import AtPoints, array
from heyoka_bike.reference.proof.error_flow import SIZE
from heyoka_bike.reference.proof.unknowns import Unknowns
from heyoka_bike.reference.proof.variation import Variation

COLUMN_BITS = 128
"""Of the columns' derivatives by state and constants: nothing is carried on from them."""

ORDERS = 24
"""Chebyshev coefficients of a published piece."""

_NODE_BITS = 160
"""Interpolation at the nodes leaves out less than 2^-160 of the largest value on the ellipse."""

_LEFT_OUT = 2.0**-44
"""Of the largest value on a published piece, what interpolation may leave out. The largest of the
run is what counts; on the first pieces, which start at zero, it is a hundred times more."""

_CONSTANT = [c.name for c in COLUMNS].index("mechanical_energy")
"""Its derivatives do not change, and are not taken from the polynomials."""


class ColumnDerivatives:
    """The derivatives of all columns over a part of the motion, as functions of u.

    Derivatives at one time are a row, by column and then by unknown.

    Attributes
    ----------
    t0, h : Fraction
        u = (t - t0) / h.
    nodes : Nodes
        Enough of them on -1 <= u <= 1.
    values : arb_mat
        Derivatives at these.
    rest : list of arb
        Bound on how far the derivatives are off, by column, for every unknown.
    between : list of arb
        Bound on what interpolation at the nodes leaves out, in the same way.
    """

    @classmethod
    def along(
        cls, variations: Sequence[Variation], unknowns: Unknowns, equations: Equations
    ) -> list[ColumnDerivatives]:
        """Of some parts; the columns' derivatives by state and constants are found together.

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
        self, variation: Variation, unknowns: Unknowns, nodes: Nodes, slopes: Sequence[Vector]
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
        # Over rho: of the states on -1 <= u <= 1, and on the circle.
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
        """Enclosures of the derivatives at times within the part, a row each."""
        u = [(t - exact_ball(self.t0)) / exact_ball(self.h) for t in times]
        if not all(abs(x) <= 1 for x in u):
            raise ValueError("a time outside the part of the motion")
        off = [x + y for x, y in zip(self.rest, self.between, strict=True)]
        wide = [flint.arb(0, x.upper()) for x in off for _ in range(self._unknowns)]
        rows = (basis(u, len(self.nodes.x)) * self.nodes.transform * self.values).tolist()
        return flint.arb_mat([[x + w for x, w in zip(row, wide, strict=True)] for row in rows])


@cache
def _nodes(radius: int) -> Nodes:
    """So many that functions analytic inside a circle are interpolated well enough."""
    with flint.ctx.workprec(COLUMN_BITS):
        return Nodes(1 + ceil(_NODE_BITS / log2(float(ellipse(radius).mid()))))


def _powers(x: flint.arb, count: int) -> Vector:
    powers = [flint.arb(1)]
    while len(powers) < count:
        powers.append(powers[-1] * x)
    return powers


@dataclass(frozen=True)
class Fitted:
    """A piece to be published.

    Attributes
    ----------
    t0, t1 : Fraction
        Its ends [s].
    coefficients : arb_mat
        By order; rows as in `ColumnDerivatives`.
    left_out : list of arb
        Bound on the distance of the polynomial from the derivatives, along a row.
    """

    t0: Fraction
    t1: Fraction
    coefficients: flint.arb_mat
    left_out: Vector

    @classmethod
    def resolved(cls, parts: Sequence[ColumnDerivatives]) -> Iterator[Fitted]:
        """On parts of the motion in a row, all together if that leaves out next to nothing."""
        found = cls.of(parts)
        if len(parts) == 1 or found.is_resolved:
            yield found
            return
        half = len(parts) // 2
        yield from cls.resolved(parts[:half])
        yield from cls.resolved(parts[half:])

    @property
    def is_resolved(self) -> bool:
        """Whether next to nothing is left out, or no more than is not known anyway."""
        unknowns = len(self.left_out) // len(COLUMNS)
        columns = zip(*self.coefficients.tolist(), strict=True)
        return all(
            e <= _LEFT_OUT * largest(abs(x) for x in column)
            or e <= 2 * ORDERS * largest(x.rad() for x in column)
            for i, (e, column) in enumerate(zip(self.left_out, columns, strict=True))
            if i // unknowns != _CONSTANT
        )

    @classmethod
    def of(cls, parts: Sequence[ColumnDerivatives]) -> Fitted:
        """On parts of the motion in a row."""
        t0, t1 = parts[0].t0 - parts[0].h, parts[-1].t0 + parts[-1].h
        middle, half = exact_ball((t0 + t1) / 2), exact_ball((t1 - t0) / 2)
        nodes = Nodes(ORDERS)
        times = [middle + half * x for x in reversed(nodes.x)]
        rows: list[Vector] = []
        for part, inside in groupby(times, lambda t: _holding(parts, t)):
            rows += part.at(list(inside)).tolist()
        coefficients = nodes.transform * flint.arb_mat(rows[::-1])
        found: Vector = [flint.arb(0)] * coefficients.ncols()
        for part in parts:
            there = [exact_ball(part.t0) + exact_ball(part.h) * u for u in part.nodes.x]
            x = [(t - middle) / half for t in there]
            difference = (basis(x, ORDERS) * coefficients - part.values).transpose().tolist()
            unknowns = len(found) // len(part.rest)
            for i, column in enumerate(difference):
                # At the nodes, and in between, the derivatives are off by the rest.
                lebesgue, rest = part.nodes.lebesgue, part.rest[i // unknowns]
                bound = (largest(abs(e) for e in column) + rest) * lebesgue + rest
                bound += part.between[i // unknowns]
                found[i] = found[i].max(bound)
        return cls(t0, t1, coefficients, [x.upper() for x in found])


def _holding(parts: Sequence[ColumnDerivatives], t: flint.arb) -> ColumnDerivatives:
    """The part that holds a time."""
    return next(p for p in parts if t <= exact_ball(p.t0 + p.h) or p is parts[-1])
