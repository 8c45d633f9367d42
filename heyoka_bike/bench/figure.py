"""Figures of what was timed: time against error, and against digits and duration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from heyoka_bike.showing.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    style,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE = (7.0, 4.6)  # [inch]; the width of a printed page of text
_COLOURS = (VERMILLION, ORANGE, BLUE, SKY, GREEN, PURPLE, BLACK, GREY)
_MARKERS = "osD^vP*X"
_COST_SIZE = (7.0, 3.2)


def draw(points: Sequence[Mapping[str, Any]], title: str) -> Figure:
    """Figure of the points of a report's ``work_precision``, one line for each code.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_SIZE, layout="constrained")
        ax = figure.subplots()
        for i, name in enumerate(dict.fromkeys(x["code"] for x in points)):
            line = [x for x in points if x["code"] == name]
            ax.loglog(
                [x["max_state_error"] for x in line],
                [x["min_ms"] for x in line],
                color=_COLOURS[i % len(_COLOURS)],
                marker=_MARKERS[i % len(_MARKERS)],
                markersize=3,
                label=name,
            )
        # Accuracy grows to the right.
        ax.invert_xaxis()
        ax.set_xlabel("largest error of roll, steer [rad], their rates [rad/s] and speed [m/s]")
        ax.set_ylabel("shortest time, rows included [ms]")
        ax.set_title(title, parse_math=False)
        ax.legend()
    return figure


def draw_costs(
    digits: Sequence[Mapping[str, Any]], durations: Sequence[Mapping[str, Any]]
) -> Figure:
    """Figure of a report's ``digits`` and ``durations``, both axes logarithmic.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_COST_SIZE, layout="constrained")
        left, right = figure.subplots(1, 2)
        left.loglog(
            [x["digits"] for x in digits], [x["seconds"] for x in digits], color=_COLOURS[2],
            marker="o", markersize=3,
        )  # fmt: skip
        left.set_xlabel("decimal digits of the significand")
        left.set_ylabel("time of 10 s of maneuver 2 [s]")
        for i, accuracy in enumerate(dict.fromkeys(x["accuracy"] for x in durations)):
            line = [x for x in durations if x["accuracy"] == accuracy]
            right.loglog(
                [x["duration"] for x in line], [1e3 * x["time"] for x in line],
                color=_COLOURS[2 * i % len(_COLOURS)], marker=_MARKERS[i], markersize=3,
                label=str(accuracy),
            )  # fmt: skip
        right.set_xlabel("duration [s]")
        right.set_ylabel("time, 1001 rows included [ms]")
        right.legend(title="accuracy", title_fontsize=7.5)
    return figure
