"""Rows as code: eight at once, from the series of their step."""

from __future__ import annotations

from typing import Any

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.workbench.fast import vector_code as v
from heyoka_bike.workbench.fast.model_code import ENERGY, columns_and_trail

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
