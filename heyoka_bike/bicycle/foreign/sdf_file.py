"""SDFormat, versions 1.4 to 1.11: the links of the one moving model at zero angles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from heyoka_bike.bicycle.foreign.bodies import (
    ORIGIN,
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
from heyoka_bike.bicycle.foreign.xml_source import MP, Element

_HINGES = ("revolute", "continuous")
_GRAVITY = "9.8"
"""Gravity of a world without <gravity> in the specification [m/s^2]."""
_GRAVITY_OF_MODEL = "9.81"
"""Gravity assumed for a model without a world [m/s^2]."""
_MODEL, _WORLD = "__model__", "world"
_AXES_OF_MODEL = (1, 5)
"""Before this version, axes of joints are along the axes of the model."""


def read(root: Element) -> ForeignBicycle:
    """Return the parameters of the bicycle in a document.

    Raises
    ------
    InputError
        The document has no single moving model, has unsupported elements, or describes no bicycle.
    """
    world = root.first("world")
    model = _model(root, world)
    for tag in ("model", "include"):
        if (inner := model.first(tag)) is not None:
            raise inner.error(f"found <{tag}> in a model, expected its links in one model")
    frames = _Frames(model, _version(root))
    links = {}
    for element in model.all("link"):
        name = element.text("name")
        pose = frames.of(name)
        links[name] = Link(_mass(element, pose), pose[0], radius_of(element, _radii), element)
    elements = list(model.all("joint"))
    ends = [_ends(joint, links) for joint in elements]
    if any(parent == _WORLD for parent, _ in ends):
        links[_WORLD] = Link(Mass.zero(ORIGIN[0]), ORIGIN[0], None, model)
    names = [*(x.text("name") for x in model.all("link")), *([_WORLD] if _WORLD in links else [])]
    order = from_the_base(names, ends, model)
    joints = [_joint(elements[i], *ends[i], frames) for i in order]
    gravity, said = _gravity(world)
    found = parameters(bodies_of(links, joints), gravity, root)
    found.name = model.attributes.get("name", "")
    found.notes += said
    found.notes += [
        f"{element.text('name')} has no <inertial>; its mass is set to 1 kg and its moments of "
        "inertia to 1 kg m^2, the defaults of SDFormat"
        for element in model.all("link")
        if element.first("inertial") is None
    ]
    return found


def _model(root: Element, world: Element | None) -> Element:
    candidates: list[Element] = [
        model
        for model in (*root.all("model"), *(world.all("model") if world else ()))
        if model.first("joint") is not None and not _is_true(model.first("static"))
    ]
    if len(candidates) != 1:
        names = ", ".join(x.attributes.get("name", "") for x in candidates)
        said = f"{len(candidates)} models with joints ({names:.80})" if candidates else "no model"
        raise root.error(f"found {said}, expected exactly one non-static <model> with joints")
    return candidates[0]


def _version(root: Element) -> tuple[int, ...]:
    words = root.attributes.get("version", "").split(".")
    return tuple(int(word) if word.isdecimal() else 0 for word in words)


def _is_true(element: Element | None) -> bool:
    return element is not None and element.content.strip() in ("true", "1")


class _Frames:
    """Poses of the named frames of a model, relative to the world."""

    def __init__(self, model: Element, version: tuple[int, ...]) -> None:
        self.model = model
        self.version = version
        self.elements = {
            element.text("name"): element
            for tag in ("frame", "joint", "link")
            for element in model.all(tag)
        }
        self.found: dict[str, Pose] = {_WORLD: ORIGIN, _MODEL: _pose(model)}
        self.open: set[str] = set()

    def of(self, name: str, asked_by: Element | None = None) -> Pose:
        """Return the pose of a frame; an error is located at `asked_by`, or else at the model."""
        if name not in self.found:
            element = self.elements.get(name)
            if element is None or name in self.open:
                raise (asked_by or self.model).error(
                    f"found frame {name!r:.40}, expected a link, joint or frame of this model that "
                    "does not depend on itself"
                )
            self.open.add(name)
            self.found[name] = self._resolved(element)
            self.open.discard(name)
        return self.found[name]

    def _resolved(self, element: Element) -> Pose:
        pose = element.first("pose")
        attached = {
            "link": _MODEL,
            "frame": element.attributes.get("attached_to", "") or _MODEL,
            "joint": _end(element, "child") if element.tag == "joint" else "",
        }
        named = pose.attributes.get("relative_to", "") if pose is not None else ""
        return composed(self.of(named or attached[element.tag], pose or element), _pose(element))

    def direction(self, xyz: Element, joint: Element) -> Matrix:
        """Return the unit vector of a joint's axis in the world."""
        named = xyz.attributes.get("expressed_in", "")
        of_model = self.version < _AXES_OF_MODEL or _is_true(
            joint.first("axis", "use_parent_model_frame")
        )
        name = named or (_MODEL if of_model else joint.text("name"))
        _, axes = self.of(name, xyz)
        return axes * unit(vector(xyz.values(3)), xyz)


def _pose(element: Element) -> Pose:
    """Return the <pose> of an element."""
    pose = element.first("pose")
    if pose is None or not pose.content.strip():
        return ORIGIN
    if pose.attributes.get("rotation_format", "euler_rpy") == "quat_xyzw":
        *place, qx, qy, qz, qw = pose.values(7)
        return vector(place), rotation(qw, qx, qy, qz)
    *place, roll, pitch, yaw = pose.values(6)
    unit_of = MP.pi / 180 if pose.attributes.get("degrees") == "true" else MP.one
    x, y, z = turns([a * unit_of for a in (roll, pitch, yaw)])
    return vector(place), z * y * x


def _mass(link: Element, pose: Pose) -> Mass:
    inertial = link.first("inertial")
    if inertial is None:
        return Mass(MP.one, pose[0], MP.eye(3))
    own = composed(pose, _pose(inertial))
    given = inertial.first("mass")
    matrix = inertial.first("inertia")
    diagonal, products = (
        [_value(matrix, f"i{ij}", default) for ij in elements]
        for elements, default in ((("xx", "yy", "zz"), MP.one), (("xy", "xz", "yz"), MP.zero))
    )
    mass = given.values(1)[0] if given is not None else MP.one
    return Mass.at(own, mass, tensor(*diagonal, *products))


def _value(element: Element | None, tag: str, default: Any) -> Any:
    found = element.first(tag) if element is not None else None
    return default if found is None else found.values(1)[0]


def _radii(shape: Element) -> Iterator[Any]:
    for kind in ("cylinder", "sphere"):
        if (found := shape.first("geometry", kind, "radius")) is not None:
            yield found.values(1)[0]
    if (found := shape.first("geometry", "ellipsoid", "radii")) is not None:
        yield max(found.values(3))


def _end(joint: Element, which: str) -> str:
    element = joint.needed(which)
    frame = element.first("link_name") or element
    return frame.content.strip()


def _ends(joint: Element, links: dict[str, Link]) -> tuple[str, str]:
    names = _end(joint, "parent"), _end(joint, "child")
    for which, name in zip(("parent", "child"), names, strict=True):
        if name not in links and not (which == "parent" and name == _WORLD):
            raise joint.needed(which).error(
                f"found link {name!r:.40}, expected the name of a link of this model"
            )
    return names


def _joint(joint: Element, parent: str, child: str, frames: _Frames) -> Joint:
    kind = joint.text("type")
    point, _ = frames.of(joint.text("name"))
    if kind == "fixed":
        return Joint("fixed", parent, child, point, point)
    if kind not in _HINGES:
        raise joint.error(
            f"found a joint of type {kind!r:.40}, expected {', '.join(_HINGES)} or fixed"
        )
    axis = frames.direction(joint.needed("axis", "xyz"), joint)
    return Joint("hinge", parent, child, point, axis)


def _gravity(world: Element | None) -> tuple[Any, list[str]]:
    if world is None:
        said = f"g is set to {_GRAVITY_OF_MODEL} m/s^2, because the file has no world"
        return MP.mpf(_GRAVITY_OF_MODEL), [said]
    element = world.first("gravity") or world.first("physics", "gravity")
    if element is None:
        said = (
            f"g is set to {_GRAVITY} m/s^2, the default of SDFormat, because the world has no "
            "<gravity>"
        )
        return MP.mpf(_GRAVITY), [said]
    return downward(element.values(3), element), []
