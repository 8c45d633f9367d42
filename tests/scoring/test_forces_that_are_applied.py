"""Dampers, springs, drag and friction: as in a program of another hand, and named."""

import numpy as np
import pytest
from corpus.newton_model import B, F, H, Program, R
from heyoka_bike.scoring.diagnosis.programs.applied import FORCES

from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.scoring.diagnosis.programs.start import Start, initial_state
from heyoka_bike.scoring.reading.results import Results, Rows

pytest.importorskip("heyoka")

AXLE = np.array([0.0, 1.0, 0.0])
SPEED, ROLL_RATE = 4.6, 0.5
KEYS = {"roll": "roll_angle", "roll_rate": "roll_rate", "speed": "forward_speed",
        "steer": "steer_angle", "steer_rate": "steer_rate",
        "kinetic": "kinetic_energy"}  # fmt: skip
AMOUNTS = {"steer_damping": 0.4, "steer_stiffness": 3.0, "air_drag": 0.3, "wheel_friction": 0.02,
           "rolling_resistance": 1.5, "velocity_damping": 0.04}  # fmt: skip
# What a force changes in a second, of what the columns are; what may be wrong, of what it changes.
SEEN, RIGHT = 1e-5, 1e-3


@pytest.fixture(scope="module")
def without():
    return run("air_drag", 0.0)[1]


def applied(name, amount, program):
    """The force on each body, as one writes it for bodies in global axes."""
    steer_axis = program._hinges()[2][3]

    def forces(attitudes, velocities, spins):
        found = np.zeros((4, 6))
        axis = attitudes[B] @ steer_axis
        if name in ("steer_damping", "steer_stiffness"):
            turned = attitudes[B].T @ attitudes[H] @ AXLE
            angle = np.arctan2(np.cross(AXLE, turned) @ steer_axis, AXLE @ turned)
            rate = (spins[H] - spins[B]) @ axis
            torque = -amount * (rate if name == "steer_damping" else angle) * axis
            found[H, 3:], found[B, 3:] = torque, -torque
        elif name == "air_drag":
            v = velocities[B]
            found[B, :3] = -amount * np.linalg.norm(v) * v
        elif name in ("wheel_friction", "rolling_resistance"):
            for frame, wheel in ((B, R), (H, F)):
                axle = attitudes[frame] @ AXLE
                rate = (spins[wheel] - spins[frame]) @ axle
                torque = -amount * (rate if name == "wheel_friction" else np.sign(rate)) * axle
                found[wheel, 3:] += torque
                found[frame, 3:] -= torque
        else:
            inertia = zip(program._masses(), program._tensors(), attitudes, strict=True)
            for i, (mass, tensor, a) in enumerate(inertia):
                found[i, :3] = -amount * mass * velocities[i]
                found[i, 3:] = -amount * a @ tensor @ a.T @ spins[i]
        return found

    return forces


def run(name, amount, steps=100, h=0.01):
    """Columns of a second, by Runge and Kutta."""
    right = Program(method=None)
    program = Program(method=None, applied=applied(name, amount, right))
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


@pytest.mark.parametrize("name", FORCES)
def test_they_move_as_in_a_program_of_another_hand(simulator, bicycle, without, name):
    p = {s: float(x) for s, x in bicycle.values.items()}
    start = initial_state(p, Start(SPEED, ROLL_RATE))
    time, columns = run(name, AMOUNTS[name])
    here, there = simulator.run(bicycle, start, time, {name: AMOUNTS[name]}), columns
    right = simulator.run(bicycle, start, time)
    for word, key in KEYS.items():
        # The error of the steps is nearly the same with and without the force.
        moved, expected = here[key] - right[key], there[word] - without[word]
        assert np.max(np.abs(expected)) > SEEN * np.max(np.abs(right[key])), key
        assert np.max(np.abs(moved - expected)) < RIGHT * np.max(np.abs(expected)), key


@pytest.mark.proof
def test_a_diagnosis_names_them(reference):
    """Damping of all velocities, as engines have it by default."""
    time, columns = run("velocity_damping", 0.04, steps=500)
    keys = {**KEYS, "potential": "potential_energy"}
    values = {key: columns[name] for name, key in keys.items()}
    values["mechanical_energy"] = values["potential_energy"] + values["kinetic_energy"]
    rows = Rows(2, time, np.zeros_like(time), values)
    found = diagnose(Results("made", "text", (rows,), 17), reference)
    first = next(f for f in found.diagnosis if f.code == "parameters")
    (change,) = first.evidence["changes"][0]
    assert (change["unknown"], change["unit"]) == ("velocity_damping", "s-1")
    # It is off by 4e-5, though the error of the steps is some 1e-7: why is not known yet.
    assert change["value"] == pytest.approx(0.04, rel=1e-4)
