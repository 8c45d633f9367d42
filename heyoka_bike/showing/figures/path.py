"""Paths of the rear wheel on the floor, and how much they are curved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from heyoka_bike.reference.load import Reference
from heyoka_bike.showing.figures.style import BLACK, BLUE, drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS = 1001
_PATH = ("rear_contact_x", "rear_contact_y")
_TURNING = ("yaw_rate", "forward_speed_contact")
_ROW_HEIGHT, _REST_HEIGHT = 1.9, 0.3  # [inch]


def curvature(reference: Reference, number: int, time: np.ndarray) -> np.ndarray:
    """Of the rear contact point's path [1/m], to the right: it moves along the wheel's heading."""
    values = reference[number].approximate(time, _TURNING)
    return values["yaw_rate"] / values["forward_speed_contact"]


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """A row for each maneuver: the path from above [m], and its curvature over time [1/km].

    Both to the right; the path is drawn with another scale across than along. A dot stands at
    every second.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    DatasetError
        The set has no motion.h5.
    """
    with drawing(_ROW_HEIGHT * len(numbers) + _REST_HEIGHT) as figure:
        grid = figure.subplots(len(numbers), 2, squeeze=False)
        for number, (above, over_time) in zip(numbers, grid, strict=True):
            maneuver = reference[number]
            end = float(maneuver.duration)
            time, seconds = np.linspace(0.0, end, POINTS), np.arange(0.0, np.floor(end) + 0.5)
            x, y = (reference.motion[number].approximate(time, _PATH)[name] for name in _PATH)
            above.plot(x, y, color=BLUE, linewidth=1.2)
            at = reference.motion[number].approximate(seconds, _PATH)
            above.plot(*at.values(), linestyle="none", marker="o", markersize=2.5, color=BLACK)
            above.invert_yaxis()
            above.set_ylabel("to the right [m]")
            above.set_title(maneuver.name, loc="left", fontsize=9, parse_math=False)
            over_time.axhline(0.0, color=BLACK, linewidth=0.5)
            bent = 1000 * curvature(reference, number, time)
            over_time.plot(time, bent, color=BLUE, linewidth=1.2)
            over_time.set_ylabel("curvature [1/km]")
        grid[-1, 0].set_xlabel("path, forward [m]; a dot every second")
        grid[-1, 1].set_xlabel("time [s]")
    return figure
