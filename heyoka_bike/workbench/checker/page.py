"""The judge as one HTML page without a server: the header as WebAssembly, and what shows it.

What ``docs/_site/checker_wasm.py`` builds of the header, by clang and lld, is kept beside this
module.
"""

import json
from base64 import b64encode
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.reading.names.columns import KEYS, TIME, may_mean
from heyoka_bike.scoring.reading.names.units import quantities
from heyoka_bike.scoring.units import UNITS
from heyoka_bike.showing.document.html import PAGE_STYLE, page
from heyoka_bike.showing.wording import MEANINGS, PHRASES, SIGNS, WORDS, Grade, reference_words

_HERE = Path(__file__).parent
KEPT = _HERE / "checker.wasm"
SCRIPTS = ("judging.js", "reading.js")
"""What reads and judges, without a page; it finds ``data`` as `page_data` has it."""

_SHOWING = ("page.js", "links.js")
_BEGIN = '"use strict";\nconst data = JSON.parse(document.getElementById("data").textContent);\n'
# As people write the units that the judge tries.
_SPELLINGS = (
    "s", "ms", "sec", "seconds", "rad", "radian", "radians", "deg", "degree", "degrees", "\u00b0",
    "rad/s", "rad s-1", "rad s^-1", "rad*s^-1", "deg/s", "deg s-1", "degree/s", "degrees/s",
    "\u00b0/s", "dps", "rpm", "m/s", "m s-1", "m s^-1", "mps", "km/h", "kph", "kmh", "mm/s", "mph",
    "J", "kJ", "mJ",
)  # fmt: skip


def checker_page() -> str:
    """The page: it judges files against the published reference, in the browser alone."""
    reference = load_reference()
    scripts = ((_HERE / name).read_text(encoding="utf-8") for name in (*SCRIPTS, *_SHOWING))
    return page(
        "Uncontrolled bicycle: how many digits are right?",
        (_HERE / "page.html").read_text(encoding="utf-8"),
        reference_words(reference.bicycle, reference.dataset_version),
        styles=(PAGE_STYLE, _HERE / "page.css"),
        script=_BEGIN + "\n".join(scripts),
        data=json.dumps(page_data()),
        has_wasm=True,
    )


def page_data() -> dict[str, Any]:
    """What the scripts of the page are given: the judge, words, and the headings that are read."""
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
        "headings": _headings(),
        "unitWords": [_unit_words(unit, UNITS[unit]) for unit in units],
        "timeUnits": _unit_words("s", ("s", "ms")),
    }


def _headings() -> dict[str, int]:
    """Words that mean one column whatever its values are: its place, -1 for the time."""
    places = {TIME: -1, **{key: i for i, key in enumerate(BENCHMARK_COLUMNS)}}
    return {word: places[key] for word, key in KEYS.items() if key in places and not may_mean(word)}


def _unit_words(si: str, known: Sequence[str]) -> dict[str, str]:
    """Spellings of the units of a column, each with the unit as `UNITS` has it."""
    found = {spelling: quantities(spelling).get(si) for spelling in _SPELLINGS}
    return {spelling: unit for spelling, unit in found.items() if unit and unit in known}
