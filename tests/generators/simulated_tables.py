"""Columns of all maneuvers from the diagnosis's simulator, as arrays for scoring."""

import numpy as np

from heyoka_bike.scoring.diagnosis.programs.program import Motion, Program, Start, initial_state

TIME = np.arange(1001) / 100


def right_program(bicycle, reference):
    """Return the correct program, which starts each maneuver with the given state."""
    starts = {
        n: Start(*(float(reference[n].rows[k][0]) for k in ("forward_speed", "roll_rate")))
        for n in reference
    }
    return Program(Motion(bicycle, starts))


def simulated(simulator, program, keys, **amounts):
    """Return columns ``<key>_<n>`` of a program, with added coefficients of forces."""
    table = {"time": TIME}
    for n, start in program.motion.starts.items():
        first, meant = initial_state(program.motion.bicycle, start), program.clock(TIME, 0.01)
        forces = dict(program.motion.amounts) | amounts
        columns = simulator.run(program.motion.bicycle, first, meant, forces)
        table |= {f"{key}_{n}": columns[key] for key in keys}
    return table
