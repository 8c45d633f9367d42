"""Figures of a maneuver: all errors over time, and each column beside the reference."""

from collections.abc import Sequence
from html import escape

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.report import ColumnScore, Curve, Explanation, ManeuverScore
from heyoka_bike.scoring.verdict import TOLERANCE
from heyoka_bike.showing.charts import axis
from heyoka_bike.showing.charts.chart import Level, Line, chart, empty, small, wide
from heyoka_bike.showing.charts.decimate import envelope, highest
from heyoka_bike.showing.document.html import prose
from heyoka_bike.showing.wording import in_unit, label, number, plain, unit_text

_ALL_HEIGHT, _ONE_HEIGHT = 300, 120
# Looks of lines in page.css; columns beyond the eight of the benchmark share them.
_STYLES = 8
_ALL_BINS, _ONE_BINS, _RANGE_BINS = 125, 200, 50
_MOST_DECADES = 10  # of one column's error; it is 0 somewhere, or nearly
_LOWEST = 1e-40


def legend(items: Sequence[tuple[str, str, str]]) -> str:
    """Legend of a figure: name, class and a remark for each line."""
    entries = "".join(
        f'<li data-name="{escape(name)}"><svg class="key" width="30" height="10" '
        f'aria-hidden="true"><path class="{style}" d="M1 5h28"/></svg> {escape(name)}'
        f"{f' <i>{escape(remark)}</i>' if remark else ''}<output></output></li>"
        for name, style, remark in items
    )
    return f'<ul class="legend">{entries}</ul>'


def style_of(key: str) -> str:
    """Class of a column's lines, the same in all figures; the benchmark's eight differ."""
    return f"s{list(COMPARED).index(key) % _STYLES}"


def run_time(maneuvers: Sequence[ManeuverScore]) -> axis.ChartAxis:
    """ChartAxis of the time, over all that is compared; some columns may go further than others."""
    runs = [c.trace.time for m in maneuvers for c in m.columns if len(c.trace.time)]
    return axis.times(
        min((float(t[0]) for t in runs), default=0.0),
        max((float(t[-1]) for t in runs), default=0.0),
    )


def all_errors(m: ManeuverScore) -> str:
    """Errors of all columns over time, each relative to its scale."""
    lines, notches, items, peaks = [], [], [], []
    for c in m.columns:
        name, style, size = label(c.key), style_of(c.key), c.scale
        t, error = highest(c.trace.time, np.abs(c.trace.error), _ALL_BINS)
        remark = "" if len(t) else "not compared"
        if size and len(t):
            lines.append(Line(name, style, t, error / size))
            if error.any():
                peaks += [x / size for x in _range(t, error)]
            else:
                remark = "no error"
        if c.floor and size and len(t):
            notches.append(Level(c.floor / size, style, f"{name}: floor {number(c.floor / size)}"))
        items.append((name, style, remark))
    if not lines:
        return empty("Nothing could be compared.")
    if not peaks:
        return empty("The error is exactly 0 in every row of every column.")
    low, high = min(peaks + [n.value for n in notches]), max(*peaks, 2 * TOLERANCE)
    drawn = chart(
        run_time([m]),
        axis.decades(low, high),
        lines,
        about=f"Errors of all columns of maneuver {m.maneuver} over time, relative to the scale of "
        "each, logarithmic",
        title="error / scale of the column",
        x_title="time [s]",
        height=_ALL_HEIGHT,
        levels=[Level(TOLERANCE, "tolerance", "1e-3 of the scale")],
        notches=notches,
    )
    caption = (
        "How fast the solutions part: the largest error in each short piece of time, divided by "
        "the largest absolute value of the reference. Above the dashed line a column has fewer "
        "than three correct digits."
    )
    if notches:
        caption += (
            " Marks on the right show the floor, the error that correctly rounded values would "
            "have."
        )
    return wide(legend(items) + drawn, caption)


def explained(e: Explanation) -> str:
    """Draw the error that an explanation leaves, in one column of each maneuver."""
    parts = "".join(
        small(f"Maneuver {c.maneuver}, {label(c.key)}", _explained(c)) for c in e.curves
    )
    items = [
        ("against the reference", "before", ""),
        ("against the program that explains it", "after", ""),
    ]
    return (
        f'<div class="wide">{legend(items)}</div><div class="columns">{parts}</div>'
        '<p class="said">Shown is, in each maneuver, the column that it explains best.</p>'
    )


def _explained(c: Curve) -> str:
    unit, name = unit_text(c.unit), label(c.key)
    lines: list[Line] = []
    ends: list[float] = []
    for called, error in (("before", c.before), ("after", c.after)):
        t, points = highest(c.time, error, _ALL_BINS)
        if points.any():
            lines.append(Line(called, called, t, points, unit))
            ends += _range(t, points)
    if not lines:
        return empty("The error is exactly 0 in every row.")
    about = f"Error of the {name} in maneuver {c.maneuver} before and after, logarithmic"
    return chart(
        axis.times(float(c.time[0]), float(c.time[-1])), axis.decades(min(ends), max(ends), 6),
        lines, about=about, title=f"absolute error [{unit}]", x_title="time [s]",
        height=_ONE_HEIGHT,
    )  # fmt: skip


def every_column(m: ManeuverScore) -> str:
    """Each column on top of the reference, and its error below."""
    return f'<div class="columns">{"".join(_one_column(m, c) for c in m.columns)}</div>'


def _one_column(m: ManeuverScore, c: ColumnScore) -> str:
    """A column on top of the reference, and the error below."""
    unit = unit_text(c.unit)
    name = label(c.key)
    if not len(c.trace.time):
        return small(name, empty("Nothing could be compared."))
    time = run_time([m])
    items = [("reference", "reference", ""), ("result", "result", "")]
    parts = [_overlay(time, c, name, unit), _error(time, c, name, unit)]
    items += [(x, x, "") for x in ("error", "floor") if f'class="{x}"' in parts[1]]
    measures = c.as_understood.measures
    said = f"largest error {in_unit(number(measures.max_abs_error, 3), c.unit)}" + (
        f" at {plain(measures.time_of_max)} s" if measures.time_of_max is not None else ""
    )
    if c.floor is not None:
        said += f", floor {in_unit(number(c.floor), c.unit)}"
    if c.missing:
        said += f"; {c.missing} of {c.missing + c.values} values are missing"
    if len(c.trace.time) == 1:
        said += "; one row only"
    return small(name, legend(items) + "".join(parts), prose(said))


def _overlay(time: axis.ChartAxis, c: ColumnScore, name: str, unit: str) -> str:
    t = c.trace
    lines = [
        Line(called, called, *envelope(t.time, values, _ONE_BINS), unit)
        for called, values in (("reference", t.reference), ("result", t.value))
    ]
    low, high = min(line.y.min() for line in lines), max(line.y.max() for line in lines)
    y = axis.values(float(low), float(high))
    about = f"{name} over time: the result on top of the reference"
    return chart(
        time, y, lines, about=about, title=f"{name}{y.offset_text} [{unit}]", x_title="",
        height=_ONE_HEIGHT,
    )  # fmt: skip


def _error(time: axis.ChartAxis, c: ColumnScore, name: str, unit: str) -> str:
    t, error = envelope(c.trace.time, np.abs(c.trace.error), _ONE_BINS)
    title = f"absolute error [{unit}]"
    if not error.any():
        return empty("The error is exactly 0 in every row.")
    low, high = _range(t, error)
    low /= 10  # room for some of what is between the peaks
    if c.floor and c.floor > high * 10.0**-_MOST_DECADES:
        low, high = min(low, c.floor), max(high, c.floor)
    low = max(low, high * 10.0**-_MOST_DECADES)
    levels = [Level(c.floor, "floor", "")] if c.floor and c.floor >= low else []
    tolerance = TOLERANCE * c.scale
    if high > 0.01 * tolerance > 0:
        high = max(high, tolerance)
        levels.append(Level(tolerance, "tolerance", "1e-3 of the scale"))
    about = f"Absolute error of the {name} over time, logarithmic"
    return chart(
        time, axis.decades(low, high, 6), [Line("error", "error", t, error, unit)], about=about,
        title=title, x_title="time [s]", height=_ONE_HEIGHT, levels=levels,
    )  # fmt: skip


def _range(t: Array, error: Array) -> tuple[float, float]:
    """Return the range to show of an error that is not all 0, cut where it crosses zero.

    Nor do the first few rows count, which are exact or nearly so: they leave the chart below.
    """
    _, error = highest(t, error, _RANGE_BINS)
    positive = error[error > 0]
    return max(float(np.quantile(positive, 0.05)), _LOWEST), float(positive.max())
