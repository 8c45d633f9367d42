"""Links and joints of a model at zero angles, and the moving bodies that they form."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from heyoka_bike.bicycle.foreign.bodies import Body, Mass, Matrix
from heyoka_bike.bicycle.foreign.xml_source import Element

_MAX_LINKS = 200


@dataclass
class Link:
    """A link with its mass and position, along the axes of the model.

    Attributes
    ----------
    mass : Mass
    place
        Position of the origin of the link.
    radius
        Radius of a round shape; None without such a shape.
    element : Element
        The element of the file that defines the link.
    """

    mass: Mass
    place: Matrix
    radius: Any
    element: Element


@dataclass
class Joint:
    """A joint that carries a link.

    Attributes
    ----------
    kind
        ``hinge``, ``fixed`` or ``free``.
    parent, child
        Names of the two links.
    point, axis
        Point and direction (a unit vector) of a hinge, along the axes of the model.
    """

    kind: Literal["hinge", "fixed", "free"]
    parent: str
    child: str
    point: Matrix
    axis: Matrix


def from_the_base(
    names: Iterable[str], ends: Sequence[tuple[str, str]], root: Element
) -> list[int]:
    """Return the indices of the joints, ordered so that parents come before their children.

    Parameters
    ----------
    names
        Names of all links.
    ends
        Parent and child of each joint.

    Raises
    ------
    InputError
        There are too many links, or they do not form a single tree.
    """
    known = list(names)
    if len(known) > _MAX_LINKS:
        raise root.error(f"found {len(known)} links, expected at most {_MAX_LINKS}")
    reached = set(known) - {child for _, child in ends}
    order: list[int] = []
    rest = list(range(len(ends)))
    if len(reached) == 1 and len(set(known)) == len(known) == len(ends) + 1:
        while ready := [i for i in rest if ends[i][0] in reached]:
            order += ready
            reached |= {ends[i][1] for i in ready}
            rest = [i for i in rest if i not in ready]
    if len(order) < len(ends) or len(reached) != len(known) or not known:
        raise root.error(
            "found links that do not form a single tree, expected different names, one root link, "
            "and one joint for each other link"
        )
    return order


def bodies_of(links: Mapping[str, Link], joints: Sequence[Joint]) -> list[Body]:
    """Return the moving bodies; links that are fixed to one another form one body.

    Parameters
    ----------
    links
        Links by name; the base is the link that is no child of a joint.
    joints
        Joints in the order of `from_the_base`.

    Raises
    ------
    InputError
        There is a second base.
    """
    (top,) = set(links) - {joint.child for joint in joints}
    bodies = {top: _body(top, links[top], "", links[top].place, links[top].place)}
    within = {top: top}
    for joint in joints:
        name, link = joint.child, links[joint.child]
        carrier = within[joint.parent]
        within[name] = name
        if joint.kind == "hinge":
            bodies[name] = _body(name, link, carrier, joint.point, joint.axis)
        elif joint.kind == "free":
            if any(body.mass.mass for body in bodies.values()):
                raise link.element.error(
                    f"found a second root link {name}, expected a file that describes one bicycle"
                )
            bodies = {name: _body(name, link, "", link.place, link.place)}
        else:
            within[name] = carrier
            body = bodies[carrier]
            body.mass = body.mass.joined(link.mass)
            body.radius = link.radius if body.radius is None else body.radius
    return list(bodies.values())


def _body(name: str, link: Link, parent: str, point: Matrix, axis: Matrix) -> Body:
    return Body(name, link.mass, parent, point, axis, link.radius, link.element)


def radius_of(link: Element, radii_of: Callable[[Element], Iterable[Any]]) -> Any:
    """Return the radius of a wheel: the largest of its collision shapes, or else visual shapes.

    Parameters
    ----------
    link
        A link of URDF or SDFormat.
    radii_of
        Function from a shape to its radii; empty if the shape is not round.

    Returns
    -------
    mpf or None
        None if the link has no round shape.
    """
    for what in ("collision", "visual"):
        radii = [radius for shape in link.all(what) for radius in radii_of(shape)]
        if radii:
            return max(radii)
    return None
