"""Charts as SVG: as wide as their place, letters and lines of fixed size.

Across, places are parts of the width; down, they are pixels. The lines lie in an inner SVG that is
stretched. A chart has no colours of its own: each line has a class, which the page gives a look.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.showing.charts.axis import ChartAxis

_WIDTH, _HEIGHT = 4000, 2000  # steps of the inner SVG
_FEW = 40  # rows that are drawn as points too


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """A line through points.

    Attributes
    ----------
    name
        For the legend and the read-out.
    style
        Class of the line.
    x, y : ndarray, shape (n,)
        Values, as the axes have them.
    unit
        Of y, for the read-out.
    has_points
        Whether its points are marked however many they are.
    """

    name: str
    style: str
    x: Array
    y: Array
    unit: str = ""
    has_points: bool = False


@dataclass(frozen=True, slots=True)
class Level:
    """A horizontal line all the way across, with some text at its start, where errors are small."""

    value: float
    style: str
    text: str


@dataclass(frozen=True, slots=True)
class Notch:
    """A short mark beside the right end of a chart."""

    value: float
    style: str
    text: str


@dataclass(frozen=True, slots=True)
class Guide:
    """A straight thin line between two points, with some text at the first."""

    x: tuple[float, float]
    y: tuple[float, float]
    text: str


@dataclass(frozen=True, slots=True)
class Mark:
    """A point with a word beside it.

    Attributes
    ----------
    x, y
        Values, as the axes have them.
    style
        Class of the point and the word.
    text
        The word.
    about
        For who points at it.
    """

    x: float
    y: float
    style: str
    text: str
    about: str


def chart(
    x: ChartAxis,
    y: ChartAxis,
    lines: Sequence[Line],
    *,
    about: str,
    title: str,
    x_title: str,
    height: int,
    levels: Sequence[Level] = (),
    notches: Sequence[Notch] = (),
    guides: Sequence[Guide] = (),
    marks: Sequence[Mark] = (),
) -> str:
    """A chart as HTML.

    Parameters
    ----------
    about
        What it shows, for those who do not see it.
    title, x_title
        Quantity and unit of the axes.
    height
        Of the area of the lines [px].
    """
    parts = [
        *_grid(x, y, height),
        f'<text class="title" x="0" y="-13">{escape(title)}</text>',
        f'<text class="title" x="100%" y="{height + 33}" text-anchor="end">{escape(x_title)}</text>'
        if x_title
        else "",
        f'<svg class="lines" width="100%" height="{height}" viewBox="0 0 {_WIDTH} {_HEIGHT}" '
        'preserveAspectRatio="none">',
        *(_guide(x, y, g) for g in guides),
        *(_level(y, v) for v in levels),
        *(_path(x, y, line) for line in lines),
        "</svg>",
        *(_points(x, y, line, height) for line in lines),
        *(_level_text(y, v, height) for v in levels),
        *(_guide_text(x, y, g, height) for g in guides),
        *(_notch(y, v, height) for v in notches),
        *(_mark(x, y, m, height) for m in marks),
    ]
    return (
        f'<div class="plot"><svg role="img" aria-label="{escape(about)}" width="100%" '
        f'height="{height}" data-x="{_ends(x)}" data-y="{_ends(y)}">{"".join(parts)}</svg></div>'
    )


def wide(drawn: str, caption: str) -> str:
    """A figure as wide as the page, with its caption below; empty without a chart."""
    return (
        f'<figure class="wide">{drawn}<figcaption>{caption}</figcaption></figure>' if drawn else ""
    )


def small(name: str, drawn: str, said: str = "") -> str:
    """A figure beside others, below its name and what is said of it."""
    about = f"<b>{escape(name)}</b>{' ' if said else ''}{said}"
    return f"<figure><figcaption>{about}</figcaption>{drawn}</figure>"


def empty(text: str) -> str:
    """What stands in place of a chart."""
    return f'<p class="empty">{text}</p>'


def _ends(axis: ChartAxis) -> str:
    """What the read-out needs to find values from places."""
    return f"{axis.low!r} {axis.high!r} {int(axis.is_log)} {axis.offset!r}"


def _grid(x: ChartAxis, y: ChartAxis, height: int) -> list[str]:
    parts = ['<g class="grid">']
    parts += [
        f'<line x1="{100 * at:.5g}%" x2="{100 * at:.5g}%" y1="0" y2="{height}"/>'
        for at, _ in x.ticks
    ]
    parts += [
        f'<line x1="0" x2="100%" y1="{(1 - at) * height:.5g}" y2="{(1 - at) * height:.5g}"/>'
        for at, _ in y.ticks
    ]
    parts += [f'</g><path class="frame" d="M0 0V{height}"/>']
    parts += [f'<line class="frame" x1="0" x2="100%" y1="{height}" y2="{height}"/>']
    parts += [
        f'<text x="{100 * at:.5g}%" y="{height + 16}" text-anchor="middle">{text}</text>'
        for at, text in x.ticks
        if text
    ]
    parts += [
        f'<text x="-7" y="{(1 - at) * height + 4:.5g}" text-anchor="end">{text}</text>'
        for at, text in y.ticks
        if text
    ]
    return parts


def _path(x: ChartAxis, y: ChartAxis, line: Line) -> str:
    """Points as steps from each to the next, in integers."""
    if not len(line.x):
        return ""
    across = np.rint(x.place(line.x) * _WIDTH).astype(int)
    down = (1 - np.clip(y.place(line.y), -0.05, 1.05)) * _HEIGHT
    places = np.column_stack((across, np.rint(down).astype(int)))
    start, steps = places[0].tolist(), np.diff(places, axis=0).tolist()
    text = "".join(f" {a}{b}" if b < 0 else f" {a} {b}" for a, b in steps)
    return (
        f'<path class="{line.style}" data-name="{escape(line.name)}" data-unit='
        f'"{escape(line.unit)}" d="M{start[0]} {start[1]}{"l" + text[1:] if text else ""}"/>'
    )


def _points(x: ChartAxis, y: ChartAxis, line: Line, height: int) -> str:
    if len(line.x) > _FEW and not line.has_points:
        return ""
    found = zip(x.place(line.x).tolist(), y.place(line.y).tolist(), strict=True)
    dots = "".join(
        f'<circle cx="{100 * a:.5g}%" cy="{(1 - max(b, 0.0)) * height:.5g}" r="2.6"/>'
        for a, b in found
    )
    return f'<g class="points {line.style}" data-name="{escape(line.name)}">{dots}</g>'


def _level(y: ChartAxis, level: Level) -> str:
    at = round((1 - y.at(level.value)) * _HEIGHT)
    return f'<path class="{level.style}" d="M0 {at}h{_WIDTH}"/>'


def _level_text(y: ChartAxis, level: Level, height: int) -> str:
    at = y.at(level.value)
    if not level.text or not 0 <= at <= 1:
        return ""
    # Above its line, but below it at the upper end.
    down = (1 - at) * height
    down += 14 if down < 16 else -5
    text = escape(level.text)
    return f'<text class="note" x="0" dx="5" y="{down:.5g}">{text}</text>'


def _guide(x: ChartAxis, y: ChartAxis, guide: Guide) -> str:
    a, b = (round(x.at(v) * _WIDTH) for v in guide.x)
    c, d = (round((1 - y.at(v)) * _HEIGHT) for v in guide.y)
    return f'<path class="guide" d="M{a} {c}L{b} {d}"/>'


def _guide_text(x: ChartAxis, y: ChartAxis, guide: Guide, height: int) -> str:
    a, b = (x.at(v) for v in guide.x)
    c, d = (y.at(v) for v in guide.y)
    if c < 0:  # where the line leaves the chart
        a, c = a + (b - a) * c / (c - d), 0.0
    return (
        f'<text class="note" x="{100 * a:.5g}%" dx="5" y="{(1 - c) * height - 5:.5g}">'
        f"{escape(guide.text)}</text>"
    )


def _mark(x: ChartAxis, y: ChartAxis, mark: Mark, height: int) -> str:
    across, down = f"{100 * x.at(mark.x):.5g}%", (1 - y.at(mark.y)) * height
    return (
        f'<g class="points {mark.style}"><title>{escape(mark.about)}</title><circle '
        f'cx="{across}" cy="{down:.5g}" r="3.4"/><text x="{across}" dx="6" y="{down - 4:.5g}">'
        f"{escape(mark.text)}</text></g>"
    )


def _notch(y: ChartAxis, notch: Notch, height: int) -> str:
    at = min(max(y.at(notch.value), 0.0), 1.0)
    return (
        f'<svg class="notch" x="100%" y="{(1 - at) * height:.5g}"><title>{escape(notch.text)}'
        f'</title><path class="{notch.style}" d="M2 0h9"/></svg>'
    )
