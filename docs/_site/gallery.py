"""The pictures of docs/gallery.md, two of which the README shows, too.

Run as a script, this carries out the commands of the page, or those that make the pictures named,
in a folder of its own with copies of ``data`` and of the figures that only pages show. A page is
photographed with Chromium, or another browser of its family, named by BROWSER; Pillow, which comes
with matplotlib, makes all small::

    python docs/_site/gallery.py [report replay ...]
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from blocks import carry_out

DOCS = Path(__file__).parent.parent
PAGE = DOCS / "gallery.md"
IMAGES = DOCS / "images" / "gallery"
_ENTRY = re.compile(r"```sh\n(.*?)```\n\n!\[[^\]]+\]\(images/gallery/([\w-]+)\.png\)", re.DOTALL)

WIDTH = 900  # of a figure, which the page shows no wider [pixels]
COLOURS = 64  # more cannot be told from it
SECONDS = 1800.0  # an atlas takes minutes
# Windows [pixels], and what the page is told.
SHOTS = {
    "report": ((900, 640), ""),
    # Where the difference is large; it is drawn a hundred times as large.
    "replay": ((1000, 600), "#t=9.2&maneuver=1&exaggerate=1&magnify=100&camera=follow"),
    "convergence": ((900, 900), ""),
    "leaderboard": ((1000, 900), ""),
    "falling": ((1000, 900), "#at=4.6,0.5&t=3.2"),
}


def entries():
    """The commands of the page that make a picture, by its name."""
    return {name: block for block, name in _ENTRY.findall(PAGE.read_text(encoding="utf-8"))}


def photograph(page, name, taken):
    (width, height), hash_ = SHOTS[name]
    browser = os.environ.get("BROWSER", "chromium")
    subprocess.run(
        [browser, "--headless", "--no-sandbox", "--hide-scrollbars", "--disable-gpu",
         f"--window-size={width},{height}", "--virtual-time-budget=5000",
         f"--screenshot={taken}", page.as_uri() + hash_],
        check=True, capture_output=True, timeout=120,
    )  # fmt: skip


def make(name, block, folder):
    """One picture, from what the commands write in the folder."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    shell = ("bash", "-e", "-o", "pipefail", "-s")
    code, output = carry_out(shell, block, folder, os.environ | {"PATH": path}, SECONDS)
    if code:
        raise SystemExit(f"exit code {code} of\n{block}\n{output}")
    taken = folder / f"{name}.png"
    if name in SHOTS:
        photograph(folder / f"{name}.html", name, taken)
    with Image.open(taken) as image:
        # A figure without a ground of its own gets white.
        whole = Image.new("RGBA", image.size, "white")
        whole.alpha_composite(image.convert("RGBA"))
        if name not in SHOTS:
            whole.thumbnail((WIDTH, 2 * WIDTH), Image.Resampling.LANCZOS)
        small = whole.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        small.save(IMAGES / taken.name, optimize=True)
    print(f"{taken.name}: {(IMAGES / taken.name).stat().st_size / 1e3:.0f} kB", flush=True)


def main(names):
    found = entries()
    IMAGES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        for name in ("data", "docs/_site/figures"):
            shutil.copytree(DOCS.parent / name, Path(place) / name)
        for name in names or found:
            make(name, found[name], Path(place))


if __name__ == "__main__":
    main(sys.argv[1:])
