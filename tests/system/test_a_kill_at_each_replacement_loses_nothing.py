"""After SIGKILL before any replacement of a file, the same command gives the same bytes.

The killed process counts its own replacements; the package has no code for this.
"""

import os
import shutil
import signal
import subprocess
import sys

import pytest

from heyoka_bike.system.files import UNFINISHED
from heyoka_bike.system.resources import data_folder

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL"),
]

# The process kills itself just before the replacement with this index (from 1; 0: never).
COUNTED = """
import os, signal, sys
left, real = int(sys.argv[1]), os.replace
def replace(*given, **named):
    global left
    left -= 1
    if left == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return real(*given, **named)
os.replace = replace
from heyoka_bike.cli import main
sys.exit(main(sys.argv[2:]))
"""
MANEUVER = """
name = "short"
[[maneuver]]
name = "short"
speed = "{speed}"
roll_rate = "0.5"
duration = "0.02"
spacing = "0.01"
"""
RESULTS = data_folder() / "peers" / "exudyn-h0.01.txt"
COMMANDS = {
    "generate": (
        "generate", "--maneuvers", "../new.toml", "--out", "set", "--force", "--workers", "1",
    ),
    "score": ("score", str(RESULTS), "-o", "r.html", "-o", "r.json", "-o", "r.txt"),
    "checker": ("export", "--checker", "-o", "out/"),
    "c": ("export", "--format", "c", "-o", "out/"),
}  # fmt: skip


def call(folder, command, kill_at=0):
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    run = subprocess.run(
        [sys.executable, "-c", COUNTED, str(kill_at), *command],
        cwd=folder, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode in (0, -signal.SIGKILL), run.stderr
    return run.returncode


def content(folder, has_parts):
    """Return the files' contents, optionally with temporary files left by a killed writer.

    A dataset has a folder of its own, where temporary files are removed; elsewhere they may belong
    to others.
    """
    files = [p for p in sorted(folder.rglob("*")) if p.is_file()]
    files = [p for p in files if has_parts or p.suffix != UNFINISHED]
    return {str(p.relative_to(folder)): p.read_bytes() for p in files}


@pytest.fixture
def before(tmp_path):
    """A folder with older versions of the files that are written."""
    for name, speed in (("old", "4.2"), ("new", "4.6")):
        (tmp_path / f"{name}.toml").write_text(MANEUVER.format(speed=speed))
    return tmp_path / "before"


@pytest.mark.parametrize("name", COMMANDS)
def test_the_same_command_gives_the_same_bytes(before, tmp_path, name):
    command = COMMANDS[name]
    before.mkdir()
    call(before, [word.replace("new.toml", "old.toml") for word in command])
    for path in (p for p in before.rglob("*") if p.is_file() and name != "generate"):
        path.write_text("old")
    expected = tmp_path / "expected"
    shutil.copytree(before, expected)
    assert call(expected, command) == 0
    is_set = name == "generate"
    kill_at, is_killed = 0, True
    while is_killed:
        kill_at += 1
        folder = tmp_path / f"killed-{kill_at}"
        shutil.copytree(before, folder)
        is_killed = call(folder, command, kill_at) != 0
        assert call(folder, command) == 0
        assert content(folder, is_set) == content(expected, is_set), kill_at
        shutil.rmtree(folder)
    print(f"{name}: {kill_at - 1} replacements")
    assert kill_at > 1
