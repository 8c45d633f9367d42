"""What blocks of commands print, written below them for who reads the pages in the repository.

The blocks are those with the option ``shown``: every block that prints something. Run as a script,
this carries out the blocks of the pages named, by default of all that show outputs, and writes
these. What needs a program that is not there keeps the output that it has.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from blocks import BLOCK, absent, fill, options, result

DOCS = Path(__file__).parent.parent


def filled(page):
    """The text of a page with the outputs of its blocks.

    Blocks that draw a figure or need what is not there are left out; all others are carried out in
    turn.
    """
    parts, end = [], 0
    with TemporaryDirectory() as folder:
        fill(Path(folder))
        for found in BLOCK.finditer(page):
            asked = options(found["asked"])
            if "figure" in asked or absent(asked):
                continue
            code, output = result(found["source"], asked, Path(folder))
            if code != int(asked.get("code", 0)):
                raise SystemExit(f"exit code {code} of\n{found['source']}\n{output}")
            if "shown" in asked:
                below = found.start("below") if found["below"] else found.end()
                shown = f"\n```text\n{output}\n```\n" if output else ""
                parts += [page[end:below], shown]
                end = found.end()
    return "".join([*parts, page[end:]])


def pages():
    """Those that show an output."""
    return [page for page in sorted(DOCS.rglob("*.md")) if _is_shown(page)]


def _is_shown(page):
    found = BLOCK.finditer(page.read_text(encoding="utf-8"))
    return any({"shown", "figure"} & options(x["asked"]).keys() == {"shown"} for x in found)


if __name__ == "__main__":
    for file in map(Path, sys.argv[1:]) if sys.argv[1:] else pages():
        file.write_text(filled(file.read_text(encoding="utf-8")), encoding="utf-8")
