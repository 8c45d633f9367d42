"""Links of the README, the changelogs and docs to files and headings exist; pages are in the site.

The test follows links as readers on GitHub do, without Sphinx. It does not visit external
addresses.
"""

import re

import pytest

from heyoka_bike.system.resources import data_folder
from redirects import moved

ROOT = data_folder().parent
DOCS = ROOT / "docs"
# The paper is left out because it is not a page of the site: its figures are made when it is built.
PAGES = sorted(
    p for p in DOCS.rglob("*.md") if not {"_build", "paper"} & {*p.relative_to(DOCS).parts}
)
CHECKED = [
    *sorted(ROOT.glob("*.md")),
    *PAGES,
    DOCS / "paper" / "README.md",
    *sorted((ROOT / "data").rglob("*.md")),
]

_FENCE = re.compile(r"^(`{3,}).*?^\1`*[ \t]*$", re.MULTILINE | re.DOTALL)
_TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\[[^\]]*\]\(\s*<?([^)\s>]+)>?[^)]*\)")
_HEADING = re.compile(r"^#{1,6} +(.+?) *#*$", re.MULTILINE)


def prose(text):
    """The text without code, where brackets are not links and # does not begin a heading."""
    return re.sub(r"`[^`\n]*`", "code", _FENCE.sub("", text))


def anchors(text):
    """The anchors that GitHub makes from the headings."""
    found = {}
    for heading in _HEADING.findall(_FENCE.sub("", text)):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        slug = re.sub(r"[^\w\- ]", "", plain).strip().replace(" ", "-")
        count = found[slug] = found.get(slug, -1) + 1
        if count:
            found[f"{slug}-{count}"] = 0
    return set(found)


def broken(page, text):
    """Links of a page without a target."""
    found = []
    for link in _LINK.findall(prose(text)):
        if re.match(r"[a-z]+:", link):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        is_here = target.exists() and target.is_relative_to(ROOT)
        if not is_here or (anchor and anchor not in anchors(target.read_text(encoding="utf-8"))):
            found.append(link)
    return found


def entries(page):
    """Pages and notebooks in the toctrees of a page."""
    named = [
        page.parent / line.strip()
        for tree in _TOCTREE.findall(page.read_text(encoding="utf-8"))
        for line in tree.splitlines()
        if line.strip() and not line.startswith(":")
    ]
    notebooks = [x.with_suffix(".ipynb") for x in named]
    return {
        (n if n.exists() else x.with_suffix(".md")).resolve()
        for x, n in zip(named, notebooks, strict=True)
    }


@pytest.mark.parametrize("page", CHECKED, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    assert not broken(page, page.read_text(encoding="utf-8"))


def test_every_page_is_in_the_contents():
    listed = set().union(*(entries(page) for page in PAGES))
    pages = {*PAGES, *DOCS.glob("*.ipynb")} - {DOCS / "index.md"}
    assert listed == {page.resolve() for page in pages}


def test_links_are_looked_at():
    here = DOCS / "start.md"
    assert broken(here, "[a](nowhere.md) [b](files.md#nothing) [c](#what-it-says-not)") == [
        "nowhere.md", "files.md#nothing", "#what-it-says-not",
    ]  # fmt: skip
    good = "[a](files.md#the-input-files) [b](../README.md) [c](https://x.org/y) `[d](nowhere)`"
    assert broken(here, good) == []
    assert anchors("# A `b.c` (d)\n## E\n## E\n```sh\n# f\n```\n") == {"a-bc-d", "e", "e-1"}
    assert sum(len(_LINK.findall(prose(page.read_text(encoding="utf-8")))) for page in PAGES) > 50


def test_pages_that_moved_are_redirected():
    found = moved((DOCS / "new.md").read_text(encoding="utf-8"))
    assert found["field-programs"] == "field.html#how-each-program-models-the-bicycle"
    table = (DOCS / "new.md").read_text(encoding="utf-8").partition("## Pages that moved")[2]
    assert len(found) == table.count("\n| ") - 1, "a row is not read"
    for old, new in found.items():
        assert not (DOCS / f"{old}.md").exists()
        assert (DOCS / new.partition("#")[0].replace(".html", ".md")).exists()


def test_pages_that_the_program_names_exist():
    named = {
        (file, page)
        for file in (ROOT / "heyoka_bike").rglob("*.py")
        for page in re.findall(r"\bdocs/[\w/-]+\.md\b", file.read_text(encoding="utf-8"))
    }
    assert len(named) > 10
    assert [(file, page) for file, page in named if not (ROOT / page).exists()] == []
