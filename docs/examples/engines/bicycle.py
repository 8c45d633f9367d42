"""Shared by the programs of this folder: states, the table for `check`, columns, pictures.

Each program has a class with these methods. Vectors are along the ground's axes, z up. The base is
the link B, and its place is the origin of that link. Angles and rates are those of rear_axle,
steer_axis and front_axle.

    set(state)      put the bicycle into a `State`
    state()         the `State` that it is in
    bodies()        a `Body` by the letters B, R, H, F
    energies()      potential and kinetic energy
    mass_matrix()   of the velocity and angular velocity of the base and the rates
    bias()          generalised forces that hold these velocities constant
    step(seconds)   move
    picture(camera) an image, if the engine draws without a window
    view()          open a window; return a function that shows the present state in it

The class is called with a file written by ``heyoka-bike export --model``. To move the bicycle it is
also called with a time step; the default is its ``STEP``. Run a program as

    python with_mujoco.py check bicycle.xml states.csv > table.csv
    python with_mujoco.py run bicycle.xml > results.txt
    python with_mujoco.py run bicycle.xml --step 0.0001 > results.txt
    python with_mujoco.py run bicycle.xml --view
    python with_mujoco.py run bicycle.xml --movie bicycle.mp4
    python with_mujoco.py run bicycle.xml --strip bicycle.png
"""

import argparse
import csv
import re
import shutil
import struct
import subprocess
import time
import zlib
from collections import namedtuple
from pathlib import Path

import numpy as np

State = namedtuple("State", "place attitude angles velocity turning rates")
"""Place, quaternion (scalar first), angles; velocity, angular velocity, rates."""

Body = namedtuple("Body", "mass centre velocity axes turning")
"""Mass; centre of mass and its velocity; the link's axes as columns; angular velocity."""

UP = np.array([0.0, 0.0, 1.0])
Z_UP = np.diag([1.0, -1.0, -1.0])
"""Rotation from the axes of the benchmark (z down) to those of the models (z up), and back."""

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
    """Product of quaternions: the rotation q, then p, both about fixed axes."""
    (a, *u), (b, *v) = p, q
    return np.array([a * b - np.dot(u, v), *(a * np.array(v) + b * np.array(u) + np.cross(u, v))])


def cross_matrix(v):
    """Matrix of the cross product ``v x``."""
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def starts(file):
    """Read the initial states from the table in the comment of a model file."""
    _, _, table = Path(file).read_text(encoding="ascii").partition("Starts:")
    found = []
    for block in re.split(r"^start_\d+:.*$", table.partition("-->")[0], flags=re.MULTILINE)[1:]:
        numbers = [float(x) for x in re.findall(r"[-+]?\d[-+.e\d]*", block)]
        found.append(State(*map(np.array, np.split(np.array(numbers), [3, 7, 10, 13, 16]))))
    return found


def parameter(file, symbol):
    """Read a decimal parameter of the bicycle from the comment of a model file."""
    text = Path(file).read_text(encoding="ascii")
    return float(re.search(rf"^  {symbol} = (\S+)", text, flags=re.MULTILINE)[1])


def states(file, radius):
    """Read the states of ``heyoka-bike check --states``; `radius` is that of the rear wheel."""
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
    """Heading of a frame: perpendicular to its axle, along the floor."""
    ahead = np.cross(axes[:, 1], UP)
    return ahead / np.linalg.norm(ahead)


def lowest(body, radius):
    """Vector from the hub of a wheel to its lowest point."""
    axle = body.axes[:, 1]
    down = axle * axle[2] - UP
    return radius * down / np.linalg.norm(down)


def lowest_rate(body, radius):
    """Rate of the vector `lowest`, whose end is a geometric point and not fixed to the tyre."""
    axle = body.axes[:, 1]
    turned = np.cross(body.turning, axle)
    down, change = axle * axle[2] - UP, turned * axle[2] + axle * turned[2]
    length = np.linalg.norm(down)
    return radius * (change / length - down * (down @ change) / length**3)


def velocities(engine, state):
    """Jacobian (6, 9) of each body: its velocities per velocity of the base and joint rate."""
    found = {letter: np.zeros((6, 9)) for letter in "BRHF"}
    for i, unit in enumerate(np.eye(9)):
        engine.set(state._replace(velocity=unit[:3], turning=unit[3:6], rates=unit[6:]))
        for letter, body in engine.bodies().items():
            found[letter][:, i] = *body.velocity, *body.turning
    engine.set(state)
    return found


def quantities(engine, state):
    """Quantities that an engine computes in a state, with the names and axes of ``states.csv``."""
    per, found = velocities(engine, state), {}
    bodies, radii = engine.bodies(), {"R": engine.radii[0], "F": engine.radii[1]}
    rear, ends = bodies["B"], {"rear": ("B", "R"), "front": ("H", "F")}

    def name(what, vector):
        named(found, what, Z_UP @ vector)

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
    # Velocities of rolling without slip, for a unit roll rate, steer rate and forward speed.
    ahead = heading(rear.axes)
    rows = np.vstack(
        [
            per[wheel][:3] - cross_matrix(lowest(bodies[wheel], r)) @ per[wheel][3:]
            for wheel, r in radii.items()
        ]
    )
    system = np.vstack([ahead @ per["B"][3:], np.eye(9)[7], ahead @ per["R"][:3], rows])
    units = np.linalg.solve(system, np.eye(9)[:, :3])
    reduced, names = units.T @ matrix @ units, ("roll", "steer", "speed")
    for i, j in zip(*np.triu_indices(3), strict=True):
        found[f"mass_{names[i]}_{names[j]}"] = reduced[i, j]
    found |= dynamics(engine, state, per, rows)
    return found


def drifts(bodies, per):
    """Linear (centres of mass) and angular accelerations at constant generalised velocities."""
    base, fork = bodies["B"], bodies["H"]
    # A steer rate alone moves the fork's centre of mass about the steer axis.
    axis, across = per["H"][3:, 7], per["H"][:3, 7]
    pivot = fork.centre + np.cross(axis, across)

    def of_point(point, body, acceleration, angular):
        arm = point - body.centre
        centripetal = np.cross(body.turning, np.cross(body.turning, arm))
        return acceleration + np.cross(angular, arm) + centripetal

    # The origin of the base has no acceleration: see `centre_drift`.
    found = {"B": (centre_drift(base, per), np.zeros(3))}
    for wheel, frame in (("R", "B"), ("H", "B"), ("F", "H")):
        carried, carrier = bodies[wheel], bodies[frame]
        angular = found[frame][1] + np.cross(carrier.turning, carried.turning - carrier.turning)
        point = pivot if wheel == "H" else carried.centre
        there = of_point(point, carrier, *found[frame])
        arm = carried.centre - point
        there = there + np.cross(angular, arm)
        there = there + np.cross(carried.turning, np.cross(carried.turning, arm))
        found[wheel] = there, angular
    return found


def centre_drift(base, per):
    """Acceleration of the base's centre of mass if its origin has none."""
    # The centre's velocity per angular velocity is minus the cross matrix of its arm.
    cross_of_arm = -per["B"][:3, 3:6]
    arm = np.array([cross_of_arm[2, 1], cross_of_arm[0, 2], cross_of_arm[1, 0]])
    return np.cross(base.turning, np.cross(base.turning, arm))


def dynamics(engine, state, per, rows):
    """Accelerations and forces of the floor and the joints, in the axes of ``states.csv``.

    The lowest point of each wheel is at rest. Its three velocity rows are added as constraints to
    the engine's own equations of motion.
    """
    bodies, radii = engine.bodies(), {"R": engine.radii[0], "F": engine.radii[1]}
    drift, change = drifts(bodies, per), []
    for wheel, r in radii.items():
        body, (linear, angular) = bodies[wheel], drift[wheel]
        change.append(
            linear + np.cross(angular, lowest(body, r))
            + np.cross(body.turning, lowest_rate(body, r))
        )  # fmt: skip
    system = np.block([[engine.mass_matrix(), rows.T], [rows, np.zeros((6, 6))]])
    solved = np.linalg.solve(system, np.concatenate([-engine.bias(), *np.negative(change)]))
    generalised, floor = solved[:9], dict(zip("RF", -solved[9:].reshape(2, 3), strict=True))
    moving = {x: per[x] @ generalised + np.concatenate(drift[x]) for x in bodies}
    rear, wheel = bodies["B"], bodies["R"]
    found = angle_accelerations(rear, moving["B"][3:])
    ahead = heading(rear.axes)
    turned = np.cross(UP * found.pop("yaw_rate"), ahead)
    found["forward_acceleration"] = ahead @ moving["R"][:3] + turned @ wheel.velocity
    found["rear_wheel_acceleration"] = -generalised[6]
    found["steer_acceleration"] = generalised[7]
    found["front_wheel_acceleration"] = -generalised[8]
    weight = -engine.gravity * UP
    load = {x: b.mass * (moving[x][:3] - weight) for x, b in bodies.items()}
    for end, frame, letter in (("rear", "B", "R"), ("front", "H", "F")):
        axes, force = bodies[frame].axes, floor[letter]
        along = heading(axes)
        right = np.cross(along, UP)
        found[f"{end}_normal_force"] = force[2]
        found[f"{end}_longitudinal_force"] = along @ force
        found[f"{end}_lateral_force"] = right @ force
        found[f"{end}_friction"] = np.hypot(along @ force, right @ force) / force[2]
        named(found, f"{end}_axle_force", Z_UP @ axes.T @ (load[letter] - force))
    held = load["H"] + load["F"] - floor["F"]
    down, right = per["H"][3:, 7], -bodies["H"].axes[:, 1]
    named(found, "steer_joint_force", np.array([np.cross(right, down), right, down]) @ held)
    return found


def angle_accelerations(rear, angular):
    """Second derivatives of yaw, roll and pitch of the rear frame, and the yaw rate; z up."""
    ahead, axle = heading(rear.axes), rear.axes[:, 1]
    axes = np.column_stack([UP, ahead, axle])
    yaw, roll, pitch = np.linalg.solve(axes, rear.turning)
    turned = roll * np.cross(yaw * UP, ahead) + pitch * np.cross(rear.turning, axle)
    found = np.linalg.solve(axes, angular - turned)
    return {
        "yaw_acceleration": -found[0], "roll_acceleration": found[1],
        "pitch_acceleration": -found[2], "yaw_rate": yaw,
    }  # fmt: skip


def named(found, what, vector):
    """Add the components of a vector to a dictionary, under the vector's name."""
    found.update({f"{what}_{axis}": x for axis, x in zip("xyz", vector, strict=True)})


def table(engine, file):
    """Lines of the table that `check` reads."""
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


CAMERAS = {
    # Vector from the middle of the bicycle to the camera [m], and the upward direction of pictures.
    "follow": ((-2.2, -2.2, 0.8), (0, 0, 1)),
    "side": ((0, -3, 0.05), (0, 0, 1)),
    "behind": ((-3.1, 0, 0.05), (0, 0, 1)),
    "above": ((0, 0, 3.2), (0, 1, 0)),
}
MIDDLE = np.array([0.5, 0, 0.85])
"""Middle of bicycle and rider, relative to the place of the base [m]."""
WIDTH, HEIGHT, FRAMES_PER_SECOND = 640, 480, 25


def png(image):
    """Bytes of a PNG file of an 8-bit RGB image."""
    height, width, _ = image.shape
    rows = np.hstack([np.zeros((height, 1), np.uint8), image.reshape(height, -1)])

    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    packed = zlib.compress(rows.tobytes(), 9)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")
    )


def strip(engine, file, seconds, count=5):
    """Write pictures from the side, behind and above; columns are evenly spaced in time."""
    columns = []
    for i in range(count):
        if i:
            engine.step(round(seconds / (count - 1), 2))
        columns.append(np.vstack([engine.picture(x) for x in ("side", "behind", "above")]))
    Path(file).write_bytes(png(np.hstack(columns)))


def movie(engine, file, seconds):
    """Write a film of the following camera, with the program ffmpeg."""
    command = [
        "ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{WIDTH}x{HEIGHT}", "-r", str(FRAMES_PER_SECOND), "-i", "-",
        "-pix_fmt", "yuv420p", str(file),
    ]  # fmt: skip
    with subprocess.Popen(command, stdin=subprocess.PIPE) as writer:
        for _ in range(round(seconds * FRAMES_PER_SECOND)):
            writer.stdin.write(engine.picture("follow").tobytes())
            engine.step(1 / FRAMES_PER_SECOND)


def view(engine, seconds):
    """Show the motion in a window, in real time."""
    show = engine.view()
    begin = time.monotonic()
    for i in range(round(seconds * FRAMES_PER_SECOND)):
        show()
        time.sleep(max(0, begin + i / FRAMES_PER_SECOND - time.monotonic()))
        engine.step(1 / FRAMES_PER_SECOND)


def main(engine):
    """Carry out ``check`` or ``run``; `engine` is a class."""
    parser = argparse.ArgumentParser(description="The exported bicycle in an engine.")
    commands = parser.add_subparsers(dest="command", required=True)
    check = commands.add_parser("check", help="print the table for heyoka-bike check")
    run = commands.add_parser("run", help="print the columns for heyoka-bike score, or draw")
    for command in (check, run):
        command.add_argument("file", help="written by heyoka-bike export --model")
    check.add_argument("states", help="written by heyoka-bike check --states")
    drawn = run.add_mutually_exclusive_group()
    drawn.add_argument("--view", action="store_true", help="show the motion in a window")
    drawn.add_argument("--movie", metavar="MP4", help="write a film, with the program ffmpeg")
    drawn.add_argument("--strip", metavar="PNG", help="write pictures from three sides")
    run.add_argument("--step", type=float, help="of the time [s]")
    run.add_argument("--maneuver", type=int, default=2, help="to draw (default: 2)")
    run.add_argument("--seconds", type=float, default=4.0, help="to draw (default: 4)")
    args = parser.parse_args()
    made = engine(args.file, *([args.step or engine.STEP] if args.command == "run" else []))
    if args.command == "check" or not (args.view or args.movie or args.strip):
        lines = table(made, args.states) if args.command == "check" else results(made, args.file)
        for line in lines:
            print(line)
        return
    if args.movie and shutil.which("ffmpeg") is None:
        parser.error("--movie needs the program ffmpeg: install it, or try --strip")
    if not hasattr(made, "view" if args.view else "picture"):
        parser.error("this program does not draw: try with_mujoco.py or with_pybullet.py")
    made.set(starts(args.file)[args.maneuver - 1])
    if args.view:
        view(made, args.seconds)
    elif args.movie:
        movie(made, args.movie, args.seconds)
    else:
        strip(made, args.strip, args.seconds)
