"""The judge of the page of ``export --page``: the header and ``checker.c``, as WebAssembly.

Run as a script, with clang and lld, this builds what is kept in the package anew; a test says when
the header has changed.
"""

import subprocess
import tempfile
from hashlib import sha256
from pathlib import Path

from heyoka_bike.reference.load import load_reference
from heyoka_bike.workbench.checker.header import checker_header
from heyoka_bike.workbench.checker.page import KEPT

SOURCES = KEPT.parent / "wasm"
EXPORTED = "uncontrolled_bicycle.h"
# Of the samples of `ub_sample`, with some to spare.
STACK = 1 << 20


def source() -> str:
    """Return the source of the module: the header without its comment, which names the version."""
    lines = checker_header(load_reference()).decode("ascii").splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith("//"))


def source_hash() -> str:
    """Of all that is compiled."""
    texts = [source(), *(path.read_text("ascii") for path in sorted(SOURCES.iterdir()))]
    return sha256("".join(texts).encode("ascii")).hexdigest()


def build(clang: str = "clang") -> bytes:
    """The module, by clang and lld."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / EXPORTED).write_text(source(), "ascii")
        made = Path(folder) / KEPT.name
        subprocess.run(
            [
                clang, "--target=wasm32", "-std=c99", "-Oz", "-nostdlib", "-ffreestanding",
                "-mbulk-memory", f"-I{SOURCES}", f"-I{folder}",
                f'-DSOURCE="{source_hash()}"', str(SOURCES / "checker.c"), "-o", str(made),
                "-Wl,--no-entry,--allow-undefined,--strip-all", f"-Wl,-z,stack-size={STACK}",
            ],
            check=True,
        )  # fmt: skip
        return made.read_bytes()


if __name__ == "__main__":
    KEPT.write_bytes(build())
