"""Result files of programs that make known mistakes, integrated by SciPy, with known errors."""

import heyoka as hy
import numpy as np
from made_results import smooth_error
from scipy.integrate import solve_ivp

from heyoka_bike.arithmetic import Multiprecision
from heyoka_bike.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.constants import constants
from heyoka_bike.exact import Exact
from heyoka_bike.integration import Expressions
from heyoka_bike.kinematics import state_names
from heyoka_bike.mistakes import Program, apply
from heyoka_bike.model import regular
from heyoka_bike.outputs import columns, unfold, yaw_rate
from heyoka_bike.parameters import Bicycle
from heyoka_bike.results import Quantum, Results, Rows
from heyoka_bike.start import Start, initial_state


def correct(reference):
    values = {s: Exact.parse(x) for s, x in reference.parameters.items()}
    starts = {
        n: Start(
            float(Exact.parse(reference[n].inputs["speed"])),
            float(Exact.parse(reference[n].inputs["roll_rate"])),
        )
        for n in reference
    }
    return Program(Bicycle("benchmark", values), starts)


def motion(bicycle, start, time):
    """Columns by DOP853, with the constants in the code; as far as the motion goes."""
    k = constants(bicycle, Multiprecision(25)).convert(float)
    a = Expressions()
    state = list(hy.make_vars(*state_names(True)))
    yaw = hy.make_vars("yaw")
    o, u = unfold(k, a, state, is_regular=True)
    right = hy.cfunc([*regular(k, a, state), yaw_rate(o, u)], [*state, yaw])
    found = columns(k, a, o, u, state[0], state[1], state[2], yaw)
    outputs = hy.cfunc([found[c.name] for c in COLUMNS], [*state, yaw])
    *rest, speed = start
    begin = np.array([*rest, speed / k.length, 0.0])
    # A late clock repeats its first time.
    times, back = np.unique(time, return_inverse=True)
    with np.errstate(all="ignore"):
        run = solve_ivp(
            lambda t, y: right(np.ascontiguousarray(y)), (0.0, float(times[-1])), begin,
            "DOP853", t_eval=times, rtol=1e-11, atol=1e-13,
        )  # fmt: skip
    states = np.full((len(begin), len(times)), np.nan)
    states[:, : run.y.shape[1]] = run.y
    made = outputs(np.ascontiguousarray(states[:, back]))
    return dict(zip([c.name for c in COLUMNS], made, strict=True))


def results_of(reference, mistakes, level=0.0):
    """What a program with these mistakes writes, with a smooth error of a level of the scales."""
    program = apply(correct(reference), mistakes)
    p = {s: float(x) for s, x in program.bicycle.values.items()}
    parts = []
    for number in reference:
        m = reference[number]
        start = initial_state(p, program.starts[number])
        meant = program.clock(m.time, 0.01)
        found = motion(program.bicycle, start, meant)
        for change in program.rows:
            found = dict(change(found, m.time))
        good = np.isfinite(found["roll_angle"])
        values = {
            key: (
                found[key] + smooth_error(reference, number, level * np.max(np.abs(m.rows[key])))
            )[good]
            for key in BENCHMARK_COLUMNS
        }
        quantum = dict.fromkeys(values, Quantum(2, 53))
        parts.append(Rows(number, m.time[good], m.time_lo[good], values, quantum=quantum))
    return Results("mistaken", "text", tuple(parts), 16)
