"""The bicycle to scale, with every parameter, the axes, and what roll, steer, pitch, yaw mean."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, pi, radians, sin
from typing import TYPE_CHECKING, Any

import numpy as np

from figures.silhouette import FROM_ABOVE, FROM_BEHIND, FROM_RIGHT, Pose, fitted, rim
from figures.silhouette import draw as draw_silhouette
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle
from heyoka_bike.bicycle.shapes import Shape
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference
from heyoka_bike.workbench.style import BLACK, BLUE, VERMILLION, WIDTH, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Spot = tuple[float, float]
"""A place on the page [m]: to the right, and up from the floor."""

_SIZE = (WIDTH, 6.25)  # [inch]
_COLOURS = {
    "rear": ("#bfd9ec", "#4f87b0"), "front": ("#f6cfae", "#b8703a"),
    "rider": ("#efefef", "#d2d2d2"), "wheel": ("#8f8f8f", "#5a5a5a"),
}  # fmt: skip
_THIN: dict[str, Any] = {"color": "#6a6a6a", "linewidth": 0.5, "zorder": 3}
_LINE: dict[str, Any] = {"color": BLACK, "linewidth": 0.8, "zorder": 5}
_TEXT: dict[str, Any] = {"fontsize": 9, "ha": "center", "va": "center", "zorder": 8}
_PAPER: dict[str, Any] = {
    "boxstyle": "square,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.85,
}  # fmt: skip
# Angles of the small views [rad].
_ROLL, _STEER, _YAW = 0.24, 0.45, 0.42


def draw(reference: Reference, numbers: Sequence[int] = ()) -> Figure:
    """Side view to scale, a view from behind with the roll, one from above with steer and yaw.

    Lengths in m. Drawn from the parameters of the set, which are listed below the drawing.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
    drawn, scale = fitted(bicycle)
    lengths = {s: scale * float(bicycle[s]) for s, x in PARAMETERS.items() if x.unit == "m"}
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_SIZE)
        side = _view(figure, (0.0, 0.195, 0.655, 0.8), (0.525, 0.6), 2.53)
        behind = _view(figure, (0.655, 0.575, 0.345, 0.415), (0.16, 0.835), 2.5)
        above = _view(figure, (0.655, 0.215, 0.345, 0.325), (0.75, -0.29), 1.98)
        _draw_side(side, drawn, lengths)
        _draw_behind(behind, drawn)
        _draw_above(above, drawn)
        _list_parameters(figure, bicycle)
    return figure


def _view(
    figure: Figure, box: tuple[float, float, float, float], centre: Spot, height: float
) -> Axes:
    """Axes without a frame in a part of the figure, so many metres high, to scale."""
    ax = figure.add_axes(box)
    ax.axis("off")
    half = height / 2 * (_SIZE[0] * box[2]) / (_SIZE[1] * box[3])
    ax.set_xlim(centre[0] - half, centre[0] + half)
    ax.set_ylim(centre[1] - height / 2, centre[1] + height / 2)
    return ax


def _draw_side(ax: Axes, drawn: Shape, p: dict[str, float]) -> None:
    floor = -0.31, -0.43, -0.55
    contact, foot = p["w"], p["w"] + p["c"]
    b, h = (p["xB"], -p["zB"]), (p["xH"], -p["zH"])
    left, right = -p["rR"] - 0.24, p["w"] + p["rF"] + 0.22
    ax.plot([left - 0.08, right + 0.08], [0, 0], color=BLACK, linewidth=1.0, zorder=1)
    draw_silhouette(ax, drawn, FROM_RIGHT, Pose(), _COLOURS)
    spots = {name: (x, -z) for name, (x, _, z) in drawn.points.items()}
    _draw_steer_axis(ax, spots, drawn.tilt, floor[2])
    for x, low, high in (
        (0.0, floor[2] - 0.03, -0.2), (b[0], floor[0] - 0.03, b[1]), (h[0], floor[1] - 0.03, h[1]),
        (contact, floor[2] - 0.03, 0.0), (foot, floor[2] - 0.03, 0.0),
    ):  # fmt: skip
        ax.plot([x, x], [low, high], linestyle=(0, (1, 2)), **_THIN)
    for (x, y), far in ((b, left - 0.03), (h, right + 0.03)):
        ax.plot([x, far], [y, y], linestyle=(0, (1, 2)), **_THIN)
    _arrow(ax, (0, floor[0]), (b[0], floor[0]), "$x_B$")
    _arrow(ax, (0, floor[1]), (h[0], floor[1]), "$x_H$")
    _arrow(ax, (0, floor[2]), (contact, floor[2]), "$w$", both=True)
    _narrow(ax, contact, foot, floor[0], "$c$")
    _arrow(ax, (left, 0), (left, b[1]), "$z_B$")
    _arrow(ax, (right, 0), (right, h[1]), "$z_H$")
    for hub, radius, angle, label in (
        (spots["P1"], p["rR"], radians(205), "$r_R$"),
        (spots["P3"], p["rF"], radians(-38), "$r_F$"),
    ):  # fmt: skip
        _arrow(ax, hub, (hub[0] + radius * cos(angle), hub[1] + radius * sin(angle)), label)
    _axes(ax, (0.0, 0.0), {"$x$": (1, 0), "$z$": (0, -1)}, 0.2)
    _towards(ax, (0.0, 0.0), "$y$")
    for spot, letter, offset in (
        (b, "B", (-9, 8)), (h, "H", (10, 7)),
        (spots["P1"], "R", (-9, 8)), (spots["P3"], "F", (6, 11)),
    ):  # fmt: skip
        _centre_of_mass(ax, spot, letter, offset)
    ax.plot(*spots["P2"], "o", color=BLACK, markersize=3, zorder=7)
    for name, offset in (("P1", (10, -8)), ("P2", (11, 4)), ("P3", (15, 1))):
        _label(ax, spots[name], f"$P_{name[1]}$", offset)
    _pitch(ax, spots["P1"], p["rR"])
    _arrow(ax, (right, 1.55), (right, 1.25), "", colour=BLACK, width=1.4)
    _label(ax, (right, 1.4), "$g$", (9, 0))


def _draw_steer_axis(ax: Axes, spots: dict[str, Spot], tilt: float, low: float) -> None:
    """The axis, its tilt below the floor, the steer angle at its upper end."""
    foot = spots["foot"]

    def along(up: float) -> Spot:
        return foot[0] - up * sin(tilt), foot[1] + up * cos(tilt)

    top, bottom = along(1.52), along(low / cos(tilt))
    ax.plot(*zip(top, bottom, strict=True), linestyle=(0, (8, 2, 1.5, 2)), **_LINE)
    arc = _circle(foot, -0.92 * low, -pi / 2, -pi / 2 + tilt)
    ax.plot(*arc.T, **_LINE)
    _label(ax, arc[14], r"$\lambda$", (1, -7))
    # On the near side the fork's front comes towards the eye and goes back: to the left.
    middle = along(1.38)
    turn = np.linspace(radians(-20), radians(-200), 40)
    wide, flat = 0.12, 0.035
    x, y = wide * np.cos(turn), flat * np.sin(turn)
    c, s = cos(tilt), sin(tilt)
    _curve(ax, np.column_stack((middle[0] + c * x - s * y, middle[1] + s * x + c * y)))
    _label(ax, middle, r"steer $\delta$", (28, 7), VERMILLION)


def _pitch(ax: Axes, hub: Spot, radius: float) -> None:
    arc = _circle(hub, radius + 0.09, radians(112), radians(158))
    _curve(ax, arc)
    _label(ax, arc[14], r"pitch $\theta$", (-13, 8), VERMILLION)


def _draw_behind(ax: Axes, drawn: Shape) -> None:
    pose = Pose(roll=_ROLL)
    ax.plot([-0.62, 0.78], [0, 0], color=BLACK, linewidth=1.0, zorder=0)
    draw_silhouette(ax, drawn, FROM_BEHIND, pose, _COLOURS)
    ax.plot([0, 0], [0, 1.95], linestyle=(0, (1, 2)), **_THIN)
    ax.plot([0, 1.95 * sin(_ROLL)], [0, 1.95 * cos(_ROLL)], linestyle=(0, (8, 2, 1.5, 2)), **_LINE)
    arc = _circle((0.0, 0.0), 1.86, pi / 2, pi / 2 - _ROLL)
    _curve(ax, arc)
    _label(ax, arc[14], r"roll $\varphi$", (2, 9), VERMILLION)
    _axes(ax, (0.0, 0.0), {"$y$": (1, 0), "$z$": (0, -1)}, 0.3)
    _name(ax, "from behind")


def _draw_above(ax: Axes, drawn: Shape) -> None:
    pose = Pose(steer=_STEER, yaw=_YAW)
    draw_silhouette(ax, drawn, FROM_ABOVE, pose, _COLOURS, parts=("bicycle",))
    _name(ax, "from above")
    hub = pose.place(drawn, np.array([drawn.points["P3"]]), "front")[0] @ FROM_ABOVE.T
    middle = rim(drawn, FROM_ABOVE, pose, "front", drawn.radii[1])
    ahead = middle[int(np.argmax(np.hypot(*middle.T)))] - hub[:2]
    steered = atan2(ahead[1], ahead[0])
    far, near = 1.78, 0.5
    ax.plot([0, far], [0, 0], linestyle=(0, (1, 2)), **_THIN)
    ax.plot([0, far * cos(_YAW)], [0, -far * sin(_YAW)], linestyle=(0, (8, 2, 1.5, 2)), **_LINE)
    ax.plot(
        [hub[0], hub[0] + (near + 0.1) * cos(steered)],
        [hub[1], hub[1] + (near + 0.1) * sin(steered)],
        linestyle=(0, (8, 2, 1.5, 2)), **_LINE,
    )  # fmt: skip
    _curve(ax, _circle((0.0, 0.0), far - 0.06, 0.0, -_YAW))
    _label(ax, _circle((0.0, 0.0), far, 0.0, -_YAW)[14], r"yaw $\psi$", (-22, 2), VERMILLION)
    _curve(ax, _circle((hub[0], hub[1]), near, -_YAW, steered))
    _label(
        ax,
        _circle((hub[0], hub[1]), near, -_YAW, steered)[14],
        r"steer $\delta$",
        (19, -10),
        VERMILLION,
    )
    _axes(ax, (0.0, 0.0), {"$x$": (1, 0), "$y$": (0, -1)}, 0.45)


def _list_parameters(figure: Figure, bicycle: Bicycle) -> None:
    groups = {
        "bicycle": ("w", "c", "lam", "g"),
        "rear wheel R": tuple(s for s in PARAMETERS if s[1:2] == "R"),
        "rear frame, rider B": tuple(s for s in PARAMETERS if s[1:2] == "B"),
        "fork, handlebar H": tuple(s for s in PARAMETERS if s[1:2] == "H"),
        "front wheel F": tuple(s for s in PARAMETERS if s[1:2] == "F"),
    }
    for i, (title, symbols) in enumerate(groups.items()):
        x = 0.03 + 0.196 * i
        figure.text(x, 0.185, title, fontsize=7.5, fontweight="bold", va="top")
        for j, symbol in enumerate(symbols):
            figure.text(
                x, 0.16 - 0.022 * j, _equation(symbol, bicycle[symbol]), fontsize=7.5, va="top"
            )


def _equation(symbol: str, value: Exact) -> str:
    unit = PARAMETERS[symbol].unit.replace("kg m^2", "kg m$^2$")
    return f"{_symbol(symbol)} = {_number(value)} {unit}"


def _symbol(symbol: str) -> str:
    if symbol == "lam":
        return r"$\lambda$"
    return f"${symbol[0]}_{{{symbol[1:]}}}$" if symbol[1:] else f"${symbol}$"


def _number(value: Exact) -> str:
    if value.rational == 0 and value.pi_multiple:
        over = value.pi_multiple
        times = {1: "", -1: "-"}.get(over.numerator, f"{over.numerator} ")
        text = rf"{times}$\pi$" + ("" if over.denominator == 1 else f"/{over.denominator}")
    else:
        text = f"{float(value):.6g}"
    return text.replace("-", "\N{MINUS SIGN}")


def _arrow(
    ax: Axes, a: Spot, b: Spot, label: str, *, both: bool = False, colour: str = BLACK,
    width: float = 0.7,
) -> None:  # fmt: skip
    """An arrow from a to b, a coordinate; with both heads a length."""
    style = "<|-|>" if both else "-|>"
    ax.annotate(
        "", b, xytext=a, zorder=6,
        arrowprops={
            "arrowstyle": f"{style},head_width=0.13,head_length=0.3", "linewidth": width,
            "color": colour, "shrinkA": 0, "shrinkB": 0,
        },
    )  # fmt: skip
    if label:
        middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
        ax.text(*middle, label, bbox=_PAPER, **_TEXT)


def _narrow(ax: Axes, a: float, b: float, y: float, label: str) -> None:
    """A length too short for a label: arrows from outside."""
    low, high = min(a, b), max(a, b)
    _arrow(ax, (low - 0.09, y), (low, y), "")
    _arrow(ax, (high + 0.09, y), (high, y), "")
    _label(ax, (low, y), label, (-9, 7))


def _axes(ax: Axes, origin: Spot, directions: dict[str, Spot], size: float) -> None:
    for label, (x, y) in directions.items():
        end = origin[0] + size * x, origin[1] + size * y
        _arrow(ax, origin, end, "", colour=BLUE, width=1.4)
        _label(ax, end, label, (7 * y + 5 * x, 7 * x - 3 * abs(y)), colour=BLUE)


def _towards(ax: Axes, spot: Spot, label: str) -> None:
    """An axis towards the eye."""
    ax.plot(*spot, "o", markersize=6, color=BLUE, markerfacecolor="white", zorder=7)
    ax.plot(*spot, "o", markersize=1.8, color=BLUE, zorder=7)
    _label(ax, spot, label, (-8, -8), colour=BLUE)


def _centre_of_mass(ax: Axes, spot: Spot, letter: str, offset: Spot) -> None:
    """The usual circle of four quarters, two of them black."""
    from matplotlib.patches import Circle, Wedge

    size = 0.033
    ax.add_patch(Circle(spot, size, facecolor="white", edgecolor=BLACK, linewidth=0.7, zorder=6))
    for start in (0, 180):
        ax.add_patch(Wedge(spot, size, start, start + 90, facecolor=BLACK, linewidth=0, zorder=6))
    _label(ax, spot, letter, offset, weight="bold")


def _label(
    ax: Axes, spot: Spot, text: str, offset: Spot, colour: str = BLACK, weight: str = "normal"
) -> None:
    """Text beside a spot, so many points to the right and up."""
    ax.annotate(
        text, spot, xytext=offset, textcoords="offset points", color=colour, fontweight=weight,
        **_TEXT,
    )  # fmt: skip


def _circle(centre: Spot, radius: float, start: float, end: float) -> Array:
    """A part of a circle, shape (30, 2); angles from the right towards up [rad]."""
    turn = np.linspace(start, end, 30)
    return np.array(centre) + radius * np.column_stack((np.cos(turn), np.sin(turn)))


def _name(ax: Axes, name: str) -> None:
    """What a small view is, in its upper left."""
    ax.text(0.03, 0.97, name, transform=ax.transAxes, fontsize=8, va="top", style="italic")


def _curve(ax: Axes, points: Any) -> None:
    """A curved arrow: an angle, in the direction in which it is positive."""
    ax.plot(*points.T, color=VERMILLION, linewidth=1.3, zorder=6)
    ax.annotate(
        "", points[-1], xytext=points[-4], zorder=6,
        arrowprops={
            "arrowstyle": "-|>,head_width=0.17,head_length=0.36", "linewidth": 1.3,
            "color": VERMILLION, "shrinkA": 0, "shrinkB": 0,
        },
    )  # fmt: skip
