"""The bicycle as a file for physics engines: URDF, SDFormat, MJCF.

Numbers are exact until they are written with 17 digits. The module `bicycle.tree` contains the
common part of the formats.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import atan2, hypot

import flint

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.instant import Instant, quantities
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.bicycle.shapes import COLOURS
from heyoka_bike.bicycle.tree import INERTIA, Link, Tree, tree_of
from heyoka_bike.errors import quoted
from heyoka_bike.numbers.arithmetic import Balls, Number
from heyoka_bike.numbers.vectors import Quaternion, Vector, cross, plus, scaled
from heyoka_bike.reference.description import COPYRIGHT
from heyoka_bike.reference.exports.formats import parameter_lines, wrapped
from heyoka_bike.reference.exports.visuals import Primitive, primitives
from heyoka_bike.version import __version__

_BITS = 200
_DIGITS = 17

_CAMERAS = (
    # Each camera has a name, a position, and the axes that point right and up in its picture.
    ("follow", "-1.7 -2.2 1.5", "0.707 -0.707 0", "0.166 0.166 0.972"),
    ("side", "0.5 -3 0.9", "1 0 0", "0 0 1"),
    ("behind", "-2.6 0 0.9", "0 -1 0", "0 0 1"),
    ("above", "0.5 0 4", "1 0 0", "0 1 0"),
)
_MJCF_LIGHT = (
    '<light name="sun" mode="track" directional="true" pos="0 0 4" dir="0 0 -1" '
    'diffuse="0.4 0.4 0.4" specular="0.1 0.1 0.1"/>'
)
STEP = "0.001"
"""Time step in formats that state one [s]."""
# The measurements in docs/how-to/engines.md led to these settings.
_MJCF_STEPS = f'timestep="{STEP}" integrator="implicit" cone="elliptic" impratio="10"'
# MuJoCo raises the time constant of a contact (the first number of solref) to at least two steps,
# so this tiny value suits every step size. The priority makes MuJoCo use the wheel's settings
# instead of the floor's.
_MJCF_CONTACT = 'priority="1" friction="1" solref="1e-5 1"'
_SDF_FRICTION = "<surface><friction><ode><mu>1</mu><mu2>1</mu2></ode></friction></surface>"
_SDF_SUN = (
    '    <light name="sun" type="directional">',
    "      <pose>0 0 10 0 0 0</pose><direction>0.3 0.4 -1</direction>",
    "      <diffuse>0.8 0.8 0.8 1</diffuse><cast_shadows>true</cast_shadows>",
    "    </light>",
)
_MJCF_SCENE = (
    "  <visual>",
    '    <global offwidth="1280" offheight="720"/>',
    '    <headlight ambient="0.35 0.35 0.35" diffuse="0.25 0.25 0.25" specular="0 0 0"/>',
    '    <quality shadowsize="4096"/>',
    "  </visual>",
    '  <statistic center="0.5 0 0.8" extent="2"/>',
    "  <asset>",
    '    <texture name="sky" type="skybox" builtin="gradient" width="64" height="384"',
    '             rgb1="0.91 0.93 0.95" rgb2="0.7 0.78 0.86"/>',
    '    <texture name="tiles" type="2d" builtin="checker" width="256" height="256"',
    '             rgb1="0.9 0.9 0.89" rgb2="0.78 0.8 0.81"/>',
    '    <material name="tiles" texture="tiles" texrepeat="1 1" texuniform="true"/>',
)

THINNEST = Fraction(1, 10**6)
"""Width of a wheel without width [m], which every engine accepts."""


@dataclass(frozen=True, slots=True)
class Start:
    """Posture and velocities of a tree at the start of a maneuver, along the ground axes.

    Attributes
    ----------
    place, attitude
        Origin of the base [m], and its attitude as a unit quaternion, scalar first.
    angles
        Angles of the hinges [rad], in their order.
    velocity, turning
        Velocity of the base's origin [m/s], and angular velocity of the base [rad/s].
    rates
        Angular rates of the hinges [rad/s]; both wheels roll.
    """

    place: Vector
    attitude: Quaternion
    angles: tuple[Number, ...]
    velocity: Vector
    turning: Vector
    rates: tuple[Number, ...]


def start_of(equations: Equations, maneuver: Maneuver) -> Start:
    """Return the posture and the velocities at the start of a maneuver, as balls.

    Parameters
    ----------
    equations : Equations
        Equations of the regular form, over `Balls`.
    maneuver : Maneuver

    Raises
    ------
    InputError
        The maneuver cannot start, see `initial_state`.
    """
    with equations.precision():
        nothing = equations.a.number(0)
        state = [*initial_state(equations, maneuver), *[nothing] * len(INTEGRALS)]
        found = quantities(Instant.of(equations, state))

        def vector(name: str) -> Vector:
            return found[f"{name}_x"], found[f"{name}_y"], found[f"{name}_z"]

        rows = [[found[f"rear_frame_r{i}{j}"] for j in (1, 2, 3)] for i in (1, 2, 3)]

        def along_ground(v: Vector) -> Vector:
            x, y, z = (sum(r * u for r, u in zip(row, v, strict=True)) for row in rows)
            return x, y, z

        turning = along_ground(vector("rear_frame_omega"))
        below = scaled(equations.b.rear.wheel_r, along_ground((0, 0, 1)))
        q0, *q = (found[f"rear_frame_q{i}"] for i in range(4))
        return Start(
            place=_turned(plus(vector("rear_hub"), below)),
            attitude=(q0, *_turned((q[0], q[1], q[2]))),
            angles=(nothing, state[2], nothing),
            velocity=_turned(plus(vector("rear_hub_velocity"), cross(turning, below))),
            turning=_turned(turning),
            rates=(-found["rear_wheel_rate"], state[4], -found["front_wheel_rate"]),
        )


def _turned(v: Vector) -> Vector:
    """Convert a vector from axes with z down to axes with z up."""
    return v[0], -v[1], -v[2]


@dataclass(frozen=True, slots=True)
class _Model:
    """Content of a model file.

    Attributes
    ----------
    bicycle : Bicycle
    tree : Tree
        Tree in balls.
    starts : tuple of Start
        Initial states of the maneuvers, in their order.
    maneuvers
    gravity, width, quarter
        Gravity [m/s^2], width of the wheels [m], and a quarter turn [rad].
    visuals : mapping
        Primitives to look at, by the name of the link that carries them; empty for none.
    """

    bicycle: Bicycle
    tree: Tree
    starts: tuple[Start, ...]
    maneuvers: Sequence[Maneuver]
    gravity: Number
    width: Number
    quarter: Number
    visuals: Mapping[str, Sequence[Primitive]]


def render(
    name: str,
    bicycle: Bicycle,
    maneuvers: Sequence[Maneuver],
    width: Fraction = Fraction(0),
    *,
    has_visuals: bool = True,
) -> bytes:
    """Return the model file of a bicycle.

    Parameters
    ----------
    name
        Name of the format, see `MODELS`.
    bicycle
    maneuvers
        Maneuvers whose initial states the file contains.
    width
        Width of the wheels' collision shapes [m]; zero stands for `THINNEST`.
    has_visuals
        True to add shapes, colours and lights to look at.

    Raises
    ------
    InputError
        A maneuver cannot start.
    """
    balls = Balls(_BITS)
    equations = Equations.of(bicycle, balls)
    starts = tuple(start_of(equations, m) for m in maneuvers)
    with balls.precision():
        tree = tree_of(bicycle, balls)
        model = _Model(
            bicycle, tree, starts, maneuvers, balls.number(bicycle["g"]),
            balls.number(width or THINNEST), flint.arb.pi() / 2,
            _visuals(bicycle, tree) if has_visuals else {},
        )  # fmt: skip
        kind = MODELS[name]
        about = _comment([*_about(model, kind), *_start_lines(model)])
        text = "\n".join(['<?xml version="1.0"?>', about, *kind.lines(model)])
    return f"{text}\n".encode("ascii")


def _visuals(bicycle: Bicycle, tree: Tree) -> dict[str, list[Primitive]]:
    places = {
        name: (float(x.mid()), float(y.mid()), float(z.mid()))
        for name, link in tree.links.items()
        for x, y, z in [link.place]
    }
    found: dict[str, list[Primitive]] = {name: [] for name in tree.links}
    for primitive in primitives(bicycle, places):
        found[primitive.link].append(primitive)
    return found


def refused(bicycle: Bicycle) -> Iterator[str]:
    """Yield each reason why engines refuse or change a bicycle, as one line of text."""
    for warning in bicycle.warnings:
        yield f"{warning}: most engines refuse this or change it"
    for letter in "RBHF":
        if bicycle[f"m{letter}"].is_zero:
            yield f"{letter} has no mass: most engines refuse this or change it"


def _about(model: _Model, kind: ModelFormat) -> Iterator[str]:
    named = quoted(model.bicycle.name)
    yield f"The uncontrolled Carvallo-Whipple bicycle {named} as {kind.title}."
    yield f"Written by heyoka-bike export {__version__}. Licence: {COPYRIGHT}."
    yield (
        "SI units. Axes: x forward, y to the left, z up. Those of the benchmark, y to the right "
        "and z down, are turned by half a turn about x: here ixz, heights, the rates of the "
        "wheels, pitch and yaw have the other sign. Roll and steer are positive to the right as "
        "there, since the steer axis points down."
    )
    yield (
        "Links: B rear frame with rider, R rear wheel, H fork and handlebar, F front wheel. All "
        "frames are parallel when the bicycle is upright and straight. The origin of B is where "
        "the rear wheel touches the floor then, that of H the point of the steer axis nearest to "
        "the rear hub, those of R and F are the hubs. A base at the origin that is not turned, "
        "with all angles zero, is that posture."
    )
    yield kind.says
    yield (
        f"The wheels touch the floor with {kind.shape} {_text(model.width)} m wide. All other "
        "shapes are to look at: no shape has mass, and only the wheels collide. Joints have no "
        "damping, no friction and no limits."
    )
    yield "Parameters, in the benchmark's axes:"
    yield from parameter_lines(model.bicycle)


def _start_lines(model: _Model) -> Iterator[str]:
    yield (
        "Starts: place x y z of the origin of B, quaternion w x y z of B; angles of rear_axle, "
        "steer_axis, front_axle; velocity of the origin of B and angular velocity of B along the "
        "axes of the ground; rates of the three joints."
    )
    for n, (maneuver, start) in enumerate(zip(model.maneuvers, model.starts, strict=True), 1):
        yield f"start_{n}: {quoted(maneuver.name)}"
        yield f"  place {_words(start.place)}; quaternion {_words(start.attitude)}"
        yield f"  angles {_words(start.angles)}"
        yield f"  velocity {_words(start.velocity)}; angular velocity {_words(start.turning)}"
        yield f"  rates {_words(start.rates)}"


def _comment(paragraphs: Sequence[str]) -> str:
    """Return paragraphs as an XML comment, which must not contain two hyphens in a row."""
    text = "\n".join(wrapped(paragraphs))
    return "<!--\n" + re.sub("-(?=-)", "- ", text) + "\n-->"


def _text(x: Number) -> str:
    """Return the middle of a ball as a decimal; zero if the ball contains zero."""
    text = "0" if x.contains(0) else x.mid().str(_DIGITS, radius=False)
    digits, mark, power = text.partition("e")
    return (digits.rstrip("0").rstrip(".") if "." in digits else digits) + mark + power


def _words(numbers: Sequence[Number]) -> str:
    return " ".join(map(_text, numbers))


def _rounded(*numbers: float) -> str:
    """Return lengths or angles of a visual as text, rounded to 0.1 mm or 1e-4 rad."""
    return " ".join(f"{round(x, 4) + 0.0:g}" for x in numbers)


def _size(x: float) -> str:
    """Return a radius or length of a shape as text; 4 significant digits keep it positive."""
    return f"{x:.4g}"


def _turned_to(primitive: Primitive) -> str:
    """Return the roll, pitch and yaw that turn the z axis to the axis of a primitive, as text."""
    x, y, z = primitive.along
    return _rounded(0, atan2(hypot(x, y), z), atan2(y, x))


def _rgba(colour: str) -> str:
    red, green, blue = bytes.fromhex(COLOURS[colour].removeprefix("#"))
    return " ".join(f"{part / 255:.3g}" for part in (red, green, blue, 255))


def _urdf(model: _Model) -> Iterator[str]:
    tree = model.tree
    yield '<robot name="bicycle">'
    for colour in COLOURS if model.visuals else ():
        yield f'  <material name="{colour}"><color rgba="{_rgba(colour)}"/></material>'
    for link in tree.links.values():
        yield f'  <link name="{link.name}">'
        yield "    <inertial>"
        yield f'      <origin xyz="{_words(link.centre)}" rpy="0 0 0"/>'
        yield f'      <mass value="{_text(link.mass)}"/>'
        elements = zip(INERTIA, map(_text, link.inertia), strict=True)
        yield "      <inertia " + " ".join(f'i{ij}="{x}"' for ij, x in elements) + "/>"
        yield "    </inertial>"
        if link.radius is not None:
            yield "    <collision>"
            yield f'      <origin xyz="0 0 0" rpy="{_text(model.quarter)} 0 0"/>'
            size = f'radius="{_text(link.radius)}" length="{_text(model.width)}"'
            yield f"      <geometry><cylinder {size}/></geometry>"
            yield "    </collision>"
        for seen in model.visuals.get(link.name, ()):
            at = f'<origin xyz="{_rounded(*seen.middle)}" rpy="{_turned_to(seen)}"/>'
            size = f'radius="{_size(seen.radius)}"'
            shape = (
                f"<sphere {size}/>" if seen.is_sphere
                else f'<cylinder {size} length="{_size(seen.length)}"/>'
            )  # fmt: skip
            yield (
                f"    <visual>{at}<geometry>{shape}</geometry>"
                f'<material name="{seen.colour}"/></visual>'
            )
        yield "  </link>"
    for hinge in tree.hinges:
        yield f'  <joint name="{hinge.name}" type="continuous">'
        yield f'    <parent link="{hinge.parent}"/>'
        yield f'    <child link="{hinge.child}"/>'
        place = tree.offset(tree.links[hinge.child])
        yield f'    <origin xyz="{_words(place)}" rpy="0 0 0"/>'
        yield f'    <axis xyz="{_words(hinge.axis)}"/>'
        yield '    <dynamics damping="0" friction="0"/>'
        yield "  </joint>"
    yield "</robot>"


def _sdf(model: _Model) -> Iterator[str]:
    tree = model.tree
    # Version 1.5 is the newest version from which both DART and sdformat read the gravity. DART
    # reads it only in <physics>, where later versions forbid it; programs for later versions move
    # it to the world.
    yield '<sdf version="1.5">'
    yield '  <world name="uncontrolled_bicycle">'
    gravity = f"<gravity>0 0 {_text(-model.gravity)}</gravity>"
    steps = f"<max_step_size>{STEP}</max_step_size><real_time_factor>1</real_time_factor>"
    yield f'    <physics name="steps" default="true" type="ode">{steps}{gravity}</physics>'
    if model.visuals:
        yield from _SDF_SUN
    yield '    <model name="floor">'
    yield "      <static>true</static>"
    yield '      <link name="floor">'
    # The inertia has no effect on the fixed floor, but DART prints a warning about a link without
    # one.
    unit = "<ixx>1</ixx><iyy>1</iyy><izz>1</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz>"
    yield f"        <inertial><mass>1</mass><inertia>{unit}</inertia></inertial>"
    yield '        <collision name="floor">'
    plane = "<normal>0 0 1</normal><size>1000 1000</size>"
    yield f"          <geometry><plane>{plane}</plane></geometry>"
    yield f"          {_SDF_FRICTION}"
    yield "        </collision>"
    if model.visuals:
        yield '        <visual name="floor">'
        yield f"          <geometry><plane>{plane}</plane></geometry>"
        yield f"          {_sdf_material('floor')}"
        yield "        </visual>"
    yield "      </link>"
    yield "    </model>"
    yield '    <model name="bicycle">'
    for link in tree.links.values():
        yield f'      <link name="{link.name}">'
        yield f"        <pose>{_words(link.place)} 0 0 0</pose>"
        yield "        <inertial>"
        yield f"          <pose>{_words(link.centre)} 0 0 0</pose>"
        yield f"          <mass>{_text(link.mass)}</mass>"
        elements = zip(INERTIA, map(_text, link.inertia), strict=True)
        inertia = "".join(f"<i{ij}>{x}</i{ij}>" for ij, x in elements)
        yield f"          <inertia>{inertia}</inertia>"
        yield "        </inertial>"
        if link.radius is not None:
            yield f'        <collision name="{link.name}_collision">'
            yield f"          <pose>0 0 0 {_text(model.quarter)} 0 0</pose>"
            size = f"<radius>{_text(link.radius)}</radius><length>{_text(model.width)}</length>"
            yield f"          <geometry><cylinder>{size}</cylinder></geometry>"
            yield f"          {_SDF_FRICTION}"
            yield "        </collision>"
        for n, seen in enumerate(model.visuals.get(link.name, ()), 1):
            at = f"<pose>{_rounded(*seen.middle)} {_turned_to(seen)}</pose>"
            yield f'        <visual name="{link.name}_{n}">{at}'
            size = f"<radius>{_size(seen.radius)}</radius>"
            shape = (
                f"<sphere>{size}</sphere>" if seen.is_sphere
                else f"<cylinder>{size}<length>{_size(seen.length)}</length></cylinder>"
            )  # fmt: skip
            yield f"          <geometry>{shape}</geometry>{_sdf_material(seen.colour)}</visual>"
        yield "      </link>"
    for hinge in tree.hinges:
        yield f'      <joint name="{hinge.name}" type="revolute">'
        yield f"        <parent>{hinge.parent}</parent>"
        yield f"        <child>{hinge.child}</child>"
        yield "        <axis>"
        yield f"          <xyz>{_words(hinge.axis)}</xyz>"
        # PyBullet rejects a joint without limits; these limits are never reached.
        yield "          <limit><lower>-1e16</lower><upper>1e16</upper></limit>"
        yield "          <dynamics><damping>0</damping><friction>0</friction></dynamics>"
        yield "        </axis>"
        yield "      </joint>"
    yield "    </model>"
    yield "  </world>"
    yield "</sdf>"


def _sdf_material(colour: str) -> str:
    rgba = _rgba(colour)
    return f"<material><ambient>{rgba}</ambient><diffuse>{rgba}</diffuse></material>"


def _mjcf(model: _Model) -> Iterator[str]:
    yield '<mujoco model="bicycle">'
    yield '  <compiler angle="radian" inertiafromgeom="false"/>'
    yield f'  <option gravity="0 0 {_text(-model.gravity)}" {_MJCF_STEPS}/>'
    floor = 'name="floor" type="plane" size="0 0 1" contype="2" conaffinity="1"'
    if model.visuals:
        yield from _MJCF_SCENE
        for colour in COLOURS:
            yield f'    <material name="{colour}" rgba="{_rgba(colour)}"/>'
        yield "  </asset>"
        floor += ' material="tiles"'
    yield "  <worldbody>"
    yield f"    <geom {floor}/>"
    (base, *_) = model.tree.links.values()
    yield from _mjcf_body(model, base, "    ")
    yield "  </worldbody>"
    yield "  <keyframe>"
    for n, start in enumerate(model.starts, 1):
        yield f'    <key name="start_{n}"'
        yield f'         qpos="{_words((*start.place, *start.attitude, *start.angles))}"'
        # MuJoCo expects the angular velocity of a free body along the body's own axes.
        turning = _back(start.attitude, start.turning)
        yield f'         qvel="{_words((*start.velocity, *turning, *start.rates))}"/>'
    yield "  </keyframe>"
    yield "</mujoco>"


def _mjcf_body(model: _Model, link: Link, indent: str) -> Iterator[str]:
    yield f'{indent}<body name="{link.name}" pos="{_words(model.tree.offset(link))}">'
    hinge = model.tree.hinge_of(link.name)
    if hinge is None:
        yield f'{indent}  <freejoint name="{link.name}"/>'
        if model.visuals:
            yield f"{indent}  {_MJCF_LIGHT}"
        for name, place, across, up in _CAMERAS if model.visuals else ():
            yield (
                f'{indent}  <camera name="{name}" mode="track" pos="{place}" '
                f'xyaxes="{across} {up}"/>'
            )
    else:
        axis = f'axis="{_words(hinge.axis)}"'
        yield f'{indent}  <joint name="{hinge.name}" type="hinge" {axis} damping="0"/>'
    of_mass = f'pos="{_words(link.centre)}" mass="{_text(link.mass)}"'
    yield f'{indent}  <inertial {of_mass} fullinertia="{_words(link.inertia)}"/>'
    if link.radius is not None:
        size = (link.radius, model.width / 2, link.radius)
        yield (
            f'{indent}  <geom name="{link.name}" type="ellipsoid" size="{_words(size)}" mass="0" '
            'contype="1" conaffinity="2" group="3"'
        )
        yield f"{indent}        {_MJCF_CONTACT}/>"
    for seen in model.visuals.get(link.name, ()):
        shape = (
            f'type="sphere" pos="{_rounded(*seen.middle)}"' if seen.is_sphere
            else f'type="cylinder" fromto="{_rounded(*seen.ends[0], *seen.ends[1])}"'
        )  # fmt: skip
        yield (
            f'{indent}  <geom {shape} size="{_size(seen.radius)}" material="{seen.colour}" '
            'mass="0" contype="0" conaffinity="0" group="2"/>'
        )
    for child in model.tree.children(link.name):
        yield from _mjcf_body(model, child, f"{indent}  ")
    yield f"{indent}</body>"


def _back(attitude: Quaternion, v: Vector) -> Vector:
    """Convert a vector from the ground axes to the axes of a body with this attitude."""
    scalar, *along = attitude
    axis = (-along[0], -along[1], -along[2])
    twice = scaled(2, cross(axis, v))
    return plus(plus(v, scaled(scalar, twice)), cross(axis, twice))


@dataclass(frozen=True, slots=True)
class ModelFormat:
    """A format of model files.

    Attributes
    ----------
    title
        Name of the format.
    suffix
        Suffix of the files.
    shape
        Shape of the wheels.
    says
        Sentences on missing or additional content.
    lines
        Function that yields the lines of a model.
    """

    title: str
    suffix: str
    shape: str
    says: str
    lines: Callable[[_Model], Iterator[str]]


MODELS: Mapping[str, ModelFormat] = {
    "urdf": ModelFormat(
        "URDF", ".urdf", "cylinders",
        "URDF has no gravity, no floor and no velocities: set g, a floor and the start yourself, "
        "and load B as a free-floating base.",
        _urdf,
    ),
    "sdf": ModelFormat(
        "SDFormat", ".sdf", "cylinders",
        "The world has gravity and a floor. Set the start yourself.",
        _sdf,
    ),
    "mjcf": ModelFormat(
        "MJCF", ".xml", "ellipsoids",
        "The file has gravity, a floor, and each start as a keyframe.",
        _mjcf,
    ),
}  # fmt: skip
"""Formats by the names that the command line accepts."""
