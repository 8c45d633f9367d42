"""The uncontrolled bicycle by heyoka's Taylor integrator, on the equations of this project.

``simulate`` is what `../field.py` calls. The equations are heyoka's expressions, in the form of few
products; heyoka compiles them and their Taylor coefficients, which is not timed.
"""

import time

import numpy as np
from own import bicycle_of, maneuver_of

from heyoka_bike.motion.heyoka_adapter import TaylorIntegrator
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.workbench.bench.problem import ReferenceProblem


def simulate(p, speed, roll_rate, tolerance, compact=True, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; steps."""
    # It knows the start and the columns; a reference is not needed for them.
    problem = ReferenceProblem(bicycle_of(p), maneuver_of(speed, roll_rate, rate), None)
    equations = right_hand_side(problem.bicycle, Precision.of("binary64"), with_yaw=False)
    integrator = TaylorIntegrator(
        equations, problem.start(float), float, tolerance=tolerance, is_compact=compact
    )
    columns, times = problem.columns(), problem.times
    begin = time.process_time()
    states, steps = integrator.over(times)
    rows = np.array(columns(states)).T
    return rows, time.process_time() - begin, {"steps": steps}
