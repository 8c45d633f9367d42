"""The uncontrolled bicycle of SymBRiM, integrated by SciPy.

``simulate`` is what `../field.py` calls; the equations are those of `../equations/whipple.py`.
"""

import time

import numpy as np
from equations.whipple import Bicycle
from scipy.integrate import solve_ivp


def simulate(p, speed, roll_rate, tolerance, method="DOP853", rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; calls of the equations."""
    bicycle = Bicycle(p)
    times, begin = np.arange(1001) / rate, time.process_time()
    y = solve_ivp(
        bicycle.slope, (0, times[-1]), bicycle.start(speed, roll_rate), method=method,
        t_eval=times, rtol=tolerance, atol=tolerance * 1e-3,
    ).y.T  # fmt: skip
    cpu, calls = time.process_time() - begin, {"calls": bicycle.calls}
    return bicycle.rows(y), cpu, calls
