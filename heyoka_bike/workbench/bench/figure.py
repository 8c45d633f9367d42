"""Figure of what was timed: time against error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from heyoka_bike.showing.figures import style as s

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE = (7.0, 4.6)  # [inch]; the width of a printed page of text
COLOURS = (s.VERMILLION, s.ORANGE, s.BLUE, s.SKY, s.GREEN, s.PURPLE, s.BLACK, s.GREY)
MARKERS = "osD^vP*X"


def draw(points: Sequence[Mapping[str, Any]], title: str) -> Figure:
    """Figure of the points of a report's ``work_precision``, one line for each code.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with s.style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_SIZE, layout="constrained")
        ax = figure.subplots()
        for i, name in enumerate(dict.fromkeys(x["code"] for x in points)):
            line = [x for x in points if x["code"] == name]
            ax.loglog(
                [x["max_state_error"] for x in line],
                [x["min_ms"] for x in line],
                color=COLOURS[i % len(COLOURS)],
                marker=MARKERS[i % len(MARKERS)],
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
