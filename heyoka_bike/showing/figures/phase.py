"""Phase portraits: roll against its rate, steer against its rate, roll against steer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from heyoka_bike.reference.load import Reference
from heyoka_bike.showing.figures.style import BLACK, BLUE, drawing, unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PORTRAITS = (
    ("roll_angle", "roll_rate"),
    ("steer_angle", "steer_rate"),
    ("roll_angle", "steer_angle"),
)
"""Columns across and up."""

POINTS = 2001
"""Of a curve: the fastest oscillation of the benchmark turns by less than 2 degrees in between."""

_COLUMNS = tuple(dict.fromkeys(name for pair in PORTRAITS for name in pair))
_ROW_HEIGHT, _REST_HEIGHT, _PAD = 2.1, 0.35, 0.06  # [inch]
_START = {"marker": "o", "markersize": 4.5, "markerfacecolor": "white", "markeredgecolor": BLACK}
_END = {"marker": "s", "markersize": 3.5, "markerfacecolor": BLACK, "markeredgecolor": BLACK}


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """A row of portraits for each maneuver, from the dense output; angles in rad, rates in rad/s.

    A circle is where the motion starts, a square where it ends.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with drawing(_ROW_HEIGHT * len(numbers) + _REST_HEIGHT) as figure:
        figure.set_layout_engine("constrained", w_pad=_PAD, h_pad=_PAD)
        grid = figure.subplots(len(numbers), len(PORTRAITS), squeeze=False)
        for number, row in zip(numbers, grid, strict=True):
            maneuver = reference[number]
            end = float(maneuver.duration)
            values = maneuver.approximate(np.linspace(0.0, end, POINTS), _COLUMNS)
            for ax, (across, up) in zip(row, PORTRAITS, strict=True):
                x, y = values[across], values[up]
                ax.plot(x, y, color=BLUE, linewidth=1.0)
                ax.plot(x[:1], y[:1], linestyle="none", label="0 s", **_START)
                ax.plot(x[-1:], y[-1:], linestyle="none", label=f"{end:g} s", **_END)
                ax.set_xlabel(f"{across.replace('_', ' ')} [{unit(maneuver.units, across)}]")
                ax.set_ylabel(f"{up.replace('_', ' ')} [{unit(maneuver.units, up)}]")
                ax.locator_params(nbins=5)
            row[0].set_title(maneuver.name, loc="left", fontsize=9, parse_math=False)
        grid[0, -1].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
        figure.align_ylabels(grid)
    return figure
