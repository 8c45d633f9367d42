"""Charts as SVG that fill the available width, with text and lines of fixed size.

Horizontal positions are fractions of the width, vertical ones are pixels. The lines are in an inner
SVG that is stretched. A chart has no colours: each line has a class, and the style sheet of the
page defines its look.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.numbers.double import Array

Indices = NDArray[np.intp]
_LEAST_POSITIVE = 1e-300
_SVG_WIDTH, _SVG_HEIGHT = 4000, 2000  # width and height of the inner SVG, in its integer units
_FEW_POINTS = 40  # maximum number of points of a line on which the points are drawn, too


@dataclass(frozen=True, slots=True)
class ChartAxis:
    """A range of values, linear or logarithmic.

    Attributes
    ----------
    low, high
        The ends; their decimal logarithms if logarithmic.
    is_log
    ticks : tuple of (float, str)
        Position from 0 to 1 and label (SVG markup), ascending; the label may be empty.
    offset
        Subtracted from the values of a linear axis, so that small changes of large values can be
        read.
    """

    low: float
    high: float
    is_log: bool
    ticks: tuple[tuple[float, str], ...]
    offset: float = 0.0

    def place(self, values: Array) -> Array:
        """Return positions of values on the axis, from 0 at the lower end to 1 at the upper end.

        On a logarithmic axis the position of zero is minus infinity.
        """
        if self.is_log:
            with np.errstate(divide="ignore"):
                values = np.log10(values)
        else:
            values = values - self.offset
        return np.asarray((values - self.low) / (self.high - self.low))

    def at(self, value: float) -> float:
        """Return the position of one value on the axis; see `place`."""
        return float(self.place(np.array(value)))

    @property
    def offset_text(self) -> str:
        """Text after the name of the quantity, such as `` − 8.0``; empty without an offset."""
        return f" {'−' if self.offset > 0 else '+'} {abs(self.offset)!r}" if self.offset else ""


def times(start: float, end: float) -> ChartAxis:
    """Return the time axis of a run, from its first to its last row."""
    if not end > start:
        start, end = start - 0.5, start + 0.5
    return _ticked(start, end, 6)


def linear(low: float, high: float) -> ChartAxis:
    """Return a linear axis for a range of values, with some room at both ends.

    It spans at least 1e-5 of the values; smaller differences belong in a figure of errors.
    """
    size = max(abs(low), abs(high))
    middle, half = low / 2 + high / 2, high / 2 - low / 2
    half = max(1.08 * half, 0.5e-5 * size) or 1.0
    offset = 0.0
    if half < 1e-3 * size:
        # Round the offset of the axis, because it is shown and should have few digits.
        offset = round(middle, -math.ceil(math.log10(half)))
    return _ticked(middle - offset - half, middle - offset + half, 4, offset)


def decades(low: float, high: float, labels: int = 7) -> ChartAxis:
    """Return a logarithmic axis of whole decades that contains two positive values.

    Each decade has a grid line.

    Parameters
    ----------
    labels
        Maximum number of labelled lines.
    """
    # The values may be quotients that underflowed to 0, which has no logarithm.
    low, high = max(low, _LEAST_POSITIVE), max(high, _LEAST_POSITIVE)
    first, last = math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9)
    last = max(last, first + 1)
    step = next(s for s in (1, 2, 3, 4, 5, 10, 20, 50, 100) if (last - first) // s < labels)
    ticks = tuple(
        ((n - first) / (last - first), "" if n % step else _power(n))
        for n in range(first, last + 1)
    )
    return ChartAxis(first, last, True, ticks)


def spread(low: float, high: float) -> ChartAxis:
    """Return a logarithmic axis around two positive values, labelled at 1, 2 and 5 times 10^n."""
    a, b = math.log10(low), math.log10(high)
    room = max(0.15 * (b - a), 0.05)
    a, b = a - room, b + room / 3
    mantissas = (1, 2, 5) if b - a < 2.2 else (1,)
    found = [
        m * 10.0**n for n in range(math.floor(a), math.ceil(b) + 1) for m in mantissas
        if a <= math.log10(m * 10.0**n) <= b
    ]  # fmt: skip
    ticks = tuple(((math.log10(v) - a) / (b - a), f"{v:g}") for v in found)
    return ChartAxis(a, b, True, ticks)


def _ticked(low: float, high: float, count: int, offset: float = 0.0) -> ChartAxis:
    """Return a linear axis with about `count` labels at 1, 2 or 5 times a power of ten."""
    rough = (high - low) / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough * 0.999)
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    ticks = tuple(
        ((n * step - low) / (high - low), _decimal(n * step, step)) for n in range(first, last + 1)
    )
    return ChartAxis(low, high, False, ticks, offset)


def _decimal(value: float, step: float) -> str:
    places = max(0, -math.floor(math.log10(step) + 1e-9))
    text = f"{value:.{places}f}" if places < 5 and abs(value) < 1e6 else f"{value:.4g}"
    return text.replace("-", "−")


def _power(n: int) -> str:
    if n in (0, 1):
        return str(10**n)
    sign = "−" if n < 0 else ""
    return f'10<tspan class="power" dy="-5">{sign}{abs(n)}</tspan>'


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """A line of a chart, through points.

    Attributes
    ----------
    name
        Name for the legend and the read-out.
    style
        Class of the line.
    x, y : ndarray, shape (n,)
        Values in the units of the axes.
    unit
        Unit of y for the read-out.
    has_points
        True to mark the points, however many there are.
    """

    name: str
    style: str
    x: Array
    y: Array
    unit: str = ""
    has_points: bool = False


@dataclass(frozen=True, slots=True)
class Level:
    """A value with a text: a horizontal line, or a notch at the right end of a chart.

    The text is at the start of the line, where errors are small. For a notch it is a tooltip.
    """

    value: float
    style: str
    text: str


@dataclass(frozen=True, slots=True)
class Guide:
    """A straight thin line between two points, with a text at the first point."""

    x: tuple[float, float]
    y: tuple[float, float]
    text: str


@dataclass(frozen=True, slots=True)
class Mark:
    """A point of a chart, with a label and a tooltip.

    Attributes
    ----------
    x, y
        Values in the units of the axes.
    style
        Class of the point and the label.
    text
        The label.
    about
        The tooltip.
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
    height: int,
    x_title: str = "time [s]",
    levels: Sequence[Level] = (),
    notches: Sequence[Level] = (),
    guides: Sequence[Guide] = (),
    marks: Sequence[Mark] = (),
) -> str:
    """Draw a chart as HTML.

    Parameters
    ----------
    about
        Description for screen readers.
    title, x_title
        Quantity and unit of the axes.
    height
        Height of the area of the lines [px].
    """
    area = _Area(x, y, height)
    below = f'x="100%" y="{height + 33}" text-anchor="end"'
    parts = [
        *area.grid(),
        f'<text class="title" x="0" y="-13">{escape(title)}</text>',
        f'<text class="title" {below}>{escape(x_title)}</text>' if x_title else "",
        f'<svg class="lines" width="100%" height="{height}" '
        f'viewBox="0 0 {_SVG_WIDTH} {_SVG_HEIGHT}" '
        'preserveAspectRatio="none">',
        *map(area.guide, guides),
        *map(area.level, levels),
        *map(area.line, lines),
        "</svg>",
        *map(area.points, lines),
        *map(area.level_text, levels),
        *map(area.guide_text, guides),
        *map(area.notch, notches),
        *map(area.mark, marks),
    ]
    return (
        f'<div class="plot"><svg role="img" aria-label="{escape(about)}" width="100%" '
        f'height="{height}" data-x="{_ends(x)}" data-y="{_ends(y)}">{"".join(parts)}</svg></div>'
    )


def wide(drawn: str, caption: str) -> str:
    """Return a figure as wide as the page with a caption below; empty if there is no chart."""
    return (
        f'<figure class="wide">{drawn}<figcaption>{caption}</figcaption></figure>' if drawn else ""
    )


def small(name: str, drawn: str, said: str = "") -> str:
    """Return a small figure with its name and a remark above the chart."""
    about = f"<b>{escape(name)}</b>{' ' if said else ''}{said}"
    return f"<figure><figcaption>{about}</figcaption>{drawn}</figure>"


def empty(text: str) -> str:
    """Return HTML that shows a text in place of a chart."""
    return f'<p class="empty">{text}</p>'


def _ends(axis: ChartAxis) -> str:
    """Return an axis as text: page.js uses its ends and offset to read values off the chart."""
    return f"{axis.low!r} {axis.high!r} {int(axis.is_log)} {axis.offset!r}"


class _Area:
    """Draws the parts of a chart; horizontal positions are fractions, vertical ones pixels."""

    def __init__(self, x: ChartAxis, y: ChartAxis, height: int) -> None:
        self._x, self._y, self._height = x, y, height

    def _down(self, at: float) -> float:
        """Distance of a position on the y axis (0 to 1) from the upper end [px]."""
        return (1 - at) * self._height

    def grid(self) -> Iterator[str]:
        height = self._height
        below = f'y="{height + 16}" text-anchor="middle"'
        yield '<g class="grid">'
        for at, _ in self._x.ticks:
            yield f'<line x1="{100 * at:.5g}%" x2="{100 * at:.5g}%" y1="0" y2="{height}"/>'
        for at, _ in self._y.ticks:
            down = f"{self._down(at):.5g}"
            yield f'<line x1="0" x2="100%" y1="{down}" y2="{down}"/>'
        yield f'</g><path class="frame" d="M0 0V{height}"/>'
        yield f'<line class="frame" x1="0" x2="100%" y1="{height}" y2="{height}"/>'
        for at, text in self._x.ticks:
            if text:
                yield f'<text x="{100 * at:.5g}%" {below}>{text}</text>'
        for at, text in self._y.ticks:
            if text:
                yield f'<text x="-7" y="{self._down(at) + 4:.5g}" text-anchor="end">{text}</text>'

    def line(self, line: Line) -> str:
        """Return a line as an SVG path of integer steps from point to point."""
        if not len(line.x):
            return ""
        across = np.rint(self._x.place(line.x) * _SVG_WIDTH).astype(int)
        down = (1 - np.clip(self._y.place(line.y), -0.05, 1.05)) * _SVG_HEIGHT
        places = np.column_stack((across, np.rint(down).astype(int)))
        start, steps = places[0].tolist(), np.diff(places, axis=0).tolist()
        text = "".join(f" {a}{b}" if b < 0 else f" {a} {b}" for a, b in steps)
        return (
            f'<path class="{line.style}" data-name="{escape(line.name)}" data-unit='
            f'"{escape(line.unit)}" d="M{start[0]} {start[1]}{"l" + text[1:] if text else ""}"/>'
        )

    def points(self, line: Line) -> str:
        if len(line.x) > _FEW_POINTS and not line.has_points:
            return ""
        found = zip(self._x.place(line.x).tolist(), self._y.place(line.y).tolist(), strict=True)
        dots = "".join(
            f'<circle cx="{100 * a:.5g}%" cy="{self._down(max(b, 0.0)):.5g}" r="2.6"/>'
            for a, b in found
        )
        return f'<g class="points {line.style}" data-name="{escape(line.name)}">{dots}</g>'

    def level(self, level: Level) -> str:
        at = round((1 - self._y.at(level.value)) * _SVG_HEIGHT)
        return f'<path class="{level.style}" d="M0 {at}h{_SVG_WIDTH}"/>'

    def level_text(self, level: Level) -> str:
        at = self._y.at(level.value)
        if not level.text or not 0 <= at <= 1:
            return ""
        # Put the text above its line; near the upper end of the chart, below it.
        down = self._down(at)
        down += 14 if down < 16 else -5
        return f'<text class="note" x="0" dx="5" y="{down:.5g}">{escape(level.text)}</text>'

    def notch(self, notch: Level) -> str:
        down = self._down(min(max(self._y.at(notch.value), 0.0), 1.0))
        return (
            f'<svg class="notch" x="100%" y="{down:.5g}"><title>{escape(notch.text)}'
            f'</title><path class="{notch.style}" d="M2 0h9"/></svg>'
        )

    def guide(self, guide: Guide) -> str:
        a, b = (round(self._x.at(v) * _SVG_WIDTH) for v in guide.x)
        c, d = (round((1 - self._y.at(v)) * _SVG_HEIGHT) for v in guide.y)
        return f'<path class="guide" d="M{a} {c}L{b} {d}"/>'

    def guide_text(self, guide: Guide) -> str:
        a, b = map(self._x.at, guide.x)
        c, d = map(self._y.at, guide.y)
        if c < 0:  # where the line leaves the chart
            a, c = a + (b - a) * c / (c - d), 0.0
        return (
            f'<text class="note" x="{100 * a:.5g}%" dx="5" y="{self._down(c) - 5:.5g}">'
            f"{escape(guide.text)}</text>"
        )

    def mark(self, mark: Mark) -> str:
        across, down = f"{100 * self._x.at(mark.x):.5g}%", self._down(self._y.at(mark.y))
        return (
            f'<g class="points {mark.style}"><title>{escape(mark.about)}</title><circle '
            f'cx="{across}" cy="{down:.5g}" r="3.4"/><text x="{across}" dx="6" y="{down - 4:.5g}">'
            f"{escape(mark.text)}</text></g>"
        )


def envelope(x: Array, y: Array, bins: int) -> tuple[Array, Array]:
    """Return the points with the smallest and the largest y in each bin of x, in order.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Finite values; x ascending.
    bins
        Number of bins. If there are at most twice as many points, all are returned.
    """
    if len(x) <= 2 * bins:
        return x, y
    starts = _starts(x, bins)
    keep = np.zeros(len(x), dtype=bool)
    keep[_where(y, np.minimum, starts)] = True
    keep[_where(y, np.maximum, starts)] = True
    return x[keep], y[keep]


def highest(x: Array, y: Array, bins: int) -> tuple[Array, Array]:
    """Return the points with the largest y in each bin of x; see `envelope`."""
    if len(x) <= bins:
        return x, y
    keep = _where(y, np.maximum, _starts(x, bins))
    return x[keep], y[keep]


def _starts(x: Array, bins: int) -> Indices:
    """Return the index of the first point in each bin that is not empty."""
    edges = np.linspace(x[0], x[-1], bins, endpoint=False)
    starts: Indices = np.searchsorted(x, edges)
    return np.unique(starts[starts < len(x)])


def _where(y: Array, extreme: np.ufunc, starts: Indices) -> Indices:
    """Return the index of the smallest or largest y in each bin, the first if several are equal."""
    bin_of = np.repeat(np.arange(len(starts)), np.diff(np.append(starts, len(y))))
    found = np.flatnonzero(y == extreme.reduceat(y, starts)[bin_of])
    first = np.diff(bin_of[found], prepend=-1) > 0
    return found[first]
