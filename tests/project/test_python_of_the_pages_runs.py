"""Every block of Python on a page runs unchanged, or the page says why it does not.

The blocks of a page run in order in one namespace, in a folder with the result files and packages
that the pages mention.
"""

import re
import shutil
from contextlib import chdir

import pytest

from heyoka_bike.system.resources import data_folder

ROOT = data_folder().parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
_BLOCK = re.compile(r"^```(?:\{run\} )?python\b([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)

# Blocks that this test cannot run: their needs, and the place where they are tested instead.
ELSEWHERE = {
    "docs/after-ten-seconds.md": "runs of minutes; when the site is built",
    "docs/atlas.md": "an atlas; tests/workbench/test_an_atlas_says_what_becomes.py",
    "docs/how-to/equations.md": "IDA; reference/test_descriptor_equations_are_followed_by_ida.py",
    "docs/how-to/cluster.md": "a cluster; tests/workbench/test_a_cluster_carries_out_jobs.py",
    "docs/pytest.md": "tests of a project; tests/example_project",
    "docs/how-to/continuous-integration.md": "tests of a project; tests/example_project",
    "docs/why-taylor.md": "two minutes; when the site is built",
}


def blocks(page):
    return [code for _, code in _BLOCK.findall(page.read_text(encoding="utf-8"))]


WITH_PYTHON = {page.relative_to(ROOT).as_posix(): page for page in PAGES if blocks(page)}


def test_the_pages_that_are_left_out_have_python():
    assert set(ELSEWHERE) <= set(WITH_PYTHON)
    assert "docs/reference/python.md" in set(WITH_PYTHON) - set(ELSEWHERE)


@pytest.mark.proof
@pytest.mark.parametrize("name", sorted(set(WITH_PYTHON) - set(ELSEWHERE)))
def test_blocks_run(name, tmp_path):
    """The blocks run in order in one namespace, in a folder like the one of the site's builder."""
    shutil.copytree(ROOT / "data", tmp_path / "data")
    shutil.copyfile(ROOT / "data" / "peers" / "exudyn-h0.001.txt", tmp_path / "my-results.txt")
    namespace = {"__name__": "page"}
    with chdir(tmp_path):
        for number, code in enumerate(blocks(WITH_PYTHON[name]), start=1):
            try:
                exec(compile(code, f"{name}, block {number}", "exec"), namespace)
            except Exception as error:
                error.add_note(f"in a block of {name}:\n{code}")
                raise
