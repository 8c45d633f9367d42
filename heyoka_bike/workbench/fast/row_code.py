"""Rows as code: eight at once, from the series of their step."""

from __future__ import annotations

from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.workbench.fast.model_code import columns_and_trail
from heyoka_bike.workbench.fast.vector_code import (
    POINTS,
    STATE,
    Code,
    Loop,
    Memory,
    Register,
    fused,
)

_MASKED = f"llvm.masked.{{}}.v{POINTS}f64.p0"
_ENERGY = BENCHMARK_COLUMNS.index("mechanical_energy")


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
        self, c: Code, equations: Equations, count: Register, times: Memory, columns: Memory,
        states: Memory,
    ) -> None:  # fmt: skip
        self._code, self._equations = c, equations
        self._count, self._times, self._columns, self._states = count, times, columns, states
        self.row = c.variable(0)
        self._aligned = Register(c, "i32", "8")  # bytes of an address
        # Least and largest of mechanical trail and energy.
        self._extremes = c.memory(4)
        self._extremes.store([float("inf"), -float("inf")] * 2)

    def write(
        self, series: Memory, zeroth: Memory, begin: Register, h: Register, end: Register
    ) -> None:
        """Those up to the end of a step, from coefficients 1 to 8 of its series, and 0."""
        c, half = self._code, h * 0.5
        middle, rate = (begin + half).spread(), (1.0 / half).spread()
        stop = c.variable(self.row[0])
        with Loop(c) as counting:
            counting.leave(stop[0] >= self._count)
            counting.leave(self._times[stop[0]] > end)
            stop[0] += 1
        with Loop(c) as block:
            row = self.row[0]
            block.leave(row >= stop[0])
            mask = c.vector(range(POINTS)) < stop[0] - row
            place = self._times.part(row).address
            time = c.call(middle.kind, _MASKED.format("load"), place, self._aligned, mask, middle)
            x = ((time - middle) * rate).at_most(1.0)
            twice = x + x
            states = [_clenshaw(series.numbers(i), zeroth[i], x, twice) for i in range(STATE)]
            *columns, trail = columns_and_trail(self._equations, states)
            self._put(self._columns, columns, row, mask)
            for i, value in enumerate((trail, columns[_ENERGY])):
                self._extremes[2 * i] = self._extremes[2 * i].at_most(value)
                self._extremes[2 * i + 1] = self._extremes[2 * i + 1].at_least(value)
            with c.unless(self._states.address.is_null()):
                self._put(self._states, states, row, mask)
            self.row[0] = row + POINTS
        self.row[0] = stop[0]

    def report(self, report: Memory) -> None:
        """Of all rows: least and largest trail, least and largest energy."""
        for i, name in enumerate(("fmin", "fmax") * 2):
            report[i] = self._extremes[i].over_places(name)

    def _put(self, memory: Memory, values: list[Register], row: Register, mask: Register) -> None:
        for i, value in enumerate(values):
            place = memory.part(self._count * i + row).address
            self._code.call("void", _MASKED.format("store"), value, place, self._aligned, mask)


def _clenshaw(series: Memory, zeroth: Register, x: Register, twice: Register) -> Any:
    """Chebyshev series of a variable."""
    *rest, last_but_one, last = series.load(POINTS)
    before, value = last.spread(), fused(twice, last, last_but_one)
    for coefficient in reversed(rest):
        before, value = value, fused(twice, value, coefficient - before)
    return fused(x, value, zeroth - before)
