"""The judge as one HTML page without a server: the header as WebAssembly, and what shows it.

What ``docs/_site/checker_wasm.py`` builds of the header, by clang and lld, is kept beside this
module.
"""

import json
from base64 import b64encode
from pathlib import Path

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.load import load_reference
from heyoka_bike.showing.document.html import PAGE_STYLE, page
from heyoka_bike.showing.wording import MEANINGS, PHRASES, SIGNS, WORDS, Grade, reference_words

_HERE = Path(__file__).parent
KEPT = _HERE / "checker.wasm"


def checker_page() -> str:
    """The page: it judges files against the published reference, in the browser alone."""
    reference = load_reference()
    data = {
        "wasm": b64encode(KEPT.read_bytes()).decode("ascii"),
        "keys": BENCHMARK_COLUMNS,
        "units": [DEFINITIONS[key][0].unit for key in BENCHMARK_COLUMNS],
        "words": [WORDS.get(g, "") for g in Grade],
        "signs": [SIGNS.get(g, "") for g in Grade],
        "meanings": [MEANINGS.get(g, "") for g in Grade],
        "styles": [g.style for g in Grade],
        "phrases": PHRASES,
    }
    return page(
        "Uncontrolled bicycle: how many digits are right?",
        (_HERE / "page.html").read_text(encoding="utf-8"),
        reference_words(reference.bicycle, reference.dataset_version),
        styles=(PAGE_STYLE, _HERE / "page.css"),
        script=(_HERE / "page.js").read_text(encoding="utf-8"),
        data=json.dumps(data),
        has_wasm=True,
    )
