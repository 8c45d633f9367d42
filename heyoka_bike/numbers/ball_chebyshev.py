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
        """Lebesgue constant: bounds a polynomial's maximum, relative to its values at the nodes."""
        count = len(self.x)
        return (2 * flint.arb(count).log() / flint.arb.pi() + 1).upper()

    def left_out(self, radius: int) -> flint.arb:
        """Bound the error of interpolating a function analytic for abs(x) <= radius.

        The bound is relative to that of the function on the circle. At the zeros of T_n each
        polynomial beyond T_(n - 1) equals a lower one, its negative, or zero. So each omitted
        coefficient counts twice.
        """
        rho = ellipse(radius)
        return (4 * rho ** (1 - len(self.x)) / (rho - 1)).upper()


def chebyshev_nodes(count: int) -> list[flint.arb]:
    """Return the zeros of the Chebyshev polynomial T_count."""
    return [flint.arb.cos_pi_fmpq(angle) for angle in _angles(count)]


def _angles(count: int) -> list[flint.fmpq]:
    return [flint.fmpq(2 * j + 1, 2 * count) for j in range(count)]


def in_between(degree: int, count: int) -> flint.arb:
    """Bound a polynomial's maximum, relative to its values at `count` > degree nodes."""
    return (1 / flint.arb.cos_pi_fmpq(flint.fmpq(degree, 2 * count))).upper()


def ellipse(radius: int) -> flint.arb:
    """Return the sum of half axes of the largest ellipse with foci -1 and 1 inside a circle."""
    r = flint.arb(radius)
    return r + (r * r - 1).sqrt()


def basis(x: Sequence[flint.arb], orders: int) -> flint.arb_mat:
    """Return T_0 .. T_(orders - 1) at some x: a row for each x, a column for each order."""
    return flint.arb_mat([[t.chebyshev_t(k) for k in range(orders)] for t in x])
