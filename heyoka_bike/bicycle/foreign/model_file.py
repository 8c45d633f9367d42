"""URDF and MJCF files: their moving bodies at zero angles."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from heyoka_bike.bicycle.foreign.bodies import (
    Body,
    Mass,
    Matrix,
    parameters,
    tensor,
    turn,
    unit,
    vector,
)
from heyoka_bike.bicycle.foreign.found import Found
from heyoka_bike.bicycle.foreign.xml_source import MP, Element, parse

_HINGES = ("continuous", "revolute")
_ORIENTATIONS = ("axisangle", "xyaxes", "zaxis")
_GRAVITY = "9.81"
"""Gravity for files that do not state it [m/s^2]: MuJoCo's default."""

_MAX_LINKS = 200
_NOT_READ = ("default", "include")


def read(text: str, file: str) -> Found:
    """Read the parameters of a model.

    Raises
    ------
    InputError
        The text is neither URDF nor MJCF, has unsupported elements, or does not describe a bicycle;
        see `parameters`.
    """
    root = parse(text, file)
    if root.tag not in _READERS:
        raise root.error(f"found <{root.tag}>, expected <robot> (URDF) or <mujoco> (MJCF)")
    return _READERS[root.tag](root)


def _urdf(root: Element) -> Found:
    links = {link.text("name"): link for link in root.all("link")}
    joints = list(root.all("joint"))
    held = {_link_of(joint, "child", links): joint for joint in joints}
    tops = [name for name in links if name not in held]
    if len(links) > _MAX_LINKS:
        raise root.error(f"found {len(links)} links, expected at most {_MAX_LINKS}")
    if len(tops) != 1 or len(held) != len(joints) or len(links) != len(list(root.all("link"))):
        raise root.error(
            "found no single tree of links, expected links of different names, of which no joint "
            "holds one and one joint each of the others"
        )
    bodies: dict[str, Body] = {}

    def visit(name: str, within: str, place: Matrix, axes: Matrix) -> None:
        link, joint = links[name], held.get(name)
        own = _urdf_mass(link, place, axes)
        if joint is not None and joint.text("type") in _HINGES:
            given = joint.first("axis")
            numbers = given.numbers("xyz", 3, "1 0 0") if given else [1, 0, 0]
            axis = axes * unit(vector(numbers), given or joint)
            bodies[name] = Body(name, own, within, place, axis, _urdf_radius(link), link)
            within = name
        elif joint is None or joint.text("type") == "floating":
            if any(body.mass.mass for body in bodies.values()):
                raise link.error(f"found a second base {name}, expected one bicycle")
            bodies.clear()
            bodies[name] = Body(name, own, "", place, place, _urdf_radius(link), link)
            within = name
        elif joint.text("type") == "fixed":
            body = bodies[within]
            body.mass = body.mass.joined(own)
            body.radius = _urdf_radius(link) if body.radius is None else body.radius
        else:
            raise joint.error(
                f"found a joint of type {joint.text('type')!r:.40}, expected {', '.join(_HINGES)}, "
                "fixed or floating"
            )
        for child, below in held.items():
            if _link_of(below, "parent", links) == name:
                moved, turned = _origin(below)
                visit(child, within, place + axes * moved, axes * turned)

    visit(tops[0], "", vector([0, 0, 0]), MP.eye(3))
    found = parameters(list(bodies.values()), MP.mpf(_GRAVITY), root)
    found.name = root.attributes.get("name", "")
    found.notes.append(f"g = {_GRAVITY} m/s^2 is taken: URDF has no gravity")
    return found


def _link_of(joint: Element, end: str, links: Mapping[str, Element]) -> str:
    element = joint.needed(end)
    name = element.text("link")
    if name not in links:
        raise element.error(f"found link {name!r:.40}, expected the name of a link of this file")
    return name


def _origin(element: Element) -> tuple[Matrix, Matrix]:
    """Return the position and rotation in an element of URDF."""
    origin = element.first("origin")
    if origin is None:
        return vector([0, 0, 0]), MP.eye(3)
    x, y, z = (turn(MP.eye(3)[:, i], a) for i, a in enumerate(origin.numbers("rpy", 3, "0 0 0")))
    return vector(origin.numbers("xyz", 3, "0 0 0")), z * y * x


def _urdf_mass(link: Element, place: Matrix, axes: Matrix) -> Mass:
    inertial = link.first("inertial")
    if inertial is None:
        return Mass(MP.zero, place, MP.zeros(3))
    (mass,) = inertial.needed("mass").numbers("value", 1)
    matrix = inertial.needed("inertia")
    elements = [
        matrix.numbers(f"i{ij}", 1, None if ij[0] == ij[1] else "0")[0]
        for ij in ("xx", "yy", "zz", "xy", "xz", "yz")
    ]
    moved, turned = _origin(inertial)
    own = axes * turned
    return Mass(mass, place + axes * moved, own * tensor(*elements) * own.T)


def _urdf_radius(link: Element) -> Any:
    for what in ("collision", "visual"):
        for shape in ("cylinder", "sphere"):
            if (found := link.first(what, "geometry", shape)) is not None:
                return found.numbers("radius", 1)[0]
    return None


def _mjcf(root: Element) -> Found:
    compiler, option = root.first("compiler"), root.first("option")
    in_degrees = compiler is None or compiler.attributes.get("angle", "degree") == "degree"
    if compiler is not None and compiler.attributes.get("eulerseq", "xyz") != "xyz":
        raise compiler.error("found another eulerseq, expected xyz")
    bodies: dict[str, Body] = {}

    def visit(element: Element, within: str, place: Matrix, axes: Matrix) -> None:
        name = element.attributes.get("name", f"body of line {element.line}")
        moved, turned = _pose(element, in_degrees)
        place, axes = place + axes * moved, axes * turned
        own = _mjcf_mass(element, place, axes, in_degrees)
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
                raise element.error(f"found a second base {name}, expected one bicycle")
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
            visit(child, within, place, axes)

    for top in root.needed("worldbody").all("body"):
        visit(top, "", vector([0, 0, 0]), MP.eye(3))
    gravity = (option or root).numbers("gravity", 3, f"0 0 -{_GRAVITY}")
    if gravity[0] or gravity[1] or gravity[2] > 0:
        raise (option or root).error("found gravity that is not down, expected 0 0 -g")
    found = parameters(list(bodies.values()), -gravity[2], root)
    found.name = root.attributes.get("model", "")
    found.notes += [f"<{tag}> is not read" for tag in _NOT_READ if root.first(tag)]
    return found


def _pose(element: Element, in_degrees: bool) -> tuple[Matrix, Matrix]:
    """Return the position and rotation in an element of MJCF."""
    for name in _ORIENTATIONS:
        if name in element.attributes:
            raise element.error(f"found {name} of <{element.tag}>, expected quat or euler")
    place = vector(element.numbers("pos", 3, "0 0 0"))
    if "euler" in element.attributes:
        unit_of = MP.pi / 180 if in_degrees else MP.one
        x, y, z = (
            turn(MP.eye(3)[:, i], a * unit_of) for i, a in enumerate(element.numbers("euler", 3))
        )
        return place, x * y * z
    scalar, *along = element.numbers("quat", 4, "1 0 0 0")
    length = MP.norm(along)
    if not length:
        return place, MP.eye(3)
    return place, turn(vector(along) / length, 2 * MP.atan2(length, scalar))


def _mjcf_mass(element: Element, place: Matrix, axes: Matrix, in_degrees: bool) -> Mass:
    inertial = element.first("inertial")
    if inertial is None:
        for geom in element.all("geom"):
            if geom.numbers("mass", 1, "1")[0]:
                raise geom.error(
                    "found a body whose mass is that of its shapes, expected an <inertial>"
                )
        return Mass(MP.zero, place, MP.zeros(3))
    moved, turned = _pose(inertial, in_degrees)
    (mass,) = inertial.numbers("mass", 1)
    if "fullinertia" in inertial.attributes:
        matrix = tensor(*inertial.numbers("fullinertia", 6))
    else:
        matrix = MP.diag(inertial.numbers("diaginertia", 3))
    own = axes * turned
    return Mass(mass, place + axes * moved, own * matrix * own.T)


def _mjcf_radius(element: Element) -> Any:
    for geom in _round(element):
        return geom.numbers("size", max(1, len(geom.text("size").split())))[0]
    return None


def _round(element: Element) -> Iterator[Element]:
    kinds = ("ellipsoid", "cylinder", "sphere")
    return (x for x in element.all("geom") if x.attributes.get("type", "sphere") in kinds)


_READERS: Mapping[str, Callable[[Element], Found]] = {"robot": _urdf, "mujoco": _mjcf}
