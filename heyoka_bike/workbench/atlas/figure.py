"""Draw an atlas as a map: where a bicycle runs steadily, weaves or falls, and how soon."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Maneuver, benchmark
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.atlas.data import CYCLE, FALLS, LIFTS, UNDECIDED, UPRIGHT, WEAVES, Atlas
from heyoka_bike.workbench.atlas.store import load_atlas
from heyoka_bike.workbench.style import BLACK, WIDTH, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE_OF_MAP = (WIDTH, 4.9)  # [inch]
_DIGITS_OF_AXES = 15
_NOTE: dict[str, Any] = {"fontsize": 7.5, "linespacing": 1.25}
# Tints of blue, sky blue, orange and vermillion of Okabe and Ito's palette. They also differ in
# lightness.
_COLOURS = {
    UNDECIDED: "#ffffff", UPRIGHT: "#7fb8d9", CYCLE: "#f7d98b", LIFTS: "#1f5f8b",
    WEAVES: "#df8a4f",
}  # fmt: skip
_GREYS = (0.55, 0.94)
"""Greys from an immediate fall to a fall at the end of the time limit."""
_SOONEST = 0.1  # [s], shortest time to a fall on the scale of greys
_SHIFTS = {LIFTS: (-0.16, 0.13), WEAVES: (-0.115, -0.03), UNDECIDED: (0.14, 0.02)}
"""Offset of labels from narrow regions, in widths and heights of the map."""
_NAME_WIDTH = 0.12  # width of the name of a maneuver, as a fraction of the map's width
_LEAST_PART_NAMED = 0.002  # smallest fraction of the map that a region must cover to get a name
_STYLE_OF_EDGE: dict[str, Any] = {
    "linestyle": "none",
    "marker": ".",
    "markersize": 2.4,
    "color": BLACK,
}
_ARROW: dict[str, Any] = {"arrowstyle": "-", "linewidth": 0.5, "shrinkA": 1, "shrinkB": 0}


@dataclass(frozen=True, slots=True)
class EnergyCurve:
    """Initial conditions with the energy of straight running at a critical speed.

    Attributes
    ----------
    name
        Name of the critical speed.
    limit
        Critical speed [m/s], where the stability changes.
    speed, roll_rate : ndarray
        Initial values [m/s, rad/s].
    """

    name: str
    limit: float
    speed: Array
    roll_rate: Array


def atlas_figure(folder: str | Path) -> Figure:
    """Draw the map of the atlas in a folder."""
    return draw(load_atlas(folder))


def draw(atlas: Atlas) -> Figure:
    """Draw the map of an atlas: the first axis to the right, the second up, early falls dark.

    A map over speed and roll rate also shows the range in which the linear equations are stable
    (dashed), and the starts with the energy of straight running at its ends. A map of the benchmark
    bicycle shows the maneuvers.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_SIZE_OF_MAP, layout="constrained")
        ax = figure.subplots()
        ax.grid(visible=False)
        _draw_map(figure, ax, atlas)
        _draw_edge(ax, atlas)
        names = tuple(axis.name for axis in atlas.axes)
        if names == ("speed", "roll_rate") and not any(atlas.start.values()):
            curves = limits(atlas)
            for curve in curves:
                _draw_limit(ax, curve)
            barriers = [*(curve.limit for curve in curves), atlas.axes[0].values[-1]]
            for number, maneuver in enumerate(maneuvers(atlas), start=1):
                _draw_maneuver(ax, number, maneuver, barriers)
            _name_stable_ranges(ax, atlas)
        across, up = (f"{a.title} [{a.unit}]" for a in atlas.axes)
        ax.set_xlabel(across)
        ax.set_ylabel(up)
        return figure


def limits(atlas: Atlas) -> list[EnergyCurve]:
    """Return a curve for each critical speed: the starts that have the energy at that speed."""
    equations = Equations.binary64(atlas.bicycle)
    k = equations.k
    still, rolling, turning = (
        equations.energies([0.0, 0.0, 0.0, rate, 0.0, speed / k.length])
        for rate, speed in ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))
    )
    # In the upright and straight state, the kinetic energy is a sum of squares: of the speed, and
    # of each rate. So the curve is an ellipse.
    ratio = (turning.kinetic - still.kinetic) / (rolling.kinetic - still.kinetic)
    rates = np.linspace(0.0, atlas.axes[1].values[-1], 400)
    found = []
    for low, high in linearise(atlas.bicycle, _DIGITS_OF_AXES).stable_ranges:
        for name, limit in (("weave speed", low), ("capsize speed", high)):
            if limit is not None:
                square = float(limit) ** 2 - ratio * rates**2
                speed = np.sqrt(np.maximum(square, 0.0))
                found.append(EnergyCurve(name, float(limit), speed[square > 0], rates[square > 0]))
    return found


def _draw_map(figure: Figure, ax: Axes, atlas: Atlas) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, LogNorm, to_rgb

    fate, time = atlas.variables["fate"], atlas.variables["fate_time"]
    longest = float(np.nanmax(time))
    picture = np.ones((*fate.shape, 3))
    for number, colour in _COLOURS.items():
        picture[fate == number] = to_rgb(colour)
    greys = LinearSegmentedColormap.from_list("falls", [(grey,) * 3 for grey in _GREYS])
    norm = LogNorm(_SOONEST, longest, clip=True)
    picture[fate == FALLS] = greys(norm(time[fate == FALLS]))[:, :3]
    x, y = (axis.values for axis in atlas.axes)
    ax.pcolormesh(x, y, picture.transpose(1, 0, 2), shading="nearest", rasterized=True)
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    bar = figure.colorbar(ScalarMappable(norm, greys), ax=ax, aspect=40, pad=0.015)
    bar.set_label("falls after [s]")
    bar.ax.yaxis.set_major_formatter("{x:g}")
    names = {
        UPRIGHT: "steady straight running", CYCLE: "limit\ncycle", WEAVES: "weaves\nirregularly",
        LIFTS: "lifts a wheel,\nrecovers", UNDECIDED: f"not decided\nafter {longest:g} s",
    }  # fmt: skip
    for number, name in names.items():
        _name_region(ax, x, y, fate == number, name, _SHIFTS.get(number))


def _name_region(
    ax: Axes, x: Array, y: Array, is_here: Any, name: str, shift: tuple[float, float] | None
) -> None:
    """Write the name of a region of the map in its middle, or next to it."""
    if is_here.mean() < _LEAST_PART_NAMED:
        return
    places = np.argwhere(is_here)
    i, j = places[np.argmin(np.square(places - places.mean(axis=0)).sum(axis=1))]
    if shift is None:
        ax.annotate(name, (x[i], y[j]), ha="center", va="center", **_NOTE)
        return
    at = (x[i] + shift[0] * (x[-1] - x[0]), y[j] + shift[1] * (y[-1] - y[0]))
    _point_at(ax, name, (x[i], y[j]), at)


def _draw_edge(ax: Axes, atlas: Atlas) -> None:
    edge, x, y = atlas.edge, atlas.axes[0].values, atlas.axes[1].values
    if not len(edge.at):
        return
    # The two sides of the basin boundary are neighbouring binary64 numbers, which cannot be
    # distinguished in a picture. So draw only one of them.
    ax.plot(edge.at, edge.stays, zorder=3, **_STYLE_OF_EDGE)
    highest = edge.stays >= np.quantile(edge.stays, 0.5)
    i = np.flatnonzero(highest)[np.argmin(edge.stays[highest])]
    at = (edge.at[i] - 0.06 * (x[-1] - x[0]), edge.stays[i] + 0.1 * (y[-1] - y[0]))
    _point_at(ax, "basin boundary", (edge.at[i], edge.stays[i]), at)


def _point_at(ax: Axes, text: str, place: tuple[float, float], at: tuple[float, float]) -> None:
    """Write a text, and draw a line from it to the place that it names."""
    ax.annotate(text, place, at, ha="center", va="center", arrowprops=_ARROW, zorder=4, **_NOTE)


def _write_above(ax: Axes, text: str, x: float) -> None:
    """Write text above the map."""
    ax.annotate(
        text, (x, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 3),
        textcoords="offset points", ha="center", va="bottom", **_NOTE,
    )  # fmt: skip


def _name_stable_ranges(ax: Axes, atlas: Atlas) -> None:
    for low, high in linearise(atlas.bicycle, _DIGITS_OF_AXES).stable_ranges:
        if high is not None:
            _write_above(ax, "stable by the\nlinear equations", float(low + high) / 2)


def _draw_limit(ax: Axes, curve: EnergyCurve) -> None:
    ax.axvline(curve.limit, color=BLACK, linewidth=0.7, linestyle=(0, (4, 2)))
    ax.plot(curve.speed, curve.roll_rate, color=BLACK, linewidth=0.9, linestyle=(0, (1, 1.2)))
    _write_above(ax, f"{curve.name}\n{curve.limit:.4f} m/s", curve.limit)
    i = np.searchsorted(curve.roll_rate, 0.93 * ax.get_ylim()[1])
    if i < len(curve.speed) and curve.speed[i] > ax.get_xlim()[0]:
        ax.annotate(
            f"energy as at\nthe {curve.name}",
            (curve.speed[i], curve.roll_rate[i]), xytext=(6, 0), textcoords="offset points",
            va="center", **_NOTE,
        )  # fmt: skip


def _draw_maneuver(ax: Axes, number: int, maneuver: Maneuver, barriers: Sequence[float]) -> None:
    """Draw a maneuver as a circle, with its name on the side where no line is in the way."""
    x, y = float(maneuver.speed), float(maneuver.roll_rate)
    low, high = ax.get_xlim()
    is_narrow = any(0 < barrier - x < _NAME_WIDTH * (high - low) for barrier in barriers)
    ax.plot(
        x, y, marker="o", markersize=4.5, markerfacecolor="white", markeredgecolor=BLACK,
        clip_on=False, zorder=5,
    )  # fmt: skip
    ax.annotate(
        f"maneuver {number}", (x, y), xytext=(-5 if is_narrow else 5, 5),
        textcoords="offset points", ha="right" if is_narrow else "left", zorder=5, **_NOTE,
    )  # fmt: skip


def maneuvers(atlas: Atlas) -> tuple[Maneuver, ...]:
    """Return the maneuvers of the benchmark, if the atlas is of its bicycle."""
    published, found = benchmark()
    return found if atlas.bicycle.values == published.values else ()
