"""Links and joints of a model at zero angles, and the bodies that they make."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from heyoka_bike.bicycle.foreign.bodies import Body, Mass, Matrix
from heyoka_bike.bicycle.foreign.xml_source import Element

_MAX_LINKS = 200


@dataclass
class Link:
    """A link with its mass and its place, along the axes of the model.

    Attributes
    ----------
    mass : Mass
    place
        Of its origin.
    radius
        Of its round shape; None without one.
    element : Element
        Where it stands in the file.
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
        Links by their names.
    point, axis
        Of a hinge, along the axes of the model; the axis is a unit vector.
    """

    kind: Literal["hinge", "fixed", "free"]
    parent: str
    child: str
    point: Matrix
    axis: Matrix


def from_the_base(
    names: Iterable[str], ends: Sequence[tuple[str, str]], root: Element
) -> list[int]:
    """Positions of the joints in an order in which each parent comes before its children.

    Parameters
    ----------
    names
        Of all links.
    ends
        Parent and child of each joint.

    Raises
    ------
    InputError
        The links are too many, or no single tree.
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
            "found no single tree of links, expected links of different names: one base, and one "
            "joint for each other link"
        )
    return order


def bodies_of(links: Mapping[str, Link], joints: Sequence[Joint]) -> list[Body]:
    """The bodies that move; links that are fixed to one another are one body.

    Parameters
    ----------
    links
        By their names; the base is the one that no joint carries.
    joints
        Each after those that carry its parent, see `from_the_base`.

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
                raise link.element.error(f"found a second base {name}, expected one bicycle")
            bodies = {name: _body(name, link, "", link.place, link.place)}
        else:
            within[name] = carrier
            body = bodies[carrier]
            body.mass = body.mass.joined(link.mass)
            body.radius = link.radius if body.radius is None else body.radius
    return list(bodies.values())


def _body(name: str, link: Link, parent: str, point: Matrix, axis: Matrix) -> Body:
    return Body(name, link.mass, parent, point, axis, link.radius, link.element)
