"""Axes of the charts: where values lie and which of them are written."""

import math
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array

_LEAST = 1e-300


@dataclass(frozen=True, slots=True)
class ChartAxis:
    """A range of values, linear or logarithmic.

    Attributes
    ----------
    low, high
        The ends; their decimal logarithms if logarithmic.
    is_log
    ticks : tuple of (float, str)
        Place from 0 to 1 and label (SVG markup), ascending; an empty label for a line without.
    offset
        Subtracted from the values of a linear axis before anything else, so that small changes
        of large values can be read.
    """

    low: float
    high: float
    is_log: bool
    ticks: tuple[tuple[float, str], ...]
    offset: float = 0.0

    def place(self, values: Array) -> Array:
        """Where values lie, 0 at the lower end and 1 at the upper one; zero is minus infinity."""
        if self.is_log:
            with np.errstate(divide="ignore"):
                values = np.log10(values)
        else:
            values = values - self.offset
        return np.asarray((values - self.low) / (self.high - self.low))

    def at(self, value: float) -> float:
        """Where one value lies."""
        return float(self.place(np.array(value)))

    @property
    def offset_text(self) -> str:
        """Return what follows the name of the quantity: `` − 8.0`` if that is the offset."""
        return f" {'−' if self.offset > 0 else '+'} {abs(self.offset)!r}" if self.offset else ""


def times(start: float, end: float) -> ChartAxis:
    """ChartAxis of a run's time, from its first to its last row."""
    if not end > start:
        start, end = start - 0.5, start + 0.5
    return _linear(start, end, 6)


def values(low: float, high: float) -> ChartAxis:
    """ChartAxis of a quantity with some room around it.

    It spans at least 1e-5 of the values themselves: less is for a figure of errors.
    """
    size = max(abs(low), abs(high))
    middle, half = low / 2 + high / 2, high / 2 - low / 2
    half = max(1.08 * half, 0.5e-5 * size) or 1.0
    offset = 0.0
    if half < 1e-3 * size:
        # Of the axis only, so that a few digits do.
        offset = round(middle, -math.ceil(math.log10(half)))
    return _linear(middle - offset - half, middle - offset + half, 4, offset)


def decades(low: float, high: float, labels: int = 7) -> ChartAxis:
    """Logarithmic axis of whole decades around two positive values, a line for each.

    Parameters
    ----------
    labels
        At most so many of the lines have a label.
    """
    # A quotient of tiny numbers may have become 0.
    low, high = max(low, _LEAST), max(high, _LEAST)
    first, last = math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9)
    last = max(last, first + 1)
    step = next(s for s in (1, 2, 3, 4, 5, 10, 20, 50, 100) if (last - first) // s < labels)
    ticks = tuple(
        ((n - first) / (last - first), "" if n % step else _power(n))
        for n in range(first, last + 1)
    )
    return ChartAxis(first, last, True, ticks)


def spread(low: float, high: float) -> ChartAxis:
    """Logarithmic axis with room at both ends of two positive values; labels at 1, 2 and 5."""
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


def _linear(low: float, high: float, count: int, offset: float = 0.0) -> ChartAxis:
    """Linear axis with about so many labels at 1, 2 or 5 times a power of ten."""
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
