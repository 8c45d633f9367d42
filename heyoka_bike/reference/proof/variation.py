"""Derivatives of the state with respect to the unknowns along the exact motion, with bounds.

The matrix S of derivatives satisfies ``S' = J S + g``, where J is the derivative of the equations
of motion with respect to the state. g is their derivative with respect to the constants, times the
derivatives of the constants with respect to the unknowns. Both are taken along the exact motion x.
Each piece of the candidate p is treated about its middle, with u = (t - middle) / h, -1 <= u <= 1:

1. h J and h g along p are expanded in u, from values on the unit circle (see `analytic`). Cauchy's
   estimate on a circle and a polydisc of states and constants bounds the omitted terms, and the
   effect of the distance of x from p (see `cauchy`).
2. Y nearly solves ``Y' = h J Y``, Y(0) = 1, with a defect D, and p ``p' = h J p + h g``, p(0) = 0,
   each bounded by its coefficients. With the constant C that joins it to the previous piece,
   q = Y C + p nearly solves the equation; f is its residual.
3. S - q = Y z with ``z' = Y^-1 (f - D z)``: Y contains all of the linear motion, so Gronwall's
   inequality applies only to D.
4. From piece to piece S - q is carried by Y(1) Y(-1)^-1 in a moving frame, as in `enclose`. One box
   bounds it for every unknown, because each unknown has a unit of its own.

A piece on which no circle works, or over which Y is badly conditioned, is halved, exactly.

The unknowns are those of `structure.UNKNOWNS`: 26 parameters and five initial conditions. The
derivatives of constants and initial state are exact: dual numbers over fractions, then over the
requested number type.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from math import ceil, frexp, log2
from typing import Any

import flint

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.equations.constants import Assembly, Constants, constants_of
from heyoka_bike.bicycle.equations.initial import pitch_at_start, varied_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Certificate, Piece, Trajectory
from heyoka_bike.numbers.analytic import Samples
from heyoka_bike.numbers.arithmetic import Arithmetic, Balls, Number, exact_ball, value_of
from heyoka_bike.numbers.ball_matrices import (
    BallVector,
    abs_times,
    identity,
    largest,
    norm,
    solution,
    total,
    value,
)
from heyoka_bike.numbers.dual import Dual, Duals, Traced, Traces
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.reference.proof import cauchy
from heyoka_bike.reference.proof.cauchy import SIZE, Function
from heyoka_bike.reference.proof.enclose import CONDITION, RESOLVED, Flow, Frame, size_about_middle

COUNT = len(PARAMETERS) + len(START)


@dataclass(frozen=True)
class Varied:
    """Constants and initial state of a motion, with derivatives with respect to the unknowns.

    Attributes
    ----------
    k : Constants
    state : list
        State at t = 0, the yaw last.
    """

    k: Constants
    state: list[Number]

    @classmethod
    def of(
        cls, bicycle: Bicycle, maneuver: Maneuver, pitch: Number, a: Arithmetic, *, is_regular: bool
    ) -> Varied:
        """Construct the dual numbers in the number type of `a`; `pitch` is the initial pitch."""
        duals = Duals(a)
        symbols = list(PARAMETERS)
        p = {s: _unknown(x.rational, symbols.index(s)) for s, x in bicycle.values.items()}
        tilt = _unknown(a.number(bicycle["lam"]), symbols.index("lam"))
        k = constants_of(p, tilt, duals, is_vertical=bicycle["lam"].is_zero)
        start = {
            key: _unknown(a.number(getattr(maneuver, key)), len(symbols) + i)
            for i, key in enumerate(START)
        }
        return cls(k, varied_state(k, duals, start, pitch, is_regular=is_regular))

    def columns(self, equations: Equations) -> Mapping[str, Number]:
        """Return all columns at t = 0, as dual numbers."""
        return replace(equations, k=self.k, a=Duals(equations.a)).columns(self.state)

    def is_smooth(self, unknown: int) -> bool:
        """True if the equations have a derivative with respect to an unknown.

        The equations contain the ratio of two inertias of an assembly. Both are zero if all of its
        mass lies on a line along the steer axis, and then the effect of changing one of them has no
        limit.
        """
        return not any(_moves(x, unknown) for x in (self.k.rear, self.k.front))


@dataclass(frozen=True)
class Unknowns:
    """Derivatives of constants and initial state with respect to unknowns, in their units.

    Attributes
    ----------
    varied : Varied
    smooth : tuple of int
        The unknowns with respect to which there are derivatives.
    units : tuple of int
        Exponents of 2: the unit of each unknown, chosen so that its largest entry is between 1/2
        and 1.
    constants : tuple of int
        Indices of the constants that depend on unknowns.
    by_constant : arb_mat
        Derivatives of these constants, one row per constant.
    start : arb_mat
        Derivatives of the state at t = 0.
    """

    varied: Varied
    smooth: tuple[int, ...]
    units: tuple[int, ...]
    constants: tuple[int, ...]
    by_constant: flint.arb_mat
    start: flint.arb_mat

    @classmethod
    def of(cls, run: Trajectory, equations: Equations) -> Unknowns:
        """Compute the derivatives for a run, in the precision of its equations in balls."""
        with equations.precision():
            pitch = pitch_at_start(equations, run.maneuver)
            varied = Varied.of(
                run.bicycle, run.maneuver, pitch, equations.a, is_regular=run.is_regular
            )
            numbers: list[Number] = []
            varied.k.convert(numbers.append)
            smooth = tuple(i for i in range(COUNT) if varied.is_smooth(i))
            rows = [[slope(x, i) for i in smooth] for x in numbers]
            constants = tuple(j for j, row in enumerate(rows) if any(s != 0 for s in row))
            rows = [rows[j] for j in constants]
            start = [[slope(x, i) for i in smooth] for x in varied.state]
            sizes = [
                largest(abs(flint.arb(x)) for x in column)
                for column in zip(*start, *rows, strict=True)
            ]
            units = tuple(-frexp(float(x.mid()))[1] for x in sizes)

            def scaled(table: list[list[Number]]) -> flint.arb_mat:
                return flint.arb_mat(
                    [
                        [x * flint.arb(2) ** e for x, e in zip(row, units, strict=True)]
                        for row in table
                    ]
                )

            return cls(varied, smooth, units, constants, scaled(rows), scaled(start))

    def gradients(
        self, function: Function, equations: Equations, a: Arithmetic, state: Sequence[Number]
    ) -> list[list[Number]]:
        """Return derivatives of a function's values with respect to the state and `constants`.

        They are in the number type of `a`, to which the constants of `equations` are converted. A
        derivative with respect to something that a value does not depend on is the integer 0. There
        are many variables, so differentiation runs backward from the values.
        """
        traces, numbers = Traces(a), list[Number]()

        def constant(x: Number) -> Number:
            numbers.append(Traced(x) if len(numbers) in self.constants else x)
            return numbers[-1]

        k, by_state = equations.k.convert(constant), [Traced(x) for x in state]
        variables = [*by_state, *(numbers[j] for j in self.constants)]
        values = function(replace(equations.over(traces), k=k), by_state)
        return [traces.gradient(x, variables) for x in values]


def slope(x: Number, unknown: int) -> Number:
    """Return the derivative of a number with respect to an unknown."""
    return x.slopes[unknown] if isinstance(x, Dual) else 0


def _unknown(value: Number, i: int) -> Dual:
    return Dual(value, tuple(1 if i == j else 0 for j in range(COUNT)))


def _moves(x: Assembly, unknown: int) -> bool:
    if value_of(x.i33) != 0:
        return False
    return any(slope(inertia, unknown) != 0 for inertia in (x.i13, x.i33))


_RADII_OF_CIRCLES = (10, 8, 6, 4)
"""Radii of the circles tried, in half lengths of the piece."""

_REACH = Fraction(1, 2**8)
"""Radius of the polydisc around the constants, relative to each of them."""

BITS = 192
"""Precision. High-order coefficients are as uncertain as low-order ones, so many bits are
needed."""

_BITS_OF_VARIATION_TAIL = 164
"""The truncation error of the expansions is below 2^-164 where it depends on constants."""

_SMALL, _SMALLER = 2, 64
"""After `_SMALL` halvings the polydisc is divided by `_SMALLER`: for bicycles about to fall, see
`cauchy`."""

_YAW_RATE = [c.name for c in COLUMNS].index("yaw_rate")


@dataclass(frozen=True)
class Variation:
    """The derivatives of the state over a piece, -1 <= u <= 1, in units of the unknowns.

    Attributes
    ----------
    piece : Piece
        The right half of the piece: its t0 is the middle, and its h half the length [s].
    q : list of arb_mat
        Enclosures of the coefficients of an exact polynomial, of shape (state, unknowns).
    bound : list of arb
        Bound on abs(S - q), by state variable, valid for every unknown.
    radius : int
        Radius of a circle in u inside of which the columns are analytic.
    sizes : list of arb
        Bound on the columns on the circle, for states and constants in a polydisc.
    rho : list of arb
        Radii of the polydisc of states. Derivatives at its centre are bounded by sizes / rho.
    pull : arb
        Factor for the constants: sizes * pull bounds their contribution, for every unknown.
    off : arb
        Fraction of these bounds that bounds the error of the expansions along the exact motion.
    """

    piece: Piece
    q: list[flint.arb_mat]
    bound: BallVector
    radius: int
    sizes: BallVector
    rho: BallVector
    pull: flint.arb
    off: flint.arb


def variations(
    run: Trajectory, certificate: Certificate, unknowns: Unknowns
) -> Iterator[Variation]:
    """Yield the derivatives along all pieces of a candidate.

    Raises
    ------
    NotCertifiedError
        The proof does not work over some piece.
    """
    prover = _Prover(run, unknowns)
    for piece, bounds in certificate.along(run):
        yield from prover.piece(piece, bounds)


class _Prover:
    """Carries the derivatives along the candidate, and the frame that contains their errors."""

    def __init__(self, run: Trajectory, unknowns: Unknowns) -> None:
        self.unknowns = unknowns
        self.circles = cauchy.circle_equations(run)
        equations = run.equations(Balls(BITS))
        self.at_points = equations.convert(flint.acb, equations.a)
        numbers: list[flint.arb] = []
        equations.k.convert(numbers.append)
        with working_bits(BITS):
            reach = exact_ball(_REACH)
            self.reach = [flint.arb(0)] * len(numbers)
            for j in unknowns.constants:
                self.reach[j] = reach if numbers[j] == 0 else (abs(numbers[j]) * reach).upper()
            self.pull = largest(
                total(
                    abs(unknowns.by_constant[i, u]) / self.reach[j]
                    for i, j in enumerate(unknowns.constants)
                )
                for u in range(unknowns.by_constant.ncols())
            )
            self.q = unknowns.start.mid()
            self.frame = Frame(identity(SIZE), _apart(unknowns.start, self.q))

    def piece(self, piece: Piece, bounds: Sequence[Fraction]) -> Iterator[Variation]:
        """Yield the derivatives over a piece, divided if it is too long."""
        return cauchy.in_parts(
            piece,
            lambda part, depth: self._whole(part, bounds, _SMALLER if depth >= _SMALL else 1),
        )

    def _whole(self, piece: Piece, bounds: Sequence[Fraction], smaller: int) -> Variation:
        """Return the derivatives over a piece; `smaller` divides the polydisc of the constants."""
        # In the variable of its right half, a piece extends from -1 to 1: 0 is its middle, and 1
        # its end.
        _, centred = piece.halves()
        circle = cauchy.circle_bound(
            centred, partial(self._widened, smaller), self.circles, _RADII_OF_CIRCLES
        )
        pull = self.pull * smaller
        steepest = float((largest(circle.values[: SIZE - 1]) * pull).mid())
        length = ceil((_BITS_OF_VARIATION_TAIL + log2(steepest)) / log2(circle.radius))
        a = Samples.of(BITS, length, circle.radius)
        jacobian, forcing = self._linear(centred, a)
        with working_bits(BITS):
            step = exact_ball(centred.h)
            off = (a.left_out + 4 * cauchy.moved(bounds, circle.rho)).upper()
            rates = [*range(SIZE - 1), SIZE - 1 + _YAW_RATE]
            sizes = [step * circle.values[i] * off for i in rates]
            tail = flint.arb_mat([[(m / x).upper() for x in circle.rho] for m in sizes])
            tail_g = [(m * pull).upper() for m in sizes]
            flow = Flow.of(jacobian, tail, is_centred=True)
            if not flow.condition < CONDITION:
                raise cauchy.TooLongError("Y is badly conditioned")
            if not flow.eta * flow.condition**2 < RESOLVED:
                raise cauchy.TooLongError("Y is not resolved")
            p, force = _solution(jacobian, forcing, tail, tail_g, flow.weights)
            q, bound = self._carry(flow, p, force)
            sizes = circle.values[SIZE - 1 :]
            return Variation(centred, q, bound, circle.radius, sizes, circle.rho, pull, off)

    def _carry(
        self, flow: Flow, p: list[flint.arb_mat], force: flint.arb
    ) -> tuple[list[flint.arb_mat], BallVector]:
        """Return the derivatives over a piece and the bound on their error, and advance to its end.

        `p` is a near solution with residual `force`.
        """
        y, weights, defect = flow.y, flow.weights, flow.defect
        size_y = size_about_middle(y, weights)
        minus, plus = flint.arb(-1), flint.arb(1)
        back = value(y, minus).inv()
        # Solution of the variational equation that continues the derivatives at the end of the
        # previous piece.
        c = (back * (self.q - value(p, minus))).mid()
        q = [m * c + n for m, n in zip(y, p, strict=True)]
        force += defect * _size(c, weights)
        frame = self.frame.widened(_apart(value(q, minus), self.q))
        # Gronwall's inequality bounds z by its size at -1. Over the piece, z changes by at most
        # `drift`.
        start = largest(x / w for x, w in zip(abs_times(back, frame.bound()), weights, strict=True))
        kappa = flow.size_inverse * defect
        push = flow.size_inverse * force
        drift = 2 * (kappa * (2 * kappa).exp() * (start + 2 * push) + push)
        added = [(size_y * drift * w).upper() for w in weights]
        incoming = back * frame.matrix
        over = [flint.arb(0)] * SIZE
        for m in y:
            over = [x + e for x, e in zip(over, abs_times(m * incoming, frame.radii), strict=True)]
        bound = [(x + e).upper() for x, e in zip(over, added, strict=True)]
        end = value(q, plus)
        self.q = end.mid()
        rounding = _apart(end, self.q)
        self.frame = Frame(value(y, plus) * incoming, frame.radii).widened(
            [x + e for x, e in zip(added, rounding, strict=True)]
        )
        return q, bound

    def _widened(self, smaller: int, equations: Equations, state: Sequence[Number]) -> list[Number]:
        """Return rates and columns on a circle, as balls for all constants in their polydisc."""
        reach = iter(self.reach)
        rim: Any = equations.a

        def widen(x: flint.arb) -> Number:
            r = next(reach)
            wide = flint.arb(0, r / smaller)
            return x if r == 0 else rim.value(flint.acb(x + wide, wide))

        return _rates_and_columns(replace(equations, k=equations.k.convert(widen)), state)

    def _linear(self, piece: Piece, a: Samples) -> tuple[list[flint.arb_mat], list[flint.arb_mat]]:
        """Return Taylor coefficients of h J along a piece, and of h g for the unknowns."""
        with a.precision():
            state, step = piece.samples(a), exact_ball(piece.h)
            slopes = self.unknowns.gradients(Equations.rates_with_yaw, self.at_points, a, state)
            jacobian = a.matrices([row[:SIZE] for row in slopes])
            by_constant = a.matrices([row[SIZE:] for row in slopes])
            forcing = [m * self.unknowns.by_constant * step for m in by_constant]
            return [m * step for m in jacobian], forcing


def _rates_and_columns(equations: Equations, state: Sequence[Number]) -> list[Number]:
    """Return the rates of the state without the yaw, and the columns, which include its rate."""
    return [*equations.rates(state), *equations.every_column(state)]


def _solution(
    a: list[flint.arb_mat], g: list[flint.arb_mat], tail: flint.arb_mat, tail_g: BallVector,
    weights: BallVector,
) -> tuple[list[flint.arb_mat], flint.arb]:  # fmt: skip
    """Return a polynomial p that nearly solves p' = a p + g, p(0) = 0, in exact numbers.

    Also return a bound on the norm of a p + g - p' for -1 <= u <= 1 and the worst unknown, where a
    and g may be off by the tails.
    """
    p, left_over = solution(a, 0 * g[0], g)
    defect = _size(left_over, weights) + _size(g[-1], weights)
    sizes = [_size(x, weights) for x in p]
    # Bound on the terms of the product of a and p from order len(a) - 1 on. p' has no terms of
    # these orders, so here the product is the whole defect.
    for j, x in enumerate(a):
        defect += norm(x, weights) * total(sizes[len(a) - 1 - j :])
    defect += norm(tail, weights) * total(sizes)
    defect += largest(x / w for x, w in zip(tail_g, weights, strict=True))
    return p, defect


def _size(m: flint.arb_mat, weights: BallVector) -> flint.arb:
    """Return the weighted maximum norm of the largest column."""
    return largest(x / w for x, w in zip(_rows(m), weights, strict=True))


def _apart(x: flint.arb_mat, y: flint.arb_mat) -> BallVector:
    """Bound the rows of abs(x - y), for every column."""
    return _rows(x - y)


def _rows(m: flint.arb_mat) -> BallVector:
    """Return the largest absolute value of each row."""
    return [largest(abs(m[i, j]) for j in range(m.ncols())) for i in range(m.nrows())]
