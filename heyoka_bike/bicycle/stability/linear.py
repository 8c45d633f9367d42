"""Linearisation about upright straight running: matrices, eigenvalues, critical speeds.

To first order in roll and steer, pitch and speed are constant and, with q = (roll, steer),

    M q'' + v C1 q' + (g K0 + v^2 K2) q = 0,

in the notation of Meijaard, Papadopoulos, Ruina and Schwab (2007), doi:10.1098/rspa.2007.1857.
`matrices` takes no formula from there: M comes from the kinetic energy of the nonlinear model, the
other matrices from derivatives of its accelerations. These are taken by dual numbers, which are
exact up to rounding. `closed_form` has the formulas.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property, reduce
from itertools import pairwise, zip_longest
from typing import Any

import flint
import mpmath
import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.arithmetic import Arithmetic, Multiprecision, Number, midpoint
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.numbers.exact import Exact

MIN_DIGITS, MAX_DIGITS = 5, 1000

_GUARD = 15

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
        Significant decimal digits to which each number here is rounded.
    """

    M: Matrix
    C1: Matrix
    K0: Matrix
    K2: Matrix
    g: mpmath.mpf
    digits: int
    _quartic: _Quartic = field(repr=False, compare=False)

    def eigenvalues(self, speed: Fraction | int | mpmath.mpf) -> tuple[mpmath.mpc, ...]:
        """Four eigenvalues [1/s] at a speed [m/s], ordered by real, then by imaginary part."""
        q = self._quartic
        is_exact = isinstance(speed, int | Fraction)
        v = q.a.number(speed) if is_exact else q.a.context.mpf(speed)
        roots = [z / q.root_w for z in _roots(q.at(v / q.root_w, q.g))]
        parts = sorted((self._rounded(z.real), self._rounded(z.imag)) for z in roots)
        return tuple(x.context.mpc(x, y) for x, y in parts)

    @cached_property
    def weave_speeds(self) -> tuple[tuple[mpmath.mpf, mpmath.mpf], ...]:
        """Speeds [m/s] where a complex pair crosses the imaginary axis, and its frequency [rad/s].

        Hurwitz' determinant changes sign there, and s^2 = -d / b is negative.
        """
        q = self._quartic
        changes = [x for x in q.changes(q.hurwitz()) if q.b.sign(x) * q.d.sign(x) > 0]
        return tuple((self._speed(x), self._eigenvalue(_sqrt(q.d(x) / q.b(x)))) for x in changes)

    @cached_property
    def capsize_speeds(self) -> tuple[mpmath.mpf, ...]:
        """Speeds [m/s] where a real eigenvalue changes sign."""
        return tuple(self._speed(x) for x in self._quartic.changes(self._quartic.e))

    @cached_property
    def double_roots(self) -> tuple[tuple[mpmath.mpf, mpmath.mpf], ...]:
        """Speeds [m/s] where two real eigenvalues merge into a complex pair, and their value [1/s].

        The discriminant changes sign there; the value is a stationary point of the quartic.
        """
        found = []
        for x in self._quartic.changes(self._quartic.discriminant()):
            p = self._quartic.at(_sqrt(x), 1)
            slope = [power * c for power, c in zip((4, 3, 2, 1), p, strict=False)]
            real = [s.real for s in _roots(slope) if s.imag == 0]
            _, value = min((abs(reduce(lambda y, c: y * s + c, p)), s) for s in real)
            found.append((self._speed(x), self._eigenvalue(value)))
        return tuple(found)

    @cached_property
    def stable_ranges(self) -> tuple[tuple[mpmath.mpf, mpmath.mpf | None], ...]:
        """Ranges of forward speed [m/s] where all real parts are negative; None if without end.

        Every coefficient and Hurwitz' determinant are positive there. Without gravity there is
        none: an eigenvalue is zero.
        """
        q = self._quartic
        if q.g == 0:
            return ()
        conditions = (q.b, q.c, q.d, q.e, q.hurwitz())
        edges = sorted({0 * q.g, *(x for p in conditions for x in q.changes(p))})
        found: list[tuple[mpmath.mpf, mpmath.mpf | None]] = []
        for low, high in pairwise([*edges, None]):
            inside = 2 * low + 1 if high is None else (low + high) / 2
            if all(p.sign(inside) > 0 for p in conditions):
                found.append((self._speed(low), None if high is None else self._speed(high)))
        return tuple(found)

    def _speed(self, x: mpmath.mpf) -> mpmath.mpf:
        return self._rounded(_sqrt(x * self._quartic.g) * self._quartic.root_w)

    def _eigenvalue(self, s: mpmath.mpf) -> mpmath.mpf:
        return self._rounded(s * _sqrt(self._quartic.g) / self._quartic.root_w)

    def _rounded(self, x: mpmath.mpf) -> mpmath.mpf:
        return _rounded(x, self.digits)


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
    a = Multiprecision(_working_digits(digits))
    found = matrices(bicycle, a)
    w = a.number(bicycle["w"])
    parts = found["M"] / w, found["C1"], found["K0"], found["K2"] * w
    residue = max(_residue(x) for part in parts for x in part.flat)
    chopped = np.frompyfunc(lambda x: _chopped(x, residue), 1, 1)
    m, c1, k0, k2 = map(chopped, parts)

    def shown(part: Array, unit: Number) -> Matrix:
        (a, b), (c, d) = ([_rounded(x, digits) for x in row] for row in part * unit)
        return (a, b), (c, d)

    g = a.number(bicycle["g"])
    return Linearisation(
        M=shown(m, w), C1=shown(c1, 1), K0=shown(k0, 1), K2=shown(k2, 1 / w),
        g=_rounded(g, digits), digits=digits, _quartic=_Quartic.of(a, g, w, m, c1, k0, k2),
    )  # fmt: skip


def matrices(bicycle: Bicycle, a: Arithmetic) -> dict[str, Array]:
    """Return M, C1, K0 and K2 in the number type of `a`, unrounded: zeros are up to rounding.

    Raises
    ------
    InputError
        The mass matrix of roll and steer is singular.
    """
    masses = Equations.of(bicycle, a).masses([a.number(0)] * 3)
    m11, m12, m22 = masses[0, 0], masses[0, 1], masses[1, 1]
    if abs(m11 * m22 - m12 * m12) <= abs(m11 * m22) / 10**_GUARD:
        raise InputError(
            f"the mass matrix of roll and steer of '{bicycle.name}' is singular, "
            "expected mass or inertia that resists both"
        )
    mass = np.array([[m11, m12], [m12, m22]], dtype=object)
    # The derivatives by the angles are linear in g and in v^2, those by the rates in v.
    weight = -(mass @ _acceleration_slopes(bicycle, a, g=1, speed=0))
    motion = -(mass @ _acceleration_slopes(bicycle, a, g=0, speed=1))
    return {"M": mass, "C1": motion[:, 2:], "K0": weight[:, :2], "K2": motion[:, :2]}


def _acceleration_slopes(bicycle: Bicycle, a: Arithmetic, *, g: int, speed: int) -> Array:
    """Derivatives of roll and steer acceleration by (roll, steer, roll rate, steer rate).

    The pitch is fixed: by the symmetry of left and right it is of second order.
    """
    dual = Duals(a)
    weighed = Bicycle(bicycle.name, {**bicycle.values, "g": Exact(Fraction(g))})
    equations = Equations.of(weighed, a).over(dual)
    zero, spin = a.number(0), speed / equations.k.length
    roll, steer, roll_rate, steer_rate = dual.variables([zero] * 4)
    rates = equations.rates((roll, zero, steer, roll_rate, steer_rate, spin))
    return np.array([rates[3].slopes, rates[4].slopes], dtype=object)


def _working_digits(digits: int) -> int:
    # A double eigenvalue has half of the digits of the matrices.
    return 2 * (digits + _GUARD) + _GUARD


def _residue(x: Number) -> Number:
    """Return the bound below which a number is zero up to rounding beside x."""
    return abs(x) * x.context.eps * 10**_GUARD


def _sqrt(x: Number) -> Number:
    return x.context.sqrt(x)


def _chopped(x: Number, residue: Number) -> Number:
    return x if abs(x) > residue else 0 * x


def _sum(x: Number, y: Number) -> Number:
    return _chopped(x + y, _residue(abs(x) + abs(y)))


def _rounded(x: mpmath.mpf, digits: int) -> mpmath.mpf:
    """The nearest number of so many decimal digits, in a context that holds little more."""
    return _context(digits).mpf(mpmath.nstr(x, digits))


@cache
def _context(digits: int) -> mpmath.ctx_mp.MPContext:
    return Multiprecision(digits).context


def _roots(coefficients: Sequence[mpmath.mpf]) -> list[mpmath.mpc]:
    """Roots of a real polynomial, highest power first, each part exact to half the digits or zero.

    A double root comes out with half of the digits of the coefficients.
    """
    mp = coefficients[0].context
    least = min(x.exp for x in coefficients if x)
    p = flint.fmpz_poly([int(mp.ldexp(x, -least)) for x in reversed(coefficients)])
    with flint.ctx.workprec(mp.prec):
        isolated: Any = p.complex_roots()
        found = [
            mp.mpc(_middle(mp, z.real), _middle(mp, z.imag))
            for z, times in isolated
            for _ in range(times)
        ]
    residue = mp.mpf(10) ** -(mp.dps // 2 - _GUARD - 2)
    upper = [z for z in found if z.imag > residue * abs(z)]
    real = sorted(found, key=lambda z: abs(z.imag))[: len(found) - 2 * len(upper)]
    pairs = [mp.mpc(z.real if abs(z.real) > residue * abs(z) else 0, z.imag) for z in upper]
    return [*(mp.mpc(z.real) for z in real), *pairs, *(z.conjugate() for z in pairs)]


def _middle(mp: mpmath.ctx_mp.MPContext, x: flint.arb) -> mpmath.mpf:
    n, grid = midpoint(x)
    return mp.ldexp(n, -grid)


Pair = tuple[Number, Number]


def characteristic(m: Any, c1: Any, k0: Any, k2: Any) -> tuple[Number, Number, Pair, Pair, Pair]:
    """Coefficients of the characteristic polynomial, without gravity.

    It is a s^4 + v b s^3 + (g c0 + c1 x) s^2 + v (g d0 + d1 x) s + g (g e0 + e1 x) with x = v^2.
    """

    def det(p: Any) -> Number:
        return p[0][0] * p[1][1] - p[0][1] * p[1][0]

    def mixed(p: Any, q: Any) -> Number:
        """Return the part of det(p + q) that is of first order in both."""
        return p[0][0] * q[1][1] + q[0][0] * p[1][1] - p[0][1] * q[1][0] - q[0][1] * p[1][0]

    c, d = (mixed(m, k0), mixed(m, k2) + det(c1)), (mixed(c1, k0), mixed(c1, k2))
    # K2 has no first column, and so no determinant.
    return det(m), mixed(m, c1), c, d, (det(k0), mixed(k0, k2))


@dataclass(frozen=True, slots=True)
class _Polynomial:
    """A polynomial in x = v^2, lowest power first; sums that cancel up to rounding are zero."""

    coefficients: tuple[Number, ...]

    def __add__(self, other: _Polynomial) -> _Polynomial:
        pairs = zip_longest(self.coefficients, other.coefficients, fillvalue=0)
        return _Polynomial(tuple(_sum(p, q) for p, q in pairs))

    def __sub__(self, other: _Polynomial) -> _Polynomial:
        return self + other * -1

    def __mul__(self, other: _Polynomial | Number) -> _Polynomial:
        if not isinstance(other, _Polynomial):
            return _Polynomial(tuple(p * other for p in self.coefficients))
        out: list[Number] = [0] * (len(self.coefficients) + len(other.coefficients) - 1)
        for i, p in enumerate(self.coefficients):
            for j, q in enumerate(other.coefficients):
                out[i + j] = _sum(out[i + j], p * q)
        return _Polynomial(tuple(out))

    def times_x(self) -> _Polynomial:
        return _Polynomial((0 * self.coefficients[0], *self.coefficients))

    def __call__(self, x: Number, g: Number = 1) -> Number:
        """The value at x, made homogeneous by powers of g."""
        value, power = 0 * x, 1
        for p in reversed(self.coefficients):
            value = value * x + p * power
            power = power * g
        return value

    def sign(self, x: Number) -> int:
        """Sign of the value at x, 0 if that is zero up to rounding."""
        value = self(x)
        size = _Polynomial(tuple(abs(p) for p in self.coefficients))(x)
        return 0 if abs(value) <= _residue(size) else 1 if value > 0 else -1

    def sign_changes(self) -> list[Number]:
        """Positive x where the sign changes, ascending."""
        p = self._trimmed()
        if len(p.coefficients) < 2:
            return []
        roots = sorted(z.real for z in _roots(p.coefficients[::-1]) if z.imag == 0 < z.real)
        ends = [0 * p.coefficients[0], *roots, 2 * max(roots, default=1)]
        signs = [p.sign((low + high) / 2) for low, high in pairwise(ends)]
        found, before = [], signs[0]
        for x, after in zip(roots, signs[1:], strict=True):
            if before * after < 0:
                found.append(x)
            # Between roots that are equal up to rounding it is zero.
            before = after or before
        return found

    def _trimmed(self) -> _Polynomial:
        """Without coefficients that are rounding residues, and divided by a power of x."""
        residue = max(_residue(p) for p in self.coefficients)
        kept = [i for i, p in enumerate(self.coefficients) if abs(p) > residue]
        return _Polynomial(self.coefficients[kept[0] : kept[-1] + 1] if kept else ())


@dataclass(frozen=True, slots=True)
class _Quartic:
    """Characteristic polynomial s^4 + v b s^3 + c s^2 + v d s + e, b to e polynomials of x = v^2.

    Here s is in units of 1/sqrt(w) and v of sqrt(w), with w the wheel base, and gravity is 1: all
    critical speeds and eigenvalues are proportional to sqrt(g).
    """

    a: Multiprecision
    g: Number
    root_w: Number
    b: _Polynomial
    c: _Polynomial
    d: _Polynomial
    e: _Polynomial

    @classmethod
    def of(
        cls, a: Multiprecision, g: Number, w: Number, m: Array, c1: Array, k0: Array, k2: Array
    ) -> _Quartic:
        """From M / w, C1, K0 and w K2."""
        constant = np.frompyfunc(lambda x: _Polynomial((x,)), 1, 1)
        mass, b, *pairs = characteristic(*map(constant, (m, c1, k0, k2)))
        scale = 1 / mass.coefficients[0]
        c, d, e = ((low + high.times_x()) * scale for low, high in pairs)
        return cls(a=a, g=g, root_w=_sqrt(w), b=b * scale, c=c, d=d, e=e)

    def at(self, v: Number, g: Number) -> list[Number]:
        """Coefficients at a speed and gravity, highest power first."""
        x = v * v
        return [1 + 0 * x, v * self.b(x, g), self.c(x, g), v * self.d(x, g), g * self.e(x, g)]

    def changes(self, p: _Polynomial) -> list[Number]:
        """Values of x where p changes sign, if there is gravity."""
        return p.sign_changes() if self.g else []

    def hurwitz(self) -> _Polynomial:
        """Hurwitz' determinant over x."""
        return self.b * self.c * self.d - self.d * self.d - self.b * self.b * self.e

    def discriminant(self) -> _Polynomial:
        """27 times the discriminant of the quartic."""
        b, c, d, e = self.b, self.c, self.d, self.e
        i = e * 12 - (b * d * 3).times_x() + c * c
        j = c * e * 72 + (b * c * d * 9 - d * d * 27 - b * b * e * 27).times_x() - c * c * c * 2
        return i * i * i * 4 - j * j


def closed_form(p: Mapping[str, Number], a: Arithmetic) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """M, C1, K0 and K2 from the parameters by symbol, over any number type.

    Typed from Meijaard, Papadopoulos, Ruina and Schwab (2007), Appendix A, in its symbols. These
    need fewer operations than `matrices`, which is what intervals and affine numbers ask for. The
    tests compare the two.
    """
    w, c = p["w"], p["c"]
    sin, cos = a.sin(p["lam"]), a.cos(p["lam"])

    # Total: m_T x_T and m_T z_T, and the inertia about the rear contact point.
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

    # Front assembly A: its inertia about the steer axis, from each body's distance u to it, ahead.
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
