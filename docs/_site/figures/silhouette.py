"""Bicycle and rider as flat outlines, seen from far away in any direction.

What they look like is in `shapes`; wheels, steer axis and hubs are to scale.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.bicycle.shapes import Shape, shape
from heyoka_bike.numbers.double import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Rows: to the right and up on the page, and towards the eye, in x forward, y right, z down.
FROM_RIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
FROM_BEHIND = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
FROM_ABOVE = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])

TYRE = 0.014
"""Half the width of a tyre [m]."""

# Drawings are laid out for the size of the benchmark bicycle with its rider [m].
_LENGTH, _AHEAD, _HEIGHT = 1.67, 1.37, 1.76
_CIRCLE = np.array([(np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 17)[:-1]])
_RIM = np.linspace(0, 2 * np.pi, 73)[:-1]
_EDGE = 0.5  # [pt]


def fitted(bicycle: Bicycle) -> tuple[Shape, float]:
    """What a bicycle looks like, scaled to the size of the benchmark's, and the scale."""
    drawn = shape(bicycle)
    height = max(r - z for solid in drawn.solids for *_, z, r in solid.spheres)
    ahead = float(bicycle["w"]) + drawn.radii[1]
    length = ahead + drawn.radii[0]
    scale = 1 / max(length / _LENGTH, ahead / _AHEAD, height / _HEIGHT)

    def scaled(numbers: Sequence[float]) -> Any:
        return tuple(scale * x for x in numbers)

    solids = tuple(
        replace(solid, spheres=tuple(map(scaled, solid.spheres))) for solid in drawn.solids
    )
    points = {name: scaled(point) for name, point in drawn.points.items()}
    return replace(drawn, points=points, radii=scaled(drawn.radii), solids=solids), scale


@dataclass(frozen=True, eq=False, slots=True)
class Pose:
    """How a bicycle stands: frame leaned and turned about the rear contact point, fork steered.

    Attributes
    ----------
    roll, steer, yaw
        [rad], right positive. The pitch is left at zero: this is for drawing.
    """

    roll: float = 0.0
    steer: float = 0.0
    yaw: float = 0.0

    def place(self, drawn: Shape, points: Array, body: str) -> Array:
        """Points of a body of the upright bicycle, shape (n, 3), as they stand."""
        if body == "front":
            foot = np.array(drawn.points["foot"])
            up = np.array(drawn.points["top"]) - foot
            axis = -up / np.linalg.norm(up)
            points = foot + (points - foot) @ _turn(axis, self.steer).T
        attitude = _turn(np.array([0.0, 0.0, 1.0]), self.yaw) @ _turn(
            np.array([1.0, 0.0, 0.0]), self.roll
        )
        found: Array = points @ attitude.T
        return found


def draw(
    ax: Axes, drawn: Shape, view: Array, pose: Pose, colours: Mapping[str, tuple[str, str]],
    parts: Sequence[str] = ("bicycle", "rider", "head"),
) -> None:  # fmt: skip
    """Draw bicycle and rider, farther solids first.

    Parameters
    ----------
    ax : Axes
        Of equal aspect, in metres.
    drawn : Shape
    view : ndarray, shape (3, 3)
        Such as `FROM_RIGHT`.
    pose : Pose
    colours
        Of fill and edge, for ``rear``, ``front``, ``rider`` and ``wheel``.
    parts
        Of solids that are drawn.
    """
    from matplotlib.collections import PolyCollection

    items = []
    for solid in drawn.solids:
        if solid.part not in parts:
            continue
        spheres = np.array(solid.spheres)
        seen = pose.place(drawn, spheres[:, :3], solid.body) @ view.T
        rims = seen[:, None, :2] + spheres[:, 3, None, None] * _CIRCLE
        kind = solid.body if solid.part == "bicycle" else "rider"
        items.append((float(seen[:, 2].mean()), hull(rims.reshape(-1, 2)), colours[kind]))
    items.sort(key=lambda item: item[0])
    for body, radius in zip(("rear", "front"), drawn.radii, strict=True):
        _draw_wheel(ax, rim(drawn, view, pose, body, radius), colours["wheel"])
    ax.add_collection(
        PolyCollection(
            [corners for _, corners, _ in items],
            facecolors=[fill for *_, (fill, _) in items],
            edgecolors=[edge for *_, (_, edge) in items],
            linewidths=_EDGE,
        )
    )


def rim(drawn: Shape, view: Array, pose: Pose, body: str, radius: float) -> Array:
    """The middle of a wheel's tyre on the page, shape (n, 2)."""
    hub = np.array(drawn.points["P1" if body == "rear" else "P3"])
    around = np.stack([np.cos(_RIM), 0 * _RIM, np.sin(_RIM)], axis=1)
    points = hub + (radius - TYRE) * around
    found: Array = (pose.place(drawn, points, body) @ view.T)[:, :2]
    return found


def _draw_wheel(ax: Axes, middle: Array, colours: tuple[str, str]) -> None:
    from matplotlib.patches import PathPatch, Polygon
    from matplotlib.path import Path

    fill, edge = colours
    centre = middle.mean(axis=0)
    outward = middle - centre
    size = np.linalg.norm(outward, axis=1, keepdims=True)
    look = {"facecolor": fill, "edgecolor": edge, "linewidth": _EDGE}
    if size.min() < 2 * TYRE:
        # Seen edge-on there is no hole.
        rounds = middle[:, None] + TYRE * _CIRCLE
        ax.add_patch(Polygon(hull(rounds.reshape(-1, 2)), closed=True, **look))
        return
    outer, inner = (centre + outward * (1 + s * TYRE / size) for s in (1, -1))
    # The inner ring runs the other way round, which makes it a hole.
    rings = (np.concatenate((ring, ring[:1])) for ring in (outer, inner[::-1]))
    path = Path.make_compound_path(*(Path(ring, closed=True) for ring in rings))
    ax.add_patch(PathPatch(path, **look))


def _turn(axis: Array, angle: float) -> Array:
    """Matrix of a turn about a unit vector, Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    found: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return found


def hull(points: Array) -> Array:
    """Convex hull of points of shape (n, 2), Andrew's monotone chain."""
    ordered = sorted(map(tuple, points.tolist()))
    chain: list[tuple[float, ...]] = []
    for part in (ordered, ordered[::-1]):
        start = len(chain)
        for p in part:
            while len(chain) - start > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (p[1] - ay) > (by - ay) * (p[0] - ax):
                    break
                chain.pop()
            chain.append(p)
        chain.pop()
    return np.array(chain)
