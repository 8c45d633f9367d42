"""The package can be read by one person: short chains of imports, short lists, one name a class.

How many branches a function may have is kept by ruff.
"""

import re
from collections import Counter
from functools import cache
from pathlib import Path

import grimp

ROOT = Path(__file__).resolve().parents[2] / "heyoka_bike"
CHAIN = 18  # modules outside the workbench, from one to what it needs, and so on
ENTRIES = 20  # of a folder


def longest_chain(needs):
    @cache
    def chain(module):
        below = max((chain(m) for m in sorted(needs[module])), key=len, default=())
        return (module, *below)

    return max(map(chain, sorted(needs)), key=len)


def needs(graph):
    core = {m for m in graph.modules if not m.startswith("heyoka_bike.workbench")}
    return {m: graph.find_modules_directly_imported_by(m) & core for m in core}


def test_no_chain_of_imports_is_long():
    graph = grimp.build_graph("heyoka_bike", exclude_type_checking_imports=True, cache_dir=None)
    chain = longest_chain(needs(graph))
    assert len(chain) <= CHAIN, chain


def test_a_long_chain_is_found():
    assert longest_chain({1: {2, 3}, 2: {3}, 3: {4}, 4: set()}) == (1, 2, 3, 4)


def test_no_folder_is_long():
    for folder in {p.parent for p in ROOT.rglob("*.py")}:
        entries = [p.name for p in folder.iterdir() if not p.name.startswith("__")]
        assert len(entries) <= ENTRIES, (folder, entries)


def test_no_two_classes_have_one_name():
    texts = (p.read_text(encoding="utf-8") for p in ROOT.rglob("*.py"))
    names = Counter(
        name for text in texts for name in re.findall(r"^ *class (\w+)[(:]", text, re.M)
    )
    assert len(names) > 200
    assert [name for name, n in names.items() if n > 1] == []
