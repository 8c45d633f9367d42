"""The names that scripts outside the package import from it exist; few of these scripts run in a
test."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = sorted(
    p.relative_to(ROOT).as_posix() for name in ("data", "docs") for p in (ROOT / name).rglob("*.py")
)


def imported(text):
    """Module and name of each import from the package; the name is empty if the
    module is imported."""
    for x in ast.walk(ast.parse(text)):
        if isinstance(x, ast.ImportFrom) and (x.module or "").split(".")[0] == "heyoka_bike":
            yield from ((x.module, alias.name) for alias in x.names)
        elif isinstance(x, ast.Import):
            names = (alias.name for alias in x.names)
            yield from ((name, None) for name in names if name.split(".")[0] == "heyoka_bike")


def missing(text):
    """Imports from the package that do not exist."""
    return [f"{module}.{name}" for module, name in imported(text) if not exists(module, name)]


def exists(module, name):
    try:
        found = import_module(module)
        return name is None or hasattr(found, name) or bool(import_module(f"{module}.{name}"))
    except ModuleNotFoundError as error:
        # If a package other than heyoka_bike is missing, the error shows nothing about the names.
        return not (error.name or "").startswith("heyoka_bike")


@pytest.mark.parametrize("script", SCRIPTS)
def test_names_are_there(script):
    assert missing((ROOT / script).read_text(encoding="utf-8")) == []


def test_a_name_that_has_moved_is_seen():
    text = "from heyoka_bike.motion.integrate import require_heyoka\nimport heyoka_bike.gone"
    assert len(missing(text)) == 2
    assert missing("from heyoka_bike import score, motion\nimport heyoka_bike.cli") == []
