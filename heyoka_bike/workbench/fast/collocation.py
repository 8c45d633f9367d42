"""Collocation at eight points of a step: the constants of Radau's method of order 15.

E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 2nd edition, Springer 1996,
sections IV.5 and IV.8. The eight points are as many as one vector of the processor holds; the
polynomial through them is of degree 8, and good to that degree all over the step.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import flint
import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.fast.vector_code import POINTS

_BITS = 160


@dataclass(frozen=True, slots=True)
class Collocation:
    """Constants of the method; matrices act on a column of values at the points.

    Attributes
    ----------
    points : ndarray, shape (8,)
        Places in the step, 0 to 1; the last one is its end.
    integral : ndarray, shape (8, 8)
        From derivatives to increments since the step's beginning, over its length.
    eigenvalues : ndarray, shape (4,)
        Of the inverse of `integral`, those with positive imaginary part.
    to_modes : ndarray, shape (8, 8)
        From the points to modes: real parts of the four, then imaginary parts.
    from_modes : ndarray, shape (8, 8)
        The inverse of `to_modes`.
    series : ndarray, shape (8, 8)
        From increments to coefficients 1 to 8 of their Chebyshev series over the step.
    """

    points: Array
    integral: Array
    eigenvalues: Array
    to_modes: Array
    from_modes: Array
    series: Array


@cache
def collocation() -> Collocation:
    """Constants, each rounded once from balls of 160 bits but for the modes.

    The modes only precondition an iteration; what it converges to does not depend on them.
    """
    with flint.ctx.workprec(_BITS):
        # Zeros of P_8 - P_7 on 0 to 1, P being Legendre's polynomials.
        difference = flint.fmpq_poly.legendre_p(POINTS) - flint.fmpq_poly.legendre_p(POINTS - 1)
        roots: Any = difference.complex_roots()
        points = sorted(((x.real + 1) / 2 for x, _ in roots), key=float)
        powers = flint.arb_mat([[c**j for j in range(POINTS)] for c in points])
        integrals = flint.arb_mat([[c**j / j for j in range(1, POINTS + 1)] for c in points])
        integral = integrals * powers.inv()
        # The increment at the beginning is zero, which gives coefficient 0.
        chebyshev = [
            [(2 * c - 1).chebyshev_t(j) - (-1) ** j for j in range(1, POINTS + 1)] for c in points
        ]
        inverse, series = _rounded(integral.inv()), _rounded(flint.arb_mat(chebyshev).inv())
    values, vectors = np.linalg.eig(inverse)
    chosen = values.imag > 0
    # Of z + conj(z) = 2 (re re - im im).
    from_modes = 2 * np.hstack([vectors[:, chosen].real, -vectors[:, chosen].imag])
    return Collocation(
        points=np.array(points, dtype=float),
        integral=_rounded(integral),
        eigenvalues=values[chosen],
        to_modes=np.linalg.inv(from_modes),
        from_modes=from_modes,
        series=series,
    )


def _rounded(matrix: flint.arb_mat) -> Array:
    return np.array(matrix.tolist(), dtype=float)
