"""The checker as one HTML page without a server; it contains the C header as WebAssembly.

``docs/_site/checker_wasm.py`` builds the WebAssembly from the header, with clang and lld. The
result is stored next to this module.
"""

import json
from base64 import b64encode
from collections.abc import Callable, Sequence
from pathlib import Path
from string import Template
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS, RATE_OF
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.outputs import yaw_rate
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import Configuration, track_speeds, wheel_rates
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.straight_line import JAVASCRIPT, StraightLine
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring import recognition
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.grades import LIMITS, Grade
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.reading.names.heading import KEYS, TIME, may_mean
from heyoka_bike.scoring.reading.names.heading_units import quantities
from heyoka_bike.scoring.units import UNITS
from heyoka_bike.showing.document.html import PAGE_STYLE, page
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.showing.wording.grade_text import MEANINGS, SIGNS, WORDS
from heyoka_bike.showing.wording.origin_text import reference_words
from heyoka_bike.showing.wording.verdict_text import PHRASES
from heyoka_bike.workbench.replay import scenes
from heyoka_bike.workbench.replay.page import PITCH_SCRIPT, drawing, stage
from heyoka_bike.workbench.replay.page import SCRIPT as REPLAY_SCRIPT
from heyoka_bike.workbench.replay.page import STYLE as REPLAY_STYLE

_HERE = Path(__file__).parent
_Formulas = Callable[[Equations, Sequence[Number]], Sequence[Number]]
KEPT = _HERE / "checker.wasm"
SCRIPTS = ("judging.js", "reading.js", "recognising.js")
"""Scripts that read and judge files without a page; they find `page_data` in ``data``."""

_SHOWING = (PITCH_SCRIPT, _HERE / "moving.js", REPLAY_SCRIPT, _HERE / "page.js", _HERE / "links.js")
_BEGIN = '"use strict";\nconst data = JSON.parse(document.getElementById("data").textContent);\n'
# Spellings of units that the checker recognises in headings.
_SPELLINGS = (
    "s", "ms", "sec", "seconds", "rad", "radian", "radians", "deg", "degree", "degrees", "\u00b0",
    "rad/s", "rad s-1", "rad s^-1", "rad*s^-1", "deg/s", "deg s-1", "degree/s", "degrees/s",
    "\u00b0/s", "dps", "rpm", "m/s", "m s-1", "m s^-1", "mps", "km/h", "kph", "kmh", "mm/s", "mph",
    "J", "kJ", "mJ",
)  # fmt: skip


def checker_page() -> str:
    """Return the HTML page that judges files against the published reference in the browser."""
    reference = load_reference()
    bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
    files = (*(_HERE / name for name in SCRIPTS), *_SHOWING)
    scripts = [kinematics_source(bicycle), *(file.read_text(encoding="utf-8") for file in files)]
    body = Template((_HERE / "page.html").read_text(encoding="utf-8"))
    return page(
        "Uncontrolled bicycle: how many digits are right?",
        body.substitute(stage=stage([(str(n), str(n)) for n in reference], True)),
        reference_words(reference.bicycle, reference.dataset_version),
        styles=(PAGE_STYLE, REPLAY_STYLE, _HERE / "page.css"),
        script=_BEGIN + "\n".join(scripts),
        data=json.dumps(page_data() | {"replay": _replay_data(bicycle)}),
        has_wasm=True,
    )


def page_data() -> dict[str, Any]:
    """Return the data for the page's scripts: the checker, words, and known headings."""
    units = [DEFINITIONS[key][0].unit for key in BENCHMARK_COLUMNS]
    return {
        "wasm": b64encode(KEPT.read_bytes()).decode("ascii"),
        "keys": BENCHMARK_COLUMNS,
        "units": units,
        "words": [WORDS.get(g, "") for g in Grade],
        "signs": [SIGNS.get(g, "") for g in Grade],
        "meanings": [MEANINGS.get(g, "") for g in Grade],
        "styles": [g.style for g in Grade],
        "phrases": PHRASES,
        "limits": [*LIMITS],
        "headings": _headings(),
        "unitWords": [_unit_words(unit, UNITS[unit]) for unit in units],
        "timeUnits": _unit_words("s", ("s", "ms")),
        "recognition": _recognition_data(load_reference()),
    }


def _recognition_data(reference: Reference) -> dict[str, Any]:
    """Return the limits and values of `scoring.recognition` that ``recognising.js`` needs.

    Columns and maneuvers are represented by their indices.
    """
    keys, maneuvers = list(BENCHMARK_COLUMNS), [reference[n] for n in reference]
    return {
        "fastest": recognition.FASTEST_MODE,
        "near": recognition.NEAR,
        "exact": recognition.EXACT,
        "far": recognition.FAR,
        "clearly": CLEARLY,
        "farthest": MEANINGLESS_ERROR,
        "mostRows": recognition.MOST_ROWS_OF_SPAN,
        "logOdds": recognition.LOG_ODDS_AS_WRITTEN,
        "roundoff": recognition.ROUNDOFF,
        "zeroed": [keys.index(key) for key in recognition.ZEROED],
        "factors": [recognition.factors(key, None, maneuvers[0]) for key in keys],
        "rates": [keys.index(RATE_OF[key]) if key in RATE_OF else None for key in keys],
        "varies": [[recognition.varies(key, m) for key in keys] for m in maneuvers],
        "middles": [[recognition.middle(key, m) for key in keys] for m in maneuvers],
    }


def kinematics_source(bicycle: Bicycle) -> str:
    """Return functions for ``moving.js``, generated by evaluating the model.

    Parameters
    ----------
    bicycle : Bicycle

    ``floorGap([roll, pitch, steer], f)`` puts the height of the front wheel [m] into f;
    ``rolling(state, f)`` takes the columns of `motion_3d.STATE`. It puts the rates of yaw and
    wheels [rad/s] and of the rear track [m/s] into f, and the distance of the front contact ahead
    and to the right of the rear one [m].
    """

    def gap(e: Equations, y: Sequence[Number]) -> Sequence[Number]:
        return [front_contact_height(e.k, e.a, *y)]

    def rolling(e: Equations, y: Sequence[Number]) -> Sequence[Number]:
        # Replace the forward speed by the spin, to get the state of the regular form.
        state = [*y[:5], y[5] / (e.k.length * e.k.rear.r)]
        o, u = e.unfold(state)
        zeros = [e.a.number(0)] * 3  # yaw, and x and y position
        ahead = Configuration.of(e, [*state, *zeros]).places()["front_contact"][:2]
        return [yaw_rate(o, u), *wheel_rates(e.k, u), track_speeds(e.k, u)[0], *ahead]

    plain = Equations.binary64(bicycle)

    def function(name: str, size: int, formulas: _Formulas) -> str:
        def evaluated(code: StraightLine, y: Sequence[Number]) -> Sequence[Number]:
            return formulas(plain.convert(code.literal, code), y)

        return JAVASCRIPT.function(name, {"y": size}, "f", evaluated)

    parts = [
        "const kinematics = (() => {", "const { sin, cos, sqrt } = Math;",
        function("floorGap", 3, gap), function("rolling", 6, rolling),
        "return { floorGap, rolling };", "})();",
    ]  # fmt: skip
    return "\n".join(parts)


def _replay_data(bicycle: Bicycle) -> dict[str, Any]:
    """Return the data of the replay: a drawing of the bicycle, and constants of `scenes`."""
    return {
        "bicycle": drawing(bicycle),
        "states": scenes.WRITTEN_STATES,
        "labels": [label(name) for name in scenes.WRITTEN_STATES],
        "rate": scenes.RATE,
        "leastFrames": scenes.LEAST_FRAMES,
        "fallen": scenes.FALLEN,
        "smallestGap": scenes.SMALLEST_GAP,
        "outOfSight": scenes.OUT_OF_SIGHT,
        "derived": scenes.DERIVED,
        "brought": scenes.CONVERTED_NOTE,
    }


def _headings() -> dict[str, int]:
    """Return a mapping from unambiguous headings to the index of the column; -1 is the time."""
    places = {TIME: -1, **{key: i for i, key in enumerate(BENCHMARK_COLUMNS)}}
    return {word: places[key] for word, key in KEYS.items() if key in places and not may_mean(word)}


def _unit_words(si: str, known: Sequence[str]) -> dict[str, str]:
    """Return a mapping from spellings of the units of a column to the unit in `UNITS`."""
    found = {spelling: quantities(spelling).get(si) for spelling in _SPELLINGS}
    return {spelling: unit for spelling, unit in found.items() if unit and unit in known}
