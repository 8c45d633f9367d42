"""An independent small reader of models for engines, and the package's expectations.

The reader uses XML and rigid-body kinematics but nothing from the package. All frames in these
files are parallel at zero angles. Velocities of a model are those of the base's origin and of the
base, along the ground's axes with z up, and the rates of the hinges in their order.
"""

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from heyoka_bike.bicycle.equations.descriptor import Descriptor
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.reference.exports.models import render

Z_UP = np.diag([1.0, -1.0, -1.0])
BITS = 128
ELEMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def numbers(text):
    return np.array([float(x) for x in text.split()])


def tensor(xx, yy, zz, xy, xz, yz):
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@dataclass
class Model:
    """A model read from a file. Its mappings are by link.

    Attributes
    ----------
    places
        Origins at zero angles.
    masses, radii
    centres
        Centres of mass, from the origins.
    tensors
        Inertia tensors about the centres of mass.
    hinges
        For each child link: name of the hinge, parent link, axis.
    """

    places: dict
    masses: dict
    centres: dict
    tensors: dict
    radii: dict
    hinges: dict

    def bodies(self, place, axes, angles):
        """Return origin, axes, and velocities per velocity of the model, (6, 9), by link."""
        base = np.hstack([np.vstack([np.eye(3), np.zeros((3, 3))]), np.zeros((6, 6))])
        base[3:, 3:6] = np.eye(3)
        found = {"B": (np.array(place), np.array(axes), base)}
        for i, (child, (_, parent, axis)) in enumerate(self.hinges.items()):
            at, turned, per = found[parent]
            arm = turned @ (self.places[child] - self.places[parent])
            own = np.array(per)
            own[:3] -= cross(arm) @ own[3:]
            own[3:, 6 + i] = turned @ axis
            found[child] = (at + arm, turned @ about(axis, angles[i]), own)
        return found

    def mass_matrix(self, place, axes, angles):
        matrix = np.zeros((9, 9))
        for name, (_, turned, per) in self.bodies(place, axes, angles).items():
            centre = per[:3] - cross(turned @ self.centres[name]) @ per[3:]
            matrix += self.masses[name] * centre.T @ centre
            matrix += per[3:].T @ turned @ self.tensors[name] @ turned.T @ per[3:]
        return matrix

    def centres_of_mass(self, place, axes, angles):
        bodies = self.bodies(place, axes, angles).items()
        return {name: at + turned @ self.centres[name] for name, (at, turned, _) in bodies}

    def floor(self, place, axes, angles, velocities):
        """Return heights of the wheels' lowest points, and velocities of their material."""
        found = []
        bodies = self.bodies(place, axes, angles)
        for name, radius in self.radii.items():
            at, turned, per = bodies[name]
            down = turned[:, 1] * turned[2, 1] - [0, 0, 1]
            arm = radius * down / np.linalg.norm(down)
            both = per @ velocities
            found += [(at + arm)[2], *(both[:3] + np.cross(both[3:], arm))]
        return np.array(found)


def cross(v):
    return np.cross(np.eye(3), v)


def about(axis, angle):
    k = cross(axis)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def matrix_of(quaternion):
    scalar, *along = quaternion
    half = np.linalg.norm(along)
    return about(np.array(along) / half, 2 * np.arctan2(half, scalar)) if half else np.eye(3)


def quaternion_of(yaw, roll, pitch):
    """Return a quaternion, scalar first, for axes with z up, from angles with z down."""
    (a, b, c), (x, y, z) = (f(np.array([yaw, roll, pitch]) / 2) for f in (np.cos, np.sin))
    return np.array([
        a * b * c - x * y * z, a * y * c - x * b * z,
        -a * b * z - x * y * c, -x * b * c - a * y * z,
    ])  # fmt: skip


def read_urdf(root):
    model = Model({}, {}, {}, {}, {}, {})
    for link in root.iter("link"):
        inertial, name = link.find("inertial"), link.get("name")
        model.masses[name] = float(inertial.find("mass").get("value"))
        model.centres[name] = numbers(inertial.find("origin").get("xyz"))
        model.tensors[name] = tensor(
            *(float(inertial.find("inertia").get(f"i{e}")) for e in ELEMENTS)
        )
        if (cylinder := link.find("collision/geometry/cylinder")) is not None:
            model.radii[name] = float(cylinder.get("radius"))
    model.places["B"] = np.zeros(3)
    for joint in root.iter("joint"):
        parent, child = (joint.find(x).get("link") for x in ("parent", "child"))
        model.places[child] = model.places[parent] + numbers(joint.find("origin").get("xyz"))
        axis = numbers(joint.find("axis").get("xyz"))
        model.hinges[child] = (joint.get("name"), parent, axis)
    return model


def read_sdf(root):
    model = Model({}, {}, {}, {}, {}, {})
    (bicycle,) = (x for x in root.iter("model") if x.get("name") == "bicycle")
    for link in bicycle.iter("link"):
        inertial, name = link.find("inertial"), link.get("name")
        model.masses[name] = float(inertial.findtext("mass"))
        model.centres[name] = numbers(inertial.findtext("pose"))[:3]
        model.places[name] = numbers(link.findtext("pose"))[:3]
        model.tensors[name] = tensor(*(float(inertial.findtext(f"inertia/i{e}")) for e in ELEMENTS))
        if (radius := link.findtext("collision/geometry/cylinder/radius")) is not None:
            model.radii[name] = float(radius)
    for joint in bicycle.iter("joint"):
        axis = numbers(joint.findtext("axis/xyz"))
        model.hinges[joint.findtext("child")] = (joint.get("name"), joint.findtext("parent"), axis)
    return model


def read_mjcf(root):
    model = Model({}, {}, {}, {}, {}, {})

    def body(element, parent, place):
        inertial, name = element.find("inertial"), element.get("name")
        model.places[name] = place = place + numbers(element.get("pos"))
        model.masses[name] = float(inertial.get("mass"))
        model.centres[name] = numbers(inertial.get("pos"))
        model.tensors[name] = tensor(*numbers(inertial.get("fullinertia")))
        if (geom := element.find("geom[@type='ellipsoid']")) is not None:
            model.radii[name] = numbers(geom.get("size"))[0]
        if parent:
            joint = element.find("joint")
            model.hinges[name] = (joint.get("name"), parent, numbers(joint.get("axis")))
        for child in element.findall("body"):
            body(child, name, place)

    body(root.find("worldbody/body"), None, np.zeros(3))
    return model


READERS = {"urdf": read_urdf, "sdf": read_sdf, "mjcf": read_mjcf}


def read(name, text):
    return READERS[name](ElementTree.fromstring(text))


def model_of(name, bicycle, maneuvers=(), **options):
    """Write a model and read it back."""
    return read(name, render(name, bicycle, maneuvers, **options))


@dataclass
class Posed:
    """A state in the descriptor form of the package, and in the form of a model."""

    equations: Equations
    q: np.ndarray
    place: np.ndarray
    axes: np.ndarray
    quaternion: np.ndarray
    angles: np.ndarray
    per_rate: np.ndarray  # velocities of the model's bodies per unit rate of each coordinate

    def expected(self):
        """Return the mass matrix of the coordinates, exact except for last bits."""
        found = Descriptor(self.equations.b, self.equations.a).mass(list(self.q))
        return np.array(found, dtype=float)


def posed(bicycle, maneuver):
    """Return the start of a maneuver, with the yaw, position and wheel angles changed."""
    balls = Balls(BITS)
    exact = Equations.of(bicycle, balls)
    roll, pitch, steer = (float(x.mid()) for x in initial_state(exact, maneuver)[:3])
    yaw, wheels = 0.7, (0.4, -1.1)
    equations = Equations.binary64(bicycle)
    radius = equations.b.rear.wheel_r
    axis_x, axis_y, axis_z = np.eye(3)
    yawed = about(axis_z, yaw)
    rolled = yawed @ about(axis_x, roll)
    pitched = rolled @ about(axis_y, pitch)
    hub = np.array([2.0, -3.0, -radius * np.cos(roll)])
    below = pitched @ [0, 0, radius]
    turning = np.column_stack([axis_z, yawed @ axis_x, rolled @ axis_y])
    per_rate = np.zeros((9, 9))
    per_rate[:3, :3] = Z_UP
    per_rate[:3, 3:6] = -Z_UP @ cross(below) @ turning
    per_rate[3:6, 3:6] = Z_UP @ turning
    per_rate[6, 7], per_rate[7, 6], per_rate[8, 8] = -1, 1, -1
    return Posed(
        equations, np.array([*hub, yaw, roll, pitch, steer, *wheels]), Z_UP @ (hub + below),
        Z_UP @ pitched @ Z_UP, quaternion_of(yaw, roll, pitch),
        np.array([-wheels[0], steer, -wheels[1]]), per_rate,
    )  # fmt: skip
