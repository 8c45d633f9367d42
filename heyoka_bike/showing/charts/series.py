"""Figures of a series: error against step size, processor time, and over time."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from heyoka_bike.scoring.report import ColumnScore, Convergence, Run, Series
from heyoka_bike.scoring.verdict import TOLERANCE
from heyoka_bike.showing.charts import axis
from heyoka_bike.showing.charts.chart import Guide, Level, Line, chart, empty, small, wide
from heyoka_bike.showing.charts.decimate import highest
from heyoka_bike.showing.charts.maneuver import legend, run_time, style_of
from heyoka_bike.showing.wording import label, number, run_name

_HEIGHT, _SMALL = 280, 160
_BINS = 125
_MOST_DECADES = 16
# Looks of lines in page.css, those of different colours first.
_APART = (0, 7, 2, 4, 3, 5, 1, 6)
_MOST_ORDER = 12  # of the guides


def convergence(series: Series, maneuver: int) -> str:
    """Error against step size for a maneuver; empty if no step size is known."""
    drawn = _drawing(series, maneuver, [r.step for r in series.runs], is_step=True)
    return wide(
        drawn,
        "What a smaller step buys: a method of order p follows a line of that slope, halving the "
        "step divides its error by 2 to the power p, until the error reaches the floor that the "
        "written digits set (marks on the right).",
    )


def work_precision(series: Series, maneuver: int) -> str:
    """Error against processor time for a maneuver; empty if no time is known."""
    drawn = _drawing(series, maneuver, [r.cpu for r in series.runs], is_step=False)
    return wide(
        drawn,
        "What accuracy costs: of two programs, the one whose line lies lower and further left "
        "gives the same error in less time; the time is that of the whole run.",
    )


def side_by_side(series: Series, maneuver: int) -> str:
    """Error over time of each column, a line for each program."""
    held = [m for run in series.runs for m in run.report.maneuvers if m.maneuver == maneuver]
    time = run_time(held)
    figures = (
        _over_time(c.key, time, list(_error_lines(series, c)))
        for c in series.convergence
        if c.maneuver == maneuver
    )
    return f'<div class="columns">{"".join(figures)}</div>'


def _error_lines(series: Series, c: Convergence) -> Iterator[Line]:
    for i, run in enumerate(series.runs):
        found = _column(run, c.maneuver, c.key)
        if found is not None and found.scale and found.trace.error.any():
            t, error = highest(found.trace.time, np.abs(found.trace.error), _BINS)
            style = f"s{_APART[i % len(_APART)]}"
            yield Line(run_name(series, run), style, t, error / found.scale)


def _over_time(key: str, time: axis.ChartAxis, lines: Sequence[Line]) -> str:
    if not lines:
        return small(label(key), empty("No error in any program."))
    every = np.concatenate([line.y[line.y > 0] for line in lines])
    peak = float(every.max())
    low = max(float(np.quantile(every, 0.05)), peak * 10.0**-_MOST_DECADES)
    drawn = chart(
        time, axis.decades(low, max(peak, 2 * TOLERANCE), 6), lines,
        about=f"Error of the {label(key)} of each program over time, logarithmic",
        title="error / scale of the column", x_title="time [s]", height=_SMALL,
        levels=[Level(TOLERANCE, "tolerance", "1e-3 of the scale")],
    )  # fmt: skip
    items = [(line.name, line.style, "") for line in lines]
    return small(label(key), legend(items) + drawn)


def _column(run: Run, maneuver: int, key: str) -> ColumnScore | None:
    found: Mapping[str, ColumnScore] = run.report.get(maneuver, {})
    return found.get(key)


def _drawing(series: Series, maneuver: int, across: Sequence[float | None], is_step: bool) -> str:
    lines, items, notches = [], [], []
    for c in [c for c in series.convergence if c.maneuver == maneuver]:
        size = max(s.scale for run in series.runs if (s := _column(run, maneuver, c.key)))
        points = _points(across, c.errors, size)
        remark = "" if points else "no error" if set(c.errors) == {0.0} else "not compared"
        items.append((label(c.key), style_of(c.key), remark))
        if points:
            x, y = (np.array(v) for v in zip(*points, strict=True))
            lines.append(Line(label(c.key), style_of(c.key), x, y, has_points=True))
        if points and size and c.floor:
            text = f"{label(c.key)}: floor {number(c.floor / size)}"
            notches.append(Level(c.floor / size, style_of(c.key), text))
    if not lines:
        return ""
    return legend(items) + _chart(series, maneuver, lines, notches, is_step)


def _chart(
    series: Series, maneuver: int, lines: Sequence[Line], notches: Sequence[Level], is_step: bool
) -> str:
    every_x = np.concatenate([line.x for line in lines])
    every_y = np.concatenate([line.y for line in lines])
    low, high = float(every_y.min()), float(every_y.max())
    low = min([low] + [n.value for n in notches if n.value > low * 1e-3])
    x_axis = axis.spread(float(every_x.min()), float(every_x.max()))
    guides = _guides(series, maneuver, lines, x_axis) if is_step else []
    what = "step size" if is_step else "processor time"
    return chart(
        x_axis,
        axis.decades(low, high * 2),
        lines,
        about=f"Errors of all columns of maneuver {maneuver} against {what}, both logarithmic",
        title="largest error / scale of the column",
        x_title=f"{what} [s]",
        height=_HEIGHT,
        notches=[n for n in notches if n.value >= low],
        guides=guides,
    )


def _points(
    across: Sequence[float | None], errors: Sequence[float | None], size: float
) -> list[tuple[float, float]]:
    """Errors relative to the column's size, where both logarithms exist."""
    found = zip(across, errors, strict=True)
    return [(x, e / size) for x, e in found if x and e and size and x > 0 and e > 0]


def _guides(
    series: Series, maneuver: int, lines: Sequence[Line], x_axis: axis.ChartAxis
) -> list[Guide]:
    """Lines of whole orders around the observed ones, from the largest error downwards."""
    found = (p for c in series.convergence if c.maneuver == maneuver for p in c.orders)
    orders = [p for p in found if p is not None and 0.5 <= p <= _MOST_ORDER]
    if not orders:
        return []
    wide = max(float(line.x.max()) for line in lines)
    narrow = 10.0**x_axis.low
    top = 1.6 * max(float(line.y[line.x == wide].max(initial=0.0)) for line in lines)
    if not top:
        return []
    middle = round(float(np.median(orders)))
    chosen = sorted({max(middle - 1, 1), max(middle, 1), middle + 1})
    return [
        Guide((narrow, wide), (math.exp(math.log(top) + p * math.log(narrow / wide)), top),
              f"p = {p}")
        for p in chosen
    ]  # fmt: skip
