"""SymBRiM's equations of the uncontrolled bicycle, by RADAU of Hairer and Wanner.

``simulate`` is what `../field.py` calls; the equations are those of `../equations/whipple.py`. The
order is chosen by the code among 5, 9 and 13 or given: with order 5 it is the method of RADAU5.
"""

import time

import numpy as np
from equations.whipple import Bicycle
from pyradau13 import radau13


def simulate(p, speed, roll_rate, tolerance, absolute=None, order=None, dense=True, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; calls of the equations."""
    bicycle = Bicycle(p)
    absolute = tolerance * 1e-3 if absolute is None else absolute
    kept = {f"{x}_order": order for x in ("initial", "min", "max")} if order else {}
    times, found = np.arange(1001) / rate, [bicycle.start(speed, roll_rate)]

    def keep(_, t, __, inside):
        while len(found) < len(times) and times[len(found)] <= t:
            found.append(inside(times[len(found)]))

    said = {"reltol": tolerance, "abstol": absolute, "max_steps": 100000, **kept}
    begin = time.process_time()
    if dense:
        radau13(bicycle.slope, found[0], times[-1], dense_callback=keep, **said)
    else:
        found += [*radau13(bicycle.slope, found[0], times[1:].tolist(), **said)]
    cpu = time.process_time() - begin
    return bicycle.rows(found), cpu, {"calls": bicycle.calls}
