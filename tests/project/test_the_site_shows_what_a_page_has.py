"""The site compares outputs with those in a page, and shows the latter if a block is not run."""

import shutil
import stat
import subprocess
import sys

import pytest

import blocks
from heyoka_bike.system.resources import data_folder

SITE = data_folder().parent / "docs" / "_site"
PICTURE = "https://example.org/a.svg"


def block(asked, source, below=""):
    shown = f"\n```text\n{below}\n```\n" if below else ""
    return f"```{{run}} {asked}\n{source}\n```\n{shown}\n"


@pytest.fixture
def built(tmp_path):
    """Return a function that builds a page: the last messages, and the HTML."""
    pytest.importorskip("myst_parser")
    (tmp_path / "data").mkdir()
    docs = tmp_path / "docs"
    (docs / "examples").mkdir(parents=True)
    (docs / "_site" / "figures").mkdir(parents=True)
    for name in ("run.py", "blocks.py"):
        shutil.copy(SITE / name, docs)
    (docs / "conf.py").write_text(
        "import sys; sys.path.insert(0, '.'); extensions = ['myst_parser', 'run']\n"
    )

    def build(page, *flags):
        (docs / "index.md").write_text(f"# A page\n\n{page}")
        done = subprocess.run(
            [sys.executable, "-m", "sphinx", "-q", "-E", "-W", *flags, ".", "html"],
            cwd=docs, capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
        html = docs / "html" / "index.html"
        return done.stderr, html.read_text(encoding="utf-8") if html.exists() else ""

    return build


@pytest.mark.parametrize(
    ("page", "said"),
    [
        (block("", "echo one"), "found an output, expected the option shown:\none"),
        (block("shown", "echo one"), "another output than below"),
        (block("shown", "echo one", "two"), "another output than below"),
        (block("shown=example", "echo one"), "another output than below"),
    ],
)
@pytest.mark.proof
def test_an_output_that_the_page_lacks_is_an_error(page, said, built):
    assert said in built(page)[0]


@pytest.mark.proof
def test_outputs_are_those_of_the_run(built):
    page = (
        block("shown", "echo one", "one")
        + block("shown=example", "date +%s", "12")
        + block("", "true")
    )
    said, html = built(page)
    assert said == ""
    assert ">one\n<" in html
    assert ">12\n<" not in html


@pytest.mark.proof
def test_what_is_not_run_shows_what_the_page_has(built):
    figure = f'```{{run}} shown figure=a.svg alt="A" long\nfalse\n```\n\n![A]({PICTURE})\n\n'
    page = block("needs=no-such-program shown", "no-such-program", "of before") + figure
    said, html = built(page, "-D", "run_long=0")
    assert said == ""
    note = "Not run when this page was built: {}. Below is what it made before."
    assert note.format("no-such-program was not there") in html
    assert ">of before\n<" in html
    assert note.format("it takes long") in html
    assert PICTURE in html
    # Without the flag -D run_long=0, the block is run.
    assert "exit code 1" in built(figure)[0]


@pytest.mark.proof
def test_a_program_that_is_a_name_only_is_said(tmp_path, monkeypatch):
    shim = tmp_path / "rustc-shim"
    shim.write_text("#!/bin/sh\necho 'error: no default is configured' >&2\necho more\nexit 1\n")
    shim.chmod(shim.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    assert blocks.absent({"needs": "rustc-shim,sh-not-there", "modules": "os,not_there"}) == [
        "rustc-shim does not run (error: no default is configured)",
        "sh-not-there was not there",
        "not_there was not there",
    ]
    shim.write_text("#!/bin/sh\necho 1.0\n")
    blocks._missing.cache_clear()
    assert blocks.absent({"needs": "rustc-shim"}) == []
