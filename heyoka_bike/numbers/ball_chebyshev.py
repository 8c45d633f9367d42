"""Interpolation at Chebyshev nodes in ball arithmetic, and bounds on its error.

References
----------
H. Ehlich and K. Zeller (1964), Schwankung von Polynomen zwischen Gitterpunkten, Mathematische
Zeitschrift 86, 41-44, doi:10.1007/BF01111276 (`in_between`).
T. J. Rivlin (1990), Chebyshev Polynomials, chapter 1 (the Lebesgue constant of the zeros of T_n).
L. N. Trefethen (2013), Approximation Theory and Approximation Practice: theorem 8.1 (coefficients
of a function that is analytic in an ellipse).
"""

from collections.abc import Sequence

import flint


class Nodes:
    """The Chebyshev nodes of the first kind on -1 <= x <= 1, as balls of the current precision.

    Attributes
    ----------
    x : list of arb
    transform : arb_mat
        Matrix that takes values at the nodes to coefficients of T_0, T_1, ... (c_0 not halved).
    """

    def __init__(self, count: int) -> None:
        angles = _angles(count)
        self.x = chebyshev_nodes(count)
        self.transform = flint.arb_mat(
            [
                [flint.arb.cos_pi_fmpq(k * angle) * min(k + 1, 2) / count for angle in angles]
                for k in range(count)
            ]
        )

    @property
    def lebesgue(self) -> flint.arb:
        """Lebesgue constant: largest ratio of a polynomial to its values at the nodes."""
        count = len(self.x)
        return (2 * flint.arb(count).log() / flint.arb.pi() + 1).upper()

    def left_out(self, radius: int) -> flint.arb:
        """Error of interpolating a function analytic for abs(x) <= radius, over its bound there.

        At the zeros of T_n each polynomial beyond T_(n - 1) takes the values of a lower one, its
        opposite or zero. So each coefficient left out counts twice.
        """
        rho = ellipse(radius)
        return (4 * rho ** (1 - len(self.x)) / (rho - 1)).upper()


def chebyshev_nodes(count: int) -> list[flint.arb]:
    """The zeros of T_count."""
    return [flint.arb.cos_pi_fmpq(angle) for angle in _angles(count)]


def _angles(count: int) -> list[flint.fmpq]:
    return [flint.fmpq(2 * j + 1, 2 * count) for j in range(count)]


def in_between(degree: int, count: int) -> flint.arb:
    """How far a polynomial may exceed its values at `count` > degree nodes, as a ratio."""
    return (1 / flint.arb.cos_pi_fmpq(flint.fmpq(degree, 2 * count))).upper()


def ellipse(radius: int) -> flint.arb:
    """Sum of the half axes of the largest ellipse with foci -1 and 1 inside a circle about 0."""
    r = flint.arb(radius)
    return r + (r * r - 1).sqrt()


def basis(x: Sequence[flint.arb], orders: int) -> flint.arb_mat:
    """T_0 .. T_(orders - 1), in columns, at some x."""
    return flint.arb_mat([[t.chebyshev_t(k) for k in range(orders)] for t in x])
