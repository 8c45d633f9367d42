"""The start and the constants of the equations with their derivatives by the unknowns.

The unknowns are those of `sensitivities.UNKNOWNS`: 26 parameters and five numbers of the start.
Derivatives are exact: dual numbers over fractions, then over the number type that is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import frexp

import flint

from heyoka_bike.bicycle.equations.constants import Assembly, Constants, constants_of
from heyoka_bike.bicycle.equations.initial import pitch_at_start, varied_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.arithmetic import Arithmetic, Number, value_of
from heyoka_bike.numbers.ball_matrices import largest
from heyoka_bike.numbers.dual import Dual, Duals, Traced, Traces
from heyoka_bike.reference.proof.cauchy import Function

COUNT = len(PARAMETERS) + len(START)


@dataclass(frozen=True)
class Varied:
    """Constants and initial state of a motion, as dual numbers by the unknowns.

    Attributes
    ----------
    k : Constants
    state : list
        At t = 0, the yaw last.
    """

    k: Constants
    state: list[Number]

    @classmethod
    def of(
        cls, bicycle: Bicycle, maneuver: Maneuver, pitch: Number, a: Arithmetic, *, is_regular: bool
    ) -> Varied:
        """In the number type of `a`; `pitch` is that of the start."""
        duals = Duals(a)
        symbols = list(PARAMETERS)
        p = {s: _unknown(x.rational, symbols.index(s)) for s, x in bicycle.values.items()}
        tilt = _unknown(a.number(bicycle["lam"]), symbols.index("lam"))
        k = constants_of(p, tilt, duals, is_vertical=bicycle["lam"].is_zero)
        start = {
            key: _unknown(a.number(getattr(maneuver, key)), len(symbols) + i)
            for i, key in enumerate(START)
        }
        return cls(k, varied_state(k, duals, start, pitch, is_regular=is_regular))

    def columns(self, equations: Equations) -> Mapping[str, Number]:
        """All columns at t = 0."""
        return replace(equations, k=self.k, a=Duals(equations.a)).columns(self.state)

    def is_smooth(self, unknown: int) -> bool:
        """True if the equations have a derivative by an unknown.

        They are in the ratio of two inertias of an assembly. Where all of its mass is on a line
        along the steer axis both are zero, and what moves one of them has no limit.
        """
        return not any(_moves(x, unknown) for x in (self.k.rear, self.k.front))


@dataclass(frozen=True)
class Unknowns:
    """Derivatives of the constants and of the start as matrices, in units of each unknown.

    Attributes
    ----------
    varied : Varied
    smooth : tuple of int
        The unknowns by which there are derivatives.
    units : tuple of int
        Each is counted in 2 to the power of this, so that largest entries are between 1/2 and 1.
    constants : tuple of int
        The constants that depend on unknowns, by their place among all.
    by_constant : arb_mat
        Derivatives of these constants, a row each.
    start : arb_mat
        Derivatives of the state at t = 0.
    """

    varied: Varied
    smooth: tuple[int, ...]
    units: tuple[int, ...]
    constants: tuple[int, ...]
    by_constant: flint.arb_mat
    start: flint.arb_mat

    @classmethod
    def of(cls, run: Trajectory, equations: Equations) -> Unknowns:
        """Of a run, in the precision of its equations in balls."""
        with equations.precision():
            pitch = pitch_at_start(equations, run.maneuver)
            varied = Varied.of(
                run.bicycle, run.maneuver, pitch, equations.a, is_regular=run.is_regular
            )
            numbers: list[Number] = []
            varied.k.convert(numbers.append)
            smooth = tuple(i for i in range(COUNT) if varied.is_smooth(i))
            rows = [[slope(x, i) for i in smooth] for x in numbers]
            constants = tuple(j for j, row in enumerate(rows) if any(s != 0 for s in row))
            rows = [rows[j] for j in constants]
            start = [[slope(x, i) for i in smooth] for x in varied.state]
            sizes = [
                largest(abs(flint.arb(x)) for x in column)
                for column in zip(*start, *rows, strict=True)
            ]
            units = tuple(-frexp(float(x.mid()))[1] for x in sizes)

            def scaled(table: list[list[Number]]) -> flint.arb_mat:
                return flint.arb_mat(
                    [
                        [x * flint.arb(2) ** e for x, e in zip(row, units, strict=True)]
                        for row in table
                    ]
                )

            return cls(varied, smooth, units, constants, scaled(rows), scaled(start))

    def gradients(
        self, function: Function, equations: Equations, a: Arithmetic, state: Sequence[Number]
    ) -> list[list[Number]]:
        """Derivatives of the values of a function by the state, and then by `constants`.

        In the numbers of `a`, which take the constants of `equations`; the integer 0 by what a
        value is not made of. These are many, so they are taken from the values back.
        """
        traces, numbers = Traces(a), list[Number]()

        def constant(x: Number) -> Number:
            numbers.append(Traced(x) if len(numbers) in self.constants else x)
            return numbers[-1]

        k, by_state = equations.k.convert(constant), [Traced(x) for x in state]
        variables = [*by_state, *(numbers[j] for j in self.constants)]
        values = function(replace(equations.over(traces), k=k), by_state)
        return [traces.gradient(x, variables) for x in values]


def slope(x: Number, unknown: int) -> Number:
    """The derivative of a number by an unknown."""
    return x.slopes[unknown] if isinstance(x, Dual) else 0


def _unknown(value: Number, i: int) -> Dual:
    return Dual(value, tuple(1 if i == j else 0 for j in range(COUNT)))


def _moves(x: Assembly, unknown: int) -> bool:
    if value_of(x.i33) != 0:
        return False
    return any(slope(inertia, unknown) != 0 for inertia in (x.i13, x.i33))
