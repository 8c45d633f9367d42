"""Primitive shapes that show the frame, fork, rider and wheels of a model; for viewing only.

Every format for engines has spheres and cylinders, so the drawing of the bicycle consists of these
two. Places are in a model's axes: x forward, y to the left, z up.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from math import cos, hypot, pi, sin

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.bicycle.shapes import Point, Solid, shape

_LINKS = {"rear": "B", "front": "H"}
_SEGMENTS = 24  # number of straight cylinders that form a tyre
_TYRE = 0.017
"""Radius of a tyre's cross-section [m], reduced to an eighth of the wheel's radius if that is less.
The other dimensions of the wheel are reduced by the same factor."""
_SPOKES = 6  # number of spokes, each from rim to rim
_SPOKE, _MARK, _HUB = 0.0025, 0.011, 0.022  # radii of a spoke, of a mark on it, and of the hub [m]
# Angle of the first spoke [rad]. The coloured marks on this spoke show how the wheel turns.
_MARK_ANGLE = 0.17
_MARK_SPAN = (0.55, 0.8)  # distances of the ends of a mark from the hub, in wheel radii


@dataclass(frozen=True, slots=True)
class Primitive:
    """A cylinder, or a sphere if both ends are one point.

    Attributes
    ----------
    link
        Name of the link that carries it.
    colour
        A key of `shapes.COLOURS`.
    ends
        Centres of the end faces, relative to the origin of the link [m].
    radius
        Radius [m].
    """

    link: str
    colour: str
    ends: tuple[Point, Point]
    radius: float

    @property
    def is_sphere(self) -> bool:
        """True if both ends are one point."""
        return self.ends[0] == self.ends[1]

    @property
    def middle(self) -> Point:
        """Centre of the primitive [m]."""
        x, y, z = ((a + b) / 2 for a, b in zip(*self.ends, strict=True))
        return x, y, z

    @property
    def along(self) -> Point:
        """Vector from the first end of the primitive to the second [m]."""
        x, y, z = (b - a for a, b in zip(*self.ends, strict=True))
        return x, y, z

    @property
    def length(self) -> float:
        """Distance between the two ends of the primitive [m]."""
        return hypot(*self.along)


def primitives(bicycle: Bicycle, places: Mapping[str, Point]) -> Iterator[Primitive]:
    """Yield the primitives of a bicycle; `places` are the origins of its links [m]."""
    drawn = shape(bicycle)
    for solid in drawn.solids:
        link = _LINKS[solid.body]
        yield from _solid(solid, link, places[link])
    for link, radius in zip("RF", drawn.radii, strict=True):
        yield from _wheel(link, radius)


def _solid(solid: Solid, link: str, origin: Point) -> Iterator[Primitive]:
    """Yield the spheres of a solid, and a cylinder between each pair of spheres.

    A tube of the bicycle (two spheres) is drawn without them, as a cylinder.
    """
    balls = [((x - origin[0], -y - origin[1], -z - origin[2]), r) for x, y, z, r in solid.spheres]
    for (a, r_a), (b, r_b) in combinations(balls, 2):
        yield Primitive(link, solid.colour, (a, b), (r_a + r_b) / 2)
    if solid.part != "bicycle" or len(balls) > 2:
        for centre, r in balls:
            yield Primitive(link, solid.colour, (centre, centre), r)


def _wheel(link: str, radius: float) -> Iterator[Primitive]:
    """Yield tyre, spokes, marks and hub of a wheel that turns about the y axis at the origin."""
    tyre = min(_TYRE, radius / 8)
    scale = tyre / _TYRE
    # The tyre is drawn as a polygon. Its corners lie as far outside of the tyre's centre line as
    # the middles of its sides lie inside.
    rim = (radius - tyre) * 2 / (1 + cos(pi / _SEGMENTS))

    def at(angle: float, distance: float) -> Point:
        return distance * cos(angle), 0.0, distance * sin(angle)

    for n in range(_SEGMENTS):
        angles = (2 * pi * n / _SEGMENTS, 2 * pi * (n + 1) / _SEGMENTS)
        yield Primitive(link, "tyre", (at(angles[0], rim), at(angles[1], rim)), tyre)
    for n in range(_SPOKES):
        angle = _MARK_ANGLE + pi * n / _SPOKES
        ends = (at(angle, rim), at(angle + pi, rim))
        yield Primitive(link, "metal", ends, _SPOKE * scale)
    for angle in (_MARK_ANGLE, _MARK_ANGLE + pi):
        inner, outer = (at(angle, part * radius) for part in _MARK_SPAN)
        yield Primitive(link, "shirt", (inner, outer), _MARK * scale)
    side = 0.03 * scale
    yield Primitive(link, "metal", ((0.0, -side, 0.0), (0.0, side, 0.0)), _HUB * scale)
