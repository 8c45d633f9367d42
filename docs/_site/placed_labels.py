"""Words beside points of a figure, which cover neither each other nor what is drawn."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg

_SIZE = 7  # [pt]
_PADDING = 1.5  # around words [px]
_NEAR = 14  # a leader is drawn to what is further away than that [px]
_FAR = 150  # places are sought within this distance [px]
_BETWEEN = 12  # places on each piece of a line that words keep off


@dataclass(frozen=True)
class Label:
    """Words for a point, in a colour; the place is in data coordinates."""

    x: float
    y: float
    text: str
    colour: str


def place(figure, ax, labels, lines):
    """Write labels beside their points.

    Parameters
    ----------
    labels : sequence of Label
    lines : sequence of sequence of (float, float)
        What is drawn, in data coordinates: dots and the lines between them.
    """
    # The layout is known once the figure was drawn.
    FigureCanvasAgg(figure).draw()
    renderer, frame = figure.canvas.get_renderer(), ax.get_window_extent()
    drawn = np.vstack([_along(ax, line) for line in lines if line])
    taken = []
    for label in sorted(labels, key=lambda x: -x.y):
        point = ax.transData.transform((label.x, label.y))
        words = ax.text(label.x, label.y, label.text, fontsize=_SIZE)
        extent = words.get_window_extent(renderer)
        words.remove()
        size = np.array([extent.width, extent.height])
        box = _best(point, size, frame, taken, drawn)
        taken.append(box)
        _write(ax, label, point, box)


def _along(ax, line):
    """Places on a line [px]."""
    ends = ax.transData.transform(np.array(line, float))
    parts = [ends]
    parts += [np.linspace(a, b, _BETWEEN) for a, b in pairwise(ends)]
    return np.vstack(parts)


def _best(point, size, frame, taken, drawn):
    """The box (x0, y0, x1, y1) [px] of least cost: nearness, and how much is covered."""
    found = []
    for radius in np.arange(6, _FAR, 4):
        for angle in np.linspace(0, 2 * np.pi, 24, endpoint=False):
            direction = np.array([np.cos(angle), np.sin(angle)])
            # The middle of the words, so that their nearest edge is at the radius.
            middle = point + radius * direction + direction * size / 2
            low, high = middle - size / 2 - _PADDING, middle + size / 2 + _PADDING
            if low[0] < frame.x0 or high[0] > frame.x1 or low[1] < frame.y0 or high[1] > frame.y1:
                continue
            covered = np.sum(np.all((drawn > low) & (drawn < high), axis=1))
            overlaps = sum(
                low[0] < b[2] and high[0] > b[0] and low[1] < b[3] and high[1] > b[1] for b in taken
            )
            found.append((radius + 25 * covered + 1000 * overlaps, (*low, *high)))
    return min(found)[1]


def _write(ax, label, point, box):
    low, high = np.array(box[:2]), np.array(box[2:])
    to_data = ax.transData.inverted()
    ax.text(
        *to_data.transform((low + high) / 2), label.text, color=label.colour, fontsize=_SIZE,
        ha="center", va="center", in_layout=False,
    )  # fmt: skip
    edge = np.clip(point, low, high)
    if np.hypot(*(edge - point)) > _NEAR:
        ends = to_data.transform([point, edge])
        ax.plot(*ends.T, color=label.colour, linewidth=0.4, zorder=0.5)
