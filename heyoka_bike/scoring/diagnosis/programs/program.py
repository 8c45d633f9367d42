"""Model of a program: its bicycle, its initial conditions, its clock and its output.

Initial velocities that violate rolling cannot be simulated. Programs that enforce constraints at
velocity level replace them with the admissible velocities that are nearest in kinetic energy. An
impulse of the constraint forces has the same effect: u = (J^T M J)^-1 J^T M v, with the Jacobian J
of the body velocities v with respect to roll rate, steer rate and speed. Admissible velocities do
not change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS, FOLLOWING
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.vectors import Vector
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, Moving
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.rows.edits import (
    Change,
    Clock,
    Columns,
    Edit,
    Rewritten,
    Stage,
    meant_times,
    written,
)

NAMES = (
    *(c.name for c in (*COLUMNS, *FOLLOWING)),
    "spin_energy", "spin_energy_R", "spin_energy_F", "rotation_energy", "rotation_energy_of_wheels",
    *(f"{x}_energy_of_{body}" for x in ("kinetic", "potential", "rotation") for body in "RBHF"),
)  # fmt: skip
"""Names of the columns that are computed for a motion."""

Parameters = dict[str, float]
"""Parameters of a bicycle, by symbol [SI]."""


@dataclass(frozen=True, slots=True)
class Terms:
    """Powers of speed and gravity that multiply the matrices of the linear equations.

    None for a matrix that is left out; see `linear`.

    Attributes
    ----------
    c1, k0, k2
        Power of the speed that multiplies C1, of gravity that multiplies K0, and of the speed that
        multiplies K2.
    """

    c1: int | None = 1
    k0: int | None = 1
    k2: int | None = 2


BODIES = "RBHF"
"""Rear wheel, frame with rider, fork with handlebar, front wheel."""

INITIAL_STATE = ("roll", "pitch", "steer", "roll_rate", "steer_rate", "speed")
"""Names of the numbers that `initial_state` returns."""


@dataclass(frozen=True, slots=True)
class Start:
    """Velocities given to the bodies at t = 0.

    Attributes
    ----------
    speed, roll_rate
        [m/s], [rad/s]
    rolling
        Bodies that start with the roll rate.
    turning
        Of these bodies, those that also turn with it; the centres of mass of the others only move.
    rear_spin, front_spin
        Initial spin of each wheel, relative to the speed divided by its radius.
    about_centre
        True if the roll is about a line through the centre of mass, not about one on the ground.
    speed_of_centre
        True if the speed is that of the centre of mass, not that of the rear hub.
    falling
        True if the centres of mass start with the sideways velocities that belong to the roll rate.
    steer_rate
        Added to the steer rate that rolling requires [rad/s].
    added
        Changes of the state that follows: pairs of an index in `INITIAL_STATE` and a change [SI].
    """

    speed: float
    roll_rate: float
    rolling: frozenset[str] = frozenset(BODIES)
    turning: frozenset[str] = frozenset(BODIES)
    rear_spin: float = 1.0
    front_spin: float = 1.0
    about_centre: bool = False
    speed_of_centre: bool = False
    falling: bool = True
    steer_rate: float = 0.0
    added: tuple[tuple[int, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Motion:
    """The motion that a program computes. Equal motions are simulated once.

    Attributes
    ----------
    bicycle : Bicycle
    starts
        Initial conditions by number of the maneuver.
    amounts
        Pairs of name and coefficient, for additional forces and for missing terms, see `forces`.
    linear : Terms or None
        Terms of the linearised equations; None for the nonlinear equations.
    """

    bicycle: Bicycle
    starts: Mapping[int, Start]
    amounts: tuple[tuple[str, float], ...] = ()
    linear: Terms | None = None


@dataclass(frozen=True, slots=True)
class Program:
    """A program: the motion that it computes, and the edits (changes) of its output.

    Attributes
    ----------
    motion : Motion
    edits : tuple of Edit
    """

    motion: Motion
    edits: tuple[Edit, ...] = ()

    def moving(self, **changes: Any) -> Program:
        """Return the program with some attributes of its motion changed."""
        return replace(self, motion=replace(self.motion, **changes))

    def edited(self, edit: Edit) -> Program:
        """Return the program with one more edit of its output."""
        return replace(self, edits=(*self.edits, edit))

    def clock(self, time: Array, step: float) -> Array:
        """Convert written times to times of the motion, which are at least 0 [s]."""
        return meant_times(self.edits, time, step)

    def written(self, columns: Columns, time: Array) -> Columns:
        """Return the columns that the program writes, from the columns of its motion."""
        return written(self.edits, columns, time)


@dataclass(frozen=True, slots=True)
class FittedValue:
    """A fitted value that explains a file.

    Attributes
    ----------
    name
        A parameter, a force, or ``initial_`` and a member of `INITIAL_STATE`.
    maneuver
        Number of the maneuver for an initial value; otherwise None.
    value, right
        The fitted value, and the value in the correct program [SI].
    uncertain
        A further change by this amount would double the remaining error [SI].
    """

    name: str
    maneuver: int | None
    value: float
    right: float
    uncertain: float

    @property
    def is_whole_term(self) -> bool:
        """True if the value is the missing fraction of a term, and the whole term is missing."""
        is_part = self.name in FORCES and FORCES[self.name].is_part
        return is_part and abs(self.value - 1.0) < TOLERANCE

    @property
    def key(self) -> str:
        """Name of the value among the changes that `changed` takes."""
        return self.name if self.maneuver is None else f"{self.name}_{self.maneuver}"


@dataclass(frozen=True, slots=True)
class Cause:
    """A difference of a program from the correct one.

    Attributes
    ----------
    code
        Stable name.
    says
        A clause for messages: what the program does.
    check
        The place to check in the user's program.
    kind
        ``model``, ``start``, ``output``, or ``method`` for an integrator of the correct equations.
        All kinds but ``output`` change the motion.
    change
        Function from a program to the program with this difference.
    """

    code: str
    says: str
    check: str
    kind: str
    change: Callable[[Program], Program]

    @property
    def found(self) -> tuple[FittedValue, ...]:
        """The fitted values, if the cause consists of these; otherwise empty."""
        return ()

    @property
    def fitted(self) -> int:
        """Number of values that were fitted to the file."""
        return len(self.found)

    @property
    def changes(self) -> dict[str, float]:
        """Differences between fitted and correct values, as an argument of `changed`."""
        return {x.key: x.value - x.right for x in self.found}


@dataclass(frozen=True, slots=True)
class Mistake(Cause):
    """A usual mistake from the library."""


@dataclass(frozen=True, slots=True)
class OtherScale(Cause):
    """Times multiplied by a scale that was fitted to the file."""

    @property
    def fitted(self) -> int:
        """Return 1, because one value was fitted: the scale."""
        return 1


@dataclass(frozen=True, slots=True)
class FittedValues(Cause):
    """Parameters, forces or initial conditions with values that were fitted to the file.

    Attributes
    ----------
    values : tuple of FittedValue
    """

    values: tuple[FittedValue, ...]

    @property
    def found(self) -> tuple[FittedValue, ...]:
        """The fitted values."""
        return self.values

    @property
    def fitted(self) -> int:
        """Number of values that were fitted; a term that is missing as a whole needs no value."""
        return sum(not x.is_whole_term for x in self.values)


@dataclass(frozen=True, slots=True)
class NumericalMethod(Cause):
    """The correct equations, integrated by a method with a fixed step.

    Attributes
    ----------
    method
        Name of the method.
    step
        Step that was fitted to the file [s].
    """

    method: str
    step: float

    @property
    def fitted(self) -> int:
        """Return 1, because one value was fitted: the step."""
        return 1


def apply(program: Program, mistakes: Iterable[Cause]) -> Program:
    """Return the program with all of the mistakes."""
    for mistake in mistakes:
        program = mistake.change(program)
    return program


def differences(one: Program, other: Program) -> set[str]:
    """Return the names of the parameters, forces and terms in which two programs differ."""
    a, b = ({**p.motion.bicycle.values, **dict(p.motion.amounts)} for p in (one, other))
    return {name for name in a.keys() | b.keys() if a.get(name) != b.get(name)}


def initial_state(bicycle: Bicycle, start: Start) -> tuple[float, ...]:
    """Compute roll, pitch, steer, roll rate, steer rate [rad, rad/s] and speed [m/s] at t = 0.

    Parameters
    ----------
    bicycle : Bicycle
        Any parameters, plausible or not.
    start : Start

    Raises
    ------
    ZeroDivisionError
        One half of the bicycle has neither mass nor inertia.
    """
    m, length = _upright(tuple(bicycle.values.items()))
    # Sideways velocities of the centres of mass with a unit roll rate.
    sideways = {b: m.units[0][f"v_{b}"][1] for b in BODIES}
    centre = sum(m.masses[b] * sideways[b] for b in BODIES) / sum(m.masses.values())
    speed = start.speed
    if start.speed_of_centre:
        speed = float(np.sqrt(max(speed**2 - (start.roll_rate * centre) ** 2, 0.0)))
    spins = {"R": start.rear_spin, "F": start.front_spin}
    given: dict[str, Vector] = {}
    for b in BODIES:
        rate = start.roll_rate if b in start.rolling else 0.0
        spin = -spins[b] * speed / float(bicycle[f"r{b}"]) if b in spins else 0.0
        arm = sideways[b] - (centre if start.about_centre else 0.0)
        turn = m.axes.to_rear if b in "RB" else m.axes.to_front
        given[f"v_{b}"] = (speed, rate * arm if start.falling else 0.0, 0.0)
        given[f"w_{b}"] = turn((rate if b in start.turning else 0.0, spin, 0.0))
    momentum = [float(m.product(unit, given)) for unit in m.units]
    made = np.linalg.lstsq(np.array(m.mass, dtype=float), momentum, rcond=None)[0]
    roll_rate, steer_rate, forward = made.tolist()
    state = [0.0, 0.0, 0.0, roll_rate, steer_rate + start.steer_rate, forward * length]
    for place, change in start.added:
        state[place] += change
    return tuple(state)


ParameterValues = tuple[tuple[str, Exact], ...]
"""Parameters of a bicycle, as pairs of symbol and value."""


@lru_cache(512)
def equations_of(values: ParameterValues) -> Equations:
    """Return the equations of a bicycle with any parameters, in binary64.

    Raises
    ------
    ZeroDivisionError
        One half of the bicycle has neither mass nor inertia.
    """
    return Equations.of(Bicycle("", dict(values)), Arrays())


@lru_cache(256)
def _upright(values: ParameterValues) -> tuple[Moving, float]:
    """Return the upright straight bicycle at rest, and its unit of length [m]."""
    equations = equations_of(values)
    with np.errstate(all="ignore"):
        return Moving(equations, [np.zeros(())] * 7), float(equations.k.length)


def beginning(program: Program, number: int) -> tuple[float, ...]:
    """Return a maneuver's initial state (`INITIAL_STATE`) with both wheels on the floor."""
    bicycle = program.motion.bicycle
    roll, pitch, steer, *rates = initial_state(bicycle, program.motion.starts[number])
    if steer != 0.0:
        k = equations_of(tuple(bicycle.values.items())).k
        pitch = float(pitch_on_the_floor(k, roll, 0.0, steer))
    return roll, pitch, steer, *rates


def model_mistake(
    code: str, says: str, check: str, change: Callable[[Parameters], None]
) -> Mistake:
    """Make a mistake in the parameters; `change` alters them in place."""

    def make(program: Program) -> Program:
        values = program.motion.bicycle.values
        p = {s: float(x) for s, x in values.items()}
        change(p)
        # The parameters are not checked, because a program with a mistake may compute with values
        # that have no meaning.
        altered = {s: Exact(Fraction(x)) for s, x in p.items() if x != float(values[s])}
        name = program.motion.bicycle.name
        return program.moving(bicycle=Bicycle(name, {**values, **altered}))

    return Mistake(code, says, check, "model", make)


def start_mistake(code: str, says: str, check: str, change: Callable[[Start], Start]) -> Mistake:
    """Make a mistake in the initial conditions of every maneuver."""

    def make(program: Program) -> Program:
        starts = program.motion.starts
        return program.moving(starts={n: change(s) for n, s in starts.items()})

    return Mistake(code, says, check, "start", make)


def output_mistake(
    code: str, says: str, check: str, change: Change, stage: Stage = Stage.FROM_COLUMNS
) -> Mistake:
    """Make a mistake in the output of a correct motion."""
    edit = Rewritten(change, stage)
    return Mistake(code, says, check, "output", lambda p: p.edited(edit))


def clock_mistake(
    code: str, says: str, check: str, *, scale: float = 1.0, shift: float = 0.0
) -> Mistake:
    """Make a mistake in the times of the rows."""
    return Mistake(code, says, check, "output", _other_clock(scale, shift))


def fitted_scale(code: str, says: str, check: str, scale: float) -> OtherScale:
    """Make the cause of times with a scale that was fitted to the file."""
    return OtherScale(code, says, check, "output", _other_clock(scale, 0.0))


def _other_clock(scale: float, shift: float) -> Callable[[Program], Program]:
    edit = Clock(scale, shift)
    return lambda program: program.edited(edit)


_INITIAL = "initial_"


def changed(program: Program, changes: Mapping[str, float]) -> Program:
    """Return the program with changes of parameters, forces and initial values, by name [SI].

    The name of an initial value includes the number of the maneuver: ``initial_roll_rate_2``.
    """
    values, starts = dict(program.motion.bicycle.values), dict(program.motion.starts)
    amounts = dict(program.motion.amounts)
    for name, change in changes.items():
        if name in values:
            x = values[name]
            values[name] = replace(x, rational=x.rational + Fraction(change))
        elif name.startswith(_INITIAL):
            place, n = _of_start(name)
            starts[n] = replace(starts[n], added=(*starts[n].added, (place, change)))
        else:
            amounts[name] = amounts.get(name, 0.0) + change
    return program.moving(
        bicycle=Bicycle(program.motion.bicycle.name, values),
        starts=starts,
        amounts=tuple(sorted(amounts.items())),
    )


def _of_start(name: str) -> tuple[int, int]:
    """Return the index in `INITIAL_STATE` and the maneuver in an initial value's name."""
    what, number = name.removeprefix(_INITIAL).rsplit("_", 1)
    return INITIAL_STATE.index(what), int(number)


def other_values(
    changes: Mapping[str, float], uncertain: Mapping[str, float], program: Program
) -> FittedValues:
    """Make the cause of changed parameters, forces and initial values."""
    p = {symbol: float(x) for symbol, x in program.motion.bicycle.values.items()}
    found, kind = [], "model"
    for name, change in changes.items():
        right, what, maneuver = p.get(name, 0.0), name, None
        if name.startswith(_INITIAL):
            kind, (place, maneuver) = "start", _of_start(name)
            right, what = beginning(program, maneuver)[place], _INITIAL + INITIAL_STATE[place]
        found.append(FittedValue(what, maneuver, right + change, right, uncertain[name]))
    code = "_".join(["other", *changes])
    check = ("this parameter" if len(found) == 1 else "these parameters") + " in your input"
    return FittedValues(code, "", check, kind, lambda p: changed(p, changes), tuple(found))
