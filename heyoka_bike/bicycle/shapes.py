"""Shapes of bicycle and rider: solids of spheres, fixed in frame or fork.

The four bodies of the model have no shape. The parameters determine the wheels, the steer axis, the
hubs and the centre of mass B; frame, fork and rider are drawn around them. As in the benchmark, the
rider is rigid with the frame and does not hold the handlebar. Bicycles measured without a rider
have none.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import cos, sin

import numpy as np

from heyoka_bike.bicycle.parameters import Bicycle

# Distance, along the steer axis, from the floor to the benchmark's point P2 [m]. This value
# reproduces the digits that the benchmark prints.
_P2 = 0.9
# The wheels and the rider are drawn for a bicycle with this sum of the wheel radii, and this height
# of the point B [m]. Other bicycles scale the drawing.
_DRAWN_WHEELS, _DRAWN_B = 0.65, 0.9
_DRAWN_X = 0.3  # distance of B ahead of the rear hub in the drawing [m]
_SCALES = (0.8, 2.0)
_RIDER = 40.0
"""Mass from which a rear frame includes a rider [kg]; frames without a rider have 3 to 23 kg."""

COLOURS = {
    "frame": "#d55e00", "metal": "#8d969f", "dark": "#3a4048", "tyre": "#24282d",
    "skin": "#d9a982", "shirt": "#e69f00", "shorts": "#4a5663", "helmet": "#f4f5f6",
    "floor": "#d8dadb",
}  # fmt: skip
"""Colours of the solids, the tyres and the floor on a light page."""

Point = tuple[float, float, float]
_To = Callable[[float, float, float], Point]


@dataclass(frozen=True, slots=True)
class Solid:
    """The convex hull of spheres.

    Attributes
    ----------
    body
        Body whose attitude the solid has: ``rear`` (frame and rider) or ``front`` (fork).
    part
        ``bicycle``, ``rider`` or ``head``.
    colour
        A key of `COLOURS`.
    spheres : tuple of (x, y, z, radius)
        Spheres in the upright bicycle: x forward, y right, z down, origin at the rear contact point
        [m].
    """

    body: str
    part: str
    colour: str
    spheres: tuple[tuple[float, float, float, float], ...]


@dataclass(frozen=True, slots=True)
class Shape:
    """A bicycle to draw; points of the upright bicycle as in `Solid`.

    Attributes
    ----------
    points : dict of str to Point
        P1, P2, P3, B, `foot` (where the steer axis meets the floor), `top` (end of the steer axis),
        and `eye` of the rider.
    radii : (rear, front)
        Radii of the wheels [m].
    tilt
        Tilt of the steer axis [rad].
    solids : tuple of Solid
    """

    points: dict[str, Point]
    radii: tuple[float, float]
    tilt: float
    solids: tuple[Solid, ...]


def shape(bicycle: Bicycle) -> Shape:
    """Return solids and points of a bicycle."""
    p = {symbol: float(value) for symbol, value in bicycle.values.items()}
    s, c = sin(p["lam"]), cos(p["lam"])
    is_ridden = p["mB"] >= _RIDER
    size = -p["zB"] / _DRAWN_B if is_ridden else (p["rR"] + p["rF"]) / _DRAWN_WHEELS
    scale = min(max(size, _SCALES[0]), _SCALES[1])
    shift = p["xB"] if is_ridden else _DRAWN_X

    def fork(ahead: float, y: float, up: float) -> Point:
        """Return the point at distances ahead of the steer axis, to the right, and up the axis."""
        return p["w"] + p["c"] - up * s + ahead * c, y, -up * c - ahead * s

    def rider(x: float, y: float, z: float) -> Point:
        """Return a point of the benchmark's rider or saddle, scaled and moved to this bicycle."""
        return shift + (x - _DRAWN_X) * scale, y * scale, z * scale

    crown = p["c"] * s + p["rF"] * c + p["rF"] + 0.03
    head = max(_P2, crown + 0.12)
    hubs = (0.0, 0.0, -p["rR"]), (p["w"], 0.0, -p["rF"])
    crank = (0.42 * p["w"], 0.0, -0.29 * scale)
    return Shape(
        points={
            "P1": hubs[0], "P2": fork(0.0, 0.0, _P2), "P3": hubs[1],
            "B": (p["xB"], 0.0, p["zB"]), "foot": fork(0.0, 0.0, 0.0),
            "top": fork(0.0, 0.0, head + 0.3), "eye": rider(0.43, 0.0, -1.66),
        },
        radii=(p["rR"], p["rF"]),
        tilt=p["lam"],
        solids=(
            *_frame(hubs[0], crank, (fork(0, 0, crown + 0.04), fork(0, 0, head - 0.03)), rider),
            *_fork(hubs[1], crown, head, fork),
            *(_rider(crank, scale, rider) if is_ridden else ()),
        ),
    )  # fmt: skip


def _tube(
    body: str, colour: str, a: Point, b: Point, r: float, r_b: float | None = None,
    part: str = "bicycle",
) -> Solid:  # fmt: skip
    return Solid(body, part, colour, ((*a, r), (*b, r if r_b is None else r_b)))


def _sides(p: Point, y: float) -> tuple[Point, Point]:
    """Return the points at this distance to the left and the right of a point in the middle."""
    return (p[0], -y, p[2]), (p[0], y, p[2])


def _frame(hub: Point, crank: Point, head: tuple[Point, Point], to: _To) -> Iterator[Solid]:
    low, high = head
    post, saddle = to(0.215, 0.0, -0.80), to(0.18, 0.0, -0.895)
    for a, b, r in (
        (crank, post, 0.016), (post, saddle, 0.013), (crank, low, 0.019), (post, high, 0.016),
    ):  # fmt: skip
        yield _tube("rear", "frame", a, b, r)
    yield _tube("rear", "frame", low, high, 0.022)
    for one, other, cranked in zip(_sides(hub, 0.06), _sides(post, 0.03), (-1, 1), strict=True):
        yield _tube("rear", "frame", one, (crank[0], 0.04 * cranked, crank[2]), 0.010)
        yield _tube("rear", "frame", one, other, 0.009)
        pedal = (crank[0] + 0.17 * cranked, 0.08 * cranked, crank[2])
        yield _tube("rear", "metal", (crank[0], 0.08 * cranked, crank[2]), pedal, 0.010)
        yield _tube("rear", "metal", pedal, (pedal[0], 0.17 * cranked, pedal[2]), 0.014)
    yield _tube("rear", "metal", *_sides(crank, 0.08), 0.018)
    yield _tube("rear", "metal", *_sides(hub, 0.07), 0.016)
    wide = [(*to(0.07, y, -0.905), 0.028) for y in (-0.06, 0.06)]
    yield Solid("rear", "bicycle", "dark", (*wide, (*to(0.31, 0.0, -0.905), 0.018)))


def _fork(hub: Point, crown: float, head: float, to: _To) -> Iterator[Solid]:
    grip = to(-0.10, 0.28, head + 0.10)
    for side in (-1, 1):
        blade = to(0.0, 0.05 * side, crown)
        yield _tube("front", "frame", (hub[0], 0.06 * side, hub[2]), blade, 0.009, 0.014)
        bend = to(0.07, 0.10 * side, head + 0.08)
        end = (grip[0], grip[1] * side, grip[2])
        yield _tube("front", "metal", to(0.05, 0.0, head + 0.06), bend, 0.012)
        yield _tube("front", "metal", bend, end, 0.012)
        middle = tuple((a + 1.6 * b) / 2.6 for a, b in zip(bend, end, strict=True))
        yield _tube("front", "dark", (middle[0], middle[1], middle[2]), end, 0.018)
    yield _tube("front", "frame", to(0, -0.05, crown), to(0, 0.05, crown), 0.017)
    yield _tube("front", "metal", to(0, 0, head), to(0, 0, head + 0.06), 0.016)
    yield _tube("front", "metal", to(0, 0, head + 0.06), to(0.05, 0, head + 0.06), 0.015)
    yield _tube("front", "metal", *_sides(hub, 0.07), 0.015)


def _rider(crank: Point, scale: float, to: _To) -> Iterator[Solid]:
    def limb(colour: str, a: Point, b: Point, r: float, r_b: float) -> Solid:
        return _tube("rear", colour, a, b, r * scale, r_b * scale, "rider")

    def hull(part: str, colour: str, *spheres: tuple[float, float, float, float]) -> Solid:
        scaled = tuple((*to(x, y, z), r * scale) for x, y, z, r in spheres)
        return Solid("rear", part, colour, scaled)

    for side in (-1, 1):
        hip, pedal = to(0.17, 0.085 * side, -0.985), crank[0] + 0.17 * side
        ankle = (pedal - 0.07 * scale, 0.115 * side, crank[2] - 0.09 * scale)
        knee = _joint(hip, ankle, 0.43 * scale, 0.42 * scale)
        yield limb("shorts", hip, knee, 0.085, 0.058)
        yield limb("skin", knee, ankle, 0.055, 0.036)
        heel = (ankle[0] - 0.03 * scale, ankle[1], ankle[2] + 0.045 * scale)
        toe = (pedal + 0.08 * scale, ankle[1], crank[2] - 0.035 * scale)
        yield limb("dark", heel, toe, 0.036, 0.028)
        shoulder, sleeve = to(0.285, 0.185 * side, -1.42), to(0.268, 0.225 * side, -1.28)
        elbow, hand = to(0.25, 0.265 * side, -1.15), to(0.42, 0.175 * side, -1.06)
        yield limb("skin", sleeve, elbow, 0.042, 0.040)
        yield limb("shirt", shoulder, sleeve, 0.060, 0.054)
        yield limb("skin", elbow, hand, 0.040, 0.030)
        yield limb("skin", hand, to(0.49, 0.15 * side, -1.035), 0.036, 0.026)
    yield hull(
        "rider", "shorts",
        *((0.165, y, -0.995, 0.10) for y in (-0.065, 0.065)),
        *((0.19, y, -1.07, 0.095) for y in (-0.05, 0.05)),
    )  # fmt: skip
    yield hull(
        "rider", "shirt",
        *((0.185, y, -1.08, 0.10) for y in (-0.055, 0.055)),
        *((0.255, y, -1.30, 0.105) for y in (-0.075, 0.075)),
        *((0.285, y, -1.42, 0.062) for y in (-0.15, 0.15)),
        (0.285, 0.0, -1.455, 0.065),
    )  # fmt: skip
    yield hull("head", "skin", (0.29, 0.0, -1.46, 0.058), (0.325, 0.0, -1.53, 0.052))
    yield hull("head", "skin", (0.355, 0.0, -1.630, 0.088), (0.375, 0.0, -1.580, 0.062))
    yield hull("head", "skin", (0.442, 0.0, -1.600, 0.018), (0.44, 0.0, -1.625, 0.012))
    yield hull(
        "head", "helmet",
        (0.34, 0.0, -1.660, 0.100), (0.29, 0.0, -1.645, 0.085), (0.41, 0.0, -1.680, 0.062),
    )  # fmt: skip


def _joint(hip: Point, ankle: Point, thigh: float, shank: float) -> Point:
    """Return the position of the knee, which is ahead of the line between hip and ankle."""
    a, b = np.array(hip), np.array(ankle)
    along = b - a
    distance = float(np.hypot(along[0], along[2]))
    reach = min(distance, thigh + shank)
    from_hip = (thigh**2 - shank**2 + reach**2) / (2 * reach)
    out = max(thigh**2 - from_hip**2, 0.0) ** 0.5
    ahead = np.array([along[2], 0.0, -along[0]])
    knee = a + (along * from_hip + ahead * out) / distance
    return float(knee[0]), float(knee[1]), float(knee[2])
