"""Imports between tests and the scripts of the pages go in one direction.

A test may import a script of the pages in order to test it. Code that both use is in `oracles` or
`generators`, which import neither.
"""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
OF_PAGES = {
    p.stem
    for folder in ("_site", "paper")
    for p in (ROOT / "docs" / folder).iterdir()
    if p.suffix == ".py" or (p / "__init__.py").exists()
}

# Each package may import only the packages before it in this list.
LAYERS = ("corpus", "oracles", "generators", "games", "support")
# Packages of the tests that the scripts of the pages may use.
SHARED = {"oracles", "generators"}


def imported(text):
    """The top-level package of every module that a file imports."""
    for x in ast.walk(ast.parse(text)):
        if isinstance(x, ast.Import):
            yield from (alias.name.split(".")[0] for alias in x.names)
        elif isinstance(x, ast.ImportFrom) and not x.level:
            yield (x.module or "").split(".")[0]


def misplaced(folder, forbidden):
    """Imports in a folder of packages that must not be used there."""
    return [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in sorted(folder.rglob("*.py"))
        for name in imported(path.read_text(encoding="utf-8"))
        if name in forbidden
    ]


@pytest.mark.parametrize("layer", LAYERS)
def test_what_tests_share_uses_what_is_below_it_and_no_page(layer):
    above = set(LAYERS[LAYERS.index(layer) + 1 :])
    assert misplaced(TESTS / layer, above | OF_PAGES) == []


@pytest.mark.parametrize("folder", ["_site", "paper"])
def test_pages_use_of_the_tests_what_is_shared(folder):
    assert misplaced(ROOT / "docs" / folder, {*LAYERS, "tests", "conftest"} - SHARED) == []


def test_the_package_knows_neither():
    assert misplaced(ROOT / "heyoka_bike", {*LAYERS, "tests", "conftest", "docs"}) == []


def test_a_wrong_import_is_seen():
    text = "import numpy as np\n\ndef f():\n    from support.pages import text\n    import run.x\n"
    assert list(imported(text)) == ["numpy", "support", "run"]
    assert {"blocks", "figures", "run"} <= OF_PAGES
