"""The conda recipe has the same requirements as pyproject.toml, and the constraints
contain them."""

import re
import tomllib
from pathlib import Path

import yaml
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from heyoka_bike.version import __version__

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
# Packages whose name in conda-forge differs from that on PyPI
CONDA = {"heyoka": "heyoka.py"}


def as_conda(requirement):
    found = Requirement(requirement)
    bounds = sorted(map(str, found.specifier), key=lambda x: x.startswith("<"))
    return f"{CONDA.get(found.name, found.name)} {','.join(bounds)}"


def output(name):
    recipe = yaml.safe_load((ROOT / ".conda" / "recipe.yaml").read_text(encoding="utf-8"))
    assert recipe["context"]["version"] == PROJECT["version"] == __version__
    (found,) = [x for x in recipe["outputs"] if x["package"]["name"] == name]
    return found


def test_the_conda_recipe_requires_what_the_package_does():
    plain = output("heyoka_bike")
    python = f"python {PROJECT['requires-python']}"
    assert plain["requirements"]["run"] == [python, *map(as_conda, PROJECT["dependencies"])]
    build = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]
    host = plain["requirements"]["host"]
    assert set(map(as_conda, build["requires"])) <= set(host)
    ((command, function),) = PROJECT["scripts"].items()
    assert plain["build"]["python"]["entry_points"] == [f"{command} = {function}"]
    more = output("heyoka_bike-generate")["requirements"]["run"]
    assert more == ["heyoka_bike ==${{ version }}", *map(as_conda, EXTRAS["generate"])]


def test_the_constraints_hold_what_is_installed_here():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pinned = {}
    for line in lines:
        found = Requirement(line)
        if found.marker is None or found.marker.evaluate(dict(default_environment())):
            assert re.fullmatch(r"==[\w.+]+", str(found.specifier)), line
            pinned[canonicalize_name(found.name)] = found.specifier
    asked = [*PROJECT["dependencies"]]
    for extra in ("generate", "plot", "bench", "atlas", "cluster", "docs", "test"):
        asked += EXTRAS[extra]
    for text in asked:
        required = Requirement(text)
        if required.name != PROJECT["name"]:
            (version,) = (x.version for x in pinned[canonicalize_name(required.name)])
            assert required.specifier.contains(version), text
