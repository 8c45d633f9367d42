"""Every public name of heyoka_bike exists, has a docstring, and is documented under one path."""

import importlib
import inspect
import re
import subprocess
import sys
from collections import Counter

import pytest

import heyoka_bike
from heyoka_bike.system.resources import data_folder

PAGE = (data_folder().parent / "docs" / "reference" / "python.md").read_text(encoding="utf-8")
PUBLIC = sorted(set(heyoka_bike.__all__) - {"__version__"})
_DIRECTIVE = re.compile(r"^\.\. auto(\w+):: (\S+)$", re.MULTILINE)
_HEADING = re.compile(r"^(\w+)\n-{3,}$", re.MULTILINE)


def sections(thing):
    """The sections of a docstring by heading, without the text above the first heading."""
    parts = _HEADING.split(inspect.getdoc(thing))
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def named(section):
    """Names at the left margin of a docstring's section."""
    left = re.findall(r"^\w.*", section, re.MULTILINE)
    return [name for line in left for name in re.split(r",\s*", line.partition(" :")[0])]


@pytest.mark.parametrize("name", PUBLIC)
def test_every_name_says_what_it_is(name):
    thing = getattr(heyoka_bike, name)
    assert inspect.getdoc(thing)
    found = sections(thing)
    if inspect.isfunction(thing):
        assert named(found["Parameters"]) == list(inspect.signature(thing).parameters)
        assert {"Returns", "Raises"} <= set(found)
    elif not issubclass(thing, Exception):
        assert {"Attributes", "Parameters"} & set(found)


def test_what_is_documented_stands_where_the_page_says():
    named = [path.partition("(")[0] for _, path in _DIRECTIVE.findall(PAGE)]
    paths = [path for path in named if path.startswith("heyoka_bike.")]
    assert len(paths) > 20
    for path in paths:
        module, _, name = path.rpartition(".")
        thing = getattr(importlib.import_module(module), name, None)
        assert thing is not None, path
        assert thing.__module__ == module, f"{path} is of {thing.__module__}"


def test_every_name_is_documented_at_one_path():
    paths = [path if "." in path else f"heyoka_bike.{path}" for _, path in _DIRECTIVE.findall(PAGE)]
    assert {path for path, count in Counter(paths).items() if count > 1} == set()
    for name in PUBLIC:
        assert [p for p in paths if p.rpartition(".")[2] == name] == [f"heyoka_bike.{name}"]


def test_the_table_of_names_is_that_of_the_package():
    rows = re.findall(r"^\| [a-z ]+ \|(.*)\|$", PAGE, re.MULTILINE)
    properties = {"motion", "sensitivities"}  # these properties belong to `Reference`
    named = {x for row in rows for x in re.findall(r"`(\w+)`", row)}
    assert sorted(named - properties) == PUBLIC


def test_other_names_are_refused():
    assert set(heyoka_bike.__all__) <= set(dir(heyoka_bike))
    with pytest.raises(AttributeError, match="module 'heyoka_bike' has no attribute 'nonsense'"):
        _ = heyoka_bike.nonsense


def test_names_do_not_depend_on_how_python_runs():
    """The names are the same with -OO, which removes assertions and docstrings."""
    code = "import heyoka_bike as h; print(*(n for n in h.__all__ if hasattr(h, n)))"
    run = subprocess.run([sys.executable, "-OO", "-c", code], capture_output=True, text=True)
    assert run.stdout.split() == heyoka_bike.__all__, run.stderr


@pytest.mark.proof
def test_type_checkers_see_the_names(tmp_path):
    pytest.importorskip("mypy")
    code = "import heyoka_bike as h\n" + "".join(f"reveal_type(h.{name})\n" for name in PUBLIC)
    (tmp_path / "uses.py").write_text(code)
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), "uses.py"],
        cwd=tmp_path, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout
    assert run.stdout.count("Revealed type") == len(PUBLIC)
    assert 'is "Any"' not in run.stdout
