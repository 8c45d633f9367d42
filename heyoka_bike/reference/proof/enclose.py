"""A rigorous bound on the distance between a candidate trajectory and the exact motion.

The candidate p is any piecewise polynomial; the proof assumes nothing about the run that produced
it. All steps use ball arithmetic (Arb), with the parameters as exact rationals and the tilt as a
ball around a multiple of pi. On a piece of length h, with s = (t - t0) / h:

1. The defect ``delta = p' - h f(p)`` is expanded in s to a length L, from values of f(p) on the
   unit circle (see `analytic`); the sum of its coefficients' absolute values bounds it on
   0 <= s <= 1.
2. The omitted terms are bounded by Cauchy's estimate from the size of f on the circle abs(s) = R.
   There the state is widened by a polydisc of radius rho, so the same numbers bound the derivatives
   of f with respect to the state (Cauchy again) on the whole disc. Analyticity: see `analytic`.
3. The Jacobian J along p is expanded in the same way (dual numbers over complex values).
4. Y is a polynomial that nearly solves ``Y' = h J Y``, Y(0) = 1; its own defect D is bounded.
5. The error is ``e = Y z`` with ``z' = Y^-1 (-D z + q - delta)``, where q, the part of
   ``h (f(p + e) - f(p))`` of second and higher order in e, is bounded by Cauchy's estimate on the
   line through p and p + e. Y contains all of the linear motion, so Gronwall's inequality applies
   only to the tiny D. Y^-1 is bounded by a polynomial V that nearly solves ``V' = -h V J``. From
   piece to piece e is carried by Y(1) in a moving frame (Lohner's QR method), which keeps the bound
   from growing where the motion does not. Jumps between pieces and the distance of the initial
   states are added.

A piece over which Y is badly conditioned, or on which no circle works, is halved, exactly.

The bound of q assumes a bound eps on e. By a fixed point theorem the assumption is true if the
bound obtained for e is not above eps. Statement and proof are in docs/proof.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from math import ceil

import flint
import numpy as np

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, OnTime, Piece, Trajectory
from heyoka_bike.numbers.analytic import NotAnalyticError, Samples
from heyoka_bike.numbers.arithmetic import Balls, exact_ball, upper_fraction
from heyoka_bike.numbers.ball_matrices import (
    BallVector,
    abs_times,
    fundamental,
    identity,
    largest,
    norm,
    perron,
    supremum,
    total,
    turned,
    value,
    weighted,
)
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.reference.proof import cauchy
from heyoka_bike.reference.proof.cauchy import SIZE
from heyoka_bike.system.jobs import OnStage

MATRIX_BITS = 128

CONDITION, RESOLVED = 1e6, 0.1
"""Limits on the condition number of Y, and on eta times its square."""

_SPANS = 8


@dataclass(frozen=True)
class Frame:
    """A set that contains the error: ``matrix . box`` for every box with abs(box) <= radii."""

    matrix: flint.arb_mat
    radii: BallVector

    def bound(self) -> list[flint.arb]:
        """Componentwise bound on the error."""
        return abs_times(self.matrix, self.radii)

    def widened(self, by: BallVector) -> Frame:
        """Return a frame that also contains the sum of this one and a box of the given radii."""
        if all(x == 0 for x in by):
            return self
        with working_bits(MATRIX_BITS):
            return Frame(*turned(self.matrix, self.radii, by))


@dataclass(frozen=True)
class Flow:
    """An approximate solution Y of the variational equation Y' = h J Y, Y(0) = 1, over a piece.

    Attributes
    ----------
    y, v
        Coefficients of polynomials in s: Y, and V, which is close to the inverse of Y.
    weights
        Weights of the state variables in the norm of the three bounds.
    defect
        Bound on Y' - h J Y.
    size_inverse
        Bound on the inverse of Y.
    eta
        Bound on V Y - 1.
    condition
        Bound on the product of the sizes of Y and V.
    """

    y: list[flint.arb_mat]
    v: list[flint.arb_mat]
    weights: BallVector
    defect: flint.arb
    size_inverse: flint.arb
    eta: flint.arb
    condition: flint.arb

    @classmethod
    def of(
        cls, jacobian: list[flint.arb_mat], tail: flint.arb_mat, *, is_centred: bool = False
    ) -> Flow:
        """Construct a flow from the Taylor coefficients of h J and a bound on the omitted terms.

        The piece is 0 <= s <= 1, or -1 <= s <= 1 if it is centred.
        """
        weights = perron(jacobian)
        y, defect, v, defect_v = fundamental(jacobian, tail, weights)
        size = size_about_middle if is_centred else _size
        size_y, size_v = size(y, weights), size(v, weights)
        eta = (defect_v * size_y + size_v * defect).upper()
        # Y^-1 = (V Y)^-1 V, provided that V Y is close enough to the identity to be invertible.
        size_inverse = size_v / (1 - eta) if eta < 1 else flint.arb.pos_inf()
        return cls(y, v, weights, defect, size_inverse, eta, size_y * size_v)


def size_about_middle(p: list[flint.arb_mat], weights: BallVector) -> flint.arb:
    """Return a bound on the norm of a polynomial for -1 <= s <= 1, from its coefficients."""
    return total(norm(m, weights) for m in p)


def _size(p: list[flint.arb_mat], weights: BallVector) -> flint.arb:
    """Return a bound on the norm of a polynomial for 0 <= s <= 1."""
    return norm(supremum(p), weights)


class Carried:
    """The error over a piece: the part that it has at the start, and the part that forces add.

    A force at tau acts at s through Y(s) Y(tau)^-1. The product is formed before its absolute value
    is taken, because the two factors are large and cancel. Its bound for all s is assembled from
    spans: up to the middle c of a span from Y(c) V(tau), beyond it from Y(s) V(c).
    """

    def __init__(self, flow: Flow, frame: Frame) -> None:
        self.flow, self.frame = flow, frame
        weights = flow.weights
        self.product = [m * frame.matrix for m in flow.y]
        self.incoming = abs_times(supremum(self.product), frame.radii)
        self.start = weighted(frame.bound(), weights)
        self.size_y = norm(supremum(flow.y), weights)
        y_end = value(flow.y, flint.arb(1))
        self.push_end = supremum([y_end * m for m in flow.v])
        self.push = _entrywise(self.push_end, self.push_end)
        for j in range(_SPANS):
            low, high = flint.arb(j) / _SPANS, flint.arb(j + 1) / _SPANS
            c = (low + high) / 2
            y, v = value(flow.y, c), value(flow.v, c)
            there = supremum([y * m for m in flow.v], high=high)
            onward = supremum([m * v for m in flow.y], 1, low=low, high=high)
            self.push = _entrywise(self.push, onward * there)

    def bounds(self, forces: BallVector) -> tuple[BallVector, BallVector]:
        """Bound abs(e) over the piece, and the part of e due to `forces` at its end.

        Replacing Y^-1 with V, and the defect D of Y, each add a bound in norm.
        """
        flow, weights = self.flow, self.flow.weights
        size = weighted(forces, weights)
        kappa = flow.size_inverse * flow.defect
        inside = kappa * kappa.exp() * (self.start + flow.size_inverse * size)
        # `one` bounds the change of a factor Y(s) Y(c)^-1 if V(c) replaces Y(c)^-1. The size of
        # such a factor is at most `size_y` times `size_inverse`. So a product of two factors
        # changes by at most twice `one` times this size, plus `one` squared.
        one = self.size_y * flow.size_inverse * flow.eta
        replaced = one * (1 + 2 * self.size_y * flow.size_inverse + one)
        charge = self.size_y * inside + replaced * size
        charges = [(charge * w).upper() for w in weights]
        over = abs_times(self.push, forces)
        sup = [(x + y + z).upper() for x, y, z in zip(self.incoming, over, charges, strict=True)]
        at_end = abs_times(self.push_end, forces)
        return sup, [(x + y).upper() for x, y in zip(at_end, charges, strict=True)]

    def end(self, added: BallVector) -> Frame:
        """Return the frame at the end of the piece; `added` is the part that the forces add."""
        return Frame(*turned(value(self.product, flint.arb(1)), self.frame.radii, added))


def _entrywise(a: flint.arb_mat, b: flint.arb_mat) -> flint.arb_mat:
    """Return, for each entry, an upper bound of the larger entry of two nonnegative matrices."""
    return flint.arb_mat([[a[i, j].max(b[i, j]).upper() for j in range(SIZE)] for i in range(SIZE)])


_TRIALS = 20
_MATRIX_LENGTHS = (40, 64)
"""Orders of Y that are tried."""


def enclose(trajectory: Trajectory, progress: OnTime | None = None) -> Certificate:
    """Bound the distance of the exact motion from a candidate, over its whole time.

    Raises
    ------
    NotCertifiedError
        The step, the time and the inequality that failed.
    """
    _check_shape(trajectory)
    prover = Prover(trajectory)
    frame = prover.initial_frame()
    bounds = []
    for i in range(trajectory.steps):
        sup, frame = prover.piece(trajectory.piece(i), frame)
        frame = frame.widened(prover.jump(i))
        bounds.append(_fractions(sup))
        if progress is not None:
            progress(float(trajectory.breaks[i + 1]))
    # The bound over the last piece is also valid at its end, where it may be smaller than the bound
    # that the frame gives. So use the smaller of the two bounds.
    with working_bits(MATRIX_BITS):
        end = tuple(map(min, _fractions(frame.bound()), bounds[-1]))
    return Certificate(trajectory.states, tuple(bounds), end)


def enclosed(trajectory: Trajectory, report: OnStage) -> Certificate:
    """Run `enclose` as a job, whose stage is ``certify``."""
    return enclose(trajectory, lambda t: report("certify", t))


def _check_shape(run: Trajectory) -> None:
    breaks = run.breaks
    problem = None
    if breaks[0] != 0 or breaks[-1] < run.maneuver.duration:
        problem = (
            f"it covers {float(breaks[0]):g} to {float(breaks[-1]):g} s, "
            f"expected 0 to {float(run.maneuver.duration):g} s"
        )
    elif any(a >= b for a, b in pairwise(breaks)):
        problem = "its breaks do not increase"
    elif len(run.pieces) != len(breaks) - 1:
        problem = f"it has {len(run.pieces)} pieces for {len(breaks) - 1} intervals"
    elif any(len(piece) != SIZE for piece in run.pieces):
        problem = f"a piece does not have {SIZE} state variables"
    if problem:
        raise NotCertifiedError(f"{run.maneuver.name}: the candidate is incomplete: {problem}")


class Prover:
    """Carries the bound on the error from piece to piece along a candidate."""

    matrix_bits = MATRIX_BITS
    """Working precision of all computations with Y."""

    def __init__(self, run: Trajectory) -> None:
        self.run = run
        self.too_long = run.breaks[-1] * 2
        self.bits = run.grid + 64
        longest = max(len(row) for piece in run.pieces for row in piece)
        # Number of terms L such that R^-L is below the rounding unit 2^-grid of the candidate, for
        # the radius R of every circle that is tried.
        self.lengths = {
            radius: max(ceil((run.grid + 16) / np.log2(radius)), longest) + 2
            for radius in cauchy.RADII
        }
        self.circles = cauchy.circle_equations(run)
        self.matrix = run.equations(Balls(self.matrix_bits))
        self.high = run.equations(Balls(self.bits))

    def initial_frame(self) -> Frame:
        """Return a frame that contains the error of the candidate's initial state."""
        run = self.run
        with self.high.precision():
            start = initial_state(self.high, run.maneuver)
            unit = flint.arb(2) ** -run.grid
            first = [row[0] * unit for row in run.pieces[0]]
            distance = [abs(x - y).upper() for x, y in zip(start, first, strict=True)]
        with working_bits(MATRIX_BITS):
            return Frame(identity(SIZE), [x.upper() for x in distance])

    def piece(self, piece: Piece, frame: Frame) -> tuple[BallVector, Frame]:
        """Bound the error over a piece, divided if needed; return bound and final frame."""
        self.frame = frame
        parts = zip(*cauchy.in_parts(piece, self._part), strict=True)
        return [reduce(flint.arb.max, bounds) for bounds in parts], self.frame

    def _part(self, piece: Piece, depth: int) -> BallVector:
        # Halve a piece at once if it is as long as the last piece over which the proof failed.
        if depth < cauchy.DEPTH and piece.h >= self.too_long:
            raise cauchy.TooLongError
        try:
            rim = cauchy.circle_bound(piece, Equations.rates_with_yaw, self.circles)
            near = cauchy.circle_bound(piece, Equations.rates_with_yaw, self.circles, (1,))
            sup, self.frame = self.whole(piece, self.frame, rim, near)
        except (cauchy.TooLongError, NotAnalyticError):
            self.too_long = piece.h
            raise
        return sup

    def whole(
        self, piece: Piece, frame: Frame, rim: cauchy.Circle, near: cauchy.Circle
    ) -> tuple[BallVector, Frame]:
        """Bound the error over a whole piece, using two circles; also return the final frame."""
        with working_bits(self.matrix_bits):
            carried = Carried(self.flow(piece, rim), frame)
        delta = self._defect(piece, rim)
        with working_bits(self.matrix_bits):
            step = exact_ball(piece.h)
            sup, added = carried.bounds(delta)
            for _ in range(_TRIALS):
                eps = [2 * x for x in sup]
                reach = largest(x / y for x, y in zip(eps, near.rho, strict=True))
                if not reach < 0.5:
                    break
                # Bound on the terms of f of second and higher order in the error e, by Cauchy's
                # estimate in one variable along the line through p.
                beyond = [2 * step * m * reach**2 for m in near.values]
                forces = [d + m for d, m in zip(delta, beyond, strict=True)]
                sup, added = carried.bounds(forces)
                if all(x < y or x == 0 for x, y in zip(sup, eps, strict=True)):
                    return sup, carried.end(added)
            raise cauchy.refused(
                piece,
                f"the error bound is {_show(reach)} of the polydisc's radius, expected less than "
                "1/2",
            )

    def flow(self, piece: Piece, rim: cauchy.Circle, lengths: Sequence[int] = ()) -> Flow:
        """Return the flow over a piece, at the first of some orders that resolves Y."""
        tried = lengths or _MATRIX_LENGTHS
        for length in tried:
            jacobian, tail = self._jacobian(piece, rim, length)
            flow = Flow.of(jacobian, tail)
            if not flow.condition < CONDITION:
                raise cauchy.TooLongError(
                    f"the condition number of the matrix Y is {_show(flow.condition)}, expected "
                    f"less than {CONDITION}"
                )
            if flow.eta * flow.condition**2 < RESOLVED:
                return flow
        raise cauchy.TooLongError(f"the matrix Y is not resolved at order {tried[-1]}")

    def jump(self, i: int) -> BallVector:
        """Return the jump between the end of piece i and the start of the next piece."""
        run = self.run
        if i + 1 == run.steps:
            return [flint.arb(0)] * SIZE
        with working_bits(MATRIX_BITS):
            unit = flint.arb(2) ** -run.grid
            return [
                (abs(flint.arb(sum(now) - after[0])) * unit).upper()
                for now, after in zip(run.pieces[i], run.pieces[i + 1], strict=True)
            ]

    def _defect(self, piece: Piece, rim: cauchy.Circle) -> list[flint.arb]:
        """Bound abs(p' - h f(p)) over the piece, by state variable."""
        a = Samples.of(self.bits, self.lengths[rim.radius], rim.radius)
        with a.precision():
            unit = flint.arb(2) ** -piece.grid
            step = exact_ball(piece.h)
            equations = self.high.convert(flint.acb, a)
            rates = a.coefficients(equations.rates_with_yaw(piece.samples(a)))
            bounds = []
            for row, rate, biggest in zip(piece.rows, rates, rim.values, strict=True):
                inside = cauchy.defect([c * unit for c in row], [step * c for c in rate])
                bound = (inside + step * biggest * a.left_out).upper()
                if not bound.is_finite():
                    raise cauchy.refused(piece, "the defect is not finite")
                bounds.append(bound)
            return bounds

    def _jacobian(
        self, piece: Piece, rim: cauchy.Circle, length: int
    ) -> tuple[list[flint.arb_mat], flint.arb_mat]:
        """Return Taylor coefficients of h J along the piece, and a bound on the omitted terms."""
        a = Samples.of(self.matrix_bits, length, rim.radius)
        duals = Duals(a)
        with a.precision():
            step = exact_ball(piece.h)
            equations = self.matrix.convert(flint.acb, duals)
            values = equations.rates_with_yaw(duals.variables(piece.samples(a)))
            slopes = [x.slopes if isinstance(x, Dual) else [0] * SIZE for x in values]
            rest = step * a.left_out
            # No rate depends on the yaw. So the last column of the matrix, which contains the
            # derivatives with respect to the yaw, is zero.
            tail = flint.arb_mat(
                [[*((rest * f / x).upper() for x in rim.rho[:-1]), 0] for f in rim.values]
            )
            return [m * step for m in a.matrices(slopes)], tail


def _fractions(bounds: Sequence[flint.arb]) -> tuple[Fraction, ...]:
    """Return the upper bounds of balls as exact fractions."""
    return tuple(map(upper_fraction, bounds))


def _show(x: flint.arb) -> str:
    return str(x.mid().str(3, radius=False))
