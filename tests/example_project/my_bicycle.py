"""The uncontrolled bicycle by SciPy's DOP853, in binary64.

This file is a placeholder for your own code. Only the equations of motion are from heyoka_bike,
which has them for any type of number; here it is NumPy's.
"""

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from heyoka_bike import read_bicycle, read_maneuvers
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers

TRAIL = "0.08"  # [m]


def run(times):
    """Return the columns of the benchmark at these times [s], by maneuver."""
    bicycle = read_bicycle(benchmark_bicycle())
    bicycle = replace(bicycle, values={**bicycle.values, "c": Exact.parse(TRAIL)})
    equations = Equations.binary64(bicycle)
    found = {}
    for number, maneuver in enumerate(read_maneuvers(benchmark_maneuvers()), start=1):
        # The state contains roll, pitch, steer, roll rate, steer rate, and the speed of the rear
        # hub [wheel radii per second].
        start = [0, 0, 0, float(maneuver.roll_rate), 0, float(maneuver.speed)]
        start[-1] /= equations.k.length
        motion = solve_ivp(
            lambda _, state: equations.rates(state), (0, times[-1]), start,
            "DOP853", t_eval=times, rtol=1e-12, atol=1e-14,
        )  # fmt: skip
        # None of these columns depends on the yaw, so the yaw is set to zero.
        values = equations.columns([*motion.y, np.zeros(len(times))])
        found[number] = {"time": times} | {key: values[key] for key in BENCHMARK_COLUMNS}
    return found
