"""The builder of the site ends all programs that a block started, and names a block that hangs
or fails."""

import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from blocks import HangError, carry_out
from heyoka_bike.system.resources import data_folder

SITE = data_folder().parent / "docs" / "_site"
SHELL = ("bash", "-e", "-o", "pipefail", "-s")
# [s] This time is long enough for a shell to start a program on a busy machine, but short compared
# with a program that hangs.
SECONDS = 2.0
HANGS = "sleep 1000 & echo $! > pid; echo begun; wait"


def is_there(folder):
    """True if the program that the block started in the background still runs."""
    # The killed program is not a child of this process, so it may remain as a zombie for a moment.
    pid = int((folder / "pid").read_text())
    for _ in range(100):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return False
        with open(f"/proc/{pid}/stat") as file:
            if file.read().rpartition(")")[2].split()[0] == "Z":
                return False
        time.sleep(0.05)
    return True


@pytest.mark.proof
@pytest.mark.parametrize("block", [HANGS, "sleep 1000 & echo $! > pid; echo begun"])
def test_a_block_that_hangs_is_ended_with_what_it_started(block, tmp_path):
    with pytest.raises(HangError, match=r"(?s)no end after 2 s; killed\. It wrote:\nbegun"):
        carry_out(SHELL, block, tmp_path, os.environ, SECONDS)
    assert not is_there(tmp_path)


@pytest.mark.proof
@pytest.mark.timeout(60)
def test_a_program_that_leaves_the_group_holds_nothing_up(tmp_path):
    block = "setsid sleep 1000 & echo $! > pid; echo begun"
    with pytest.raises(HangError, match="begun"):
        carry_out(SHELL, block, tmp_path, os.environ, SECONDS)
    os.kill(int((tmp_path / "pid").read_text()), signal.SIGKILL)


def test_what_a_block_leaves_in_the_background_is_ended(tmp_path):
    block = "sleep 1000 > /dev/null 2>&1 & echo $! > pid; echo done; exit 4"
    assert carry_out(SHELL, block, tmp_path, os.environ, 60.0) == (4, "done\n")
    assert not is_there(tmp_path)


@pytest.mark.parametrize(
    ("block", "said"),
    [(HANGS, "no end after 2 s; killed. It wrote:\nbegun"), ("echo oops; false", "exit code 1")],
)
def test_the_build_names_page_line_and_block(block, said, tmp_path):
    pytest.importorskip("myst_parser")
    (tmp_path / "data").mkdir()
    docs = tmp_path / "docs"
    (docs / "examples").mkdir(parents=True)
    (docs / "_site" / "figures").mkdir(parents=True)
    shutil.copy(SITE / "run.py", docs)
    shutil.copy(SITE / "blocks.py", docs)
    (docs / "conf.py").write_text(
        "import sys; sys.path.insert(0, '.'); extensions = ['myst_parser', 'run']\n"
        f"run_seconds = {SECONDS}\n"
    )
    (docs / "index.md").write_text(f"# A page\n\nWords.\n\n```{{run}}\n{block}\n```\n")
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", ".", "html"],
        cwd=docs, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert f"index.md:5: {said}" in done.stderr
    assert f"The block:\n{block}" in done.stderr
