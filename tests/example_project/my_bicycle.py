"""The uncontrolled bicycle by SciPy's DOP853, in binary64.

It stands for a code of your own. Only the equations of motion are borrowed: heyoka_bike has them
for any kind of number, here NumPy's.
"""

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from heyoka_bike import read_bicycle, read_maneuvers
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.model import regular
from heyoka_bike.bicycle.equations.outputs import columns, unfold
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers

TRAIL = "0.08"  # [m]


class Numpy:
    """The functions that the equations need, of numbers and of arrays."""

    sin, cos, sqrt, atan2, sum = np.sin, np.cos, np.sqrt, np.arctan2, sum

    def number(self, value):
        return float(value)


def run(times):
    """The columns of the benchmark at these times [s], by maneuver."""
    bicycle = read_bicycle(benchmark_bicycle())
    bicycle = replace(bicycle, values={**bicycle.values, "c": Exact.parse(TRAIL)})
    a = Numpy()
    k = constants(bicycle, a)
    found = {}
    for number, maneuver in enumerate(read_maneuvers(benchmark_maneuvers()), start=1):
        # Roll, pitch, steer, roll rate, steer rate, speed of the rear hub in wheel radii.
        start = [0, 0, 0, float(maneuver.roll_rate), 0, float(maneuver.speed) / k.length]
        motion = solve_ivp(
            lambda _, state: regular(k, a, state), (0, times[-1]), start,
            "DOP853", t_eval=times, rtol=1e-12, atol=1e-14,
        )  # fmt: skip
        roll, pitch, steer = motion.y[:3]
        posture, speeds = unfold(k, a, motion.y, is_regular=True)
        values = columns(k, a, posture, speeds, roll, pitch, steer, yaw=0 * roll)
        found[number] = {"time": times} | {key: values[key] for key in BENCHMARK_COLUMNS}
    return found
