"""The fast path of this project, `heyoka_bike.simulate`: implicit steps in code compiled by LLVM.

``simulate`` is what `../field.py` calls. Compiling and finding the start are not timed.
"""

import time

from own import bicycle_of, maneuver_of

from heyoka_bike.workbench.fast.simulate import prepare


def simulate(p, speed, roll_rate, tolerance, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; steps."""
    run = prepare(maneuver_of(speed, roll_rate, rate), bicycle=bicycle_of(p), tolerance=tolerance)
    begin = time.process_time()
    found = run()
    return found.values[0].T, time.process_time() - begin, {"steps": sum(run.steps)}
