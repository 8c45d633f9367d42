"""The header as WebAssembly, for the page: built by clang and lld, and kept beside this module.

``python -m heyoka_bike.showing.checker.wasm`` builds `KEPT` anew, when the header has changed.
"""

import subprocess
import tempfile
from hashlib import sha256
from pathlib import Path

from heyoka_bike.reference.load import load_reference
from heyoka_bike.showing.checker.header import render

_HERE = Path(__file__).parent
KEPT = _HERE / "checker.wasm"
_EXPORTED = "uncontrolled_bicycle.h"
# Of the samples of `ub_sample`, with some to spare.
_STACK = 1 << 20


def source() -> str:
    """Return the source of the module: the header without its comment, which names the version."""
    lines = render(load_reference()).decode("ascii").splitlines(keepends=True)
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


if __name__ == "__main__":
    KEPT.write_bytes(build())
