"""The page on oracles names all modules of the package that each oracle imports."""

import ast
import re
from pathlib import Path

import pytest

ORACLES = Path(__file__).resolve().parents[1] / "oracles"
MODULES = sorted(p.stem for p in ORACLES.glob("*.py") if p.stem != "__init__")
PAGE = (ORACLES / "README.md").read_text(encoding="utf-8")
ROWS = dict(re.findall(r"^\| `(\w+)` \|[^|]+\| (.+) \|$", PAGE, re.MULTILINE))


def taken(path):
    """Modules of the package that a file imports."""
    for x in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [x.module] if isinstance(x, ast.ImportFrom) else []
        names += [alias.name for alias in x.names] if isinstance(x, ast.Import) else []
        yield from (name for name in names if name and name.split(".")[0] == "heyoka_bike")


def test_every_oracle_has_a_row():
    assert sorted(ROWS) == MODULES


@pytest.mark.parametrize("name", MODULES)
def test_the_row_names_what_is_shared(name):
    said = set(re.findall(r"`(heyoka_bike[\w.]*)`", ROWS[name]))
    assert said == set(taken(ORACLES / f"{name}.py"))
    assert said or ROWS[name] == "nothing"
