"""The site builds without a warning, its commands run, and its generated parts are up to date."""

import importlib.util
import os
import pkgutil
import re
import shlex
import shutil
import subprocess
import sys
import tomllib

import pytest

import heyoka_bike.scoring.rows
from addresses import addresses
from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.reading.formats import FORMATS
from heyoka_bike.system.resources import data_folder
from support.site import broken, served

ROOT = data_folder().parent
DOCS = ROOT / "docs"
_SH = re.compile(r"^```sh\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def sh_lines(name):
    blocks = _SH.findall((DOCS / name).read_text(encoding="utf-8"))
    return [line.partition("#")[0].strip() for block in blocks for line in block.splitlines()]


def module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def test_the_table_of_columns_is_that_of_the_code():
    made = module(DOCS / "_site" / "columns_table.py")
    text = made.PAGE.read_text(encoding="utf-8")
    assert made.page(text) == text, "run python docs/_site/columns_table.py"
    for column in COLUMNS:
        assert f"| `{column.name}` | {column.unit} |" in text


def test_the_table_of_formats_is_that_of_the_code():
    made = module(DOCS / "_site" / "formats_table.py")
    text = made.PAGE.read_text(encoding="utf-8")
    assert made.page(text) == text, "run python docs/_site/formats_table.py"
    assert all(f"| {f.label} | {f.about}" in text for f in FORMATS)


def test_the_table_of_findings_is_that_of_the_code():
    made = module(DOCS / "_site" / "findings_table.py")
    text = made.PAGE.read_text(encoding="utf-8")
    assert made.page(text) == text, "run python docs/_site/findings_table.py"
    # The table has a row for every class of evidence, except for base classes.
    classes = {*made.classes(), Evidence}
    bases = {base for c in classes for base in c.__mro__[1:]}
    assert classes - bases == {*made.findings()}


def test_the_page_says_what_to_do_about_every_fault_that_a_diagnosis_finds():
    package = heyoka_bike.scoring.rows
    found = pkgutil.iter_modules(package.__path__, f"{package.__name__}.")
    checks = [importlib.import_module(x.name) for x in found]
    reported = {
        code.code
        for x, codes in module(DOCS / "_site" / "findings_table.py").findings().items()
        if x.__module__.startswith("heyoka_bike.scoring.diagnosis.")
        or any(vars(c).get(x.__name__) is x for c in checks)
        for code in codes
    }
    rows = re.findall(r"^\| (`.+?) \|", (DOCS / "diagnosis.md").read_text("utf-8"), re.MULTILINE)
    listed = {code for row in rows for code in re.findall(r"`(.+?)`", row)}
    assert reported - listed == set()


@pytest.mark.parametrize("page", ["start.md", "installation.md"])
def test_the_pages_that_start_install_as_the_readme_does(page):
    (install,) = sh_lines(page)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert install.endswith(" && . .venv/bin/activate")
    assert f"{install} && heyoka-bike score" in readme
    # Scoring needs fewer packages than generating.
    more = install.replace(" -e .", " -e '.[generate]'")
    assert more != install
    assert f"{more} && heyoka-bike generate" in readme


def test_every_extra_is_named_where_installation_is_explained():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    table = (DOCS / "installation.md").read_text(encoding="utf-8")
    first_cells = [line.split(" | ")[0] for line in table.splitlines() if line.startswith("| `")]
    named = set(re.findall(r"`(\w+)`", " ".join(first_cells)))
    assert set(project["optional-dependencies"]) <= named


@pytest.mark.slow
def test_commands_of_pages_that_are_not_run_by_the_site_work(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copyfile(data_folder() / "peers" / "exudyn-h0.001.txt", "my-results.txt")
    shutil.copytree(folder, "my-reference")
    lines = [line for name in ("verify.md", "replay.md") for line in sh_lines(name)]
    # Commands that make an atlas are left out: an atlas takes minutes and has its own tests.
    lines = [line for line in lines if ".zarr" not in line]
    assert len(lines) == 7
    for line in lines:
        command, *arguments = shlex.split(line)
        assert command == "heyoka-bike"
        assert main(arguments) == 0, line
    assert {p.name for p in tmp_path.iterdir()} >= {
        "uncontrolled-bicycle.html", "replay.html", "two.html",
    }  # fmt: skip


@pytest.mark.slow
def test_the_site_builds_without_a_warning(folder, tmp_path):
    for name in ("sphinx", "furo", "myst_nb", "sphinx_argparse_cli"):
        pytest.importorskip(name)
    before = {p.name: p.stat().st_mtime_ns for p in folder.iterdir()}
    (command,) = (x for x in sh_lines("../CONTRIBUTING.md") if "sphinx-build" in x)
    arguments = shlex.split(command.rpartition("sphinx-build ")[2])
    assert "-W" in arguments
    assert arguments[-2:] == ["docs", "docs/_build/html"]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *arguments[:-1], str(tmp_path / "html")], cwd=ROOT,
        env=os.environ | {"HEYOKA_BIKE_TRACEBACK": "1"}, capture_output=True, text=True,
        timeout=900, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    html = {
        p.relative_to(tmp_path / "html").as_posix(): p.read_text(encoding="utf-8")
        for p in (tmp_path / "html").rglob("*.html")
    }
    assert "the worst column has 1.6 correct" in html["start.html"]
    with served(tmp_path) as address:
        checked, found = broken(address, "/html/", ["/html/"])
    assert found == []
    assert {f"{address}/html/judge/", f"{address}/html/data/"} <= checked
    _, home = addresses()
    for page in html.values():
        assert home not in page, "a link of the site itself is not relative"
        # The page loads no script, style sheet or image from another site.
        assert not re.search(r"<(?:script|link|img)\b[^>]*(?:src|href)=\"https?:", page)
    assert {p.name: p.stat().st_mtime_ns for p in folder.iterdir()} == before
