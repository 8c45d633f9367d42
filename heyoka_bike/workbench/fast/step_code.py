"""A whole run as code: steps, dense output, rows and columns in one function.

The eight points of a collocation step lie in the eight places of a vector, so that one evaluation
of the equations serves them all, in little more than the time of a single one. Its system is
solved by Newton's iteration with the Jacobian of the step's beginning (differences in the places of
a vector, too), in modes, where it falls into four complex systems of six equations.

The step is chosen by the last coefficient of its Chebyshev series, which is about the error of the
dense output times the rate at which the coefficients fall.
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.workbench.fast import vector_code as v
from heyoka_bike.workbench.fast.collocation import collocation
from heyoka_bike.workbench.fast.complex_code import Complex, factor, solve
from heyoka_bike.workbench.fast.model_code import call_rates, rates_code
from heyoka_bike.workbench.fast.row_code import RowWriter

RUN = "run"
"""Name of the function, see `run_source`."""

_DIFFERENCE = 2.0**-24  # of the state, for the Jacobian: half of the digits
_MOST_ITERATIONS = 12
_DIVERGING = 0.5  # an iteration that reduces the error by less is given up
_CLOSE = 0.02  # of the tolerance: what is left of Newton's iteration
_SAFETY, _LEAST, _MOST = 0.9, 0.25, 2.5  # of a change of the step
_MOST_ERROR = 4.0  # of the tolerance; a step beyond is repeated
_SHORTEST = 2.0**-30  # [s]
_FIRST = 0.25  # of the tolerance's root, over the rate of the fastest variable: the first step
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
            run.leave(~(h >= _SHORTEST))
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
        first = v.eighth_root(self._tolerance) * (_FIRST * v.POINTS) / fastest
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
        change = is_number.choose(change.at_most(_MOST).at_least(_LEAST), _LEAST)
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
