"""SymBRiM's equations of the uncontrolled bicycle, by SUNDIALS CVODE.

``simulate`` is what `../field.py` calls; the equations are those of `../equations/whipple.py`.
"""

import time

import numpy as np
from equations.whipple import Bicycle
from sksundae.cvode import CVODE


def simulate(p, speed, roll_rate, tolerance, absolute=None, method="Adams", rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; calls of the equations."""
    bicycle = Bicycle(p)

    def slope(t, state, rates):
        rates[:] = bicycle.slope(t, state)

    absolute = tolerance * 1e-3 if absolute is None else absolute
    solver = CVODE(slope, method=method, rtol=tolerance, atol=absolute, max_num_steps=100000)
    begin = time.process_time()
    found = solver.solve(np.arange(1001) / rate, bicycle.start(speed, roll_rate))
    cpu = time.process_time() - begin
    if len(found.y) != 1001:
        raise RuntimeError(found.message)
    return bicycle.rows(found.y), cpu, {"calls": bicycle.calls}
