"""A whole run as code: steps, dense output, rows and columns in one function.

The method is Radau's of order 15, collocation at eight points of a step: E. Hairer and G. Wanner,
Solving Ordinary Differential Equations II, 2nd edition, Springer 1996, sections IV.5 and IV.8. The
points lie in the eight places of a vector, so that one evaluation of the equations serves them all,
in little more than the time of a single one. The polynomial through them is of degree 8, and good
to that degree all over the step. Its system is solved by Newton's iteration with the Jacobian of
the step's beginning (differences in the places of a vector, too), in modes, where it falls into
four complex systems of six equations. These are solved side by side, in the places of half a
vector. Rows are written eight at once, from the series of their step.

The step is chosen by the last coefficient of its Chebyshev series, which is about the error of the
dense output times the rate at which the coefficients fall.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, reduce
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.workbench.fast import vector_code as v
from heyoka_bike.workbench.fast.model_code import ENERGY, call_rates, columns_and_trail, rates_code
from heyoka_bike.workbench.fast.vector_code import POINTS, Register, fused

_BITS_OF_NODES = 160


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
    with working_bits(_BITS_OF_NODES):
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


Numbers = np.ndarray[Any, np.dtype[np.object_]]
"""Arrays of `Complex`."""


@dataclass(frozen=True, slots=True)
class Complex:
    """Four complex numbers: real and imaginary parts."""

    re: Register
    im: Register

    @staticmethod
    def of_halves(x: Register) -> Complex:
        """A vector's first half and its second."""
        return Complex(x.places(range(POINTS // 2)), x.places(range(POINTS // 2, POINTS)))

    def joined(self) -> Register:
        """Real and imaginary parts as one vector."""
        return self.re.places(range(POINTS), self.im)

    def __mul__(self, other: Complex) -> Complex:
        return Complex(
            fused(self.re, other.re, -(self.im * other.im)),
            fused(self.re, other.im, self.im * other.re),
        )

    def inverse(self) -> Complex:
        over = 1.0 / fused(self.re, self.re, self.im * self.im)
        return Complex(self.re * over, -(self.im * over))

    def without(self, x: Complex, y: Complex) -> Complex:
        """The difference between this number and the product of two others."""
        minus = -x.re
        return Complex(
            fused(x.im, y.im, fused(minus, y.re, self.re)),
            fused(-x.im, y.re, fused(minus, y.im, self.im)),
        )


_without = np.frompyfunc(Complex.without, 3, 1)


def factor(m: Numbers) -> None:
    """Factors of four complex matrices in their place; inverses on the diagonal.

    Without exchanges: a short step makes the diagonal large, and where the iteration does not
    converge the step is made shorter.
    """
    for k in range(len(m)):
        m[k, k] = m[k, k].inverse()
        rest = slice(k + 1, None)
        m[rest, k] *= m[k, k]
        m[rest, rest] = _without(m[rest, rest], m[rest, k : k + 1], m[k, rest])


def solve(m: Numbers, x: Numbers) -> Numbers:
    """Solutions of four complex systems in place of the right sides, from what `factor` left."""
    for k in range(len(m)):
        x[k + 1 :] = _without(x[k + 1 :], m[k + 1 :, k], x[k])
    for k in reversed(range(len(m))):
        x[k] *= m[k, k]
        x[:k] = _without(x[:k], m[:k, k], x[k])
    return x


_MASKED = f"llvm.masked.{{}}.v{v.POINTS}f64.p0"


class RowWriter:
    """The rows of a run.

    Parameters
    ----------
    c, equations
        The function, and what the columns are made by.
    count, times
        Of the rows.
    columns, states
        Get one variable after the other; states unless there is no such memory.

    Attributes
    ----------
    row
        The next one.
    """

    def __init__(
        self, c: v.Code, equations: Equations, count: v.Register, times: v.Memory,
        columns: v.Memory, states: v.Memory,
    ) -> None:  # fmt: skip
        self._code, self._equations = c, equations
        self._count, self._times, self._columns, self._states = count, times, columns, states
        self.row = c.variable(0)
        self._aligned = v.Register(c, "i32", "8")  # bytes of an address
        # Least and largest of mechanical trail and energy.
        self._extremes = c.memory(4)
        self._extremes.store([float("inf"), -float("inf")] * 2)

    def write(
        self, series: v.Memory, zeroth: v.Memory, begin: v.Register, h: v.Register, end: v.Register
    ) -> None:
        """Those up to the end of a step, from coefficients 1 to 8 of its series, and 0."""
        c, half = self._code, h * 0.5
        middle, rate = (begin + half).spread(), (1.0 / half).spread()
        stop = c.variable(self.row[0])
        with v.Loop(c) as counting:
            counting.leave(stop[0] >= self._count)
            counting.leave(self._times[stop[0]] > end)
            stop[0] += 1
        with v.Loop(c) as block:
            row = self.row[0]
            block.leave(row >= stop[0])
            mask = c.vector(range(v.POINTS)) < stop[0] - row
            place = self._times.part(row).address
            time = c.call(middle.kind, _MASKED.format("load"), place, self._aligned, mask, middle)
            x = ((time - middle) * rate).at_most(1.0)
            twice = x + x
            states = [_clenshaw(series.numbers(i), zeroth[i], x, twice) for i in range(v.STATE)]
            *columns, trail = columns_and_trail(self._equations, states)
            self._put(self._columns, columns, row, mask)
            for i, value in enumerate((trail, columns[ENERGY])):
                self._extremes[2 * i] = self._extremes[2 * i].at_most(value)
                self._extremes[2 * i + 1] = self._extremes[2 * i + 1].at_least(value)
            with c.unless(self._states.address.is_null()):
                self._put(self._states, states, row, mask)
            self.row[0] = row + v.POINTS
        self.row[0] = stop[0]

    def report(self, report: v.Memory) -> None:
        """Of all rows: least and largest trail, least and largest energy."""
        for i, name in enumerate(("fmin", "fmax") * 2):
            report[i] = self._extremes[i].over_places(name)

    def _put(
        self, memory: v.Memory, values: list[v.Register], row: v.Register, mask: v.Register
    ) -> None:
        for i, value in enumerate(values):
            place = memory.part(self._count * i + row).address
            self._code.call("void", _MASKED.format("store"), value, place, self._aligned, mask)


def _clenshaw(series: v.Memory, zeroth: v.Register, x: v.Register, twice: v.Register) -> Any:
    """Chebyshev series of a variable."""
    *rest, last_but_one, last = series.load(v.POINTS)
    before, value = last.spread(), v.fused(twice, last, last_but_one)
    for coefficient in reversed(rest):
        before, value = value, v.fused(twice, value, coefficient - before)
    return v.fused(x, value, zeroth - before)


RUN = "run"
"""Name of the function, see `run_source`."""

_DIFFERENCE = 2.0**-24  # of the state, for the Jacobian: half of the digits
_MOST_ITERATIONS = 12
_DIVERGING = 0.5  # an iteration that reduces the error by less is given up
_CLOSE = 0.02  # of the tolerance: what is left of Newton's iteration
_SAFETY, _LEAST_CHANGE_OF_STEP, _MOST_CHANGE_OF_STEP = 0.9, 0.25, 2.5  # of a change of the step
_MOST_ERROR = 4.0  # of the tolerance; a step beyond is repeated
_SHORTEST_STEP = 2.0**-30  # [s]
_FIRST_PART = 0.25  # of the tolerance's root, over the rate of the fastest variable: the first step
_JOINED = 1.01  # of the rest: a last step much shorter than the one before is joined to it


def run_source(equations: Equations) -> str:
    """The module of function ``run``, for equations with constants in binary64.

    ``long run(start, rows, times, tolerance, most, columns, states, report)`` integrates from
    ``start`` (6 numbers) at time 0 through ascending ``times``, and writes eight columns, and six
    states unless that pointer is null, of so many rows, one variable after the other. It gives the
    number of steps, or -1 for a motion that cannot be continued, and -2 for more than ``most``
    steps. ``report`` gets the time reached, and of the rows the least and the largest of the
    mechanical trail over the front wheel's radius, and of the mechanical energy.
    """
    c = v.Code(f"i64 @{RUN}(ptr, i64, ptr, double, i64, ptr, ptr, ptr)")
    start, count, times, tolerance, most, columns, states, report = c.arguments
    rows, step = RowWriter(c, equations, count, times, columns, states), _Step(c, tolerance)
    step.state.store(start.load())
    step.lost.store([0.0] * v.STATE)
    end = times[count - 1]
    t, steps, result = c.variable(0.0), c.variable(0), c.variable(0)
    with v.Loop(c) as run:
        result[0] = -2
        run.leave(steps[0] >= most)
        result[0] = -1
        begin, (slopes, jacobian) = t[0], step.begin()
        with v.Loop(c) as attempt:
            is_last = step.wish[0] * _JOINED >= end - begin
            # The step is what the clock goes on by: else the clock would drift from the motion.
            after = is_last.choose(end, begin + step.wish[0])
            h = after - begin
            run.leave(~(h >= _SHORTEST_STEP))
            step.solve(h, slopes, jacobian, attempt)
            attempt.leave(step.judge(h))
        step.advance()
        rows.write(step.series, step.zeroth, begin, h, after)
        t[0], steps[0] = after, steps[0] + 1
        result[0] = steps[0]
        run.leave(rows.row[0] >= count)
    report[0] = t[0]
    rows.report(report.part(1))
    c.do(f"ret i64 {result[0].text}")
    return v.module(rates_code(equations), c)


class _Step:
    """A collocation step.

    Attributes
    ----------
    state, lost, zeroth
        Of each variable: at the beginning, what rounding took from it, coefficient 0.
    series
        Coefficients 1 to 8 of the step's Chebyshev series.
    wish
        Its length [s]; 0 before the first one.
    """

    def __init__(self, c: v.Code, tolerance: v.Register) -> None:
        self._code, self._tolerance, self._constants = c, tolerance, collocation()
        # From what is left at the points to the right side in modes, over the step's length.
        self._from_rest = self._constants.to_modes @ np.linalg.inv(self._constants.integral)
        # States at the points, increments since the beginning, derivatives, right sides in modes.
        self._y, self._z, self._f, self._right, self.series = (c.memory() for _ in range(5))
        self.state, self.lost, self.zeroth = (c.memory(kind=v.ONE) for _ in range(3))
        self.wish = c.variable(0.0)

    def begin(self) -> tuple[v.Registers, v.Registers]:
        """Derivatives at the beginning and their Jacobian, by differences in the places.

        The length of the first step is by its largest entry.
        """
        values = self.state.load()
        units = np.array([abs(x).at_least(1.0) * _DIFFERENCE for x in values])
        # The increment that is really added, after rounding.
        units = (values + units) - values
        places = [self._code.vector(x) for x in np.eye(v.STATE, v.POINTS, 1)]
        self._y.store(v.fused(units, places, values))
        call_rates(self._y, self._f)
        rates = np.array([self._f.numbers(k).load(v.STATE + 1) for k in range(v.STATE)])
        jacobian = (rates[:, 1:] - rates[:, :1]) / units
        fastest = _largest(jacobian.ravel()).at_least(0.0)
        first = v.eighth_root(self._tolerance) * (_FIRST_PART * v.POINTS) / fastest
        self.wish[0] = (self.wish[0] > 0.0).choose(self.wish[0], first)
        return rates[:, 0], jacobian

    def solve(
        self, h: v.Register, slopes: v.Registers, jacobian: v.Registers, attempt: v.Loop
    ) -> None:
        """Newton's iteration; where it does not converge the attempt is made with half the step."""
        c, m = self._code, self._constants
        inverse = 1.0 / h
        zero = c.vector([0.0] * (v.POINTS // 2))
        matrix = np.array([[Complex(zero - x, zero) for x in row] for row in jacobian])
        re, im = (c.vector(x) * inverse for x in (m.eigenvalues.real, m.eigenvalues.imag))
        for i in range(v.STATE):
            matrix[i, i] = Complex(matrix[i, i].re + re, im)
        factor(matrix)
        # Increments of zero: the derivatives at the points are those of the beginning.
        self._right.store(slopes * c.vector(self._from_rest @ m.points))
        self._z.store([0.0] * v.STATE)
        base = [x.spread() for x in self.state.load()]
        count, before = c.variable(1), c.variable(float("inf"))
        # Where it does not converge.
        self.wish[0] = h * 0.5
        with v.Loop(c) as iteration:
            right = np.array([Complex.of_halves(x) for x in self._right.load()])
            self._f.store(x.joined() for x in solve(matrix, right))
            changes = v.products(m.from_modes, self._f)
            self._z.store(self._z.load() + changes)
            size = _largest(changes).at_least(0.0).over_places("fmax")
            # The next change is as much smaller as this one is; of the first nothing is known.
            ratio, goal = size / before[0], self._tolerance * _CLOSE
            iteration.leave((count[0] > 1).choose(size * ratio <= goal, size <= goal))
            attempt.again((ratio >= _DIVERGING) | (count[0] >= _MOST_ITERATIONS))
            self._y.store(self._z.load() + base)
            call_rates(self._y, self._f)
            # Residual of the equations: increments from the derivatives, less the present ones.
            self._y.store(v.fused(h.spread(), v.products(m.integral, self._f), -self._z.load()))
            self._right.store(v.products(self._from_rest, self._y) * inverse.spread())
            count[0], before[0] = count[0] + 1, size

    def judge(self, h: v.Register) -> v.Register:
        """Accept a step by the end of its series, which gives the length of the next."""
        self.series.store(v.products(self._constants.series, self._z))
        error = _largest(_last(self.series))
        # Greatest values pass over what is no number; a sum does not.
        total = sum(_last(self._z), error)
        is_number = total <= total
        change = v.eighth_root(self._tolerance / error) * _SAFETY
        change = is_number.choose(
            change.at_most(_MOST_CHANGE_OF_STEP).at_least(_LEAST_CHANGE_OF_STEP),
            _LEAST_CHANGE_OF_STEP,
        )
        self.wish[0] = h * change
        return (error <= self._tolerance * _MOST_ERROR) & is_number

    def advance(self) -> None:
        """To the state at the end."""
        # The polynomial begins at the state: this gives its constant coefficient.
        signs = self._code.vector([1.0, -1.0] * (v.POINTS // 2))
        before = self.state.load()
        self.zeroth.store(before + [(x * signs).total() for x in self.series.load()])
        # The rounding error is added with the next step.
        x = _last(self._z) + self.lost.load()
        after = before + x
        added = after - before
        self.lost.store((x - added) + (before - (after - added)))
        self.state.store(after)


def _last(vectors: v.Memory) -> v.Registers:
    """The value in the last place of each variable's vector."""
    return np.array([vectors.numbers()[v.POINTS * (i + 1) - 1] for i in range(v.STATE)])


def _largest(values: v.Registers) -> v.Register:
    """The largest magnitude."""
    found: v.Register = reduce(v.Register.at_least, abs(values))
    return found
