"""A wide picture for a page of any colour: the bicycle, and how the maneuvers roll."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from figures.silhouette import FROM_RIGHT, Pose, fitted
from figures.silhouette import draw as draw_silhouette
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.workbench.style import BLUE, GREEN, VERMILLION, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE = (6.0, 2.1)  # [inch]; 1200 by 420 dots
_MOST = 3  # strips that there is room for
# About as far from white as from a dark page.
_COLOUR = (BLUE, VERMILLION, GREEN)
_INK = "#768390"
_COLOURS = {
    "rear": (BLUE, BLUE), "front": (VERMILLION, VERMILLION), "rider": ("#a3acb5", "#8c96a0"),
    "wheel": (_INK, _INK),
}  # fmt: skip
_POINTS = 1001


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """The bicycle from the side, and the roll angle [rad] of up to three maneuvers over time.

    Each strip has a scale of its own; the largest angle is written beside it. The background is
    transparent.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    drawn, _ = fitted(Bicycle.parse(reference.bicycle, reference.parameters))
    shown = [reference[n] for n in numbers[:_MOST]]
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_SIZE, facecolor="none")
        side = figure.add_axes((0.0, 0.0, 0.34, 1.0))
        side.axis("off")
        height = 1.98
        half = height / 2 * 0.34 * _SIZE[0] / _SIZE[1]
        side.set(xlim=(0.53 - half, 0.53 + half), ylim=(-0.12, height - 0.12))
        side.plot([-0.36, 1.43], [0, 0], color=_INK, linewidth=1.0)
        draw_silhouette(side, drawn, FROM_RIGHT, Pose(), _COLOURS)
        top, bottom = 0.97, 0.15
        high = (top - bottom) / len(shown)
        for i, (maneuver, colour) in enumerate(zip(shown, _COLOUR, strict=False)):
            box = (0.515, top - (i + 1) * high, 0.36, high)
            _draw_strip(figure.add_axes(box), maneuver, colour)
        figure.text(
            0.695, 0.03, f"roll angle over {float(shown[0].duration):g} s, and its largest value",
            color=_INK, ha="center", fontsize=8,
        )  # fmt: skip
    return figure


def _draw_strip(ax: Axes, maneuver: ReferenceManeuver, colour: str) -> None:
    end = float(maneuver.duration)
    time = np.linspace(0.0, end, _POINTS)
    roll = maneuver.approximate(time, ("roll_angle",))["roll_angle"]
    ax.axis("off")
    ax.margins(x=0.0, y=0.12)
    ax.plot([0.0, end], [0.0, 0.0], color=_INK, linewidth=0.5)
    ax.plot(time, roll, color=colour, linewidth=1.6)
    largest = float(np.abs(roll).max())
    speed = float(Exact.parse(maneuver.inputs["speed"]))
    ax.text(
        -0.04, 0.5, f"{maneuver.name}\n{speed:g} m/s", transform=ax.transAxes, ha="right",
        va="center", color=colour, fontsize=8.5, parse_math=False,
    )  # fmt: skip
    ax.text(
        1.03, 0.5, f"{largest:.2g} rad", transform=ax.transAxes, ha="left",
        va="center", color=_INK, fontsize=8,
    )  # fmt: skip
