"""Linearisation about upright straight running: matrices, eigenvalues, critical speeds.

To first order in roll and steer, pitch and speed are constant and, with q = (roll, steer),

    M q'' + v C1 q' + (g K0 + v^2 K2) q = 0,

in the notation of Meijaard, Papadopoulos, Ruina and Schwab (2007), doi:10.1098/rspa.2007.1857.
`matrices` takes no formula from there: M comes from the kinetic energy of the nonlinear model, the
other matrices from derivatives of its accelerations. The derivatives use dual numbers, which are
exact up to rounding. `closed_form` has the published formulas.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise, zip_longest
from math import ceil, log2
from typing import Any

import flint
import mpmath
import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.arithmetic import Arithmetic, Balls, Number, dyadic, exact_ball, sign_of
from heyoka_bike.numbers.double import with_usual_errors
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.numbers.exact import Exact

MIN_DIGITS, MAX_DIGITS = 5, 1000

_GUARD_DIGITS = 15

Matrix = tuple[tuple[Number, Number], tuple[Number, Number]]
Array = np.ndarray[Any, np.dtype[np.object_]]
"""A matrix of numbers of any type."""


@dataclass(frozen=True)
class Linearisation:
    """The linear bicycle M q'' + v C1 q' + (g K0 + v^2 K2) q = 0, q = (roll, steer).

    Attributes
    ----------
    M, C1, K0, K2 : Matrix
        First row: roll equation; second row: steer equation [kg m^2, kg m, kg m, kg].
    g : mpf
        Gravity [N/kg].
    digits : int
        Significant decimal digits to which each number is rounded.
    """

    M: Matrix
    C1: Matrix
    K0: Matrix
    K2: Matrix
    g: mpmath.mpf
    digits: int
    _quartic: _Quartic = field(repr=False, compare=False)

    def eigenvalues(self, speed: Fraction | int | mpmath.mpf) -> tuple[mpmath.mpc, ...]:
        """Return four eigenvalues [1/s] at a speed [m/s], sorted by real, then imaginary part."""
        q = self._quartic
        with q.balls.precision():
            if isinstance(speed, int | Fraction):
                v = exact_ball(Fraction(speed))
            else:
                v = flint.arb(speed)
            roots = [z / q.root_w for z in _roots(q.at(v / q.root_w, q.g), self.digits)]
            parts = sorted((self._rounded(z.real), self._rounded(z.imag)) for z in roots)
        return tuple(x.context.mpc(x, y) for x, y in parts)

    @cached_property
    def weave_speeds(self) -> tuple[tuple[mpmath.mpf, mpmath.mpf], ...]:
        """Speeds [m/s] where a complex pair crosses the imaginary axis, and its frequency [rad/s].

        Hurwitz' determinant changes sign there, and s^2 = -d / b is negative.
        """
        q = self._quartic
        with q.balls.precision():
            changes = [x for x in q.changes(q.hurwitz()) if sign_of(q.b(x)) * sign_of(q.d(x)) > 0]
            return tuple(
                (self._speed(x), self._eigenvalue((q.d(x) / q.b(x)).sqrt())) for x in changes
            )

    @cached_property
    def capsize_speeds(self) -> tuple[mpmath.mpf, ...]:
        """Speeds [m/s] where a real eigenvalue changes sign."""
        q = self._quartic
        with q.balls.precision():
            return tuple(self._speed(x) for x in q.changes(q.e))

    @cached_property
    def double_roots(self) -> tuple[tuple[mpmath.mpf, mpmath.mpf], ...]:
        """Speeds [m/s] where two real eigenvalues merge into a complex pair, and their value [1/s].

        The discriminant changes sign there; the value is a stationary point of the quartic.
        """
        found, q = [], self._quartic
        with q.balls.precision():
            for x in q.changes(q.discriminant()):
                p: Any = q.at(x.sqrt(), flint.arb(1))
                real = [s.real for s in _roots(p.derivative(), self.digits) if s.imag == 0]
                value = min(real, key=lambda s: abs(p(s)).mid())
                found.append((self._speed(x), self._eigenvalue(value)))
        return tuple(found)

    @cached_property
    def stable_ranges(self) -> tuple[tuple[mpmath.mpf, mpmath.mpf | None], ...]:
        """Ranges of forward speed [m/s] where all real parts are negative; None if unbounded above.

        Every coefficient and Hurwitz' determinant are positive there. Without gravity there is no
        such range, because an eigenvalue is zero.
        """
        q = self._quartic
        if q.g == 0:
            return ()
        found: list[tuple[mpmath.mpf, mpmath.mpf | None]] = []
        with q.balls.precision():
            conditions = (q.b, q.c, q.d, q.e, q.hurwitz())
            edges = sorted([flint.arb(0), *(x for p in conditions for x in q.changes(p))])
            for low, high in zip_longest(edges, edges[1:]):
                inside = 2 * low + 1 if high is None else (low + high) / 2
                if all(sign_of(p(inside)) > 0 for p in conditions):
                    found.append((self._speed(low), None if high is None else self._speed(high)))
        return tuple(found)

    def _speed(self, x: flint.arb) -> mpmath.mpf:
        return self._rounded((x * self._quartic.g).sqrt() * self._quartic.root_w)

    def _eigenvalue(self, s: flint.arb) -> mpmath.mpf:
        return self._rounded(s * self._quartic.g.sqrt() / self._quartic.root_w)

    def _rounded(self, x: flint.arb) -> mpmath.mpf:
        return _rounded(x, self.digits)


@with_usual_errors
def linearise(bicycle: Bicycle, digits: int) -> Linearisation:
    """Linearise the nonlinear model about upright straight running.

    Parameters
    ----------
    bicycle : Bicycle
    digits : int
        Significant decimal digits of the result, 5 to 1000.

    Returns
    -------
    Linearisation
        Matrices in the notation of Meijaard et al. (2007), doi:10.1098/rspa.2007.1857, eigenvalues
        and critical speeds.

    Raises
    ------
    InputError
        `digits` is out of range, or the mass matrix of roll and steer is singular.
    """
    if not MIN_DIGITS <= digits <= MAX_DIGITS:
        raise InputError(f"digits: found {digits}, expected {MIN_DIGITS} to {MAX_DIGITS}")
    balls = Balls(_working_bits(digits))
    with balls.precision():
        found = matrices(bicycle, balls)
        w, g = balls.number(bicycle["w"]), balls.number(bicycle["g"])

        def shown(part: Array) -> Matrix:
            (a, b), (c, d) = ([_rounded(_with_zero(x), digits) for x in row] for row in part)
            return (a, b), (c, d)

        quartic = _Quartic.of(balls, digits, g, w, **found)
        printed = {name: shown(part) for name, part in found.items()}
        return Linearisation(**printed, g=_rounded(g, digits), digits=digits, _quartic=quartic)


def matrices(bicycle: Bicycle, a: Arithmetic) -> dict[str, Array]:
    """Return unrounded M, C1, K0 and K2 in the number type of `a`; zeros contain roundoff.

    Raises
    ------
    InputError
        The mass matrix of roll and steer is singular.
    """
    masses = Equations.of(bicycle, a).masses([a.number(0)] * 3)
    m11, m12, m22 = masses[0, 0], masses[0, 1], masses[1, 1]
    if not abs(m11 * m22 - m12 * m12) > abs(m11 * m22) / 10**_GUARD_DIGITS:
        raise InputError(
            f"the mass matrix of roll and steer of '{bicycle.name}' is singular, "
            "expected mass or inertia that resists both"
        )
    mass = np.array([[m11, m12], [m12, m22]], dtype=object)
    # The derivatives with respect to the angles are linear in g and in v^2; those with respect to
    # the rates are linear in v. So two evaluations, one for g and one for v, separate the matrices.
    weight = -(mass @ _acceleration_slopes(bicycle, a, g=1, speed=0))
    motion = -(mass @ _acceleration_slopes(bicycle, a, g=0, speed=1))
    return {"M": mass, "C1": motion[:, 2:], "K0": weight[:, :2], "K2": motion[:, :2]}


def _acceleration_slopes(bicycle: Bicycle, a: Arithmetic, *, g: int, speed: int) -> Array:
    """Return derivatives of roll and steer acceleration by (roll, steer, roll rate, steer rate).

    The pitch is fixed: by the symmetry of left and right it is of second order.
    """
    dual = Duals(a)
    weighed = Bicycle(bicycle.name, {**bicycle.values, "g": Exact(Fraction(g))})
    equations = Equations.of(weighed, a).over(dual)
    zero, spin = a.number(0), speed / equations.k.length
    roll, steer, roll_rate, steer_rate = dual.variables([zero] * 4)
    rates = equations.rates((roll, zero, steer, roll_rate, steer_rate, spin))
    return np.array([rates[3].slopes, rates[4].slopes], dtype=object)


def _working_bits(digits: int) -> int:
    # A double eigenvalue is accurate to only half as many digits as the matrices, so compute them
    # with twice as many.
    return ceil((2 * (digits + _GUARD_DIGITS) + _GUARD_DIGITS) * log2(10))


def _with_zero(x: flint.arb) -> flint.arb:
    """Replace a ball that contains zero with zero: it is zero up to rounding."""
    return flint.arb(0) if x.contains(0) else x


def _rounded(x: flint.arb, digits: int) -> mpmath.mpf:
    """Return the nearest number with this many decimal digits."""
    exact = dyadic(x.mid())
    many = _context(flint.ctx.dps).mpf(exact.numerator) / exact.denominator
    return _context(digits).mpf(mpmath.nstr(many, digits))


@cache
def _context(digits: int) -> mpmath.ctx_mp.MPContext:
    context = mpmath.mp.clone()
    context.dps = digits
    return context


def _roots(p: flint.arb_poly, digits: int) -> list[flint.acb]:
    """Return the roots of a real polynomial; real and imaginary parts have `digits` or are zero.

    A double root has half as many digits as the coefficients.
    """
    middles = [dyadic(c.mid()) for c in p.coeffs()]
    exact = flint.fmpq_poly([flint.fmpq(x.numerator, x.denominator) for x in middles])
    isolated: Any = exact.complex_roots()
    found = [z.mid() for z, times in isolated for _ in range(times)]
    residue = flint.arb(10) ** -(digits + 5)
    upper = [z for z in found if z.imag > residue * abs(z)]
    real = sorted(found, key=lambda z: abs(z.imag))[: len(found) - 2 * len(upper)]
    pairs = [flint.acb(z.real if abs(z.real) > residue * abs(z) else 0, z.imag) for z in upper]
    return [*(flint.acb(z.real) for z in real), *pairs, *(z.conjugate() for z in pairs)]


Pair = tuple[Number, Number]


def characteristic(m: Any, c1: Any, k0: Any, k2: Any) -> tuple[Number, Number, Pair, Pair, Pair]:
    """Return the coefficients of the characteristic polynomial, which contain no g and no v.

    The polynomial is a s^4 + v b s^3 + (g c0 + c1 x) s^2 + v (g d0 + d1 x) s + g (g e0 + e1 x) with
    x = v^2.
    """

    def det(p: Any) -> Number:
        return p[0][0] * p[1][1] - p[0][1] * p[1][0]

    def mixed(p: Any, q: Any) -> Number:
        """Return the part of det(p + q) that is of first order in both."""
        return p[0][0] * q[1][1] + q[0][0] * p[1][1] - p[0][1] * q[1][0] - q[0][1] * p[1][0]

    c, d = (mixed(m, k0), mixed(m, k2) + det(c1)), (mixed(c1, k0), mixed(c1, k2))
    # The first column of K2 is zero, so det(K2) is zero, too.
    return det(m), mixed(m, c1), c, d, (det(k0), mixed(k0, k2))


@dataclass(frozen=True, slots=True)
class _Quartic:
    """Polynomial s^4 + v b s^3 + c s^2 + v d s + e, whose b, c, d, e are polynomials of x = v^2.

    The unit of s is 1/sqrt(w) and that of v is sqrt(w), where w is the wheel base, and gravity is
    1: all critical speeds and eigenvalues are proportional to sqrt(g).
    """

    balls: Balls
    digits: int
    g: flint.arb
    root_w: flint.arb
    b: flint.arb_poly
    c: flint.arb_poly
    d: flint.arb_poly
    e: flint.arb_poly

    @classmethod
    def of(
        cls, balls: Balls, digits: int, g: flint.arb, w: flint.arb,
        M: Array, C1: Array, K0: Array, K2: Array,
    ) -> _Quartic:  # fmt: skip
        mass, b, *pairs = characteristic(M / w, C1, K0, K2 * w)
        b, c, d, e = (flint.arb_poly([_with_zero(x / mass) for x in p]) for p in ([b], *pairs))
        return cls(balls, digits, g, w.sqrt(), b, c, d, e)

    def at(self, v: flint.arb, g: flint.arb) -> flint.arb_poly:
        """Return the characteristic polynomial in s at a speed and gravity."""
        x = v * v
        c, d, e = (p[0] * g + p[1] * x for p in (self.c, self.d, self.e))
        return flint.arb_poly([g * e, v * d, c, v * self.b[0], 1])

    def changes(self, p: flint.arb_poly) -> list[flint.arb]:
        """Return the positive x = v^2 where p changes sign, ascending; none without gravity."""
        p = flint.arb_poly([_with_zero(c) for c in p.coeffs()])
        if self.g == 0 or p.degree() < 1:
            return []
        roots = sorted(z.real for z in _roots(p, self.digits) if z.imag == 0 and z.real > 0)
        ends = [flint.arb(0), *roots, 2 * roots[-1] if roots else 1]
        signs = [sign_of(p((low + high) / 2)) for low, high in pairwise(ends)]
        found, before = [], signs[0]
        for x, after in zip(roots, signs[1:], strict=True):
            if before * after < 0:
                found.append(x)
            # If two roots are equal up to rounding, the sign of p between them is zero. Then keep
            # the sign that p has before both roots.
            before = after or before
        return found

    def hurwitz(self) -> flint.arb_poly:
        """Return Hurwitz' determinant as a polynomial in x."""
        return self.b * self.c * self.d - self.d * self.d - self.b * self.b * self.e

    def discriminant(self) -> flint.arb_poly:
        """Return 27 times the discriminant of the quartic."""
        b, c, d, e = self.b, self.c, self.d, self.e
        x = flint.arb_poly([0, 1])
        i = e * 12 - b * d * x * 3 + c * c
        j = c * e * 72 + (b * c * d * 9 - d * d * 27 - b * b * e * 27) * x - c * c * c * 2
        return i * i * i * 4 - j * j


def closed_form(p: Mapping[str, Number], a: Arithmetic) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """Return M, C1, K0 and K2 from the parameters by symbol, over any number type.

    The formulas are those of Meijaard, Papadopoulos, Ruina and Schwab (2007), Appendix A, in its
    symbols. They need fewer operations than `matrices`, which makes intervals and affine numbers
    narrower. The tests compare the two.
    """
    w, c = p["w"], p["c"]
    sin, cos = a.sin(p["lam"]), a.cos(p["lam"])

    # Sums over all bodies: the first moments m_T x_T and m_T z_T, and the inertia about the rear
    # contact point.
    front_x = p["mH"] * p["xH"] + p["mF"] * w
    front_z = p["mH"] * p["zH"] - p["mF"] * p["rF"]
    total_x = p["mB"] * p["xB"] + front_x
    total_z = p["mB"] * p["zB"] - p["mR"] * p["rR"] + front_z
    t_xx = (
        (p["IRxx"] + p["IBxx"] + p["IHxx"] + p["IFxx"])
        + (p["mR"] * p["rR"] * p["rR"] + p["mB"] * p["zB"] * p["zB"])
        + (p["mH"] * p["zH"] * p["zH"] + p["mF"] * p["rF"] * p["rF"])
    )
    t_xz = (
        (p["IBxz"] + p["IHxz"])
        - (p["mB"] * p["xB"] * p["zB"] + p["mH"] * p["xH"] * p["zH"])
        + p["mF"] * w * p["rF"]
    )
    t_zz = (
        (p["IRxx"] + p["IBzz"] + p["IHzz"] + p["IFxx"])
        + p["mB"] * p["xB"] * p["xB"]
        + (p["mH"] * p["xH"] * p["xH"] + p["mF"] * w * w)
    )

    # Inertia of the front assembly A about the steer axis, from the distance u of each body ahead
    # of the axis.
    u_h = (p["xH"] - w - c) * cos - p["zH"] * sin
    u_f = p["rF"] * sin - c * cos
    moment = p["mH"] * u_h + p["mF"] * u_f
    own_x = (p["IHxx"] + p["IFxx"]) * sin + p["IHxz"] * cos
    own_z = p["IHxz"] * sin + (p["IHzz"] + p["IFxx"]) * cos
    a_ll = p["mH"] * u_h * u_h + p["mF"] * u_f * u_f + own_x * sin + own_z * cos
    a_lx = own_x - p["mH"] * u_h * p["zH"] + p["mF"] * u_f * p["rF"]
    a_lz = own_z + p["mH"] * u_h * p["xH"] + p["mF"] * u_f * w

    mu = c / w * cos
    s_f = p["IFyy"] / p["rF"]
    s_t = p["IRyy"] / p["rR"] + s_f
    s_a = moment + mu * total_x
    m12 = a_lx + mu * t_xz
    swing = cos / w
    gyro = mu * s_t + s_f * cos
    zero = 0 * w
    return (
        ((t_xx, m12), (m12, a_ll + 2 * mu * a_lz + mu * mu * t_zz)),
        (
            (zero, gyro + t_xz * swing - mu * total_z),
            (-gyro, a_lz * swing + mu * (s_a + t_zz * swing)),
        ),
        ((total_z, -s_a), (-s_a, -s_a * sin)),
        ((zero, (s_t - total_z) * swing), (zero, (s_a + s_f * sin) * swing)),
    )
