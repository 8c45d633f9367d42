"""The reduced equations of one bicycle, in one number type and one form.

Everything that follows from a state starts here: the rates of the state, its columns, its energies.
Constants are computed once. Formulas are then evaluated in the number type of the constants, or in
one that accepts them (a series over balls, a dual number over a series; see `Equations.over`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace

from heyoka_bike.bicycle.columns import COLUMNS, NORMS
from heyoka_bike.bicycle.equations.bodies import Bodies, bodies
from heyoka_bike.bicycle.equations.constants import Constants, constants
from heyoka_bike.bicycle.equations.kinematics import Posture, Speeds, state_names, unfold
from heyoka_bike.bicycle.equations.model import few_product_rates, regular_rates
from heyoka_bike.bicycle.equations.outputs import Energies, columns, energies, yaw_rate
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arithmetic, Arrays, Multiprecision, Number

_DIGITS_BEFORE_ROUNDING = 25  # digits of constants before they are rounded to binary64


@dataclass(frozen=True, slots=True)
class Equations:
    """The equations of a bicycle.

    Attributes
    ----------
    bicycle : Bicycle
    k : Constants
        Constants of the reduced equations.
    b : Bodies
        The four separate bodies, for forces and positions.
    a : Arithmetic
        Number type in which formulas are evaluated.
    is_regular : bool
        Form of the equations and of the state, see `model`.
    """

    bicycle: Bicycle
    k: Constants
    b: Bodies
    a: Arithmetic
    is_regular: bool = True

    @classmethod
    def of(cls, bicycle: Bicycle, a: Arithmetic, *, is_regular: bool = True) -> Equations:
        """Return the equations of a bicycle, with constants in the number type of `a`."""
        with _precision(a):
            return cls(bicycle, constants(bicycle, a), bodies(bicycle, a), a, is_regular)

    @classmethod
    def binary64(cls, bicycle: Bicycle, *, is_regular: bool = True) -> Equations:
        """Return the equations with constants of 25 digits, rounded to binary64, for arrays."""
        exact = cls.of(bicycle, Multiprecision(_DIGITS_BEFORE_ROUNDING), is_regular=is_regular)
        return exact.convert(float, Arrays())

    def over(self, a: Arithmetic) -> Equations:
        """Return the same equations for another number type, which accepts the constants."""
        return replace(self, a=a)

    def convert(self, make: Callable[[Number], Number], a: Arithmetic) -> Equations:
        """Return the equations with `make` applied to each constant, to be evaluated in `a`."""
        return replace(self, k=self.k.convert(make), b=self.b.convert(make), a=a)

    def precision(self) -> AbstractContextManager[None]:
        """Return a context manager that sets the working precision, if the number type has one."""
        return _precision(self.a)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the state variables, the yaw last."""
        return (*state_names(self.is_regular), "yaw")

    def unfold(self, state: Sequence[Number]) -> tuple[Posture, Speeds]:
        """Return posture and speeds of a state; the yaw does not enter and may be left out."""
        return unfold(self.k, self.a, state, is_regular=self.is_regular)

    def rates(self, state: Sequence[Number]) -> list[Number]:
        """Return the time derivatives of the six state variables that determine the motion."""
        return self._rates(state, *self.unfold(state))

    def rates_with_yaw(self, state: Sequence[Number]) -> list[Number]:
        """Return the time derivatives of all seven state variables."""
        o, u = self.unfold(state)
        return [*self._rates(state, o, u), yaw_rate(o, u)]

    def columns(self, state: Sequence[Number], *, is_smooth: bool = False) -> Mapping[str, Number]:
        """Return every column of `columns.COLUMNS` by name, SI units.

        The yaw is the seventh entry of the state. `is_smooth` leaves out `NORMS`, which are not
        smooth at rest.
        """
        o, u = self.unfold(state)
        roll, pitch, steer = state[:3]
        return columns(self.k, self.a, o, u, roll, pitch, steer, state[6], is_smooth=is_smooth)

    def every_column(self, state: Sequence[Number]) -> list[Number]:
        """Return all columns in the order of `columns.COLUMNS`."""
        values = self.columns(state)
        return [values[c.name] for c in COLUMNS]

    def smooth_columns(self, state: Sequence[Number]) -> list[Number]:
        """Return all columns except `NORMS`, in the order of `columns.COLUMNS`."""
        values = self.columns(state, is_smooth=True)
        return [values[c.name] for c in COLUMNS if c.name not in NORMS]

    def norms(self, state: Sequence[Number]) -> list[Number]:
        """Return the values of `NORMS`, in their order."""
        values = self.columns(state)
        return [values[name] for name in NORMS]

    def _rates(self, state: Sequence[Number], o: Posture, u: Speeds) -> list[Number]:
        if self.is_regular:
            return regular_rates(self.k, self.a, o, u, state[3])
        return few_product_rates(self.k, self.a, o, u)

    def energies(self, state: Sequence[Number]) -> Energies:
        """Return potential and kinetic energy [J]."""
        return energies(self.k, *self.unfold(state))

    def masses(self, posture: Sequence[Number]) -> dict[tuple[int, int], Number]:
        """Return the entries of the mass matrix by (row, column), with row <= column.

        The matrix is for roll rate, steer rate and forward speed, and follows from the kinetic
        energies of unit speeds and of their sums, in the regular form.
        """
        zero, units = 0 * posture[0], (1, 1, 1 / self.k.length)

        def twice(*moving: int) -> Number:
            rates = [zero + u * moving.count(i) for i, u in enumerate(units)]
            return 2 * self.energies([*posture, *rates]).kinetic

        alone = [twice(i) for i in range(3)]
        return {
            (i, j): alone[i] if i == j else (twice(j, i) - alone[j] - alone[i]) / 2
            for i in range(3)
            for j in range(i, 3)
        }


def _precision(a: Arithmetic) -> AbstractContextManager[None]:
    context: AbstractContextManager[None] = getattr(a, "precision", nullcontext)()
    return context
