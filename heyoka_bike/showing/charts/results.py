"""Figures of results: errors over time, against step and processor time, and by definition."""

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED, DEFINITIONS
from heyoka_bike.errors import printable
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence.words import counted, ratio_words, unit_text
from heyoka_bike.scoring.explanation import Curve, Explanation
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.runs import Run, Series
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.showing.charts import chart as draw
from heyoka_bike.showing.charts.chart import ChartAxis, Level, Line, chart, empty, small, wide
from heyoka_bike.showing.document.html import prose
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.showing.wording.number_text import in_unit, number, plain
from heyoka_bike.showing.wording.run_text import run_name

_ALL_HEIGHT, _COST_HEIGHT, _PROGRAMS_HEIGHT, _ONE_HEIGHT = 300, 280, 160, 120
# Number of line styles in page.css; columns beyond the benchmark's eight reuse them.
_STYLES = 8
_APART = (0, 7, 2, 4, 3, 5, 1, 6)  # order of the styles that makes neighbours differ most in colour
_ALL_BINS, _ONE_BINS, _RANGE_BINS = 125, 200, 50
# Maximum number of decades shown for the error of one column, and for the errors of several
# programs. Without these limits, an error that crosses zero would be shown over many more decades.
_MOST_DECADES, _MOST_OF_PROGRAMS = 10, 16
_LOWEST_ERROR = 1e-40
_MOST_ORDER = 12  # largest observed order that the guides take into account
_RELATIVE = "error / largest value of the column"
_LEVEL_OF_TOLERANCE = Level(TOLERANCE, "tolerance", "1e-3 of the largest value")


def legend(items: Sequence[tuple[str, str, str]]) -> str:
    """Draw the legend of a figure from the name, CSS class and remark of each line."""
    entries = "".join(
        f'<li data-name="{escape(name)}"><svg class="key" width="30" height="10" '
        f'aria-hidden="true"><path class="{style}" d="M1 5h28"/></svg> {escape(name)}'
        f"{f' <i>{escape(remark)}</i>' if remark else ''}<output></output></li>"
        for name, style, remark in items
    )
    return f'<ul class="legend">{entries}</ul>'


def _style_of(key: str) -> str:
    """Return the CSS class of a column's lines, a different one for each benchmark column."""
    return f"s{list(COMPARED).index(key) % _STYLES}"


def run_time(maneuvers: Sequence[ManeuverScore]) -> ChartAxis:
    """Return a time axis that covers the compared rows of all columns of the maneuvers."""
    runs = [c.trace.time for m in maneuvers for c in m.columns if len(c.trace.time)]
    return draw.times(
        min((float(t[0]) for t in runs), default=0.0),
        max((float(t[-1]) for t in runs), default=0.0),
    )


def all_errors(m: ManeuverScore) -> str:
    """Draw the errors of all columns over time, each relative to its scale."""
    lines, notches, items, peaks = [], [], [], []
    for c in m.columns:
        name, style, size = label(c.key), _style_of(c.key), c.scale
        t, error = draw.highest(c.trace.time, np.abs(c.trace.error), _ALL_BINS)
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
    about = f"Errors of all columns of maneuver {m.maneuver} over time, relative to the largest "
    about += "value of the column, logarithmic"
    drawn = chart(
        run_time([m]), draw.decades(low, high), lines, about=about, title=_RELATIVE,
        height=_ALL_HEIGHT, levels=[_LEVEL_OF_TOLERANCE], notches=notches,
    )  # fmt: skip
    caption = (
        "How fast the solutions separate: the largest error in each short time interval, divided "
        "by the largest absolute value of the reference. Above the dashed line a column has fewer "
        "than three correct digits."
    )
    if notches:
        caption += (
            " Marks on the right show the floor, the largest error of exact values after rounding "
            "to the digits of the file."
        )
    return wide(legend(items) + drawn, caption)


def explained(e: Explanation) -> str:
    """Draw the error of one column per maneuver, with and without the cause that explains it."""
    parts = "".join(
        small(f"Maneuver {c.maneuver}, {label(c.key)}", _explained(c)) for c in e.curves
    )
    items = [
        ("relative to the reference", "before", ""),
        ("relative to the program with this cause", "after", ""),
    ]
    return (
        f'<div class="wide">{legend(items)}</div><div class="columns">{parts}</div>'
        '<p class="said">For each maneuver, the column that is explained best is shown.</p>'
    )


def _explained(c: Curve) -> str:
    unit = unit_text(c.unit)
    lines: list[Line] = []
    ends: list[float] = []
    for called, error in (("before", c.before), ("after", c.after)):
        t, points = draw.highest(c.time, error, _ALL_BINS)
        if points.any():
            lines.append(Line(called, called, t, points, unit))
            ends += _range(t, points)
    if not lines:
        return empty("The error is exactly 0 in every row.")
    about = f"Error of the {label(c.key)} in maneuver {c.maneuver} before and after, logarithmic"
    time, error_axis = draw.times(*c.time[[0, -1]].tolist()), draw.decades(min(ends), max(ends), 6)
    title = f"absolute error [{unit}]"
    return chart(time, error_axis, lines, about=about, title=title, height=_ONE_HEIGHT)


def every_column(m: ManeuverScore, columns: Sequence[ColumnScore]) -> str:
    """Draw each column on top of the reference, with its error below."""
    return f'<div class="columns">{"".join(_one_column(m, c) for c in columns)}</div>'


def _one_column(m: ManeuverScore, c: ColumnScore) -> str:
    """Draw a column on top of the reference, with its error below."""
    unit, name = unit_text(c.unit), label(c.key)
    if not len(c.trace.time):
        return small(name, empty("Nothing could be compared."))
    time = run_time([m])
    items = [("reference", "reference", ""), ("result", "result", "")]
    parts = [_overlay(time, c, name, unit), _error(time, c, name, unit)]
    items += [(x, x, "") for x in ("error", "floor") if f'class="{x}"' in parts[1]]
    said = f"largest error {in_unit(number(c.max_abs_error, 3), c.unit)}"
    if c.time_of_max is not None:
        said += f" at {plain(c.time_of_max)} s"
    if c.floor is not None:
        said += f", floor {in_unit(number(c.floor), c.unit)}"
    if c.missing:
        are = "is" if c.missing == 1 else "are"
        said += f"; {c.missing} of {counted(c.missing + c.values, 'value')} {are} missing"
    if len(c.trace.time) == 1:
        said += "; one row only"
    return small(name, legend(items) + "".join(parts), prose(said))


def _overlay(time: ChartAxis, c: ColumnScore, name: str, unit: str) -> str:
    t = c.trace
    lines = [
        Line(called, called, *draw.envelope(t.time, values, _ONE_BINS), unit)
        for called, values in (("reference", t.reference), ("result", t.value))
    ]
    low, high = min(line.y.min() for line in lines), max(line.y.max() for line in lines)
    y = draw.linear(float(low), float(high))
    about = f"{name} over time: the result on top of the reference"
    title = f"{name}{y.offset_text} [{unit}]"
    return chart(time, y, lines, about=about, title=title, x_title="", height=_ONE_HEIGHT)


def _error(time: ChartAxis, c: ColumnScore, name: str, unit: str) -> str:
    t, error = draw.envelope(c.trace.time, np.abs(c.trace.error), _ONE_BINS)
    if not error.any():
        return empty("The error is exactly 0 in every row.")
    low, high = _range(t, error)
    low /= 10  # leaves room for the smaller errors between the peaks
    if c.floor and c.floor > high * 10.0**-_MOST_DECADES:
        low, high = min(low, c.floor), max(high, c.floor)
    low = max(low, high * 10.0**-_MOST_DECADES)
    levels = [Level(c.floor, "floor", "")] if c.floor and c.floor >= low else []
    tolerance = TOLERANCE * c.scale
    if high > 0.01 * tolerance > 0:
        high = max(high, tolerance)
        levels.append(Level(tolerance, _LEVEL_OF_TOLERANCE.style, _LEVEL_OF_TOLERANCE.text))
    return chart(
        time, draw.decades(low, high, 6), [Line("error", "error", t, error, unit)],
        about=f"Absolute error of the {name} over time, logarithmic",
        title=f"absolute error [{unit}]", height=_ONE_HEIGHT, levels=levels,
    )  # fmt: skip


def _range(t: Array, error: Array) -> tuple[float, float]:
    """Return the smallest and the largest error that a chart should show.

    Low values, where the error crosses zero or in the nearly exact first rows, are below the range.
    """
    _, error = draw.highest(t, error, _RANGE_BINS)
    positive = error[error > 0]
    return max(float(np.quantile(positive, 0.05)), _LOWEST_ERROR), float(positive.max())


def gains_and_costs(series: Series, maneuver: int) -> str:
    """Draw error against step size, and against processor time; empty if neither is known."""
    drawn = [f(series, maneuver) for f in (convergence, work_precision)]
    return f'<div class="columns">{"".join(drawn)}</div>' if all(drawn) else "".join(drawn)


def convergence(series: Series, maneuver: int) -> str:
    """Draw error against step size for a maneuver; empty if no step size is known."""
    return wide(
        _against("step size", series, maneuver, [r.step for r in series.runs]),
        "Error against step: a method of order p follows a line of slope p, because halving the "
        "step divides its error by 2 to the power p. The line ends at the floor of the digits "
        "written (marks on the right).",
    )


def work_precision(series: Series, maneuver: int) -> str:
    """Draw error against processor time for a maneuver; empty if no time is known."""
    return wide(
        _against("processor time", series, maneuver, [r.cpu for r in series.runs]),
        "Error against processor time of the whole run: the lower and further left a line lies, "
        "the less time the program takes for the same error.",
    )


def _against(what: str, series: Series, maneuver: int, across: Sequence[float | None]) -> str:
    """Draw the relative errors of a maneuver's columns against step size or processor time.

    Both axes are logarithmic.
    """
    lines, items, notches, orders = [], [], [], []
    for c in [c for c in series.convergence if c.maneuver == maneuver]:
        name, style = label(c.key), _style_of(c.key)
        size = max(s.scale for run in series.runs if (s := _column(run, maneuver, c.key)))
        found = zip(across, c.errors, strict=True)
        points = [(x, e / size) for x, e in found if x and e and size and x > 0 and e > 0]
        remark = "" if points else "no error" if set(c.errors) == {0.0} else "not compared"
        items.append((name, style, remark))
        orders += [p for p in c.orders if p is not None and 0.5 <= p <= _MOST_ORDER]
        if points:
            x, y = (np.array(v) for v in zip(*points, strict=True))
            lines.append(Line(name, style, x, y, has_points=True))
        if points and c.floor:
            notches.append(Level(c.floor / size, style, f"{name}: floor {number(c.floor / size)}"))
    if not lines:
        return ""
    every_x = np.concatenate([line.x for line in lines])
    every_y = np.concatenate([line.y for line in lines])
    low, high = float(every_y.min()), float(every_y.max())
    low = min([low] + [n.value for n in notches if n.value > low * 1e-3])
    x_axis = draw.spread(float(every_x.min()), float(every_x.max()))
    is_step = what == "step size"
    drawn = chart(
        x_axis, draw.decades(low, high * 2), lines,
        about=f"Errors of all columns of maneuver {maneuver} against {what}, both logarithmic",
        title=f"largest {_RELATIVE}", x_title=f"{what} [s]", height=_COST_HEIGHT,
        notches=[n for n in notches if n.value >= low],
        guides=_guides(orders, lines, x_axis) if is_step and orders else (),
    )  # fmt: skip
    return legend(items) + drawn


def _guides(orders: Sequence[float], lines: Sequence[Line], x_axis: ChartAxis) -> list[draw.Guide]:
    """Return straight lines with integer slopes near the observed orders of convergence."""
    widest, narrow = max(float(line.x.max()) for line in lines), 10.0**x_axis.low
    top = 1.6 * max(float(line.y[line.x == widest].max(initial=0.0)) for line in lines)
    if not top:
        return []
    middle = round(float(np.median(orders)))
    guides = []
    for p in sorted({max(middle - 1, 1), max(middle, 1), middle + 1}):
        y = math.exp(math.log(top) + p * math.log(narrow / widest)), top
        guides.append(draw.Guide((narrow, widest), y, f"p = {p}"))
    return guides


def _column(run: Run, maneuver: int, key: str) -> ColumnScore | None:
    held = run.report.get(maneuver)
    return held.get(key) if held else None


def side_by_side(series: Series, maneuver: int) -> str:
    """Draw the error of each column over time, with a line for each program."""
    time = run_time([m for run in series.runs for m in run.report.maneuvers
                     if m.maneuver == maneuver])  # fmt: skip
    figures = (
        small(label(c.key), _programs(series, maneuver, c.key, time))
        for c in series.convergence
        if c.maneuver == maneuver
    )
    return f'<div class="columns">{"".join(figures)}</div>'


def _programs(series: Series, maneuver: int, key: str, time: ChartAxis) -> str:
    lines = []
    for i, run in enumerate(series.runs):
        c = _column(run, maneuver, key)
        if c is not None and c.scale and c.trace.error.any():
            t, error = draw.highest(c.trace.time, np.abs(c.trace.error), _ALL_BINS)
            style = f"s{_APART[i % len(_APART)]}"
            lines.append(Line(run_name(series, run), style, t, error / c.scale))
    if not lines:
        return empty("No error in any program.")
    every = np.concatenate([line.y[line.y > 0] for line in lines])
    peak = float(every.max())
    low = max(float(np.quantile(every, 0.05)), peak * 10.0**-_MOST_OF_PROGRAMS)
    drawn = chart(
        time, draw.decades(low, max(peak, 2 * TOLERANCE), 6), lines,
        about=f"Error of the {label(key)} of each program over time, logarithmic",
        title=_RELATIVE, height=_PROGRAMS_HEIGHT, levels=[_LEVEL_OF_TOLERANCE],
    )  # fmt: skip
    return legend([(line.name, line.style, "") for line in lines]) + drawn


def definitions(m: ManeuverScore) -> str:
    """Draw the error of each column in each of its definitions; empty if all have only one."""
    tables = [_definitions(c, m.maneuver) for c in m.compared if c.alternatives]
    return wide(
        "".join(tables),
        "Programs use the same name for different quantities. The full dot is the definition that "
        "fits the file best; the open dots show the errors with the other definitions, on a "
        "logarithmic scale.",
    )


def _definitions(c: ColumnScore, maneuver: int) -> str:
    """Return a table of the definitions of a column; a dot in each row shows the error."""
    found: list[tuple[str, float | None, float | None]]
    found = [(c.definition, c.max_abs_error, None)]
    found += [(a.definition, a.max_abs_error, a.log10_odds) for a in c.alternatives]
    found.sort(key=lambda x: math.inf if x[1] is None else x[1])
    errors = [e for _, e, _ in found if e]
    low = math.floor(math.log10(min(errors))) if errors else 0
    high = max(math.ceil(math.log10(max(errors))), low + 1) if errors else 1
    unit = escape(unit_text(c.unit))
    rows = "".join(_definition(c, name, error, odds, low, high) for name, error, odds in found)
    return (
        f'<div class="scroll" tabindex="0" role="group" aria-label="Definitions of the '
        f'{escape(label(c.key))}, maneuver {maneuver}"><table class="dots">'
        f"<caption>{escape(label(c.key))}</caption>"
        f'<thead><tr><th scope="col">definition</th><th scope="col">max error [{unit}]</th>'
        f'<th scope="col" class="ends"><span>1e{low}</span><span>1e{high}</span></th>'
        '<th scope="col">odds against</th><th scope="col">meaning</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _definition(
    c: ColumnScore, name: str, error: float | None, odds: float | None, low: int, high: int
) -> str:
    is_it = name == c.definition
    dot = ""
    if error is not None:
        at = (math.log10(error) - low) / (high - low) if error > 0 else 0.0
        style = "full" if is_it else "open"
        dot = f'<circle class="{style}" cx="{100 * at:.4g}%" cy="9" r="4.5"/>'
    count = high - low
    places = (f"{100 * n / count:.4g}%" for n in range(0, count + 1, 1 if count <= 20 else 5))
    ticks = "".join(f'<line x1="{at}" x2="{at}" y1="0" y2="18"/>' for at in places)
    said = escape(printable(name.replace("_", " ")))
    if name == c.as_written.definition:
        said += " <i>(default)</i>"
    if name in c.indistinguishable and not is_it:
        said += " <i>(fits as well)</i>"
    meaning = next((d.meaning for d in DEFINITIONS.get(c.key, ()) if d.definition == name), "")
    return (
        f'<tr{" class=chosen" if is_it else ""}><th scope="row">{said}</th>'
        f'<td class="n">{number(error, 3)}</td><td class="dot"><svg width="100%" height="18" '
        f'aria-hidden="true"><g class="grid">{ticks}</g>{dot}</svg></td>'
        f'<td class="n">{"" if odds is None else ratio_words(odds)}</td>'
        f'<td class="prose">{escape(meaning)}</td></tr>'
    )
