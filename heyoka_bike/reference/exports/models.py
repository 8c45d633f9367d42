"""The bicycle as a file for physics engines: URDF, SDFormat, MJCF.

Numbers are exact until they are written with 17 digits. The module `bicycle.tree` contains the
common part of the formats.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import flint

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.instant import Instant, quantities
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.bicycle.tree import INERTIA, Link, Tree, tree_of
from heyoka_bike.errors import quoted
from heyoka_bike.numbers.arithmetic import Balls, Number
from heyoka_bike.numbers.vectors import Quaternion, Vector, cross, plus, scaled
from heyoka_bike.reference.description import COPYRIGHT
from heyoka_bike.reference.exports.formats import parameter_lines, wrapped
from heyoka_bike.version import __version__

_BITS = 200
_DIGITS = 17

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
    """Return the initial state of a maneuver, in balls.

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
    """

    bicycle: Bicycle
    tree: Tree
    starts: tuple[Start, ...]
    maneuvers: Sequence[Maneuver]
    gravity: Number
    width: Number
    quarter: Number


def render(
    name: str, bicycle: Bicycle, maneuvers: Sequence[Maneuver], width: Fraction = Fraction(0)
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
        Width of the wheels [m]; zero means `THINNEST`.

    Raises
    ------
    InputError
        A maneuver cannot start.
    """
    balls = Balls(_BITS)
    equations = Equations.of(bicycle, balls)
    starts = tuple(start_of(equations, m) for m in maneuvers)
    with balls.precision():
        model = _Model(
            bicycle, tree_of(bicycle, balls), starts, maneuvers, balls.number(bicycle["g"]),
            balls.number(width or THINNEST), flint.arb.pi() / 2,
        )  # fmt: skip
        kind = MODELS[name]
        about = _comment([*_about(model, kind), *_start_lines(model)])
        text = "\n".join(['<?xml version="1.0"?>', about, *kind.lines(model)])
    return f"{text}\n".encode("ascii")


def refused(bicycle: Bicycle) -> Iterator[str]:
    """Yield the reasons why engines reject a bicycle or change it, one line each."""
    for warning in bicycle.warnings:
        yield f"{warning}, which engines refuse or change"
    for letter in "RBHF":
        if bicycle[f"m{letter}"].is_zero:
            yield f"{letter} has no mass, which engines refuse or change"


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
        f"The wheels are {kind.shape} {_text(model.width)} m wide, without mass of their own. "
        "Joints have no damping, no friction and no limits."
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


def _urdf(model: _Model) -> Iterator[str]:
    tree = model.tree
    yield '<robot name="bicycle">'
    for link in tree.links.values():
        yield f'  <link name="{link.name}">'
        yield "    <inertial>"
        yield f'      <origin xyz="{_words(link.centre)}" rpy="0 0 0"/>'
        yield f'      <mass value="{_text(link.mass)}"/>'
        elements = zip(INERTIA, map(_text, link.inertia), strict=True)
        yield "      <inertia " + " ".join(f'i{ij}="{x}"' for ij, x in elements) + "/>"
        yield "    </inertial>"
        for what in ("visual", "collision") if link.radius is not None else ():
            yield f"    <{what}>"
            yield f'      <origin xyz="0 0 0" rpy="{_text(model.quarter)} 0 0"/>'
            size = f'radius="{_text(link.radius)}" length="{_text(model.width)}"'
            yield f"      <geometry><cylinder {size}/></geometry>"
            yield f"    </{what}>"
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
    yield '<sdf version="1.6">'
    yield '  <world name="uncontrolled_bicycle">'
    yield f"    <gravity>0 0 {_text(-model.gravity)}</gravity>"
    yield '    <model name="floor">'
    yield "      <static>true</static>"
    yield '      <link name="floor">'
    yield '        <collision name="floor">'
    plane = "<normal>0 0 1</normal><size>1000 1000</size>"
    yield f"          <geometry><plane>{plane}</plane></geometry>"
    yield "        </collision>"
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
        for what in ("visual", "collision") if link.radius is not None else ():
            yield f'        <{what} name="{link.name}_{what}">'
            yield f"          <pose>0 0 0 {_text(model.quarter)} 0 0</pose>"
            size = f"<radius>{_text(link.radius)}</radius><length>{_text(model.width)}</length>"
            yield f"          <geometry><cylinder>{size}</cylinder></geometry>"
            yield f"        </{what}>"
        yield "      </link>"
    for hinge in tree.hinges:
        yield f'      <joint name="{hinge.name}" type="revolute">'
        yield f"        <parent>{hinge.parent}</parent>"
        yield f"        <child>{hinge.child}</child>"
        yield "        <axis>"
        yield f"          <xyz>{_words(hinge.axis)}</xyz>"
        # These limits are never reached, but PyBullet rejects a joint without limits.
        yield "          <limit><lower>-1e16</lower><upper>1e16</upper></limit>"
        yield "          <dynamics><damping>0</damping><friction>0</friction></dynamics>"
        yield "        </axis>"
        yield "      </joint>"
    yield "    </model>"
    yield "  </world>"
    yield "</sdf>"


def _mjcf(model: _Model) -> Iterator[str]:
    yield '<mujoco model="bicycle">'
    yield '  <compiler angle="radian" inertiafromgeom="false"/>'
    yield f'  <option gravity="0 0 {_text(-model.gravity)}"/>'
    yield "  <worldbody>"
    yield '    <geom name="floor" type="plane" size="0 0 1" contype="2" conaffinity="1"/>'
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
    else:
        axis = f'axis="{_words(hinge.axis)}"'
        yield f'{indent}  <joint name="{hinge.name}" type="hinge" {axis} damping="0"/>'
    of_mass = f'pos="{_words(link.centre)}" mass="{_text(link.mass)}"'
    yield f'{indent}  <inertial {of_mass} fullinertia="{_words(link.inertia)}"/>'
    if link.radius is not None:
        size = (link.radius, model.width / 2, link.radius)
        yield (
            f'{indent}  <geom name="{link.name}" type="ellipsoid" size="{_words(size)}" mass="0" '
            'contype="1" conaffinity="2"/>'
        )
    for child in model.tree.children(link.name):
        yield from _mjcf_body(model, child, f"{indent}  ")
    yield f"{indent}</body>"


def _back(attitude: Quaternion, v: Vector) -> Vector:
    """Convert a vector from the ground axes to those of a body of this attitude."""
    scalar, *along = attitude
    axis = (-along[0], -along[1], -along[2])
    twice = scaled(2, cross(axis, v))
    return plus(plus(v, scaled(scalar, twice)), cross(axis, twice))


@dataclass(frozen=True, slots=True)
class ModelFormat:
    """A format of models.

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
