"""Collocation at eight points of a step: the constants of Radau's method of order 15.

E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 2nd edition, Springer 1996,
sections IV.5 and IV.8. The eight points are as many as one vector of the processor holds; the
polynomial through them is of degree 8, and good to that degree all over the step.
"""

from dataclasses import dataclass
from functools import cache

import mpmath
import numpy as np

from heyoka_bike.numbers.double import Array

POINTS = 8
_DIGITS = 40


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
    """Constants, each rounded once from 40 digits but for the modes.

    The modes only precondition an iteration; what it converges to does not depend on them.
    """
    with mpmath.workdps(_DIGITS):
        points = _points()
        powers = mpmath.matrix(POINTS, POINTS)
        integrals = mpmath.matrix(POINTS, POINTS)
        for i, c in enumerate(points):
            for j in range(POINTS):
                powers[i, j] = c**j
                integrals[i, j] = c ** (j + 1) / (j + 1)
        integral = integrals * mpmath.inverse(powers)
        inverse = np.array(mpmath.inverse(integral).tolist(), dtype=float)
        # The increment at the beginning is zero, which gives coefficient 0.
        chebyshev = mpmath.matrix(POINTS, POINTS)
        for i, c in enumerate(points):
            for j in range(1, POINTS + 1):
                chebyshev[i, j - 1] = mpmath.chebyt(j, 2 * c - 1) - (-1) ** j
        series = mpmath.inverse(chebyshev)
    values, vectors = np.linalg.eig(inverse)
    chosen = values.imag > 0
    # Of z + conj(z) = 2 (re re - im im).
    from_modes = 2 * np.hstack([vectors[:, chosen].real, -vectors[:, chosen].imag])
    return Collocation(
        points=np.array(points, dtype=float),
        integral=np.array(integral.tolist(), dtype=float),
        eigenvalues=values[chosen],
        to_modes=np.linalg.inv(from_modes),
        from_modes=from_modes,
        series=np.array(series.tolist(), dtype=float),
    )


def _points() -> list[mpmath.mpf]:
    """Zeros of P_8 - P_7 on 0 to 1, P being Legendre's polynomials; the last one is 1."""
    legendre = np.polynomial.legendre
    near = np.sort(legendre.legroots([0.0] * (POINTS - 1) + [-1.0, 1.0]).real)

    def difference(x: mpmath.mpf) -> mpmath.mpf:
        return mpmath.legendre(POINTS, x) - mpmath.legendre(POINTS - 1, x)

    inner = [mpmath.findroot(difference, mpmath.mpf(float(x))) for x in near[:-1]]
    return [*((x + 1) / 2 for x in inner), mpmath.mpf(1)]
