"""The replay as one self-contained HTML page: a scene, its controls, and charts.

`animate` makes the page, in Python and for the command of that name, to view or as a file.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from os import PathLike
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.bicycle.shapes import shape
from heyoka_bike.errors import InputError, printable, quoted
from heyoka_bike.numbers.double import Array, with_usual_errors
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.reading.given import results_of
from heyoka_bike.scoring.reading.source import ARRAY
from heyoka_bike.showing.charts.chart import ChartAxis, Line, chart, linear, times
from heyoka_bike.showing.charts.results import legend
from heyoka_bike.showing.document.html import PAGE_STYLE, capital, page, prose
from heyoka_bike.showing.wording.grade_text import SIGNS, file_grade, style_of
from heyoka_bike.showing.wording.number_text import sentence
from heyoka_bike.showing.wording.origin_text import reference_words
from heyoka_bike.showing.wording.verdict_text import graded
from heyoka_bike.system.files import refuse_overwriting, write_output
from heyoka_bike.workbench.replay.motion_3d import Motion3D
from heyoka_bike.workbench.replay.scenes import Replay, Scene, replay

STYLE = Path(__file__).with_name("replay.css")
SCRIPT = Path(__file__).with_name("replay.js")
"""Script of the stage: ``replay(data)`` draws `drawing` and the motions in it."""
PITCH_SCRIPT = Path(__file__).with_name("pitch.js")
"""Script for pages that compute a motion themselves: ``pitchOnTheFloor``."""

_STAGE = Template(Path(__file__).with_name("stage.html").read_text(encoding="utf-8"))
_ABOUT_PAGE = Path(__file__).with_name("about.html").read_text(encoding="utf-8")

_CHART_HEIGHT = 84  # height of a chart's plot area [px]
_PANELS = (
    ("roll_angle", "roll", "rad"),
    ("steer_angle", "steer", "rad"),
    ("forward_speed", "forward speed", "m/s"),
)
_ENERGY_LINES = (
    ("kinetic_energy", "kinetic", "s4"),
    ("potential_energy", "potential", "s3"),
    ("mechanical_energy", "mechanical", "s5"),
)
_SHORT_NAMES = {
    "roll_angle": "roll", "steer_angle": "steer", "forward_speed": "speed",
    "roll_rate": "roll_rate", "steer_rate": "steer_rate",
}  # fmt: skip
START = 'replay(JSON.parse(document.getElementById("data").textContent));\n'
"""Call of `SCRIPT` on pages where nothing else starts it."""
_COUNTED = ("rear_wheel", "front_wheel", "track")
# Number of decimal places of positions, angles and speeds [m, rad, m/s]. The last place is finer
# than a pixel at any camera distance and any exaggeration of roll and steer.
_DECIMALS_OF_PLACES = 6
# Number of significant digits of a difference between two motions, which the page may magnify a
# million times.
_DIGITS_OF_DRAWING = 5


_PAGE_SUFFIXES = (".html", ".htm")
_FILMS = (".gif", ".mp4")
_NOTEBOOK_HEIGHT = 720  # height of the page in a notebook [px]


@dataclass(frozen=True, repr=False, slots=True)
class Page:
    """The page of a replay: a notebook shows it, and ``page.save("replay.html")`` writes it.

    Attributes
    ----------
    html
        HTML of the whole page.
    """

    html: str

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the page to a file, completely or not at all."""
        write_output(Path(path), self.html.encode())
        return Path(path)

    def __repr__(self) -> str:
        return f"<replay of {len(self.html) / 1e6:.1f} MB, for a notebook or .save(...)>"

    def _repr_html_(self) -> str:
        # The iframe isolates the script of the page from the notebook.
        return (
            f'<iframe sandbox="allow-scripts" srcdoc="{escape(self.html)}" title="replay" '
            f'style="width: 100%; height: {_NOTEBOOK_HEIGHT}px; border: 0"></iframe>'
        )


@with_usual_errors
def animate(
    results: Any = None,
    path: str | PathLike[str] | None = None,
    *,
    maneuver: int | None = None,
    reference: Reference | str | PathLike[str] | None = None,
    **named: Any,
) -> Page | Path:
    """Replay the maneuvers in 3D, with results next to the reference.

    Parameters
    ----------
    results
        Results in a form that `score` accepts; without any, only the reference is shown.
    path
        The file to write, .html; by default nothing is written.
    maneuver
        Show only this maneuver, which results of a single maneuver then belong to; by default all.
    reference
        Result of `load_reference`, or the folder of a dataset; by default the published one.
    named
        Columns by name, as in `score`.

    Returns
    -------
    Page or Path
        The page for a notebook, or the file that is written.

    Raises
    ------
    InputError, NothingScoredError
        See `score`; also if the path has another format or cannot be written.
    """
    known = load_reference(reference)
    if path is not None:
        check_suffix(Path(path))
    if maneuver is not None and maneuver not in known:
        raise InputError(f"found maneuver {maneuver!r:.40}, expected 1 to {len(known)}")
    given = None
    if results is not None or named:
        given = results_of(results, len(known), maneuver=maneuver, named=named, is_only=False)
    if path is not None:
        refuse_overwriting([r.path for r in given or ()], [Path(path)])
    found = replay(known, given, maneuver)
    name = found.report.file.path if found.report else ""
    shown = Page(render(found, "results" if name == ARRAY else name))
    return shown if path is None else shown.save(path)


def check_suffix(path: Path, option: str = "path") -> None:
    """Raise `InputError` if a file name is not that of a page; `option` names it in the error."""
    suffix = path.suffix.lower()
    if suffix in _PAGE_SUFFIXES:
        return
    more = ": a page, from which a browser's screen recorder makes a film" * (suffix in _FILMS)
    raise InputError(
        f"{option}: found {quoted(path.name)}, expected a name ending in "
        f"{' or '.join(_PAGE_SUFFIXES)}{more}"
    )


def render(replay: Replay, name: str = "") -> str:
    """Return the replay as an HTML page; `name` is that of the result file, if there is one."""
    title = printable(Path(name).name or name) if name else "The reference"
    body = f"""{_header(replay, title, bool(name))}
<div class="replay{" compared" if name else ""}">
{stage([(str(s.number), _name(s)) for s in replay.scenes], bool(name))}
{_plots(replay.scenes)}
</div>
{_about(replay, bool(name))}"""
    return page(
        f"{title} – replay",
        body,
        reference_words(replay.bicycle.name, replay.dataset_version),
        styles=(PAGE_STYLE, STYLE),
        script=SCRIPT.read_text(encoding="utf-8") + START,
        data=_data(replay),
    )


def _header(replay: Replay, title: str, has_result: bool) -> str:
    kicker = f"Uncontrolled bicycle: replay{' of' * has_result}"
    said = ""
    if replay.report is not None:
        report = replay.report
        sign, words = SIGNS.get(file_grade(report), ""), capital(sentence(graded(report)))
        shown = f'<span aria-hidden="true">{sign}</span> {prose(words)}' if sign else prose(words)
        said = f'<p class="verdict {style_of(report)}">{shown}.</p>'
    return f'<header><p class="kicker">{kicker}</p><h1>{escape(title)}</h1>{said}</header>'


def stage(scenes: Sequence[tuple[str, str]], has_result: bool) -> str:
    """Return the scene with its controls, as HTML.

    Parameters
    ----------
    scenes
        Numbers and names to choose from.
    has_result
        True if results are shown next to the reference.
    """
    keys = result = ""
    if has_result:
        keys = (
            '<ul class="legend keys"><li><span class="swatch mine"></span> reference</li>'
            '<li><span class="swatch result"></span> result</li></ul>'
        )
        result = (
            '<label><input type="checkbox" name="result" checked> result</label>'
            '<label class="menu">difference <select name="magnify"></select></label>'
        )
    return _STAGE.substitute(keys=keys, result=result, maneuver=_choice(scenes))


def _choice(scenes: Sequence[tuple[str, str]]) -> str:
    """Return HTML to choose a maneuver, initially the first; hidden if there is only one."""
    options = "".join(
        f'<label><input type="radio" name="maneuver" value="{escape(number)}"'
        f"{'' if i else ' checked'}><span>{escape(name)}</span></label>"
        for i, (number, name) in enumerate(scenes)
    )
    hidden = " hidden" if len(scenes) < 2 else ""
    return f'<fieldset class="choice"{hidden}><legend>Maneuver</legend>{options}</fieldset>'


def _name(scene: Scene) -> str:
    """Return the number of a maneuver, and its name if the name adds information."""
    is_plain = scene.name == f"maneuver {scene.number}"
    return str(scene.number) if is_plain else f"{scene.number}: {printable(scene.name)}"


def _plots(scenes: Sequence[Scene]) -> str:
    """Return the charts of all maneuvers; the script shows only those of the chosen one."""
    groups = "".join(
        f'<div class="group" data-maneuver="{s.number}"><h2>Maneuver {escape(_name(s))}</h2>'
        f"{''.join(_charts(s))}</div>"
        for s in scenes
    )
    return f'<section class="plots" aria-label="Charts over time">{groups}</section>'


def _charts(scene: Scene) -> list[str]:
    exact, result = scene.reference, scene.result
    time = times(0.0, float(exact.motion.time[-1]))
    found = []
    for name, title, unit in _PANELS:
        lines = [Line("reference", "mine", exact.motion.time, exact.columns[name])]
        if result is not None and name in result.columns:
            lines.append(Line("result", "result", result.motion.time, result.columns[name]))
        found.append(_chart(scene, time, lines, title, unit))
    lines, items = [], []
    for name, said, style in _ENERGY_LINES:
        items.append((said, style, ""))
        start = exact.columns[name][0]
        lines.append(Line(said, style, exact.motion.time, exact.columns[name] - start))
        if result is not None and name in result.columns:
            change = result.columns[name] - start
            lines.append(Line(f"{said} of the result", "thin result", result.motion.time, change))
    if len(lines) > len(_ENERGY_LINES):
        items.append(("result", "thin result", ""))
    keys = legend(items)
    found.append(f"{_chart(scene, time, lines, 'change of energy', 'J')}{keys}")
    return [f"<figure>{one}</figure>" for one in found]


def _chart(scene: Scene, time: ChartAxis, lines: Sequence[Line], title: str, unit: str) -> str:
    own = [line.y for line in lines if line.style != "result"]
    low, high = min(float(y.min()) for y in own), max(float(y.max()) for y in own)
    # A result that is far off must not compress the curve of the reference. So it may extend the
    # range of the chart on either side by at most the range of the reference.
    room = 1.0 * (high - low)
    for line in lines:
        low = min(low, max(float(line.y.min()), low - room))
        high = max(high, min(float(line.y.max()), high + room))
    y = linear(low, high)
    return chart(
        time, y, lines, about=f"{title.capitalize()} over time, maneuver {scene.number}",
        title=f"{title}{y.offset_text} [{unit}]", x_title="", height=_CHART_HEIGHT,
    )  # fmt: skip


def _about(replay: Replay, has_result: bool) -> str:
    parts = []
    for s in replay.scenes if has_result else ():
        notes = s.notes if s.result is None else s.result.notes
        items = "".join(f"<li>{prose(sentence(note))}</li>" for note in notes)
        parts.append(
            f'<section class="notes" data-maneuver="{s.number}"><h2>Notes on the result'
            f"{f', maneuver {s.number}' if len(replay.scenes) > 1 else ''}</h2>"
            f"<ul>{items}</ul></section>"
        )
    parts.append(_ABOUT_PAGE)
    return "\n".join(parts)


def drawing(bicycle: Bicycle) -> dict[str, Any]:
    """Return the drawing of a bicycle for the script, as JSON values."""
    drawn = shape(bicycle)
    return {
        "points": {name: _rounded(point) for name, point in drawn.points.items()},
        "radii": drawn.radii,
        "tilt": drawn.tilt,
        "solids": [
            {"body": s.body, "part": s.part, "colour": s.colour,
             "spheres": [_rounded(sphere) for sphere in s.spheres]}
            for s in drawn.solids
        ],
    }  # fmt: skip


def _data(replay: Replay) -> str:
    data = {
        "bicycle": drawing(replay.bicycle),
        "maneuvers": [_scene_data(s) for s in replay.scenes],
    }
    # The data contain only numbers and names of this package, so no text in them can end the script
    # element.
    return json.dumps(data, separators=(",", ":"), allow_nan=False)


def _scene_data(scene: Scene) -> dict[str, Any]:
    motion, result = scene.reference.motion, scene.result
    exact = _columns(motion, scene.reference.columns)
    found: dict[str, Any] = {
        "number": scene.number,
        "duration": float(motion.time[-1]),
        "columns": {name: _rounded(values) for name, values in exact.items()},
        "result": None,
    }
    if result is not None:
        rows = slice(result.first, result.first + len(result.motion.time))
        differences = {
            name: values - exact[name][rows]
            for name, values in _columns(result.motion, result.columns).items()
        }
        # Wheel angles and tracks of a result start at 0 in its first frame, so their differences
        # are relative to that frame.
        for name in _COUNTED:
            differences[name] = differences[name] - differences[name][0]
        found["result"] = {
            "first": result.first,
            "differences": {name: _few_digits(x) for name, x in differences.items()},
            "resolution": {_SHORT_NAMES[name]: x for name, x in result.resolution.items()},
        }
    return found


def _columns(motion: Motion3D, columns: Mapping[str, Array]) -> dict[str, Array]:
    """Return the quantities from which the script derives the positions of all parts."""
    return {
        "yaw": motion.yaw, "pitch": motion.pitch,
        "x": motion.rear_contact[:, 0], "y": motion.rear_contact[:, 1],
        "front_x": motion.front_contact[:, 0], "front_y": motion.front_contact[:, 1],
        "rear_wheel": motion.rear_wheel, "front_wheel": motion.front_wheel,
        "track": motion.rear_track,
        **{short: columns[name] for name, short in _SHORT_NAMES.items() if name in columns},
        "roll": motion.roll, "steer": motion.steer,
    }  # fmt: skip


def _rounded(values: Any) -> list[float]:
    # Adding 0.0 turns -0.0 into 0.0.
    return [float(x) for x in np.round(np.asarray(values, dtype=float), _DECIMALS_OF_PLACES) + 0.0]


def _few_digits(values: Array) -> list[float]:
    return [float(f"{x:.{_DIGITS_OF_DRAWING - 1}e}") for x in values]
