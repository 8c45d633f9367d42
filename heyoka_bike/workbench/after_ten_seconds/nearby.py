"""All motions that start in a small box: how far they stay from a candidate, and their derivatives.

The box is what the error of `enclose` begins with, so its bound holds for every one of them. On a
piece, with Y and its defect D as there, the derivative of any of these motions x by its state where
the piece begins is ``Y Z`` with ``Z' = Y^-1 (h (J(x) - J(p)) Y - D) Z``, Z(0) = 1: near Y, by
Gronwall's inequality. J moves little from p to x: on the polydisc of half the radii around p it is
at most 2 M / rho (see `cauchy`), and on the line from p through x Cauchy's estimate in one variable
bounds what it adds. Derivatives over several pieces are products.
"""

from __future__ import annotations

from dataclasses import dataclass

import flint

from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, Piece, Trajectory
from heyoka_bike.numbers.arithmetic import exact_ball, upper_fraction
from heyoka_bike.numbers.ball_matrices import Vector, identity, largest, norm, supremum, value
from heyoka_bike.reference.proof.cauchy import Circle, refused
from heyoka_bike.reference.proof.enclose import Prover
from heyoka_bike.reference.proof.error_flow import SIZE, Flow, Frame

_LENGTH = 96
"""Order of Y, whose defect is then below the bits of the matrices."""

_BITS = 192
"""The smallest multiplier is 7e-6, and 22 of its digits are wanted: 92 bits, in a product over
sixteen pieces whose enclosures grow by a factor of up to 11 each, 55 bits."""


@dataclass(frozen=True)
class Nearby:
    """Motions near a candidate.

    Attributes
    ----------
    certificate : Certificate
        Bounds that hold for each of them.
    """

    certificate: Certificate
    _parts: tuple[_FlowPart, ...]

    def derivative(self, time: flint.arb) -> flint.arb_mat:
        """Of the state at a time by that at the start, both with the yaw; for each motion.

        Raises
        ------
        NotCertifiedError
            The time, a ball, is not inside one part of a piece.
        """
        with flint.ctx.workprec(_BITS):
            product = identity(SIZE)
            for part in self._parts:
                s = (time - exact_ball(part.piece.t0)) / exact_ball(part.piece.h)
                if s > 0 and s < 1:
                    return part.derivative(s) * product
                product = part.derivative(flint.arb(1)) * product
        raise NotCertifiedError(f"found time {time}, expected one inside a piece")


@dataclass(frozen=True)
class _FlowPart:
    """A piece, or what was halved of it; Y, and how far the derivative may be from it."""

    piece: Piece
    flow: Flow
    apart: flint.arb

    def derivative(self, s: flint.arb) -> flint.arb_mat:
        """By the state where the part begins."""
        y, w = value(self.flow.y, s), self.flow.weights
        return flint.arb_mat(
            [
                [y[i, j] + flint.arb(0, (self.apart * w[i] / w[j]).upper()) for j in range(SIZE)]
                for i in range(SIZE)
            ]
        )


def nearby(run: Trajectory, radii: Vector) -> Nearby:
    """The motions whose start is within `radii` of the candidate's, state by state.

    Raises
    ------
    NotCertifiedError
        A piece over which the proof does not work.
    """
    prover = _FlowKeeper(run)
    frame = Frame(identity(SIZE), radii)
    bounds = []
    for i in range(run.steps):
        sup, frame = prover.piece(run.piece(i), frame)
        frame = frame.widened(prover.jump(i))
        bounds.append(tuple(map(upper_fraction, sup)))
    return Nearby(Certificate(run.states, tuple(bounds), bounds[-1]), tuple(prover.parts))


class _FlowKeeper(Prover):
    """Keeps the flow of each part."""

    matrix_bits = _BITS

    def __init__(self, run: Trajectory) -> None:
        super().__init__(run)
        self.parts: list[_FlowPart] = []

    def whole(self, piece: Piece, frame: Frame, rim: Circle, near: Circle) -> tuple[Vector, Frame]:
        sup, end = super().whole(piece, frame, rim, near)
        with flint.ctx.workprec(_BITS):
            flow = self.flow(piece, rim, (_LENGTH,))
            reach = largest(x / y for x, y in zip(sup, near.rho, strict=True))
            if not 4 * reach <= 1:
                raise refused(piece, "the motions leave a quarter of the polydisc")
            # The yaw, the last of the state, is not in J.
            step = exact_ball(piece.h)
            moved = flint.arb_mat(
                [[*(8 * step * m * reach / x for x in near.rho[:6]), 0] for m in near.values]
            )
            size = norm(supremum(flow.y), flow.weights)
            rest = flow.defect + norm(moved, flow.weights) * size
            kappa = flow.size_inverse * rest
            self.parts.append(_FlowPart(piece, flow, (size * kappa * kappa.exp()).upper()))
        return sup, end
