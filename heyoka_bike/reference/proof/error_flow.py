"""Propagation of an error over a piece, by the variational equation along the candidate."""

from __future__ import annotations

from dataclasses import dataclass

import flint

from heyoka_bike.numbers.ball_matrices import (
    Vector,
    abs_times,
    fundamental,
    norm,
    perron,
    supremum,
    total,
    turned,
    value,
    weighted,
)

MATRIX_BITS = 128
SIZE = 7
"""State variables, the yaw included."""

CONDITION, RESOLVED = 1e6, 0.1
"""Limits of the condition of Y, and of eta times its square."""

_SPANS = 8


@dataclass(frozen=True)
class Frame:
    """The error lies in ``matrix . box``, abs(box) <= radii."""

    matrix: flint.arb_mat
    radii: Vector

    def bound(self) -> list[flint.arb]:
        """Componentwise bound."""
        return abs_times(self.matrix, self.radii)

    def widened(self, by: Vector) -> Frame:
        """The frame with a box of the given radii added."""
        if all(x == 0 for x in by):
            return self
        with flint.ctx.workprec(MATRIX_BITS):
            return Frame(*turned(self.matrix, self.radii, by))


@dataclass(frozen=True)
class Flow:
    """The solution Y of the variational equation Y' = h J Y, Y(0) = 1, over a piece, nearly.

    Attributes
    ----------
    y, v
        Coefficients of polynomials in s: Y, and V near its inverse.
    weights
        Of the state variables in the norm of the three bounds.
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
    weights: Vector
    defect: flint.arb
    size_inverse: flint.arb
    eta: flint.arb
    condition: flint.arb

    @classmethod
    def of(
        cls, jacobian: list[flint.arb_mat], tail: flint.arb_mat, *, is_centred: bool = False
    ) -> Flow:
        """From the Taylor coefficients of h J and a bound on what they leave out.

        The piece is 0 <= s <= 1, or -1 <= s <= 1 where it is centred.
        """
        weights = perron(jacobian)
        y, defect, v, defect_v = fundamental(jacobian, tail, weights)
        size = size_about_middle if is_centred else _size
        size_y, size_v = size(y, weights), size(v, weights)
        eta = (defect_v * size_y + size_v * defect).upper()
        # Y^-1 is (V Y)^-1 V, if V Y is so near to 1 that it has an inverse.
        size_inverse = size_v / (1 - eta) if eta < 1 else flint.arb.pos_inf()
        return cls(y, v, weights, defect, size_inverse, eta, size_y * size_v)


def size_about_middle(p: list[flint.arb_mat], weights: Vector) -> flint.arb:
    """Bound on the norm of a polynomial for -1 <= s <= 1, by its coefficients."""
    return total(norm(m, weights) for m in p)


def _size(p: list[flint.arb_mat], weights: Vector) -> flint.arb:
    """Bound on the norm of a polynomial for 0 <= s <= 1."""
    return norm(supremum(p), weights)


class Carried:
    """The error over a piece: what comes in through the frame, and what forces add on the way.

    A force at tau reaches s through Y(s) Y(tau)^-1. That product is formed before its absolute
    value is taken: the two factors are large and cancel. Its bound for all s is put together from
    spans: to the middle c of a span by Y(c) V(tau), from there on by Y(s) V(c).
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

    def bounds(self, forces: Vector) -> tuple[Vector, Vector]:
        """Bounds under forces added to e': on abs(e) over the piece, and on their part at its end.

        Every replacement of Y^-1 by V, and the defect D of Y, is charged in norm.
        """
        flow, weights = self.flow, self.flow.weights
        size = weighted(forces, weights)
        kappa = flow.size_inverse * flow.defect
        inside = kappa * kappa.exp() * (self.start + flow.size_inverse * size)
        # Y(s) V(c) is off from Y(s) Y(c)^-1 by `one`; a product of two such by two and its square.
        one = self.size_y * flow.size_inverse * flow.eta
        replaced = one * (1 + 2 * self.size_y * flow.size_inverse + one)
        charge = self.size_y * inside + replaced * size
        charges = [(charge * w).upper() for w in weights]
        over = abs_times(self.push, forces)
        sup = [(x + y + z).upper() for x, y, z in zip(self.incoming, over, charges, strict=True)]
        at_end = abs_times(self.push_end, forces)
        return sup, [(x + y).upper() for x, y in zip(at_end, charges, strict=True)]

    def end(self, added: Vector) -> Frame:
        """The frame at the end."""
        return Frame(*turned(value(self.product, flint.arb(1)), self.frame.radii, added))


def _entrywise(a: flint.arb_mat, b: flint.arb_mat) -> flint.arb_mat:
    """Upper bounds of the larger entry of two nonnegative matrices."""
    return flint.arb_mat([[a[i, j].max(b[i, j]).upper() for j in range(SIZE)] for i in range(SIZE)])
