"""Generate LLVM code of a whole run: steps, dense output, rows and columns.

The method is Radau's of order 15, collocation at eight points of a step: E. Hairer and G. Wanner,
Solving Ordinary Differential Equations II, 2nd edition, Springer 1996, sections IV.5 and IV.8. The
points occupy the eight places of a vector, so one evaluation of the equations serves them all, in
little more than the time of a single one. The polynomial through them has degree 8 and is accurate
to that degree over the whole step. Newton's iteration solves its system with the Jacobian at the
beginning of the step (by differences, also in the places of a vector). In modes the system splits
into four complex systems of six equations, which are solved side by side in half a vector. Rows are
written eight at a time, from the series of their step.

The last coefficient of the Chebyshev series controls the step size: it is about the error of the
dense output times the ratio of successive coefficients.
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
from heyoka_bike.workbench.fast.vector_code import LANES, Register, fused

_BITS_OF_NODES = 160


@dataclass(frozen=True, slots=True)
class Collocation:
    """Constants of the collocation method; the matrices act on columns of values at the points.

    Attributes
    ----------
    points : ndarray, shape (8,)
        Positions in the step, 0 to 1; the last one is its end.
    integral : ndarray, shape (8, 8)
        Matrix from derivatives to increments since the step's beginning, for length 1.
    eigenvalues : ndarray, shape (4,)
        Eigenvalues of the inverse of `integral` with positive imaginary part.
    to_modes : ndarray, shape (8, 8)
        Matrix from the points to the four modes: real parts, then imaginary parts.
    from_modes : ndarray, shape (8, 8)
        The inverse of `to_modes`.
    series : ndarray, shape (8, 8)
        Matrix from increments to coefficients 1 to 8 of their Chebyshev series over the step.
    """

    points: Array
    integral: Array
    eigenvalues: Array
    to_modes: Array
    from_modes: Array
    series: Array


@cache
def collocation() -> Collocation:
    """Compute the constants of the method in 160 bits (but the modes in binary64).

    The modes only precondition an iteration; its limit does not depend on them.
    """
    with working_bits(_BITS_OF_NODES):
        # Radau's points are the zeros of P_8 - P_7, the difference of two Legendre polynomials,
        # moved from the interval -1 to 1 to the interval 0 to 1.
        difference = flint.fmpq_poly.legendre_p(LANES) - flint.fmpq_poly.legendre_p(LANES - 1)
        roots: Any = difference.complex_roots()
        points = sorted(((x.real + 1) / 2 for x, _ in roots), key=float)
        powers = flint.arb_mat([[c**j for j in range(LANES)] for c in points])
        integrals = flint.arb_mat([[c**j / j for j in range(1, LANES + 1)] for c in points])
        integral = integrals * powers.inv()
        # The increment is zero at the beginning of the step. Subtracting T_j(-1) = (-1)^j
        # eliminates the coefficient of order 0.
        chebyshev = [
            [(2 * c - 1).chebyshev_t(j) - (-1) ** j for j in range(1, LANES + 1)] for c in points
        ]
        inverse, series = _rounded(integral.inv()), _rounded(flint.arb_mat(chebyshev).inv())
    values, vectors = np.linalg.eig(inverse)
    chosen = values.imag > 0
    # Each mode is added to its complex conjugate, and z + conj(z) = 2 Re z.
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
"""An array of `Complex`."""


@dataclass(frozen=True, slots=True)
class Complex:
    """Four complex numbers, as vectors of their real and imaginary parts."""

    re: Register
    im: Register

    @staticmethod
    def of_halves(x: Register) -> Complex:
        """Take the first half of a vector as real parts and the second as imaginary parts."""
        return Complex(x.places(range(LANES // 2)), x.places(range(LANES // 2, LANES)))

    def joined(self) -> Register:
        """Return real and imaginary parts as one vector."""
        return self.re.places(range(LANES), self.im)

    def __mul__(self, other: Complex) -> Complex:
        return Complex(
            fused(self.re, other.re, -(self.im * other.im)),
            fused(self.re, other.im, self.im * other.re),
        )

    def inverse(self) -> Complex:
        over = 1.0 / fused(self.re, self.re, self.im * self.im)
        return Complex(self.re * over, -(self.im * over))

    def without(self, x: Complex, y: Complex) -> Complex:
        """Return this number minus the product of two others."""
        minus = -x.re
        return Complex(
            fused(x.im, y.im, fused(minus, y.re, self.re)),
            fused(-x.im, y.re, fused(minus, y.im, self.im)),
        )


_without = np.frompyfunc(Complex.without, 3, 1)


def factor(m: Numbers) -> None:
    """Factor four complex matrices in place (LU); the diagonal receives inverses of pivots.

    No pivoting is needed: a short step makes the diagonal large, and if the iteration does not
    converge, the step is shortened.
    """
    for k in range(len(m)):
        m[k, k] = m[k, k].inverse()
        rest = slice(k + 1, None)
        m[rest, k] *= m[k, k]
        m[rest, rest] = _without(m[rest, rest], m[rest, k : k + 1], m[k, rest])


def solve(m: Numbers, x: Numbers) -> Numbers:
    """Solve four complex systems with the result of `factor`; the solution replaces `x`."""
    for k in range(len(m)):
        x[k + 1 :] = _without(x[k + 1 :], m[k + 1 :, k], x[k])
    for k in reversed(range(len(m))):
        x[k] *= m[k, k]
        x[:k] = _without(x[:k], m[:k, k], x[k])
    return x


_MASKED = f"llvm.masked.{{}}.v{v.LANES}f64.p0"


class RowWriter:
    """Generates the code that writes the rows of a run.

    Parameters
    ----------
    c, equations
        The function, and the equations that give the columns.
    count, times
        Number and times of the rows.
    columns, states
        Memory that receives one variable after the other; that for states is optional.

    Attributes
    ----------
    row
        Index of the next row.
    """

    def __init__(
        self, c: v.Code, equations: Equations, count: v.Register, times: v.Memory,
        columns: v.Memory, states: v.Memory,
    ) -> None:  # fmt: skip
        self._code, self._equations = c, equations
        self._count, self._times, self._columns, self._states = count, times, columns, states
        self.row = c.variable(0)
        self._aligned = v.Register(c, "i32", "8")  # size of an address [bytes]
        # Memory for the minimum and maximum of the mechanical trail and of the energy.
        self._extremes = c.memory(4)
        self._extremes.store([float("inf"), -float("inf")] * 2)

    def write(
        self, series: v.Memory, zeroth: v.Memory, begin: v.Register, h: v.Register, end: v.Register
    ) -> None:
        """Write the rows up to the end of a step, from the Chebyshev series of the step."""
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
            mask = c.vector(range(v.LANES)) < stop[0] - row
            place = self._times.part(row).address
            time = c.call(middle.kind, _MASKED.format("load"), place, self._aligned, mask, middle)
            x = ((time - middle) * rate).at_most(1.0)
            twice = x + x
            states = [
                _clenshaw(series.numbers(i), zeroth[i], x, twice) for i in range(v.STATE_SIZE)
            ]
            *columns, trail = columns_and_trail(self._equations, states)
            self._put(self._columns, columns, row, mask)
            for i, value in enumerate((trail, columns[ENERGY])):
                self._extremes[2 * i] = self._extremes[2 * i].at_most(value)
                self._extremes[2 * i + 1] = self._extremes[2 * i + 1].at_least(value)
            with c.unless(self._states.address.is_null()):
                self._put(self._states, states, row, mask)
            self.row[0] = row + v.LANES
        self.row[0] = stop[0]

    def report(self, report: v.Memory) -> None:
        """Write the minimum and maximum of trail and energy over all rows to `report`."""
        for i, name in enumerate(("fmin", "fmax") * 2):
            report[i] = self._extremes[i].over_places(name)

    def _put(
        self, memory: v.Memory, values: list[v.Register], row: v.Register, mask: v.Register
    ) -> None:
        for i, value in enumerate(values):
            place = memory.part(self._count * i + row).address
            self._code.call("void", _MASKED.format("store"), value, place, self._aligned, mask)


def _clenshaw(series: v.Memory, zeroth: v.Register, x: v.Register, twice: v.Register) -> Any:
    """Evaluate the Chebyshev series of a variable by Clenshaw's recurrence."""
    *rest, last_but_one, last = series.load(v.LANES)
    before, value = last.spread(), v.fused(twice, last, last_but_one)
    for coefficient in reversed(rest):
        before, value = value, v.fused(twice, value, coefficient - before)
    return v.fused(x, value, zeroth - before)


RUN = "run"
"""Name of the LLVM function, see `run_source`."""

# Relative step of the finite differences for the Jacobian. It makes them accurate to half of the
# digits.
_DIFFERENCE = 2.0**-24
_MOST_ITERATIONS = 12
# Newton's iteration is given up if a change is at least this factor times the previous change.
_DIVERGING = 0.5
# Newton's iteration has converged if its next change is expected to be below this fraction of the
# tolerance.
_CLOSE = 0.02
# Safety factor, and smallest and largest factor by which the step controller changes a step.
_SAFETY, _LEAST_CHANGE_OF_STEP, _MOST_CHANGE_OF_STEP = 0.9, 0.25, 2.5
_MOST_ERROR = 4.0  # number of tolerances: a step with a larger error is repeated
_SHORTEST_STEP = 2.0**-30  # [s]
# Length of the first step, in units of LANES * tolerance**(1/8) / r, where r is the largest
# magnitude of an element of the Jacobian.
_FIRST_PART = 0.25
_JOINED = 1.01  # stretch a step by at most this factor to avoid a tiny last step


def run_source(equations: Equations) -> str:
    """Return the LLVM module with the function ``run``, which integrates a motion.

    ``long run(start, rows, times, tolerance, most, columns, states, report)`` integrates from
    ``start`` (6 numbers) at time 0 through ascending ``times``. It writes eight columns of ``rows``
    rows, one variable after the other, and six states unless that pointer is null. It returns the
    number of steps, -1 for a motion that cannot be continued, or -2 for more than ``most`` steps.
    ``report`` receives the time reached, and minimum and maximum over the rows of the mechanical
    trail / front wheel radius and of the mechanical energy. The constants of `equations` are in
    binary64.
    """
    c = v.Code(f"i64 @{RUN}(ptr, i64, ptr, double, i64, ptr, ptr, ptr)")
    start, count, times, tolerance, most, columns, states, report = c.arguments
    rows, step = RowWriter(c, equations, count, times, columns, states), _Step(c, tolerance)
    step.state.store(start.load())
    step.lost.store([0.0] * v.STATE_SIZE)
    end = times[count - 1]
    t, steps, result = c.variable(0.0), c.variable(0), c.variable(0)
    with v.Loop(c) as run:
        result[0] = -2
        run.leave(steps[0] >= most)
        result[0] = -1
        begin, (slopes, jacobian) = t[0], step.begin()
        with v.Loop(c) as attempt:
            is_last = step.wish[0] * _JOINED >= end - begin
            # Round the new time first, so that the step is exactly the difference of two times.
            # Otherwise the time would drift away from the motion.
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
    """Generates the code of a collocation step.

    Attributes
    ----------
    state, lost, zeroth
        Value at the beginning, rounding error, and coefficient 0 of each variable.
    series
        Coefficients 1 to 8 of the step's Chebyshev series.
    wish
        Length of the step [s]; 0 before the first one.
    """

    def __init__(self, c: v.Code, tolerance: v.Register) -> None:
        self._code, self._tolerance, self._constants = c, tolerance, collocation()
        # Matrix that converts residuals at the points to the right-hand sides of the linear systems
        # of the modes, for a step of length 1.
        self._from_rest = self._constants.to_modes @ np.linalg.inv(self._constants.integral)
        # Memory for the states at the points, the increments since the beginning of the step, the
        # derivatives, the right-hand sides for the modes, and the series.
        self._y, self._z, self._f, self._right, self.series = (c.memory() for _ in range(5))
        self.state, self.lost, self.zeroth = (c.memory(kind=v.ONE) for _ in range(3))
        self.wish = c.variable(0.0)

    def begin(self) -> tuple[v.Registers, v.Registers]:
        """Compute the derivatives at the beginning of the step, and their Jacobian by differences.

        One place of the vector contains the state, and each other place changes one variable. The
        largest element of the Jacobian determines the length of the first step.
        """
        values = self.state.load()
        units = np.array([abs(x).at_least(1.0) * _DIFFERENCE for x in values])
        # Divide by the increments that remain after rounding, not by the intended increments.
        units = (values + units) - values
        places = [self._code.vector(x) for x in np.eye(v.STATE_SIZE, v.LANES, 1)]
        self._y.store(v.fused(units, places, values))
        call_rates(self._y, self._f)
        rates = np.array([self._f.numbers(k).load(v.STATE_SIZE + 1) for k in range(v.STATE_SIZE)])
        jacobian = (rates[:, 1:] - rates[:, :1]) / units
        fastest = _largest(jacobian.ravel()).at_least(0.0)
        first = v.eighth_root(self._tolerance) * (_FIRST_PART * v.LANES) / fastest
        self.wish[0] = (self.wish[0] > 0.0).choose(self.wish[0], first)
        return rates[:, 0], jacobian

    def solve(
        self, h: v.Register, slopes: v.Registers, jacobian: v.Registers, attempt: v.Loop
    ) -> None:
        """Run Newton's iteration; if it does not converge, try again with half the step."""
        c, m = self._code, self._constants
        inverse = 1.0 / h
        zero = c.vector([0.0] * (v.LANES // 2))
        matrix = np.array([[Complex(zero - x, zero) for x in row] for row in jacobian])
        re, im = (c.vector(x) * inverse for x in (m.eigenvalues.real, m.eigenvalues.imag))
        for i in range(v.STATE_SIZE):
            matrix[i, i] = Complex(matrix[i, i].re + re, im)
        factor(matrix)
        # Begin with increments of zero, so the derivatives at all points equal those at the
        # beginning of the step.
        self._right.store(slopes * c.vector(self._from_rest @ m.points))
        self._z.store([0.0] * v.STATE_SIZE)
        base = [x.spread() for x in self.state.load()]
        count, before = c.variable(1), c.variable(float("inf"))
        # This step size will be tried if the iteration does not converge.
        self.wish[0] = h * 0.5
        with v.Loop(c) as iteration:
            right = np.array([Complex.of_halves(x) for x in self._right.load()])
            self._f.store(x.joined() for x in solve(matrix, right))
            changes = v.products(m.from_modes, self._f)
            self._z.store(self._z.load() + changes)
            size = _largest(changes).at_least(0.0).over_places("fmax")
            # The ratio of two changes predicts the next change. After the first change no ratio is
            # known, so this change itself must be small enough.
            ratio, goal = size / before[0], self._tolerance * _CLOSE
            iteration.leave((count[0] > 1).choose(size * ratio <= goal, size <= goal))
            attempt.again((ratio >= _DIVERGING) | (count[0] >= _MOST_ITERATIONS))
            self._y.store(self._z.load() + base)
            call_rates(self._y, self._f)
            # Residual of the collocation equations: the increments computed from the derivatives,
            # minus the present increments.
            self._y.store(v.fused(h.spread(), v.products(m.integral, self._f), -self._z.load()))
            self._right.store(v.products(self._from_rest, self._y) * inverse.spread())
            count[0], before[0] = count[0] + 1, size

    def judge(self, h: v.Register) -> v.Register:
        """Return true if a step is accurate enough, and choose the length of the next step."""
        self.series.store(v.products(self._constants.series, self._z))
        error = _largest(_last(self.series))
        # Use a sum to detect NaN: a sum is NaN if any of its terms is NaN, but a maximum ignores
        # NaN.
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
        """Advance to the state at the end of the step."""
        # The series equals the state at the beginning of the step. This determines its constant
        # coefficient.
        signs = self._code.vector([1.0, -1.0] * (v.LANES // 2))
        before = self.state.load()
        self.zeroth.store(before + [(x * signs).total() for x in self.series.load()])
        # Compensated summation: the next step adds the rounding error of this step.
        x = _last(self._z) + self.lost.load()
        after = before + x
        added = after - before
        self.lost.store((x - added) + (before - (after - added)))
        self.state.store(after)


def _last(vectors: v.Memory) -> v.Registers:
    """Return the last value of each variable's vector: that at the end of the step."""
    return np.array([vectors.numbers()[v.LANES * (i + 1) - 1] for i in range(v.STATE_SIZE)])


def _largest(values: v.Registers) -> v.Register:
    """Return the largest magnitude of some values."""
    found: v.Register = reduce(v.Register.at_least, abs(values))
    return found
