"""Trajectories of any bicycle in binary64, from compiled integrators: a millisecond each.

The constants of the equations are parameters of the compiled code, so that a changed bicycle needs
no new compilation. The form that is regular at zero trail is used, whose state is roll, pitch,
steer, roll rate, steer rate, the rear wheel's rolling rate and yaw. Equations without some of their
terms (see `incomplete`), or with other forces (see `applied`), are compiled when first asked for.
Motions that are asked for together are stepped together, each in a lane of the processor's vectors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import COLUMNS, FOLLOWING
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, read_bicycle
from heyoka_bike.motion.expressions import Expressions, require_heyoka
from heyoka_bike.numbers.arithmetic import Multiprecision, Number
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.following import following
from heyoka_bike.scoring.diagnosis.programs.applied import FORCES
from heyoka_bike.scoring.diagnosis.programs.incomplete import TERMS, rates_altered
from heyoka_bike.system.resources import benchmark_bicycle

# Rotations and products of the constants keep binary64 with some digits to spare.
DIGITS = 25
_TOLERANCE = 1e-14
# The maneuvers take 50 to 150 steps of such a tolerance; several times as many are a singularity.
_MOST_STEPS = 500
# Bicycles whose constants are kept: the maneuvers of a file follow each other.
KEPT = 64
# Angular velocities of frame and fork along e1, e2, e3 (see `kinematics`), absolute ones of the
# wheels about their axles, all in rad/s.
_RATES = ("w1", "q", "w3", "w1_f", "q_f", "w3_f", "spin_R", "spin_F")
_ALTERED = (*TERMS, *FORCES)
# What is computed of a motion.
_NAMES = (*(c.name for c in (*COLUMNS, *FOLLOWING)), "spin_energy", "rotation_energy")


@dataclass(frozen=True, eq=False, slots=True)
class AskedMotion:
    """A motion that is asked for, see `Simulator.run`.

    Attributes
    ----------
    bicycle : Bicycle
    start : (roll, pitch, steer, roll rate, steer rate, speed)
        [rad, rad/s, m/s]
    time : ndarray, shape (n,)
        [s]
    amounts
        Of terms and forces.
    """

    bicycle: Bicycle
    start: Sequence[float]
    time: Array
    amounts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, slots=True)
class Ready:
    """A motion in the numbers of the compiled code.

    Attributes
    ----------
    constants : ndarray
        Of the equations.
    parameters
        These, and the amounts of what is altered.
    state
        At t = 0.
    grid : ndarray
        Ascending times from 0 on, each once [s].
    back : ndarray of int
        Where in it each of the times is that were asked for.
    """

    constants: Array
    parameters: Sequence[float]
    state: Sequence[float]
    grid: Array
    back: NDArray[np.intp]


class Simulator:
    """A compiled integrator and its outputs; building it takes seconds.

    Attributes
    ----------
    lanes : int
        Motions that are stepped together.
    has_forces : bool
        Whether it has motions of equations without a term, and with other forces.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """

    # Two vectors of four, or one of eight.
    lanes = 8
    has_forces = True

    def __init__(self) -> None:
        self._hy = hy = require_heyoka()
        self._arithmetic = Multiprecision(DIGITS)
        count = 0

        def parameter(_: Number) -> Number:
            nonlocal count
            count += 1
            return hy.par[count - 1]

        exact = any_bicycle(self._arithmetic)
        self._equations = equations = exact.convert(parameter, Expressions())
        self._count = count
        self._state = state = list(hy.make_vars(*equations.states))
        self._rates = equations.rates_with_yaw(state)
        self._outputs: Any = hy.cfunc(outputs(equations, state), state, compact_mode=True)
        self._integrator = lru_cache(self._compile)
        self._constants = lru_cache(KEPT)(self._compute_constants)

    def _compile(self, altered: tuple[str, ...], in_lanes: bool) -> Any:
        """An integrator of the equations, with amounts of what is altered."""
        rates, shape = self._rates, (len(self._state), self.lanes)
        if altered:
            amounts: dict[str, Any] = dict.fromkeys(_ALTERED, 0.0)
            amounts |= {name: self._hy.par[self._count + _ALTERED.index(name)] for name in altered}
            rates = rates_altered(self._equations, self._state, amounts)
        make = self._hy.taylor_adaptive_batch if in_lanes else self._hy.taylor_adaptive
        # Compact code is slower by half but compiles several times faster.
        return make(
            list(zip(self._state, rates, strict=True)), np.zeros(shape if in_lanes else shape[:1]),
            compact_mode=True, tol=_TOLERANCE,
        )  # fmt: skip

    def run(
        self, bicycle: Bicycle, start: Sequence[float], time: Array,
        amounts: Mapping[str, float] | None = None,
    ) -> dict[str, Array]:  # fmt: skip
        """Columns of a motion as far as it goes.

        Parameters
        ----------
        bicycle : Bicycle
            Any parameters, sensible or not.
        start : (roll, pitch, steer, roll rate, steer rate, speed)
            At t = 0 [rad, rad/s, m/s]; the speed is that of the rear hub along the heading.
        time : ndarray, shape (n,)
            Ascending, from 0 on [s].
        amounts
            Of `incomplete.TERMS`, 1 for those that the equations are without; of
            `applied.FORCES`, their coefficients [SI].

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Every column of `columns.COLUMNS` and `FOLLOWING`, and the parts of the kinetic energy
            [J] ``spin_energy``, of the wheels about their axles, and ``rotation_energy``, of the
            angular velocities of all bodies, spin included; NaN from where the motion meets a
            singularity, or everywhere if the bicycle has no motion.
        """
        return self.run_all([AskedMotion(bicycle, start, time, amounts or {})])[0]

    def run_all(self, motions: Sequence[AskedMotion]) -> list[dict[str, Array]]:
        """What `run` has of each, in less time."""
        bicycles = {id(m.bicycle): m.bicycle for m in motions}
        constants = {i: self._constants(tuple(b.values.items())) for i, b in bicycles.items()}
        ready = [_prepared(m, constants[id(m.bicycle)]) for m in motions]
        alike: dict[tuple[tuple[str, ...], int], list[int]] = {}
        for i, (motion, r) in enumerate(zip(motions, ready, strict=True)):
            if r is not None:
                alike.setdefault((_altered(motion.amounts), len(r.grid)), []).append(i)
        found: list[dict[str, Array]] = [
            {name: np.full(len(m.time), np.nan) for name in _NAMES} if r is None else {}
            for m, r in zip(motions, ready, strict=True)
        ]
        for (altered, _), members in alike.items():
            for k in range(0, len(members), self.lanes):
                together = members[k : k + self.lanes]
                chosen = [r for i in together if (r := ready[i]) is not None]
                for i, r, states in zip(
                    together, chosen, self._states(chosen, altered), strict=True
                ):
                    found[i] = self._columns(motions[i], r, states)
        return found

    def _states(self, ready: Sequence[Ready], altered: tuple[str, ...]) -> list[Array]:
        """States of motions at their grids, as many of each; NaN from where one ends."""
        found: dict[int, Array] = {}
        left = list(range(len(ready)))
        while len(left) > 1:
            states, has_ended = self._together([ready[i] for i in left], altered)
            found |= {i: x for i, x, ended in zip(left, states, has_ended, strict=True) if ended}
            # A motion that meets a singularity stops the others, which begin again.
            left = [i for i in left if i not in found]
        found |= {i: self._alone(ready[i], altered) for i in left}
        return [found[i] for i in range(len(ready))]

    def _together(
        self, ready: Sequence[Ready], altered: tuple[str, ...]
    ) -> tuple[list[Array], list[bool]]:
        """States of motions, and which of them have come to an end."""
        ta = self._integrator(altered, True)
        # Lanes that are left over repeat the last motion.
        lanes = [*ready, *[ready[-1]] * (self.lanes - len(ready))]
        ta.pars[:] = np.array([r.parameters for r in lanes]).T[: len(ta.pars)]
        ta.set_time(np.zeros(self.lanes))
        ta.state[:] = np.array([r.state for r in lanes]).T
        grid = np.ascontiguousarray(np.array([r.grid for r in lanes]).T)
        states = ta.propagate_grid(grid, max_steps=_MOST_STEPS)[-1]
        outcomes = [outcome for outcome, *_ in ta.propagate_res[: len(ready)]]
        return (
            [states[:, :, lane] for lane in range(len(ready))],
            [outcome != self._hy.taylor_outcome.success for outcome in outcomes],
        )

    def _alone(self, ready: Ready, altered: tuple[str, ...]) -> Array:
        ta = self._integrator(altered, False)
        ta.pars[:] = ready.parameters[: len(ta.pars)]
        ta.time = 0.0
        ta.state[:] = ready.state
        reached = ta.propagate_grid(ready.grid, max_steps=_MOST_STEPS)[-1]
        states = np.full((len(ready.grid), len(ta.state)), np.nan)
        states[: len(reached)] = reached
        return states

    def _columns(self, motion: AskedMotion, ready: Ready, states: Array) -> dict[str, Array]:
        wanted = self._evaluated(ready, states)[:, ready.back]
        rates = dict(zip(_RATES, wanted[len(COLUMNS) :], strict=True))
        made = dict(zip([c.name for c in COLUMNS], wanted, strict=False))
        p = {s: float(x) for s, x in motion.bicycle.values.items()}
        # A motion that meets a singularity may become very fast.
        with np.errstate(over="ignore"):
            return made | following(made, p) | _energies(p, rates)

    def _evaluated(self, ready: Ready, states: Array) -> Array:
        """What is computed of the states on a grid."""
        used = ready.constants[: self._outputs.nparams, None]
        parameters = np.ascontiguousarray(np.broadcast_to(used, (len(used), len(states))))
        found: Array = self._outputs(np.ascontiguousarray(states.T), pars=parameters)
        return found

    def _compute_constants(
        self, values: tuple[tuple[str, Exact], ...]
    ) -> tuple[Array, float] | None:
        """Parameters of the compiled code, and the unit of length [m]; None without a motion."""
        found: list[float] = []
        try:
            exact = Equations.of(Bicycle("", dict(values)), self._arithmetic)
        except ZeroDivisionError:
            # Without any mass or inertia of one half.
            return None
        exact.convert(lambda x: found.append(float(x)), exact.a)
        return np.array(found), float(exact.k.length)


def any_bicycle(a: Multiprecision) -> Equations:
    """Equations of which only matters what constants there are."""
    return Equations.of(read_bicycle(benchmark_bicycle()), a)


def outputs(equations: Equations, state: Sequence[Number]) -> list[Number]:
    """Columns, and the rates that `_RATES` names."""
    found = equations.columns(state)
    _, u = equations.unfold(state)
    k = equations.k
    rates = [u.w1, u.q, u.w3, u.w1_f, u.q_f, u.w3_f, u.v / k.rear.r, u.v_f / k.front.r]
    return [*(found[c.name] for c in COLUMNS), *rates]


def _prepared(motion: AskedMotion, constants: tuple[Array, float] | None) -> Ready | None:
    if constants is None:
        return None
    values, length = constants
    *angles_and_rates, speed = motion.start
    amounts = [motion.amounts.get(name, 0.0) for name in _ALTERED] if motion.amounts else []
    # Repeated times are not allowed; nor is a grid that does not begin at the present.
    grid, back = np.unique(np.concatenate([[0.0], motion.time]), return_inverse=True)
    state = [*angles_and_rates, speed / length, 0.0]
    return Ready(values, [*values, *amounts], state, grid, back[1:])


def _altered(amounts: Mapping[str, float]) -> tuple[str, ...]:
    """What the compiled code has to know of; that of forces alone is half as long."""
    if not amounts:
        return ()
    return tuple(FORCES) if amounts.keys() <= FORCES.keys() else _ALTERED


def _energies(p: Mapping[str, float], rates: Mapping[str, Array]) -> dict[str, Array]:
    """Parts of the kinetic energy [J]."""
    s, c = sin(p["lam"]), cos(p["lam"])
    spin: Array = 0.5 * (p["IRyy"] * rates["spin_R"] ** 2 + p["IFyy"] * rates["spin_F"] ** 2)
    rotation = spin
    for body, wheel, end in (("B", "R", ""), ("H", "F", "_f")):
        w1, q, w3 = (rates[name + end] for name in ("w1", "q", "w3"))
        # In the axes of the upright bicycle.
        x, z = c * w1 + s * w3, c * w3 - s * w1
        xx, yy, zz, xz = (p[f"I{body}{ij}"] for ij in ("xx", "yy", "zz", "xz"))
        diametral = p[f"I{wheel}xx"]
        rotation = rotation + 0.5 * (
            (xx + diametral) * x**2 + yy * q**2 + (zz + diametral) * z**2 + 2 * xz * x * z
        )
    return {"spin_energy": spin, "rotation_energy": rotation}
