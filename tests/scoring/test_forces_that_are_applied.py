"""Dampers, springs, drag, friction, slopes and missing terms act as in an independent program."""

import numpy as np
import pytest
from scipy.optimize import brentq

from corpus.newton_model import B, F, H, Program, R
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.programs.forces import (
    FORCES,
    OF_THE_STATE,
    WITHOUT_POTENTIAL,
    Moving,
    rates_altered,
)
from heyoka_bike.scoring.diagnosis.programs.integrators import RK4
from heyoka_bike.scoring.diagnosis.programs.program import Start, initial_state
from heyoka_bike.scoring.reading.results import Results, Rows

AXLE, DOWN = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
SPEED, ROLL_RATE = 4.6, 0.5
KEYS = {"roll": "roll_angle", "roll_rate": "roll_rate", "speed": "forward_speed",
        "steer": "steer_angle", "steer_rate": "steer_rate",
        "kinetic": "kinetic_energy"}  # fmt: skip
AMOUNTS = {
    "steer_damping": 0.4, "steer_stiffness": 3.0, "steer_torque": 0.1, "roll_damping": 3.0,
    "air_drag": 0.3, "frame_push": 2.0, "side_wind": 1.0, "slope_along": 3e-3, "slope_across": 3e-3,
    "wheel_friction": 0.02, "wheel_friction_R": 0.02, "wheel_friction_F": 0.02,
    "rolling_resistance": 1.5, "rolling_resistance_R": 1.5, "rolling_resistance_F": 1.5,
    "brake": 1.5, "brake_R": 1.5, "brake_F": 1.5, "velocity_damping": 0.04, "linear_damping": 0.04,
    "angular_damping": 0.04, "scrub_R": 2.0, "scrub_F": 2.0,
    "steer_by_steer_angle_steer_angle_steer_angle": -300.0, "steer_by_steer_rate_steer_rate": -2.0,
    "no_spin_moment": 0.3, "no_spin_moment_R": 0.3, "no_spin_moment_F": 0.3,
    "gyroscopic_R": 0.3, "gyroscopic_F": 0.3, "wheels_gyroscopic": 0.3, "frames_gyroscopic": 1.0,
    "gyroscopic": 0.3, "gyroscopic_B": 1.0, "gyroscopic_H": 40.0, "roll_torque": 1.0,
    "roll_stiffness": 10.0, "hub_push": 2.0, "whole_push": 2.0,
    "weight_R": 0.1, "weight_F": 0.1, "weight_B": 3e-3, "weight_H": 0.1, "wheels_weight": 0.1,
}  # fmt: skip
"""Amounts of the forces that can be applied to the other program as external forces."""
_ACCELERATION = "it depends on accelerations, which the other program does not know in advance"
_SQUARE = "it is the square of the hub's speed times a law that is applied"
_ROUND = (
    "the other program has knife-edge wheels; the potential energy of the tyres is tested below"
)
NOT_APPLIED = {
    **dict.fromkeys(("frame_drag", "hub_drag", "whole_drag", "ground_drag", "air_lift"), _SQUARE),
    **dict.fromkeys(("speed_held", "spin_held", "steer_rotor"), _ACCELERATION),
    **dict.fromkeys([f"centrifugal_{b}" for b in ("RBHF", *"RBHF")], _ACCELERATION),
    **dict.fromkeys(("crown", "crown_R", "crown_F"), _ROUND),
    **dict.fromkeys(("side_B", "side_H"), "it moves a mass, whose energy is tested below"),
    "ground_push": "its point belongs to no body of the other program",
    "steer_friction": "it jumps at a steer rate of zero, and steps of 0.01 s do not resolve this",
}  # fmt: skip
"""Reasons why other forces are not applied to the other program."""
WHEELS = {"": (R, F), "R": (R,), "F": (F,)}
FRAME = {R: B, F: H, B: B, H: H}
GRAVITY = 9.81
# SEEN: a force must cause at least this change within 0.6 s, relative to the column. RIGHT: largest
# error of this change, relative to the change.
SEEN, RIGHT = 1e-5, 1e-3


@pytest.fixture(scope="module")
def without():
    return run("air_drag", 0.0)[1]


def on_steer_axis(program, torque):
    steer_axis = program._hinges()[2][3]

    def force(found, attitudes, _, spins):
        axis = attitudes[B] @ steer_axis
        turned = attitudes[B].T @ attitudes[H] @ AXLE
        angle = np.arctan2(np.cross(AXLE, turned) @ steer_axis, AXLE @ turned)
        each = torque(angle, (spins[H] - spins[B]) @ axis) * axis
        found[H, 3:] += each
        found[B, 3:] -= each

    return force


def on_axles(wheels, torque):
    def force(found, attitudes, _, spins):
        for wheel in wheels:
            axle = attitudes[wheel] @ AXLE
            each = torque((spins[wheel] - spins[FRAME[wheel]]) @ axle) * axle
            found[wheel, 3:] += each
            found[FRAME[wheel], 3:] -= each

    return force


def on_bodies(program, each):
    """Forces and torques by body. `each` gets the mass, the global inertia tensor and the motion of
    a body."""

    def force(found, attitudes, velocities, spins):
        inertia = zip(program._masses(), program._tensors(), attitudes, strict=True)
        heading = np.cross(attitudes[B] @ AXLE, DOWN)
        heading /= np.linalg.norm(heading)
        for i, (mass, tensor, a) in enumerate(inertia):
            made = each(i, mass, a @ tensor @ a.T, a, velocities[i], spins, heading)
            found[i] += np.concatenate([np.broadcast_to(x, 3) for x in made])

    return force


def gyroscopic(bodies, by_frame):
    def each(i, mass, tensor, a, v, spins, heading):
        if i not in bodies:
            return 0.0, 0.0
        axle, turning = a @ AXLE, spins[FRAME[i]] if by_frame else spins[i]
        momentum = tensor @ spins[i]
        return 0.0, np.cross(turning, axle * (axle @ momentum) if by_frame else momentum)

    return each


def applied(name, amount, program):
    """The force on each body, written for rigid bodies in global axes."""
    kind, _, one = name.rpartition("_")
    wheels = WHEELS.get(one, (R, F))
    body = dict(zip("BHRF", range(4), strict=True)).get(one)
    along, across = np.eye(3)[:2]
    laws = {
        "steer_damping": on_steer_axis(program, lambda angle, rate: -rate),
        "steer_stiffness": on_steer_axis(program, lambda angle, rate: -angle),
        "steer_torque": on_steer_axis(program, lambda angle, rate: 1.0),
        "wheel_friction": on_axles(wheels, lambda rate: -rate),
        "brake": on_axles(wheels, lambda rate: -np.sign(rate)),
        "steer_by_steer_angle_steer_angle_steer_angle": on_steer_axis(program, lambda q, _: q**3),
        "steer_by_steer_rate_steer_rate": on_steer_axis(program, lambda _, rate: rate * abs(rate)),
    }
    bodies = {
        "roll_damping": lambda i, m, t, a, v, w, h: (0.0, -(i == B) * (w[B] @ h) * h),
        "roll_torque": lambda i, m, t, a, v, w, h: (0.0, (i == B) * h),
        "roll_stiffness": lambda i, m, t, a, v, w, h: (
            0.0,
            -(i == B) * np.arcsin((a @ AXLE)[2]) * h,
        ),
        "air_drag": lambda i, m, t, a, v, w, h: (-(i == B) * np.linalg.norm(v) * v, 0.0),
        "frame_push": lambda i, m, t, a, v, w, h: ((i == B) * h, 0.0),
        "hub_push": lambda i, m, t, a, v, w, h: ((i == R) * h, 0.0),
        "whole_push": lambda i, m, t, a, v, w, h: (m / sum(program._masses()) * h, 0.0),
        "side_wind": lambda i, m, t, a, v, w, h: ((i == B) * across, 0.0),
        "slope_along": lambda i, m, t, a, v, w, h: (-m * GRAVITY * along, 0.0),
        "slope_across": lambda i, m, t, a, v, w, h: (-m * GRAVITY * across, 0.0),
        "velocity_damping": lambda i, m, t, a, v, w, h: (-m * v, -t @ w[i]),
        "linear_damping": lambda i, m, t, a, v, w, h: (-m * v, 0.0),
        "angular_damping": lambda i, m, t, a, v, w, h: (0.0, -t @ w[i]),
        # Rolling forward is a rotation about -y, so the resisting torque is about +y.
        "rolling_resistance": lambda i, m, t, a, v, w, h: (0.0, (i in wheels) * (a @ AXLE)),
        "scrub": lambda i, m, t, a, v, w, h: (0.0, -(i == FRAME[wheels[0]]) * w[i][2] * DOWN),
        "weight": lambda i, m, t, a, v, w, h: (-(i == body) * m * GRAVITY * DOWN, 0.0),
        "wheels_weight": lambda i, m, t, a, v, w, h: (-(i in (R, F)) * m * GRAVITY * DOWN, 0.0),
        "no_spin_moment": gyroscopic(wheels, by_frame=True),
        "gyroscopic": gyroscopic((B, H, R, F) if body is None else (body,), by_frame=False),
        "wheels_gyroscopic": gyroscopic((R, F), by_frame=False),
        "frames_gyroscopic": gyroscopic((B, H), by_frame=False),
    }
    laws |= {key: on_bodies(program, each) for key, each in bodies.items()}
    law = laws.get(name) or laws[kind]

    def forces(attitudes, velocities, spins):
        found = np.zeros((4, 6))
        law(found, attitudes, velocities, spins)
        return amount * found

    return forces


def run(name, amount, steps=60, h=0.01):
    """Return the times and columns over 0.6 s of a motion with the force `name` of this amount."""
    right = Program(method=None)
    return made(Program(method=None, applied=applied(name, amount, right)), steps, h)


def made(program, steps=60, h=0.01):
    """Return the times and columns of a program, integrated by the classical Runge-Kutta method."""
    state = program.start(SPEED, ROLL_RATE)
    states = [state]
    for _ in range(steps):
        k1 = program.slope(0.0, state)
        k2 = program.slope(0.0, state + h / 2 * k1)
        k3 = program.slope(0.0, state + h / 2 * k2)
        k4 = program.slope(0.0, state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(state)
    return np.arange(steps + 1) * h, program.output(np.array(states).T)


@pytest.mark.parametrize("name", AMOUNTS)
def test_they_move_as_in_a_program_of_another_hand(simulator, bicycle, without, name):
    start = initial_state(bicycle, Start(SPEED, ROLL_RATE))
    time, columns = run(name, AMOUNTS[name])
    here, there = simulator.run(bicycle, start, time, {name: AMOUNTS[name]}), columns
    right = simulator.run(bicycle, start, time)
    for word, key in KEYS.items():
        # The step error is nearly the same with and without the force, so it cancels.
        moved, expected = here[key] - right[key], there[word] - without[word]
        assert np.max(np.abs(expected)) > SEEN * np.max(np.abs(right[key])), key
        assert np.max(np.abs(moved - expected)) < RIGHT * np.max(np.abs(expected)), key


@pytest.mark.parametrize(
    ("term", "turned_by"),
    [
        ("tensors_turning", {B: None, H: None}),
        ("tensor_turning_B", {B: None}),
        ("tensor_turning_H", {H: None}),
        ("tensor_steering_H", {H: B}),
    ],
)
def test_inertia_in_other_axes_moves_as_in_a_program_of_another_hand(
    simulator, bicycle, without, term, turned_by
):
    start = initial_state(bicycle, Start(SPEED, ROLL_RATE))
    time, there = made(Program(method=None, turned_by=turned_by))
    here, right = (
        simulator.run(bicycle, start, time, {term: 1.0}),
        simulator.run(bicycle, start, time),
    )
    for word in ("roll", "roll_rate", "steer", "steer_rate"):
        key = KEYS[word]
        moved, expected = here[key] - right[key], there[word] - without[word]
        assert np.max(np.abs(expected)) > SEEN * np.max(np.abs(right[key])), key
        assert np.max(np.abs(moved - expected)) < RIGHT * np.max(np.abs(expected)), key


@pytest.mark.proof
def test_a_diagnosis_names_them(reference):
    """Engines often apply this damping to all velocities by default."""
    time, columns = run("velocity_damping", 0.04, steps=1000, h=0.005)
    keys = {**KEYS, "potential": "potential_energy"}
    values = {key: columns[name] for name, key in keys.items()}
    values["mechanical_energy"] = values["potential_energy"] + values["kinetic_energy"]
    rows = Rows(2, time, np.zeros_like(time), values)
    found = diagnose(Results("made", "text", (rows,), 17), reference)
    first = next(f for f in found.diagnosis if f.code == "parameters")
    (change,) = first.evidence["changes"][0]
    assert (change["unknown"], change["unit"]) == ("velocity_damping", "s-1")
    # With steps twice as long the error would be 3e-5, because the Runge-Kutta method itself damps
    # the castering mode.
    assert change["value"] == pytest.approx(0.04, rel=1e-5)


def test_a_new_force_is_applied_to_the_other_program():
    assert {*AMOUNTS, *NOT_APPLIED} <= set(FORCES)
    missing = FORCES.keys() - OF_THE_STATE.keys() - AMOUNTS.keys() - NOT_APPLIED.keys()
    assert not missing, (
        f"{sorted(missing)}: add an amount to AMOUNTS and the law for rigid bodies to `applied`; "
        "if the other program cannot have this force, add the reason to NOT_APPLIED"
    )


def test_every_force_says_what_it_is():
    for name, force in FORCES.items():
        assert force.says, name
        assert force.is_part == (force.unit == "1"), name


@pytest.mark.parametrize(("body", "aside"), [("B", 0.05), ("H", 0.2)])
def test_a_mass_to_the_side_keeps_its_own_energy(bicycle, body, aside):
    """The energy is that of the displaced centre of mass.

    Without the terms of second order in the displacement, or without the changed accelerations, a
    thousandth of the exchanged energy would be missing.
    """
    equations = Equations.binary64(bicycle)
    mass, d = float(bicycle[f"m{body}"].rational), (0.0, aside, 0.0)

    def energy(y):
        m = Moving(equations, list(y))
        out = m.axes.from_rear if body == "B" else m.axes.from_front
        columns = equations.columns(list(y))
        centre, turning = np.array(m.now[f"v_{body}"]), np.array(out(m.now[f"w_{body}"]))
        moved = centre + np.cross(turning.T, np.array(out(d)).T).T
        kinetic = columns["kinetic_energy"] + mass * np.sum(moved**2 - centre**2, axis=0) / 2
        potential = columns["potential_energy"] - mass * GRAVITY * out(d)[2]
        return float(kinetic[0]), float(potential[0])

    def slope(y):
        made = rates_altered(equations, list(y), {f"side_{body}": aside})
        return np.array([np.broadcast_to(x, y[0].shape) for x in made])

    start = np.array((*initial_state(bicycle, Start(SPEED, ROLL_RATE)), 0.0))
    y = start[:, None]
    y[5] /= float(equations.k.length)
    first, least = energy(y), np.inf
    for _ in range(1000):
        y = RK4(slope, y, 1e-3)
        least = min(least, energy(y)[1])
    exchanged = first[1] - least
    assert exchanged > 1.0
    assert sum(energy(y)) == pytest.approx(sum(first), abs=1e-8 * exchanged)


def _turn(axis, angle):
    """Rotation matrix about a unit vector, by Rodrigues' formula."""
    k = np.cross(axis, np.eye(3)).T
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def potential_on_tyres(bicycle, roll, steer, section):
    """Potential energy of the bicycle at rest on two tyres with a circular cross-section."""
    p = {name: float(x) for name, x in bicycle.values.items()}
    x, y, z = np.eye(3)
    axis = _turn(y, p["lam"]) @ z
    through = np.array([p["w"] + p["c"], 0.0, 0.0])
    fork = _turn(axis, steer)
    rear, front = np.array([0.0, 0.0, -p["rR"]]), np.array([p["w"], 0.0, -p["rF"]])
    masses = [
        (p["mR"], rear, False), (p["mB"], np.array([p["xB"], 0.0, p["zB"]]), False),
        (p["mH"], np.array([p["xH"], 0.0, p["zH"]]), True), (p["mF"], front, True),
    ]  # fmt: skip

    def heights(pitch):
        turn = _turn(x, roll) @ _turn(y, pitch)

        def down(point, is_fork):
            at = through + fork @ (point - through) if is_fork else point
            return (turn @ (at - rear))[2]

        leans = [(turn @ y)[2], (turn @ fork @ y)[2]]
        hubs = [
            (r - section) * np.sqrt(1.0 - lean**2) + section
            for r, lean in zip((p["rR"], p["rF"]), leans, strict=True)
        ]
        above = sum(m * (hubs[0] - down(point, is_fork)) for m, point, is_fork in masses)
        return hubs[0] - down(front, True) - hubs[1], above

    pitch = brentq(lambda angle: heights(angle)[0], -0.1, 0.1, xtol=1e-15)
    return GRAVITY * heights(pitch)[1]


@pytest.mark.parametrize(("roll", "steer"), [(0.02, 0.0), (0.0, 0.03), (0.01, -0.02)])
def test_a_round_section_of_tyres_is_the_slope_of_its_potential(bicycle, roll, steer):
    section, step = 1e-3, 1e-4
    equations = Equations.binary64(bicycle)
    angles = np.array([roll]), np.array([steer])
    pitch = pitch_on_the_floor(equations.k, angles[0], 0 * angles[0], angles[1])
    moving = Moving(equations, [angles[0], pitch, angles[1], *np.zeros((4, 1))])
    found = [section * float(x[0]) for x in moving.powers(FORCES["crown"].law(moving))[:2]]

    def slope(along):
        ahead, behind = (
            potential_on_tyres(bicycle, *(np.array([roll, steer]) + way * along), section)
            - potential_on_tyres(bicycle, *(np.array([roll, steer]) + way * along), 0.0)
            for way in (step, -step)
        )
        return (ahead - behind) / (2 * step)

    right = [-slope(along) for along in np.eye(2)]
    # The expected value neglects terms of the order of the squared lean, which is 1e-3.
    assert found == pytest.approx(right, rel=3e-3, abs=1e-3 * max(map(abs, right)))


@pytest.mark.parametrize("name", [x for x in FORCES if "gyroscopic" in x or "spin_moment" in x])
def test_a_gyroscopic_torque_does_no_work(simulator, bicycle, name):
    """So the energies of a program without this term are compared like any other column."""
    first = initial_state(bicycle, Start(SPEED, ROLL_RATE))
    columns = simulator.run(bicycle, first, np.linspace(0.0, 0.3, 31), {name: 1.0})
    assert np.ptp(columns["kinetic_energy"]) > 1e-2
    assert np.ptp(columns["mechanical_energy"]) < 1e-9
    assert name in WITHOUT_POTENTIAL
