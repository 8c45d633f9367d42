"""The judge as one HTML page without a server: the header as WebAssembly, and what shows it.

The header is built by clang and lld, and kept beside this module:

``python -m heyoka_bike.workbench.checker.wasm`` builds `KEPT` anew, when it has changed.
"""

import json
import subprocess
import tempfile
from base64 import b64encode
from hashlib import sha256
from pathlib import Path

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.load import load_reference
from heyoka_bike.showing.document.html import PAGE_STYLE, page
from heyoka_bike.showing.wording import MEANINGS, PHRASES, SIGNS, WORDS, Grade, reference_words
from heyoka_bike.workbench.checker.header import checker_header

_HERE = Path(__file__).parent
KEPT = _HERE / "checker.wasm"
_EXPORTED = "uncontrolled_bicycle.h"
# Of the samples of `ub_sample`, with some to spare.
_STACK = 1 << 20


def source() -> str:
    """Return the source of the module: the header without its comment, which names the version."""
    lines = checker_header(load_reference()).decode("ascii").splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith("//"))


def source_hash() -> str:
    """Of all that is compiled."""
    texts = [source(), *(path.read_text("ascii") for path in sorted((_HERE / "wasm").iterdir()))]
    return sha256("".join(texts).encode("ascii")).hexdigest()


def build(clang: str = "clang") -> bytes:
    """The module, by clang and lld."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / _EXPORTED).write_text(source(), "ascii")
        made = Path(folder) / KEPT.name
        subprocess.run(
            [
                clang, "--target=wasm32", "-std=c99", "-Oz", "-nostdlib", "-ffreestanding",
                "-mbulk-memory", f"-I{_HERE / 'wasm'}", f"-I{folder}",
                f'-DSOURCE="{source_hash()}"', str(_HERE / "wasm" / "checker.c"), "-o", str(made),
                "-Wl,--no-entry,--allow-undefined,--strip-all", f"-Wl,-z,stack-size={_STACK}",
            ],
            check=True,
        )  # fmt: skip
        return made.read_bytes()


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


if __name__ == "__main__":
    KEPT.write_bytes(build())
