"""Trajectories of any bicycle in binary64, from one compiled integrator: milliseconds each.

The constants of the equations are parameters of the compiled code, so that a changed bicycle needs
no new compilation. The form that is regular at zero trail is used, whose state is roll, pitch,
steer, roll rate, steer rate, the rear wheel's rolling rate and yaw.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from heyoka_bike.arithmetic import Multiprecision, Number
from heyoka_bike.chebyshev import Array
from heyoka_bike.columns import COLUMNS
from heyoka_bike.constants import constants
from heyoka_bike.integration import Expressions, require_heyoka
from heyoka_bike.kinematics import state_names
from heyoka_bike.model import regular
from heyoka_bike.outputs import columns, unfold, yaw_rate
from heyoka_bike.parameters import Bicycle, read_bicycle
from heyoka_bike.resources import benchmark_bicycle

# Rotations and products of the constants keep binary64 with some digits to spare.
_DIGITS = 25
_TOLERANCE = 1e-14
# The maneuvers take 50 to 150 steps of such a tolerance; ten times as many are a singularity.
_MOST_STEPS = 1500


class Simulator:
    """A compiled integrator and its outputs; building it takes seconds.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """

    def __init__(self) -> None:
        hy = require_heyoka()
        self._arithmetic = Multiprecision(_DIGITS)
        count = 0

        def parameter(_: Number) -> Number:
            nonlocal count
            count += 1
            return hy.par[count - 1]

        # Of any bicycle: only which constants there are is taken from it.
        k = constants(read_bicycle(benchmark_bicycle()), self._arithmetic).convert(parameter)
        a = Expressions()
        state = list(hy.make_vars(*state_names(True)))
        yaw = hy.make_vars("yaw")
        o, u = unfold(k, a, state, is_regular=True)
        equations = [*zip(state, regular(k, a, state), strict=True), (yaw, yaw_rate(o, u))]
        # Compact code is slower by half but compiles several times faster.
        self._integrator: Any = hy.taylor_adaptive(
            equations, np.zeros(len(state) + 1), compact_mode=True, tol=_TOLERANCE
        )
        found = columns(k, a, o, u, state[0], state[1], state[2], yaw)
        self._outputs: Any = hy.cfunc(
            [found[c.name] for c in COLUMNS], [*state, yaw], compact_mode=True
        )

    def run(self, bicycle: Bicycle, start: Sequence[float], time: Array) -> dict[str, Array]:
        """Columns of a motion as far as it goes.

        Parameters
        ----------
        bicycle : Bicycle
            Any parameters, sensible or not.
        start : (roll, pitch, steer, roll rate, steer rate, speed)
            At t = 0 [rad, rad/s, m/s]; the speed is that of the rear hub along the heading.
        time : ndarray, shape (n,)
            Ascending, from 0 on [s].

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Every column of `columns.COLUMNS`; NaN from where the motion meets a singularity.
        """
        values: list[float] = []
        k = constants(bicycle, self._arithmetic)
        k.convert(lambda x: values.append(float(x)))
        *angles_and_rates, speed = start
        ta = self._integrator
        ta.pars[:] = values[: len(ta.pars)]
        ta.time = 0.0
        ta.state[:] = [*angles_and_rates, speed / float(k.length), 0.0]
        # Repeated times are not allowed; nor is a grid that does not begin at the present.
        grid, back = np.unique(np.concatenate([[0.0], time]), return_inverse=True)
        reached = ta.propagate_grid(grid, max_steps=_MOST_STEPS)[-1]
        states = np.full((len(grid), len(ta.state)), np.nan)
        states[: len(reached)] = reached
        parameters = np.broadcast_to(np.array(values)[:, None], (len(values), len(grid)))
        found = self._outputs(np.ascontiguousarray(states.T), pars=np.ascontiguousarray(parameters))
        return {c.name: row[back[1:]] for c, row in zip(COLUMNS, found, strict=True)}
