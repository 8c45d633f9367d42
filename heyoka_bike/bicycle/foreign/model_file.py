"""URDF, SDFormat and MJCF: their moving bodies at zero angles."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from heyoka_bike.bicycle.foreign import sdf_file
from heyoka_bike.bicycle.foreign.bodies import (
    ORIGIN,
    Body,
    Mass,
    Matrix,
    Pose,
    composed,
    downward,
    parameters,
    rotation,
    tensor,
    turns,
    unit,
    vector,
)
from heyoka_bike.bicycle.foreign.foreign_bicycle import ForeignBicycle
from heyoka_bike.bicycle.foreign.links import Joint, Link, bodies_of, from_the_base, radius_of
from heyoka_bike.bicycle.foreign.xml_source import MP, Element, parse

_HINGES = ("continuous", "revolute")
_ORIENTATIONS = ("axisangle", "xyaxes", "zaxis")
_GRAVITY = "9.81"
"""Gravity for files that do not state it [m/s^2]: MuJoCo's default."""

_NOT_READ = ("default", "include")


def read(text: str, file: str) -> ForeignBicycle:
    """Read the parameters of a model.

    Raises
    ------
    InputError
        The text is not URDF, SDFormat or MJCF, has unsupported elements, or describes no bicycle;
        see `parameters`.
    """
    root = parse(text, file)
    if root.tag not in _READERS:
        raise root.error(f"found <{root.tag}>, expected <robot> (URDF), <sdf> or <mujoco> (MJCF)")
    return _READERS[root.tag](root)


def _urdf(root: Element) -> ForeignBicycle:
    elements = {link.text("name"): link for link in root.all("link")}
    joints = list(root.all("joint"))
    ends = [(_link_of(x, "parent", elements), _link_of(x, "child", elements)) for x in joints]
    order = from_the_base([link.text("name") for link in root.all("link")], ends, root)
    (top,) = set(elements) - {child for _, child in ends}
    frames = {top: ORIGIN}
    found_joints = []
    for i in order:
        parent, child = ends[i]
        frames[child] = composed(frames[parent], _origin(joints[i]))
        found_joints.append(_urdf_joint(joints[i], parent, child, *frames[child]))
    links = {
        name: Link(
            _urdf_mass(link, frames[name]), frames[name][0], radius_of(link, _urdf_radii), link
        )
        for name, link in elements.items()
    }
    found = parameters(bodies_of(links, found_joints), MP.mpf(_GRAVITY), root)
    found.name = root.attributes.get("name", "")
    found.notes.append(f"g is set to {_GRAVITY} m/s^2, because URDF files contain no gravity")
    return found


def _urdf_joint(joint: Element, parent: str, child: str, place: Matrix, axes: Matrix) -> Joint:
    kind = joint.text("type")
    if kind in _HINGES:
        given = joint.first("axis")
        numbers = given.numbers("xyz", 3, "1 0 0") if given else [1, 0, 0]
        axis = axes * unit(vector(numbers), given or joint)
        return Joint("hinge", parent, child, place, axis)
    if kind == "fixed":
        return Joint("fixed", parent, child, place, place)
    if kind == "floating":
        return Joint("free", parent, child, place, place)
    raise joint.error(
        f"found a joint of type {kind!r:.40}, expected {', '.join(_HINGES)}, fixed or floating"
    )


def _link_of(joint: Element, end: str, links: Mapping[str, Element]) -> str:
    element = joint.needed(end)
    name = element.text("link")
    if name not in links:
        raise element.error(f"found link {name!r:.40}, expected the name of a link of this file")
    return name


def _origin(element: Element) -> Pose:
    """Return the <origin> of an element of URDF."""
    origin = element.first("origin")
    if origin is None:
        return ORIGIN
    x, y, z = turns(origin.numbers("rpy", 3, "0 0 0"))
    return vector(origin.numbers("xyz", 3, "0 0 0")), z * y * x


def _urdf_mass(link: Element, pose: Pose) -> Mass:
    inertial = link.first("inertial")
    if inertial is None:
        return Mass.zero(pose[0])
    (mass,) = inertial.needed("mass").numbers("value", 1)
    matrix = inertial.needed("inertia")
    elements = [
        matrix.numbers(f"i{ij}", 1, None if ij[0] == ij[1] else "0")[0]
        for ij in ("xx", "yy", "zz", "xy", "xz", "yz")
    ]
    return Mass.at(composed(pose, _origin(inertial)), mass, tensor(*elements))


def _urdf_radii(shape: Element) -> Iterator[Any]:
    for kind in ("cylinder", "sphere"):
        if (found := shape.first("geometry", kind)) is not None:
            yield found.numbers("radius", 1)[0]


def _mjcf(root: Element) -> ForeignBicycle:
    compiler, option = root.first("compiler"), root.first("option")
    in_degrees = compiler is None or compiler.attributes.get("angle", "degree") == "degree"
    if compiler is not None and compiler.attributes.get("eulerseq", "xyz") != "xyz":
        raise compiler.error("found an eulerseq other than xyz, expected xyz")
    bodies: dict[str, Body] = {}

    def visit(element: Element, within: str, parent_pose: Pose) -> None:
        name = element.attributes.get("name", f"body of line {element.line}")
        pose = place, axes = composed(parent_pose, _pose(element, in_degrees))
        own = _mjcf_mass(element, pose, in_degrees)
        joints = [x for x in element.children if x.tag in ("joint", "freejoint")]
        if len(joints) > 1:
            raise joints[1].error(f"found a second joint of {name}, expected one")
        kinds = [
            "free" if x.tag == "freejoint" else x.attributes.get("type", "hinge") for x in joints
        ]
        if kinds == ["hinge"] and within:
            (joint,) = joints
            axis = axes * unit(vector(joint.numbers("axis", 3, "0 0 1")), joint)
            point = place + axes * vector(joint.numbers("pos", 3, "0 0 0"))
            bodies[name] = Body(name, own, within, point, axis, _mjcf_radius(element), element)
            within = name
        elif not within and kinds in ([], ["free"]):
            if bodies:
                raise element.error(
                    f"found a second root body {name}, expected a file that describes one bicycle"
                )
            bodies[name] = Body(name, own, "", place, place, _mjcf_radius(element), element)
            within = name
        elif not kinds:
            body = bodies[within]
            body.mass = body.mass.joined(own)
            body.radius = _mjcf_radius(element) if body.radius is None else body.radius
        else:
            raise joints[0].error(
                f"found a joint of type {kinds[0]!r:.40}, expected a free base and hinges"
            )
        for child in element.all("body"):
            visit(child, within, pose)

    for top in root.needed("worldbody").all("body"):
        visit(top, "", ORIGIN)
    gravity = (option or root).numbers("gravity", 3, f"0 0 -{_GRAVITY}")
    found = parameters(list(bodies.values()), downward(gravity, option or root), root)
    found.name = root.attributes.get("model", "")
    found.notes += [f"<{tag}> was not read" for tag in _NOT_READ if root.first(tag)]
    return found


def _pose(element: Element, in_degrees: bool) -> Pose:
    """Return the position and rotation in an element of MJCF."""
    for name in _ORIENTATIONS:
        if name in element.attributes:
            raise element.error(f"found {name} of <{element.tag}>, expected quat or euler")
    place = vector(element.numbers("pos", 3, "0 0 0"))
    if "euler" in element.attributes:
        unit_of = MP.pi / 180 if in_degrees else MP.one
        x, y, z = turns([a * unit_of for a in element.numbers("euler", 3)])
        return place, x * y * z
    return place, rotation(*element.numbers("quat", 4, "1 0 0 0"))


def _mjcf_mass(element: Element, pose: Pose, in_degrees: bool) -> Mass:
    inertial = element.first("inertial")
    if inertial is None:
        for geom in element.all("geom"):
            if geom.numbers("mass", 1, "1")[0]:
                raise geom.error(
                    "found a body that has shapes with mass but no <inertial>, expected its mass "
                    "and inertia in <inertial>"
                )
        return Mass.zero(pose[0])
    own = composed(pose, _pose(inertial, in_degrees))
    (mass,) = inertial.numbers("mass", 1)
    if "fullinertia" in inertial.attributes:
        matrix = tensor(*inertial.numbers("fullinertia", 6))
    else:
        matrix = MP.diag(inertial.numbers("diaginertia", 3))
    return Mass.at(own, mass, matrix)


def _mjcf_radius(element: Element) -> Any:
    """Return the radius of a wheel: the largest of its collision shapes, or else visual shapes."""
    kinds = ("ellipsoid", "cylinder", "sphere")
    shapes = [x for x in element.all("geom") if x.attributes.get("type", "sphere") in kinds]
    collide = [x for x in shapes if not _is_seen_only(x)]
    radii = [x.numbers("size", max(1, len(x.text("size").split())))[:1] for x in collide or shapes]
    return max((radius for (radius,) in radii), default=None)


def _is_seen_only(geom: Element) -> bool:
    return all(geom.attributes.get(name, "1") == "0" for name in ("contype", "conaffinity"))


_READERS: Mapping[str, Callable[[Element], ForeignBicycle]] = {
    "robot": _urdf, "sdf": sdf_file.read, "mujoco": _mjcf,
}  # fmt: skip
