"""The bicycle as physics engines describe it: a tree of four links and three hinges, z up.

The axes are x forward, y to the left, z up: the parameters' axes, rotated by half a turn about x.
If the bicycle is upright and straight, all frames are parallel to the ground frame, and its origin
is the rear contact point. The steer axis points down, so right is positive.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Arithmetic, Number
from heyoka_bike.numbers.vectors import Vector, minus

INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
"""Order of the elements of an inertia matrix, as in MJCF."""


@dataclass(frozen=True, slots=True)
class Link:
    """A body of the tree.

    Attributes
    ----------
    name
        The letter of the body in the parameters.
    place
        Origin of the link relative to that of the ground [m], upright and straight.
    mass, centre
        Mass [kg], and centre of mass relative to the origin of the link [m].
    inertia
        Elements of the inertia matrix about the centre [kg m^2], in the order of `INERTIA`.
    radius
        Radius of a wheel [m]; None for a frame.
    """

    name: str
    place: Vector
    mass: Number
    centre: Vector
    inertia: tuple[Number, ...]
    radius: Number | None = None


@dataclass(frozen=True, slots=True)
class Hinge:
    """A joint with one angle, at the origin of its child.

    Attributes
    ----------
    name
    parent, child
        Names of the two links.
    axis
        Direction of the hinge, a unit vector.
    """

    name: str
    parent: str
    child: str
    axis: Vector


@dataclass(frozen=True, slots=True)
class Tree:
    """Links by their names, the base first; hinges in the order of their children."""

    links: Mapping[str, Link]
    hinges: tuple[Hinge, ...]

    def hinge_of(self, child: str) -> Hinge | None:
        """Return the hinge that connects a link to its parent; None for the base."""
        return next((h for h in self.hinges if h.child == child), None)

    def children(self, parent: str) -> Iterator[Link]:
        """Yield the links whose parent is this link."""
        return (self.links[h.child] for h in self.hinges if h.parent == parent)

    def offset(self, link: Link) -> Vector:
        """Return the origin of a link relative to that of its parent, or of the ground."""
        hinge = self.hinge_of(link.name)
        return minus(link.place, self.links[hinge.parent].place) if hinge else link.place


def tree_of(bicycle: Bicycle, a: Arithmetic) -> Tree:
    """Construct the tree of a bicycle in the number type of `a`.

    The origin of B is that of the ground, and the origins of the wheels are their centres. The
    origin of H is the point of the steer axis nearest to the rear hub.
    """
    p: Mapping[str, Number] = {symbol: a.number(value) for symbol, value in bicycle.values.items()}
    zero, one = a.number(0), a.number(1)
    sine, cosine = a.sin(p["lam"]), a.cos(p["lam"])
    to_axis = (p["w"] + p["c"]) * cosine - p["rR"] * sine
    places = {
        "B": (zero, zero, zero),
        "R": (zero, zero, p["rR"]),
        "H": (to_axis * cosine, zero, p["rR"] + to_axis * sine),
        "F": (p["w"], zero, p["rF"]),
    }
    centres = {
        **places,
        "B": (p["xB"], zero, -p["zB"]),
        "H": (p["xH"], zero, -p["zH"]),
    }
    links = {}
    for body, place in places.items():
        xx, yy = p[f"I{body}xx"], p[f"I{body}yy"]
        # A wheel has no Izz, because its inertia about z equals Ixx: both axes are diameters.
        zz, xz = p.get(f"I{body}zz", xx), p.get(f"I{body}xz", zero)
        links[body] = Link(
            body, place, p[f"m{body}"], minus(centres[body], place),
            (xx, yy, zz, zero, -xz, zero), p.get(f"r{body}"),
        )  # fmt: skip
    axle = (zero, one, zero)
    return Tree(
        links,
        (
            Hinge("rear_axle", "B", "R", axle),
            Hinge("steer_axis", "B", "H", (sine, zero, -cosine)),
            Hinge("front_axle", "H", "F", axle),
        ),
    )
