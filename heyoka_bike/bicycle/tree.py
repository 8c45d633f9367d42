"""The bicycle as engines have it: a tree of four links and three hinges, in axes with z up.

x forward, y to the left, z up: the axes of the parameters after half a turn about x. All frames are
parallel to those of the ground when the bicycle is upright and straight, and the origin is where
the rear wheel touches the floor then. The steer axis points down, so right is positive.
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
    """A body.

    Attributes
    ----------
    name
        Its letter in the parameters.
    place
        Of its origin from that of the ground [m], upright and straight.
    mass, centre
        Mass [kg], and its centre from the origin of the link [m].
    inertia
        Elements of the inertia matrix about the centre [kg m^2], in the order of `INERTIA`.
    radius
        Of a wheel [m]; None for a frame.
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
        Links by their names.
    axis
        Unit vector.
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
        """The hinge that holds a link; None for the base."""
        return next((h for h in self.hinges if h.child == child), None)

    def children(self, parent: str) -> Iterator[Link]:
        """The links that a link holds."""
        return (self.links[h.child] for h in self.hinges if h.parent == parent)

    def offset(self, link: Link) -> Vector:
        """Origin of a link from that of its parent, or from the ground."""
        hinge = self.hinge_of(link.name)
        return minus(link.place, self.links[hinge.parent].place) if hinge else link.place


def tree_of(bicycle: Bicycle, a: Arithmetic) -> Tree:
    """The tree of a bicycle in the number type of `a`.

    The origin of B is that of the ground, those of the wheels are their centres. That of H is the
    point of the steer axis nearest to the rear hub.
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
        # A wheel is as its diametral inertia says.
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
