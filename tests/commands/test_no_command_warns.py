"""Each command runs in a process in which every warning of Python is an error.

A test that calls `main` only sees warnings of this call. A process also shows those of imports, of
files that remain open, and of the interpreter's end. The default encoding is not UTF-8, as on
Windows: opening a text without an encoding is also a warning, and the output has to be in code page
1252.
"""

import os
import signal
import subprocess
import sys
from urllib.request import urlopen

import pytest

from generators.submissions import copied
from heyoka_bike.commands.registry import COMMANDS as REGISTERED
from heyoka_bike.system.resources import data_folder

pytestmark = [pytest.mark.proof, pytest.mark.timeout(300)]

WRONG = data_folder() / "peers" / "exudyn-h0.01.txt"
SHORT = """\
name = "short"
[[maneuver]]
name = "short 1"
speed = "4.6"
roll_rate = "0.5"
duration = "0.1"
spacing = "0.01"
"""
GRID = ["--speed", "4:5:2", "--roll-rate", "0.3:0.5:2", "--longest", "20"]

# The package must not open a text file without stating its encoding. Other libraries may do so.
PROGRAM = """\
import sys, warnings
warnings.filterwarnings("ignore", category=EncodingWarning)
warnings.filterwarnings("error", category=EncodingWarning, module="heyoka_bike")
from heyoka_bike.cli import main
sys.exit(main())
"""

# For each command: its words, and its exit code. The name NAME.x stands for a file in a separate
# folder.
COMMANDS = {
    "generate": (["--maneuvers", "short.toml", "--out", "made"], 0),
    "certify": (["set"], 0),
    "verify": (["set"], 0),
    "linear": ([], 0),
    "import": (["bicycle.urdf", "-o", "bicycle.toml"], 0),
    "score": ([str(WRONG), "-o", "report.html"], 0),
    "diagnose": ([str(WRONG), "--budget", "2"], 4),
    "check": (["states.csv"], 0),
    "bench": (["--help"], 0),
    "animate": ([str(WRONG), "-o", "replay.html"], 0),
    "plot": (["--maneuver", "2", "-o", "figure.svg"], 0),
    "atlas": ([*GRID, "-o", "atlas.zarr"], 0),
    "export": (["--format", "csv", "-o", "rows.csv"], 0),
    "submit": ([str(WRONG), "--program", "x", "--cpu", "1", "--machine", "y", "-o", "x.zip"], 0),
    "leaderboard": (["submissions"], 0),
    "selfcheck": ([], 0),
}


def process(words, folder, **how):
    """Start the program in a folder."""
    # The configuration of matplotlib in the user's home must not influence the test.
    windows = {"PYTHONUTF8": "0", "PYTHONIOENCODING": "cp1252", "PYTHONWARNDEFAULTENCODING": "1"}
    environment = os.environ | windows | {"MPLCONFIGDIR": str(folder / "matplotlib")}
    command = [sys.executable, "-W", "error", "-c", PROGRAM, *words]
    return subprocess.Popen(
        command, cwd=folder, env=environment, text=True, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, **how,
    )  # fmt: skip


def carried_out(words, folder):
    run = process(words, folder)
    out, errors = run.communicate()
    assert "Warning" not in errors, errors
    return run.returncode, out, errors


@pytest.fixture
def folder(tmp_path, small_set):
    """A folder with the input files of the commands."""
    (tmp_path / "set").symlink_to(small_set)
    copied(tmp_path / "submissions")
    (tmp_path / "short.toml").write_text(SHORT)
    return tmp_path


def before(name, folder):
    """Run the command whose output this command reads."""
    if name == "import":
        words = ["export", "--model", "urdf", "-o", "bicycle.urdf"]
    elif name == "check":
        words = ["check", "--states", "states.csv"]
    else:
        return
    code, _, errors = carried_out(words, folder)
    assert code == 0, errors


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_warns_of_nothing(name, folder):
    before(name, folder)
    words, expected = COMMANDS[name]
    code, out, errors = carried_out([name, *words], folder)
    assert code == expected, (out, errors)


def test_a_server_warns_of_nothing(tmp_path):
    """The server is tested from its start until a signal ends it."""
    pytest.importorskip("uvicorn")
    run = process(["serve", "--port", "0"], tmp_path)
    address = next(word for line in run.stdout for word in line.split() if word.startswith("http"))
    with urlopen(address, timeout=60) as page:
        assert page.status == 200
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=60)
    assert "Warning" not in errors, errors


def test_every_command_is_here():
    assert {*COMMANDS, "serve"} == {*REGISTERED}
