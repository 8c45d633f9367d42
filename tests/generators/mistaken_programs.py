"""Result files of programs with known mistakes, integrated by SciPy, with known errors."""

from fractions import Fraction
from functools import cache

import heyoka as hy
import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from generators.made_results import smooth_error
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.equations.kinematics import state_names, unfold
from heyoka_bike.bicycle.equations.model import regular
from heyoka_bike.bicycle.equations.outputs import columns, yaw_rate
from heyoka_bike.bicycle.parameters import Bicycle, read_bicycle
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.motion.heyoka_adapter import Expressions
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring.diagnosis.mistakes.library import Program, apply
from heyoka_bike.scoring.diagnosis.programs.program import Motion, Start, initial_state
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows
from heyoka_bike.system.resources import benchmark_bicycle

NAMES = [c.name for c in COLUMNS]
LATERAL = ("roll_angle", "roll_rate", "steer_angle", "steer_rate")
# Two programs cannot be distinguished if they differ by less than this multiple of the error that
# is added to their results.
SEEN = 3.0


def correct(reference):
    values = {s: Exact.parse(x) for s, x in reference.parameters.items()}
    starts = {
        n: Start(
            float(Exact.parse(reference[n].inputs["speed"])),
            float(Exact.parse(reference[n].inputs["roll_rate"])),
        )
        for n in reference
    }
    return Program(Motion(Bicycle("benchmark", values), starts))


def with_changes(bicycle, changes):
    """Return a bicycle whose parameters differ by decimals, given by symbol."""
    values = dict(bicycle.values)
    for symbol, change in changes.items():
        x = values[symbol]
        values[symbol] = Exact(x.rational + Fraction(change), x.pi_multiple)
    return Bicycle("changed", values)


@cache
def compiled():
    """Return compiled right-hand side and columns, functions of state and constants."""
    made = []

    def parameter(_):
        made.append(hy.par[len(made)])
        return made[-1]

    k = constants(read_bicycle(benchmark_bicycle()), Multiprecision(25)).convert(parameter)
    a = Expressions()
    state = list(hy.make_vars(*state_names(True)))
    yaw = hy.make_vars("yaw")
    o, u = unfold(k, a, state, is_regular=True)
    found = columns(k, a, o, u, state[0], state[1], state[2], yaw)
    rates = [*regular(k, a, state), yaw_rate(o, u)]
    wheels = [u.v / k.rear.r, u.v_f / k.front.r]
    return (
        hy.cfunc(rates, [*state, yaw], compact_mode=True),
        hy.cfunc([*(found[n] for n in NAMES), *wheels], [*state, yaw], compact_mode=True),
    )


def numbers(bicycle):
    """Return the constants in the order of the compiled equations, and the unit of length."""
    found = []
    k = constants(bicycle, Multiprecision(25))
    k.convert(lambda x: found.append(float(x)))
    return np.array(found), float(k.length)


def right_side(bicycle):
    """Return y -> dy/dt, and the unit of length in its speed."""
    right, _ = compiled()
    pars, length = numbers(bicycle)
    used = pars[: right.nparams]  # all parameters except the units of length and mass
    return lambda y: right(np.ascontiguousarray(y), pars=used), length


def written(bicycle, states):
    """Return columns of states, shape (7, n), and the terms of the kinetic energy."""
    right, outputs = compiled()
    pars, _ = numbers(bicycle)
    states = np.ascontiguousarray(states)
    many = np.ascontiguousarray(np.broadcast_to(pars[:, None], (len(pars), states.shape[1])))
    *values, rear, front = outputs(states, pars=many)
    found = dict(zip(NAMES, values, strict=True))
    p = {s: float(x) for s, x in bicycle.values.items()}
    spins = 0.5 * p["IRyy"] * rear**2, 0.5 * p["IFyy"] * front**2
    pitch_rate = right(states, pars=many[: right.nparams])[1]
    turning = rotation_energies(p, found, pitch_rate)
    turning["R"] += spins[0]
    turning["F"] += spins[1]
    places, velocities = of_centres(p, found, pitch_rate)
    return found | {
        "spin_energy": sum(spins),
        "spin_energy_R": spins[0],
        "spin_energy_F": spins[1],
        "rotation_energy": sum(turning.values()),
        "rotation_energy_of_wheels": turning["R"] + turning["F"],
        **{f"rotation_energy_of_{b}": energy for b, energy in turning.items()},
        **{
            f"kinetic_energy_of_{b}": turning[b] + 0.5 * p[f"m{b}"] * np.sum(v**2, axis=0)
            for b, v in velocities.items()
        },
        **{f"potential_energy_of_{b}": -p[f"m{b}"] * p["g"] * x[2] for b, x in places.items()},
    }


def of_centres(p, columns, pitch_rate):
    """Return positions and velocities of the bodies' centres of mass in heading axes, z down.

    Positions are relative to the rear contact point, which moves along the heading.
    """
    roll, pitch, steer = columns["roll_angle"], columns["pitch"], columns["steer_angle"]
    rates = columns["roll_rate"], pitch_rate, columns["steer_rate"]
    places, size = centres(p, roll, pitch, steer), 1e-5
    velocities = {}
    for body, x in places.items():
        v = np.array([columns["forward_speed_contact"] - columns["yaw_rate"] * x[1],
                      columns["yaw_rate"] * x[0], 0.0 * x[2]])  # fmt: skip
        for i, rate in enumerate(rates):
            shift = size * np.eye(3)[i]
            ahead, behind = (
                centres(p, roll + way * shift[0], pitch + way * shift[1], steer + way * shift[2])
                for way in (1, -1)
            )
            v += rate * (ahead[body] - behind[body]) / (2 * size)
        velocities[body] = v
    return places, velocities


def centres(p, roll, pitch, steer):
    """Return centres of mass from the rear contact point, by Euler and Rodrigues rotations."""
    zero, axis = 0.0 * roll, np.array([np.sin(p["lam"]), 0.0, np.cos(p["lam"])])

    def turned(x):
        """Convert from the frame's axes to the heading's."""
        x, y, z = x
        x, z = np.cos(pitch) * x + np.sin(pitch) * z, np.cos(pitch) * z - np.sin(pitch) * x
        return np.array([x, np.cos(roll) * y - np.sin(roll) * z,
                         np.sin(roll) * y + np.cos(roll) * z])  # fmt: skip

    def on_fork(x, z):
        """Convert from the point of the steer axis on the ground in the upright position."""
        d = np.array([x - p["w"] - p["c"], 0.0, z])
        c, s = np.cos(steer), np.sin(steer)
        out = np.outer(d, c) + np.outer(np.cross(axis, d), s) + np.outer(axis, (1 - c) * (axis @ d))
        return out + np.array([p["w"] + p["c"], 0.0, p["rR"]])[:, None]

    hub = np.array([zero, p["rR"] * np.sin(roll), -p["rR"] * np.cos(roll)])
    from_hub = {
        "R": np.array([zero, zero, zero]),
        "B": np.array([zero + p["xB"], zero, zero + p["zB"] + p["rR"]]),
        "H": on_fork(p["xH"], p["zH"]),
        "F": on_fork(p["w"], -p["rF"]),
    }
    return {body: hub + turned(x) for body, x in from_hub.items()}


def rotation_energies(p, columns, pitch_rate):
    """Return rotation energies by body, from Euler angles and the steer axis."""
    roll, pitch = columns["roll_angle"], columns["pitch"]
    s, c = np.sin(pitch), np.cos(pitch)
    yaw_rate, roll_rate = columns["yaw_rate"], columns["roll_rate"]
    across, down = np.sin(roll) * yaw_rate, np.cos(roll) * yaw_rate
    frame = np.array([c * roll_rate - s * down, across + pitch_rate, s * roll_rate + c * down])
    axis = np.array([np.sin(p["lam"]), 0.0, np.cos(p["lam"])])
    along = axis @ frame
    steer = columns["steer_angle"]
    # Inverse Rodrigues rotation: it gives the rate of the frame in the axes of the steered fork.
    fork = (
        np.cos(steer) * frame
        - np.sin(steer) * np.cross(axis, frame, axisb=0, axisc=0)
        + (1 - np.cos(steer)) * along * axis[:, None]
        + columns["steer_rate"] * axis[:, None]
    )
    found = {}
    for body, wheel, w in (("B", "R", frame), ("H", "F", fork)):
        xx, yy, zz, xz = (p[f"I{body}{ij}"] for ij in ("xx", "yy", "zz", "xz"))
        inertia = np.array([[xx, 0.0, xz], [0.0, yy, 0.0], [xz, 0.0, zz]])
        diameter = p[f"I{wheel}xx"] * np.diag([1.0, 0.0, 1.0])
        for name, tensor in ((body, inertia), (wheel, diameter)):
            found[name] = 0.5 * np.einsum("in,ij,jn->n", w, tensor, w)
    return found


def begin(bicycle, start, length):
    *rest, speed = start
    return np.array([*rest, speed / length, 0.0])


def motion(bicycle, start, time):
    """Return columns by DOP853, up to where the motion ends."""
    right, length = right_side(bicycle)
    # A delayed clock repeats its first time, so the motion is computed only once for each time.
    times, back = np.unique(time, return_inverse=True)
    first = begin(bicycle, start, length)
    with np.errstate(all="ignore"):
        run = solve_ivp(
            lambda t, y: right(y), (0.0, float(times[-1])), first,
            "DOP853", t_eval=times, rtol=1e-11, atol=1e-13,
        )  # fmt: skip
    states = np.full((len(first), len(times)), np.nan)
    states[:, : run.y.shape[1]] = run.y
    with np.errstate(all="ignore"):
        return written(bicycle, states[:, back])


def linear_motion(bicycle, start, time, terms):
    """Return columns of linearised equations, with matrices from the nonlinear model."""
    matrices, p = linearise(bicycle, 20), {s: float(x) for s, x in bicycle.values.items()}
    m, c1, k0, k2 = (np.array(getattr(matrices, x), float) for x in ("M", "C1", "K0", "K2"))
    v, first = start[5], np.array([start[0], start[2], start[3], start[4]])
    damping, weight, speed = (
        0.0 if power is None else base**power
        for base, power in ((v, terms.c1), (p["g"], terms.k0), (v, terms.k2))
    )
    stiffness = weight * k0 + speed * k2
    a = np.block([[np.zeros((2, 2)), np.eye(2)],
                  [-np.linalg.solve(m, stiffness), -np.linalg.solve(m, damping * c1)]])  # fmt: skip
    y = np.array([expm(t * a) @ first for t in time]).T
    weight = p["mR"] * p["rR"] + p["mF"] * p["rF"] - p["mB"] * p["zB"] - p["mH"] * p["zH"]
    mass = sum(p[f"m{b}"] for b in "RBHF") + sum(p[f"I{b}yy"] / p[f"r{b}"] ** 2 for b in "RF")
    potential = p["g"] * (weight + np.einsum("it,ij,jt->t", y[:2], k0, y[:2]) / 2)
    kinetic = mass * v**2 / 2 + np.einsum("it,ij,jt->t", y[2:], m, y[2:]) / 2
    values = (
        y[0],
        y[2],
        np.full(len(time), v),
        potential,
        kinetic,
        potential + kinetic,
        y[1],
        y[3],
    )
    return dict(zip(BENCHMARK_COLUMNS, values, strict=True))


def columns_of(reference, mistakes):
    """Return the columns of a program with these mistakes, by maneuver."""
    program = apply(correct(reference), mistakes)
    made = {}
    for number in reference:
        m = reference[number]
        start = initial_state(program.motion.bicycle, program.motion.starts[number])
        time = program.clock(m.time, 0.01)
        if program.motion.linear:
            found = linear_motion(program.motion.bicycle, start, time, program.motion.linear)
        else:
            found = motion(program.motion.bicycle, start, time)
        found = dict(program.written(found, m.time))
        # A run ends when the maneuver ends, even if the labels of its rows state earlier times.
        is_within = time <= float(m.duration) * (1 + 1e-9)
        made[number] = {key: np.where(is_within, found[key], np.nan) for key in BENCHMARK_COLUMNS}
    return made


def results(reference, columns, level=0.0):
    """Return columns as a result file, with a smooth error relative to the scales.

    A column's scale is that of the reference, or its own if it contains another quantity.
    """
    parts = []
    for number, found in columns.items():
        m = reference[number]
        good = np.isfinite(found["roll_angle"])
        values = {
            key: (v + smooth_error(reference, number, level * _scale(m, key, v)))[good]
            for key, v in found.items()
        }
        quantum = dict.fromkeys(values, Quantum(2, 53))
        parts.append(Rows(number, m.time[good], m.time_lo[good], values, quantum=quantum))
    return Results("mistaken", "text", tuple(parts), 16)


def _scale(maneuver, key, values):
    own = np.fmax.reduce(np.abs(values), initial=0.0)
    return min(np.max(np.abs(maneuver.rows[key])), own)


def results_of(reference, mistakes, level=0.0):
    """Return the results of a program with these mistakes and a smooth error."""
    return results(reference, columns_of(reference, mistakes), level)


def distance(one, other, scales):
    """Return the largest difference of two files, in scales; a mirrored motion counts as equal."""
    found = []
    for sign in (1, -1):
        largest = 0.0
        for n, file in one.items():
            for key, v in file.items():
                mirrored = (sign if key in LATERAL else 1) * other[n][key]
                apart = np.abs(v - mirrored) / scales[n, key]
                # Rows after the end of both motions do not count.
                largest = max(largest, float(np.fmax.reduce(apart, initial=0.0)))
        found.append(largest)
    return min(found)
