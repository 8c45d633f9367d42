"""Every hypothesis of docs/proof.md names a function and a test that exist."""

from __future__ import annotations

import ast
import importlib
import re
from functools import cache
from pathlib import Path

import pytest

from heyoka_bike.system.resources import data_folder

ROOT = data_folder().parent
PROOF, CHECKS = (
    (ROOT / "docs" / name).read_text(encoding="utf-8")
    for name in ("proof.md", "reference/who-checks-what.md")
)
_HYPOTHESIS = re.compile(r"^- \*\*(H\d+)\.", re.MULTILINE)
_ROW = re.compile(r"^\| (?:\*\*(H\d+)\*\* )?(.+?) \| (\[`.+?) \| (\[`.+?) \|$", re.MULTILINE)
_NAMED = re.compile(r"\[`([\w.]+)`\]\(\.\./\.\./([\w/]+\.py)\)")
ROWS = _ROW.findall(CHECKS)


@cache
def names_in(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {x.name for x in tree.body if isinstance(x, ast.FunctionDef)}


def test_every_hypothesis_has_its_row_in_order() -> None:
    stated = _HYPOTHESIS.findall(PROOF)
    assert stated == [f"H{i}" for i in range(1, len(stated) + 1)]
    assert [h for h, *_ in ROWS if h] == stated
    assert CHECKS.count("\n| ") == len(ROWS) + 1, "a row has no function or no test"


@pytest.mark.parametrize("row", ROWS, ids=[what for _, what, *_ in ROWS])
def test_its_functions_and_tests_exist(row: tuple[str, str, str, str]) -> None:
    functions, tests = (_NAMED.findall(cell) for cell in row[2:])
    assert functions
    assert tests
    for name, path in functions:
        stem, *parts = name.split(".")
        assert stem == Path(path).stem
        found = importlib.import_module(path.removesuffix(".py").replace("/", "."))
        for part in parts:
            found = getattr(found, part)
        assert callable(found)
    for name, path in tests:
        assert name.startswith("test_")
        assert name in names_in(ROOT / path), f"{path} has no {name}"
