"""The package runs without system-specific parts: modules, names of `os`, UTF-8 as encoding."""

import os
import subprocess
import sys

import pytest

from heyoka_bike.system.resources import data_folder

# Python reads this file when it starts, also in the processes that a command starts.
SITE = """
import os, signal, sys
for name in (
    "chown", "fork", "forkpty", "getegid", "geteuid", "getgid", "getloadavg", "getpgid", "getuid",
    "killpg", "link", "mkfifo", "nice", "openpty", "O_DIRECTORY", "O_NOFOLLOW", "O_CLOEXEC",
    "posix_spawn", "sched_getaffinity", "sched_setaffinity", "setsid", "statvfs", "sysconf",
    "umask", "wait3", "wait4",
):
    delattr(os, name)
for name in ("SIGALRM", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGUSR1", "alarm", "pause"):
    delattr(signal, name)
class Block:
    def find_spec(self, name, path=None, target=None):
        if name in ("fcntl", "grp", "pwd", "resource", "syslog", "termios", "tty"):
            raise ModuleNotFoundError(f"{name} is blocked", name=name)
sys.meta_path.insert(0, Block())
"""
PEER = data_folder() / "peers" / "exudyn-h0.01.txt"
MANEUVERS = """
name = "short"
[[maneuver]]
name = "one"
speed = "4.6"
roll_rate = "0.5"
duration = "0.02"
spacing = "0.01"
[[maneuver]]
name = "two"
speed = "5"
roll_rate = "0.5"
duration = "0.02"
spacing = "0.01"
"""


@pytest.fixture
def command(tmp_path):
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(SITE, encoding="utf-8")
    environment = os.environ | {
        "PYTHONPATH": str(tmp_path / "site"), "PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0",
    }  # fmt: skip
    options = ["-X", "warn_default_encoding", "-W", "error::EncodingWarning:heyoka_bike"]

    def run(*arguments):
        return subprocess.run(
            [sys.executable, *options, "-m", "heyoka_bike", *map(str, arguments)],
            cwd=tmp_path, env=environment, capture_output=True, encoding="cp1252", timeout=300,
        )  # fmt: skip

    return run


def test_the_names_are_missing(tmp_path, command):
    code = "import os; print(hasattr(os, 'geteuid'))"
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True)
    assert run.stdout.split() == [b"False"], run.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("score", PEER), "the worst column has 1.6 correct digits"),
        (("linear",), "6.02426201538836"),
        (("export", "--format", "c", "-o", "export"), "export"),
        pytest.param(("diagnose", PEER), "No known mistake", marks=pytest.mark.proof),
        pytest.param(("selfcheck",), "this installation works", marks=pytest.mark.proof),
    ],
)
def test_commands_run(command, arguments, said):
    run = command(*arguments)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""
    assert said in " ".join(run.stdout.split())


@pytest.mark.proof
def test_a_set_is_made_by_two_processes(command, tmp_path):
    (tmp_path / "m.toml").write_text(MANEUVERS, encoding="utf-8")
    run = command("generate", "--maneuvers", "m.toml", "--out", "set", "--workers", "2")
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "set" / "manifest.json").exists()
    run = command("verify", "set")
    assert run.returncode == 0, run.stderr
    assert "0 failed" in run.stdout


@pytest.mark.proof
def test_letters_that_a_code_page_lacks(command, tmp_path):
    name = "велосипед.txt"
    (tmp_path / name).write_bytes(PEER.read_bytes())
    for arguments in (("score", name), ("animate", name, "-o", "велосипед.html")):
        run = command(*arguments)
        assert run.returncode == 0, run.stderr
        assert r"\u0432\u0435" in run.stdout
    assert (tmp_path / "велосипед.html").exists()
