"""What the programs of this folder share: states, the table for `check`, the columns for `score`.

Each program has a class with these methods. Vectors are along the ground's axes, z up; the base is
the link B, its place that of the link's origin. Angles and rates are those of rear_axle,
steer_axis and front_axle.

    set(state)      put the bicycle into a `State`
    state()         the `State` that it is in
    bodies()        a `Body` by the letters B, R, H, F
    energies()      potential and kinetic energy
    mass_matrix()   of the velocity and angular velocity of the base and the rates
    step(seconds)   move

Its first argument is the file of ``heyoka-bike export --model``. Run a program as

    python with_mujoco.py check bicycle.xml states.csv > table.csv
    python with_mujoco.py run bicycle.xml > results.txt
"""

import csv
import re
import sys
from collections import namedtuple
from pathlib import Path

import numpy as np

State = namedtuple("State", "place attitude angles velocity turning rates")
"""Place, quaternion (scalar first), angles; velocity, angular velocity, rates."""

Body = namedtuple("Body", "mass centre velocity axes turning")
"""Mass; its centre and that one's velocity; the link's axes as columns; angular velocity."""

UP = np.array([0.0, 0.0, 1.0])
Z_UP = np.diag([1.0, -1.0, -1.0])
"""From the axes of the benchmark, z down, to those of the models, and back."""

ROWS, SPACING = 1001, 0.01


def rotation(quaternion):
    """Matrix of a unit quaternion."""
    w, x, y, z = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def product(p, q):
    """Product of quaternions: the turn q, then p, both about axes that stay."""
    (a, *u), (b, *v) = p, q
    return np.array([a * b - np.dot(u, v), *(a * np.array(v) + b * np.array(u) + np.cross(u, v))])


def cross_matrix(v):
    """The matrix of the product ``v x``."""
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def starts(file):
    """The table of starts in the comment of a file, as states."""
    _, _, table = Path(file).read_text(encoding="ascii").partition("Starts:")
    found = []
    for block in re.split(r"^start_\d+:.*$", table.partition("-->")[0], flags=re.MULTILINE)[1:]:
        numbers = [float(x) for x in re.findall(r"[-+]?\d[-+.e\d]*", block)]
        found.append(State(*map(np.array, np.split(np.array(numbers), [3, 7, 10, 13, 16]))))
    return found


def parameter(file, symbol):
    """A parameter of the bicycle, of those in the comment of a file that are decimals."""
    text = Path(file).read_text(encoding="ascii")
    return float(re.search(rf"^  {symbol} = (\S+)", text, flags=re.MULTILINE)[1])


def states(file, radius):
    """The states of ``heyoka-bike check --states`` by their number; `radius` of the rear wheel."""
    found = {}
    for row in csv.DictReader(Path(file).read_text(encoding="ascii").splitlines()):
        given = {name.partition(" ")[0]: float(x) for name, x in row.items()}

        def vector(name, given=given):
            return Z_UP @ [given[f"{name}_{axis}"] for axis in "xyz"]

        attitude = np.array([given[f"rear_frame_q{i}"] for i in range(4)]) * [1, 1, -1, -1]
        axes = rotation(attitude)
        turning, below = axes @ vector("rear_frame_omega"), axes @ [0, 0, -radius]
        found[int(given["state"])] = State(
            vector("rear_hub") + below,
            attitude,
            np.array([0.0, given["steer_angle"], 0.0]),
            vector("rear_hub_velocity") + np.cross(turning, below),
            turning,
            np.array([-given["rear_wheel_rate"], given["steer_rate"], -given["front_wheel_rate"]]),
        )
    return found


def heading(axes):
    """Where a frame heads: across its axle, along the floor."""
    ahead = np.cross(axes[:, 1], UP)
    return ahead / np.linalg.norm(ahead)


def lowest(body, radius):
    """From the hub of a wheel to its lowest point."""
    axle = body.axes[:, 1]
    down = axle * axle[2] - UP
    return radius * down / np.linalg.norm(down)


def velocities(engine, state):
    """Velocity and angular velocity of each body per velocity of the base and rate: (6, 9) each."""
    found = {letter: np.zeros((6, 9)) for letter in "BRHF"}
    for i, unit in enumerate(np.eye(9)):
        engine.set(state._replace(velocity=unit[:3], turning=unit[3:6], rates=unit[6:]))
        for letter, body in engine.bodies().items():
            found[letter][:, i] = *body.velocity, *body.turning
    engine.set(state)
    return found


def quantities(engine, state):
    """What an engine finds of a state, by the names of ``states.csv``, in its axes."""
    per, found = velocities(engine, state), {}
    bodies, radii = engine.bodies(), {"R": engine.radii[0], "F": engine.radii[1]}
    rear, ends = bodies["B"], {"rear": ("B", "R"), "front": ("H", "F")}

    def name(what, vector):
        found.update({f"{what}_{axis}": x for axis, x in zip("xyz", Z_UP @ vector, strict=True)})

    axis = rear.axes.T @ per["H"][3:, 7]
    found["steer_axis_down_x"], found["steer_axis_down_z"] = axis[0], -axis[2]
    for end, (frame, wheel) in ends.items():
        held, rolling = bodies[frame], bodies[wheel]
        axes = Z_UP @ held.axes @ Z_UP
        for i, j in np.ndindex(3, 3):
            found[f"{end}_frame_r{i + 1}{j + 1}"] = axes[i, j]
        found[f"{end}_contact_x"], found[f"{end}_contact_y"], _ = Z_UP @ (
            rolling.centre + lowest(rolling, radii[wheel])
        )
        name(f"{end}_hub", rolling.centre)
        name(f"{end}_hub_velocity", rolling.velocity)
        name(f"{end}_frame_com", held.centre)
        name(f"{end}_frame_com_velocity", held.velocity)
        name(f"{end}_frame_omega", held.axes.T @ held.turning)
        found[f"{end}_wheel_omega_y"] = -(held.axes[:, 1] @ rolling.turning)
    mass = sum(body.mass for body in bodies.values())
    centre = sum(body.mass * body.centre for body in bodies.values()) / mass
    velocity = sum(body.mass * body.velocity for body in bodies.values()) / mass
    found["mass"] = mass
    name("com", centre)
    name("com_velocity", velocity)
    found["potential_energy"], found["kinetic_energy"] = engine.energies()
    matrix = engine.mass_matrix()
    moving = matrix @ np.concatenate([state.velocity, state.turning, state.rates])
    name("momentum", moving[:3])
    name("angular_momentum", moving[3:6] - np.cross(centre - state.place, moving[:3]))
    # The velocities that roll, with a roll rate, a steer rate or a forward speed of one.
    ahead = heading(rear.axes)
    rows = [
        per[wheel][:3] - cross_matrix(lowest(bodies[wheel], r)) @ per[wheel][3:]
        for wheel, r in radii.items()
    ]
    system = np.vstack([ahead @ per["B"][3:], np.eye(9)[7], ahead @ per["R"][:3], *rows])
    units = np.linalg.solve(system, np.eye(9)[:, :3])
    reduced, names = units.T @ matrix @ units, ("roll", "steer", "speed")
    for i, j in zip(*np.triu_indices(3), strict=True):
        found[f"mass_{names[i]}_{names[j]}"] = reduced[i, j]
    return found


def table(engine, file):
    """Lines of the table that `check` takes."""
    given = states(file, engine.radii[0])
    heading, *_ = Path(file).read_text(encoding="ascii").splitlines()
    units = dict(name.partition(" ")[::2] for name in heading.split(","))
    for number, state in given.items():
        found = quantities(engine, state)
        if number == 1:
            yield ",".join(["state", *(f"{name} {units[name]}" for name in found)])
        yield ",".join([str(number), *(f"{x:.17g}" for x in found.values())])


def columns(engine):
    """The eight columns of the benchmark: lean and its rate, speed of the hub along the heading."""
    bodies, state = engine.bodies(), engine.state()
    rear, ahead = bodies["B"], heading(bodies["B"].axes)
    potential, kinetic = engine.energies()
    return [
        np.arcsin(rear.axes[2, 1]), ahead @ rear.turning, ahead @ bodies["R"].velocity,
        potential, kinetic, potential + kinetic, state.angles[1], state.rates[1],
    ]  # fmt: skip


def results(engine, file):
    """Lines of the 25 columns."""
    blocks = []
    for start in starts(file):
        engine.set(start)
        rows = [columns(engine)]
        for _ in range(ROWS - 1):
            engine.step(SPACING)
            rows.append(columns(engine))
        blocks.append(rows)
    for i, row in enumerate(zip(*blocks, strict=True)):
        yield " ".join([f"{i * SPACING:.2f}", *(f"{x:.17g}" for x in np.concatenate(row))])


def main(engine):
    """Carry out ``check`` or ``run``; `engine` is a class."""
    what, file, *others = sys.argv[1:]
    lines = table(engine(file), *others) if what == "check" else results(engine(file), file)
    for line in lines:
        print(line)
