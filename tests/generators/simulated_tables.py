"""Columns of all maneuvers from the diagnosis's simulator, as arrays for scoring."""

import numpy as np

from heyoka_bike.scoring.diagnosis.programs.program import Program, Start, initial_state

TIME = np.arange(1001) / 100


def right_program(bicycle, reference):
    """Return the correct program, which starts each maneuver with the given state."""
    starts = {
        n: Start(*(float(reference[n].rows[k][0]) for k in ("forward_speed", "roll_rate")))
        for n in reference
    }
    return Program(bicycle, starts)


def simulated(simulator, program, keys, **amounts):
    """Return columns ``<key>_<n>`` of a program, with added coefficients of forces."""
    table = {"time": TIME}
    for n, start in program.starts.items():
        first, meant = initial_state(program.bicycle, start), program.clock(TIME, 0.01)
        columns = simulator.run(program.bicycle, first, meant, dict(program.amounts) | amounts)
        table |= {f"{key}_{n}": columns[key] for key in keys}
    return table
