"""Dense output: every column as piecewise Chebyshev polynomials, the form used for ephemerides.

Each piece interpolates the columns at the N Chebyshev nodes of the first kind. A piece is halved
until its last coefficients are far below the accuracy of the dense output, so the interpolation
error (about the first omitted coefficient) is smaller still. Coefficients are rounded to a multiple
of 2^-112 of the column's scale and stored as hi + lo.

The distance of the dense output from the exact motion has a rigorous bound. Over each piece of the
candidate every column is expanded as a Taylor series in balls, with a remainder bounded by Cauchy's
estimate on a circle (see `cauchy`). Where a Chebyshev piece overlaps this series, their difference
is a polynomial, bounded on short spans by its values at Chebyshev nodes. The distance of the exact
motion from the candidate is added through the columns' derivatives with respect to the state,
bounded on the polydisc of the same circle.

The whole motion needs the position and the wheel angles along a candidate, which are integrals of
functions g of the state. On each piece of the candidate p the Taylor coefficients of h g(p(s)) (see
`analytic`) are integrated in balls. The coefficients of the integral, rounded to the candidate's
grid, are those of a polynomial q. Its distance from the exact integral grows over a piece by at
most

- ``q' - h g(p)``: the absolute values of the coefficients, and Cauchy's estimate on a circle for
  the rest (see `cauchy`);
- ``h g(x) - h g(p)`` for the exact state x, which the certificate shows to be near p: its distance
  times the derivatives of g, bounded on the polydisc around p.

A piece on which no circle works is halved, exactly.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from itertools import pairwise
from math import ceil, frexp, ldexp, log2, nan

import flint
import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS, NORMS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import (
    INTEGRALS,
    NonnegativeRoots,
    dense_columns,
    motion_columns,
    rates_of_integrals,
)
from heyoka_bike.bicycle.motion_columns import DENSE_COLUMNS, MOTION_COLUMNS
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, OnTime, Piece, Stretch, Trajectory, row_times
from heyoka_bike.numbers.analytic import NotAnalyticError, Samples
from heyoka_bike.numbers.arithmetic import (
    Balls,
    dyadic,
    exact_ball,
    span_ball,
    to_grid,
    upper_fraction,
)
from heyoka_bike.numbers.ball_chebyshev import Nodes, basis, chebyshev_nodes, in_between
from heyoka_bike.numbers.ball_matrices import largest
from heyoka_bike.numbers.rounding import (
    Enclosure,
    Value,
    few_bits,
    hi_lo,
    nearest_pair,
    upward,
    upward_ball,
)
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.reference.layout import NODES
from heyoka_bike.reference.proof import cauchy
from heyoka_bike.reference.proof.rows import distance, round_columns
from heyoka_bike.reference.values import Dense, Values

_BITS_OF_DENSE_TAIL = 97  # the last coefficients are below 2^-97 = 6e-30 of the scale
_BITS_OF_COEFFICIENTS = 112
_FIRST_WIDTH = Fraction(1, 2)
_MIN_WIDTH = Fraction(1, 2**24)

LocalEvaluator = Callable[[flint.arb, Fraction], Mapping[str, flint.arb]]


def interpolate(
    near: LocalEvaluator, end: Fraction, balls: Balls, scales: Mapping[str, float],
    constant: Mapping[str, Value], progress: OnTime = lambda _: None,
) -> Dense:  # fmt: skip
    """Interpolate columns from time 0 to the end, by piecewise Chebyshev polynomials.

    Parameters
    ----------
    near
        Function that returns the columns by name at a time, on the piece that contains another
        time.
    balls
        Number type of the columns.
    scales
        Largest absolute value over the run of each column to be interpolated; zero for a column
        that vanishes.
    constant
        Values of the columns known to be constant.
    """
    names = list(scales)
    grids = [_BITS_OF_COEFFICIENTS - frexp(scales[name])[1] for name in names]
    breaks, rows, widths = [Fraction(0)], [], [_FIRST_WIDTH]
    with balls.precision():
        nodes = Nodes(NODES)
        known = {
            name: balls.number(x) if isinstance(x, Fraction) else x for name, x in constant.items()
        }
        while breaks[-1] < end:
            a, width = breaks[-1], widths[-1]
            b = min(a + width, end)
            coefficients = _fit(near, nodes, names, known, a, b)
            if width > _MIN_WIDTH and not _is_resolved(coefficients, scales, names):
                widths[-1:] = [width / 2, width / 2]
                continue
            widths.pop()
            if not widths:
                widths = [_FIRST_WIDTH]
            breaks.append(b)
            rows.append(_on_grid(coefficients, grids, names))
            progress(float(b))
    table = np.array(rows, dtype=np.float64)  # axes: piece, column, order, and high or low part
    return Dense(
        breaks=np.array([float(t) for t in breaks]),
        hi={name: np.ascontiguousarray(table[:, i, :, 0]) for i, name in enumerate(names)},
        lo={name: np.ascontiguousarray(table[:, i, :, 1]) for i, name in enumerate(names)},
    )


def scale_of_dense(rows: Values, name: str) -> float:
    """Return the scale of a column, to which `interpolate` resolves it.

    The scale is large enough that `interpolate` does not resolve details below the uncertainty of
    the column.
    """
    known = float(np.max(rows.bound[name], initial=0.0))
    return max(rows.scale(name), ldexp(known, _BITS_OF_DENSE_TAIL))


def _fit(
    near: LocalEvaluator, nodes: Nodes, names: Sequence[str], constant: Mapping[str, flint.arb],
    a: Fraction, b: Fraction,
) -> list[list[flint.arb]]:  # fmt: skip
    """Return Chebyshev coefficients of columns on [a, b], from their values at Chebyshev nodes."""
    middle, half = (a + b) / 2, (b - a) / 2
    values = []
    for x in nodes.x:
        t = exact_ball(middle) + exact_ball(half) * x
        row = near(t, middle + half * Fraction(float(x.mid())))
        values.append([row[name] for name in names])
    table = (nodes.transform * flint.arb_mat(values)).transpose().tolist()
    return [
        [constant[name], *[flint.arb(0)] * (NODES - 1)] if name in constant else row
        for name, row in zip(names, table, strict=True)
    ]


def _is_resolved(
    table: Sequence[Sequence[flint.arb]], scales: Mapping[str, float], names: Sequence[str]
) -> bool:
    for name, row in zip(names, table, strict=True):
        tail = sum(abs(float(c.mid())) for c in row[-3:])
        if tail > scales[name] * 2.0**-_BITS_OF_DENSE_TAIL:
            return False
    return True


def _on_grid(
    table: Sequence[Sequence[flint.arb]], grids: Sequence[int], names: Sequence[str]
) -> list[list[tuple[float, float]]]:
    """Round coefficients to the grid of their column, a power of two; return them as hi and lo."""
    out = []
    for name, row, grid in zip(names, table, grids, strict=True):
        pairs = []
        for c in row:
            scaled = c * flint.arb(2) ** grid
            n = (scaled + flint.arb(0.5)).floor()
            if n.unique_fmpz() is None:
                # Either of the two neighbouring integers may be chosen, because the bound of the
                # published value is computed afterwards, so it covers the choice.
                n = (scaled.mid() + flint.arb(0.5)).floor().mid()
            pairs.append(hi_lo(Enclosure.of(dyadic(n) / Fraction(2) ** grid), name))
        out.append(pairs)
    return out


BITS = 192
_REMAINDER_BITS = 128

_DIFFERENCE_BITS = 160
"""Precision of the difference from a Chebyshev piece, whose grid is 2^-112 of the column."""

_HALVINGS_OF_NORMS, _SPANS_OF_ENCLOSURES = 2, 64
"""Halvings of a piece on which a norm has no expansion, and spans of each part that is enclosed."""

_NODES_PER_DEGREE = 2
"""Chebyshev nodes per degree at which a polynomial is evaluated. With this many, the polynomial is
at most 1.42 times its largest value at the nodes."""


def bound_columns(
    run: Trajectory, certificate: Certificate, dense: Dense, constant: Mapping[str, Value]
) -> Dense:
    """Return dense output of `COLUMNS` with its certified bounds.

    The magnitude of a velocity has no expansion where the velocity vanishes or nearly vanishes; it
    is enclosed there.
    """
    names = [c.name for c in COLUMNS]
    if constant.keys() >= set(names):
        return bound_dense(run, (), dense, names, constant)
    try:
        # On a circle around a piece, energies and angles are analytic because the rates are
        # analytic there.
        along = list(expansions(run, Equations.every_column, certificate.along(run)))
        return bound_dense(run, along, dense, names, constant)
    except NotCertifiedError:
        others = [name for name in names if name not in NORMS]
    smooth = expansions(run, Equations.smooth_columns, certificate.along(run))
    bound = {
        **bound_dense(run, smooth, dense, others, constant).bound,
        **bound_dense(run, _norms(run, certificate), dense, NORMS, constant).bound,
    }
    return replace(dense, bound={name: bound[name] for name in names})


def bound_dense(
    run: Trajectory, parts: Iterable[Expansion | Enclosed], dense: Dense, names: Sequence[str],
    constant: Mapping[str, Value],
) -> Dense:  # fmt: skip
    """Return dense output with a certified bound for each piece and each of the columns `names`.

    `parts` are expansions of these columns along all pieces of the candidate.
    """
    _check_shape(run, dense, names)
    breaks = [Fraction(float(t)) for t in dense.breaks]
    bound = np.zeros((len(breaks) - 1, len(names)))
    for expansion in parts:
        for j, (a, b) in enumerate(pairwise(breaks)):
            low, high = max(a, expansion.piece.t0), min(b, expansion.piece.t1)
            if low < high:
                coefficients = [(dense.hi[name][j], dense.lo[name][j]) for name in names]
                found = expansion.distances(coefficients, (a, b), (low, high))
                bound[j] = np.maximum(bound[j], found)
    for m, name in enumerate(names):
        if name in constant:
            bound[:, m] = [
                _constant_distance(constant[name], hi, lo)
                for hi, lo in zip(dense.hi[name], dense.lo[name], strict=True)
            ]
    by_name = {name: np.ascontiguousarray(bound[:, m]) for m, name in enumerate(names)}
    return replace(dense, bound=by_name)


def _check_shape(run: Trajectory, dense: Dense, names: Sequence[str]) -> None:
    """Check that the candidate covers every dense piece, because its bounds hold only there."""
    breaks = dense.breaks
    problem = None
    if breaks.ndim != 1 or len(breaks) < 2 or not np.isfinite(breaks).all():
        problem = "it does not have at least two finite breaks"
    elif breaks[0] != 0 or not (np.diff(breaks) > 0).all():
        problem = "its breaks do not increase from 0"
    elif not run.maneuver.duration <= Fraction(float(breaks[-1])) <= run.breaks[-1]:
        problem = f"it ends at {breaks[-1]:g} s, expected {float(run.maneuver.duration):g} s"
    else:
        shape = dense.hi[names[0]].shape
        for name in names:
            for x in (dense.hi[name], dense.lo[name]):
                if x.dtype != np.float64 or x.shape != shape or len(x) != len(breaks) - 1:
                    problem = f"{name} is not a table of binary64 with a row for each piece"
                elif not np.isfinite(x).all():
                    problem = f"{name} has a coefficient that is not finite"
    if problem:
        raise NotCertifiedError(f"{run.maneuver.name}: the dense output is incomplete: {problem}")


def expansions(
    run: Trajectory, function: cauchy.Function, stretches: Iterable[Stretch]
) -> Iterator[Expansion]:
    """Expand a function along pieces, divided where it is not shown to be analytic around them."""
    expanding = _Expanding(run, function)
    for piece, bounds in stretches:
        yield from cauchy.in_parts(piece, partial(expanding.part, bounds))


def _norms(run: Trajectory, certificate: Certificate) -> Iterator[Expansion | Enclosed]:
    """Expand `NORMS` along pieces; enclose them over the parts where no expansion is found."""
    expanding = _Expanding(run, Equations.norms)
    enclosing = run.equations(NonnegativeRoots(BITS)).norms

    def part(bounds: tuple[Fraction, ...], piece: Piece, depth: int) -> Expansion | Enclosed:
        try:
            return expanding.part(bounds, piece, depth)
        except NotAnalyticError:
            if depth < _HALVINGS_OF_NORMS:
                raise
            return Enclosed(piece, bounds, enclosing)

    for piece, bounds in certificate.along(run):
        yield from cauchy.in_parts(piece, partial(part, bounds))


class _Expanding:
    """Expands a function along pieces around which it is shown to be analytic."""

    def __init__(self, run: Trajectory, function: cauchy.Function) -> None:
        equations, self.on_circles = run.equations(Balls(BITS)), cauchy.circle_equations(run)
        self.at_points = equations.convert(flint.acb, equations.a)
        self.function = function

    def part(self, bounds: tuple[Fraction, ...], piece: Piece, _: int) -> Expansion:
        circle = cauchy.circle_bound(piece, self.function, self.on_circles)
        a = Samples.of(BITS, ceil(_REMAINDER_BITS / log2(circle.radius)), circle.radius)
        with a.precision():
            values = a.coefficients(self.function(self.at_points.over(a), piece.samples(a)))
            # Relative bound on the omitted Taylor terms, plus the relative change of the function
            # from the candidate to the exact motion.
            rest = a.left_out + cauchy.moved(bounds, circle.rho)
            remainders = [(m * rest).upper() for m in circle.values]
        return Expansion(piece, list(map(flint.arb_poly, values)), remainders)


@dataclass(frozen=True)
class Expansion:
    """Taylor polynomials of columns along one piece of the candidate, with remainders."""

    piece: Piece
    polynomials: list[flint.arb_poly]
    remainders: list[flint.arb]

    def distances(
        self, coefficients: Sequence[tuple[np.ndarray, np.ndarray]],
        piece: tuple[Fraction, Fraction], span: tuple[Fraction, Fraction],
    ) -> list[float]:  # fmt: skip
        """Bound the distance of each column from its Chebyshev piece, over a span of time.

        The values of their difference at Chebyshev nodes of the span bound it.
        """
        orders = len(coefficients[0][0])
        degree = max(orders, *map(len, self.polynomials)) - 1
        with working_bits(_DIFFERENCE_BITS):
            x, factor = _nodes(degree)
            (low, high), (a, b) = span, piece
            middle, half = exact_ball((low + high) / 2), exact_ball((high - low) / 2)
            times = [middle + half * t for t in x]
            start, width = exact_ball(self.piece.t0), exact_ball(self.piece.h)
            powers = [[((t - start) / width) ** m for t in times] for m in range(degree + 1)]
            centre, reach = exact_ball((a + b) / 2), exact_ball((b - a) / 2)
            chebyshev = basis([(t - centre) / reach for t in times], orders).transpose()
            stored = flint.arb_mat(
                [
                    [flint.arb(float(p)) + float(q) for p, q in zip(hi, lo, strict=True)]
                    for hi, lo in coefficients
                ]
            )
            own = [[p[m] for m in range(degree + 1)] for p in self.polynomials]
            difference = flint.arb_mat(own) * flint.arb_mat(powers) - stored * chebyshev
            return [
                upward_ball(largest(map(abs, row)) * factor + rest)
                for row, rest in zip(difference.tolist(), self.remainders, strict=True)
            ]


@dataclass(frozen=True)
class Enclosed:
    """Columns that have no expansion along a part of the motion and are enclosed over spans."""

    piece: Piece
    bounds: tuple[Fraction, ...]
    columns: Callable[[Sequence[flint.arb]], list[flint.arb]]

    def distances(
        self, coefficients: Sequence[tuple[np.ndarray, np.ndarray]],
        piece: tuple[Fraction, Fraction], span: tuple[Fraction, Fraction],
    ) -> list[float]:  # fmt: skip
        """Bound the distance of each column from its Chebyshev piece, over a span of time.

        By Markov's inequality, T_k changes over a step by at most k^2 times the step.
        """
        (low, high), (a, b) = span, piece
        step = (high - low) / _SPANS_OF_ENCLOSURES
        with working_bits(BITS):
            unit = flint.arb(2) ** -self.piece.grid
            states = [flint.arb_poly(list(row)) * unit for row in self.piece.rows]
            stored = flint.arb_mat(
                [
                    [flint.arb(float(p)) + float(q) for p, q in zip(hi, lo, strict=True)]
                    for hi, lo in coefficients
                ]
            )
            orders = stored.ncols()
            reach = exact_ball(step / (b - a))
            change = [
                sum(k * k * abs(stored[i, k]) for k in range(orders)) * reach
                for i in range(stored.nrows())
            ]
            found = [flint.arb(0)] * stored.nrows()
            for j in range(_SPANS_OF_ENCLOSURES):
                t0, t1 = low + j * step, low + (j + 1) * step
                start, h = self.piece.t0, self.piece.h
                s = span_ball((t0 - start) / h, (t1 - start) / h)
                state = [
                    flint.arb(0, exact_ball(bound).upper()) + p(s)
                    for p, bound in zip(states, self.bounds, strict=True)
                ]
                u = exact_ball((t0 + t1 - a - b) / (b - a))
                values = (stored * basis([u], orders).transpose()).entries()
                off = zip(self.columns(state), values, change, strict=True)
                apart = (abs(x - y) + z for x, y, z in off)
                found = [x.max(y).upper() for x, y in zip(found, apart, strict=True)]
            return [upward_ball(x) for x in found]


@cache
def _nodes(degree: int) -> tuple[list[flint.arb], flint.arb]:
    """Return nodes, and the largest ratio of a polynomial of this degree to its values at them."""
    count = _NODES_PER_DEGREE * degree
    with working_bits(_DIFFERENCE_BITS):
        return chebyshev_nodes(count), in_between(degree, count)


def _constant_distance(x: Value, hi: np.ndarray, lo: np.ndarray) -> float:
    """Bound the distance of a Chebyshev piece from a constant; only c_0 should differ from 0."""
    rest = sum((abs(Fraction(float(c))) for c in [*hi[1:], *lo[1:]]), Fraction(0))
    return upward(Enclosure.of(x).minus(float(hi[0]), float(lo[0])).size() + rest)


def with_integrals(run: Trajectory, certificate: Certificate) -> Iterator[Stretch]:
    """Yield the pieces of the candidate, extended by the integrals from the start of the motion.

    Raises
    ------
    NotCertifiedError
        The integrands are not shown to be analytic on some piece.
    """
    integrator = _Integrator(run)
    for piece, bounds in certificate.along(run):
        yield from cauchy.in_parts(piece, partial(integrator.stretch, bounds))


class _Integrator:
    """Continues the integrals along the candidate: exact values, and bounds on their errors."""

    def __init__(self, run: Trajectory) -> None:
        self.bits = run.grid + 64
        self.circles = cauchy.circle_equations(run)
        self.equations = run.equations(Balls(self.bits))
        self.at = [Fraction(0)] * len(INTEGRALS)
        self.error = [Fraction(0)] * len(INTEGRALS)

    def stretch(self, bounds: tuple[Fraction, ...], piece: Piece, _: int) -> Stretch:
        """Return a piece extended by the integrals, whose rates must be analytic around it."""
        circle = cauchy.circle_bound(piece, rates_of_integrals, self.circles)
        # With this many terms, Cauchy's estimate of the omitted terms is below the rounding unit of
        # the coefficients.
        length = max(ceil(self.bits / log2(circle.radius)), len(piece.rows[0]))
        a = Samples.of(self.bits, length, circle.radius)
        with a.precision():
            step, unit = exact_ball(piece.h), flint.arb(2) ** -piece.grid
            apart = cauchy.moved(bounds, circle.rho)
            values = rates_of_integrals(self.equations.convert(flint.acb, a), piece.samples(a))
            integrands = a.coefficients([step * x for x in values])
            rows = [self._row(piece, i, c) for i, c in enumerate(integrands)]
            for i, (row, integrand) in enumerate(zip(rows, integrands, strict=True)):
                rest = step * circle.values[i] * (a.left_out + apart)
                off = cauchy.defect([c * unit for c in row], integrand)
                self.error[i] += upper_fraction(off + rest)
                self.at[i] = Fraction(sum(row), 2**piece.grid)
        return Stretch(
            replace(piece, rows=piece.rows + tuple(map(tuple, rows))), bounds + tuple(self.error)
        )

    def _row(self, piece: Piece, i: int, integrand: Sequence[flint.arb]) -> list[int]:
        """Return an integral's polynomial as integers; rounding its start adds to its error."""
        first = round(self.at[i] * 2**piece.grid)
        self.error[i] += abs(self.at[i] - Fraction(first, 2**piece.grid))
        powers = range(1, len(piece.rows[0]))
        return [first, *(to_grid(integrand[m - 1] / m, piece.grid) for m in powers)]


_NOTHING_BITS = 166
"""An enclosure of zero narrower than 2^-166 = 1e-50 is published as zero."""

_SMALLEST_SCALE = 2.0**-40
"""Smallest scale of the dense columns. A column that vanishes (such as the longitudinal force on a
rear wheel without inertia) then has coefficients of zero, because its grid of 2^-152 is far above
the width of its balls."""


def tabulate_motion(
    run: Trajectory, certificate: Certificate, dense: Dense | None = None,
    progress: OnTime = lambda _: None,
) -> tuple[Values, Dense]:  # fmt: skip
    """Tabulate the whole motion along a certified candidate: rows and dense output.

    The dense output is the one passed, or else a new one, with its certified bounds.

    Raises
    ------
    NotCertifiedError
        A column is not shown to be analytic on some piece.
    """
    stretches = list(with_integrals(run, certificate))
    rows = round_motion(run, stretches, progress)
    parts = list(expansions(run, dense_columns, stretches))
    if dense is None:
        scales = {name: max(rows.scale(name), _SMALLEST_SCALE) for name in DENSE_COLUMNS}
        starts = [part.piece.t0 for part in parts]

        def near(t: flint.arb, about: Fraction) -> dict[str, flint.arb]:
            part = parts[max(bisect_right(starts, about) - 1, 0)]
            s = (t - exact_ball(part.piece.t0)) / exact_ball(part.piece.h)
            return {name: p(s) for name, p in zip(DENSE_COLUMNS, part.polynomials, strict=True)}

        dense = interpolate(near, parts[-1].piece.t1, Balls(BITS), scales, {})
    return rows, bound_dense(run, parts, dense, DENSE_COLUMNS, {})


def round_motion(
    run: Trajectory, stretches: Sequence[Stretch], progress: OnTime = lambda _: None
) -> Values:
    """Return the rows of `MOTION_COLUMNS`, rounded.

    hi and lo are zero if the enclosure contains zero and is negligibly narrow.
    """
    names = [c.name for c in MOTION_COLUMNS]
    return round_columns(names, _enclosed(run, stretches, progress), _rounded)


def _enclosed(
    run: Trajectory, stretches: Sequence[Stretch], progress: OnTime
) -> Iterator[dict[str, flint.arb]]:
    """Yield enclosures of all columns of the whole motion, row by row."""
    balls = NonnegativeRoots(run.evaluation_bits)
    starts = [s.piece.t0 for s in stretches]
    at, polynomials = -1, [flint.arb_poly()]
    equations = run.equations(balls)
    with balls.precision():
        for t in row_times(run.maneuver):
            if (i := bisect_right(starts, t) - 1) != at:
                at, polynomials = i, [flint.arb_poly(list(row)) for row in stretches[i].piece.rows]
            piece = stretches[i].piece
            s, unit = exact_ball((t - piece.t0) / piece.h), flint.arb(2) ** -piece.grid
            state = [
                flint.arb(p(s) * unit, exact_ball(bound).upper())
                for p, bound in zip(polynomials, stretches[i].bounds, strict=True)
            ]
            if t == 0:
                # The integrals and the yaw are exactly zero at the start.
                state[6:] = [balls.number(0)] * len(state[6:])
            yield motion_columns(equations, state)
            progress(float(t))


def _rounded(x: flint.arb) -> tuple[float, float, float, bool]:
    """Return hi, lo, their bound, and whether the rounding is decided; NaN if not enclosed."""
    if not x.is_finite():
        return nan, nan, nan, False
    enclosed = Enclosure.of(x)
    hi, lo, is_decided = 0.0, 0.0, True
    if not _is_negligible(enclosed):
        nearest = enclosed.binary64()
        if nearest is not None and _is_negligible(enclosed.minus(nearest)):
            hi = nearest
        else:
            hi, lo, is_decided = nearest_pair(enclosed)
    return hi, lo, few_bits(distance(enclosed, hi, lo)), is_decided


def _is_negligible(x: Enclosure) -> bool:
    """True if an enclosure contains zero and is negligibly narrow."""
    return x.holds_zero and x.high - x.low <= Fraction(1, 2**_NOTHING_BITS)
