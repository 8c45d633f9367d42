"""Trajectories of any bicycle in binary64, from one compiled integrator: milliseconds each.

The constants of the equations are parameters of the compiled code, so that a changed bicycle needs
no new compilation. The form that is regular at zero trail is used, whose state is roll, pitch,
steer, roll rate, steer rate, the rear wheel's rolling rate and yaw. Equations without some of their
terms (see `incomplete`), or with other forces (see `applied`), are compiled when first asked for.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from math import cos, sin
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, read_bicycle
from heyoka_bike.motion.expressions import Expressions, require_heyoka
from heyoka_bike.numbers.arithmetic import Multiprecision, Number
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.programs.applied import FORCES
from heyoka_bike.scoring.diagnosis.programs.incomplete import TERMS, rates_altered
from heyoka_bike.system.resources import benchmark_bicycle

# Rotations and products of the constants keep binary64 with some digits to spare.
_DIGITS = 25
_TOLERANCE = 1e-14
# The maneuvers take 50 to 150 steps of such a tolerance; several times as many are a singularity.
_MOST_STEPS = 500
# The maneuvers of a file are simulated one after the other.
_KEPT = 4
# Angular velocities of frame and fork along e1, e2, e3 (see `kinematics`), absolute ones of the
# wheels about their axles, all in rad/s.
_RATES = ("w1", "q", "w3", "w1_f", "q_f", "w3_f", "spin_R", "spin_F")
_ALTERED = (*TERMS, *FORCES)
# What is computed of a motion.
_NAMES = (*(c.name for c in COLUMNS), "spin_energy", "rotation_energy")


class Simulator:
    """A compiled integrator and its outputs; building it takes seconds.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """

    def __init__(self) -> None:
        self._hy = hy = require_heyoka()
        self._arithmetic = Multiprecision(_DIGITS)
        count = 0

        def parameter(_: Number) -> Number:
            nonlocal count
            count += 1
            return hy.par[count - 1]

        # Of any bicycle: only which constants there are is taken from it.
        exact = Equations.of(read_bicycle(benchmark_bicycle()), self._arithmetic)
        self._equations = equations = exact.convert(parameter, Expressions())
        self._count = count
        self._state = state = list(hy.make_vars(*equations.states))
        self._integrator = self._compiled(equations.rates_with_yaw(state))
        found = equations.columns(state)
        _, u = equations.unfold(state)
        k = equations.k
        rates = [u.w1, u.q, u.w3, u.w1_f, u.q_f, u.w3_f, u.v / k.rear.r, u.v_f / k.front.r]
        self._outputs: Any = hy.cfunc(
            [*(found[c.name] for c in COLUMNS), *rates], state, compact_mode=True
        )
        self._constants = lru_cache(_KEPT)(self._compute_constants)

    def _compiled(self, rates: Sequence[Any]) -> Any:
        # Compact code is slower by half but compiles several times faster.
        return self._hy.taylor_adaptive(
            list(zip(self._state, rates, strict=True)), np.zeros(len(self._state)),
            compact_mode=True, tol=_TOLERANCE,
        )  # fmt: skip

    @cached_property
    def _altered(self) -> Any:
        amounts = {name: self._hy.par[self._count + i] for i, name in enumerate(_ALTERED)}
        return self._compiled(rates_altered(self._hy, self._equations, self._state, amounts))

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
            Every column of `columns.COLUMNS`, and the parts of the kinetic energy [J]
            ``spin_energy``, of the wheels about their axles, and ``rotation_energy``, of the
            angular velocities of all bodies, spin included; NaN from where the motion meets a
            singularity, or everywhere if the bicycle has no motion.
        """
        try:
            values, length = self._constants(tuple(bicycle.values.items()))
        except ZeroDivisionError:
            # Without any mass or inertia of one half.
            return {name: np.full(len(time), np.nan) for name in _NAMES}
        *angles_and_rates, speed = start
        ta = self._altered if amounts else self._integrator
        given = [*values, *((amounts or {}).get(name, 0.0) for name in _ALTERED)]
        ta.pars[:] = given[: len(ta.pars)]
        ta.time = 0.0
        ta.state[:] = [*angles_and_rates, speed / length, 0.0]
        # Repeated times are not allowed; nor is a grid that does not begin at the present.
        grid, back = np.unique(np.concatenate([[0.0], time]), return_inverse=True)
        reached = ta.propagate_grid(grid, max_steps=_MOST_STEPS)[-1]
        states = np.full((len(grid), len(ta.state)), np.nan)
        states[: len(reached)] = reached
        used = values[: self._outputs.nparams, None]
        parameters = np.broadcast_to(used, (len(used), len(grid)))
        found = self._outputs(np.ascontiguousarray(states.T), pars=np.ascontiguousarray(parameters))
        wanted = found[:, back[1:]]
        rates = dict(zip(_RATES, wanted[len(COLUMNS) :], strict=True))
        made = dict(zip([c.name for c in COLUMNS], wanted, strict=False))
        # A motion that meets a singularity may become very fast.
        with np.errstate(over="ignore"):
            return made | _energies({s: float(x) for s, x in bicycle.values.items()}, rates)

    def _compute_constants(self, values: tuple[tuple[str, Exact], ...]) -> tuple[Array, float]:
        """Parameters of the compiled code, and the unit of length [m]."""
        found: list[float] = []
        exact = Equations.of(Bicycle("", dict(values)), self._arithmetic)
        exact.convert(lambda x: found.append(float(x)), exact.a)
        return np.array(found), float(exact.k.length)


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
