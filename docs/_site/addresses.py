"""The addresses of repository and site, which stand in ``pyproject.toml`` and on pages.

Run as a script with two others, this writes them in place of these: in ``pyproject.toml``, in the
README and in all pages.
"""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROJECT = ROOT / "pyproject.toml"


def addresses(project=PROJECT):
    """Of the repository, and of the site."""
    named = tomllib.loads(project.read_text(encoding="utf-8"))["tool"]["heyoka_bike"]
    return named["repository"], named["site"]


def pages(root=ROOT):
    """Files that may name them."""
    docs = [page for page in sorted((root / "docs").rglob("*.md")) if "_build" not in page.parts]
    return [root / "pyproject.toml", *sorted(root.glob("*.md")), *docs]


def moved(text, old, new):
    """The text with the new addresses in place of the old ones."""
    for before, after in zip(old, new, strict=True):
        text = text.replace(before, after)
    return text


if __name__ == "__main__":
    was, asked = addresses(), tuple(word.rstrip("/") for word in sys.argv[1:])
    if len(asked) != len(was):
        raise SystemExit("found no two addresses, expected: addresses.py REPOSITORY SITE")
    for page in pages():
        page.write_text(moved(page.read_text(encoding="utf-8"), was, asked), encoding="utf-8")
