"""Blocks of commands in pages: what they are, and how they are carried out."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
SECONDS = 300.0  # no block takes a tenth of it
_COPIED = ("data", "docs/examples", "docs/_site/figures")
_WIDTH = "92"  # of tables, as in the README

BLOCK = re.compile(
    r"^```\{run\}(?P<asked>[^\n]*)\n(?P<source>.*?)^```\n"
    r"(?P<below>\n(?:```text\n(?P<output>.*?)^```|!\[[^\n]*\]\([^\n]*\))\n)?",
    re.MULTILINE | re.DOTALL,
)
"""A block of a page, with the text or picture below it."""


class HangError(Exception):
    """A block that did not end in its time; the text says what it had written."""


def options(words: str) -> dict[str, str]:
    """What stands behind the name of the directive, by name."""
    split = (word.partition("=") for word in shlex.split(words))
    return {key: value for key, _, value in split}


def absent(asked: Mapping[str, str]) -> list[str]:
    """What is to be said of programs and Python modules that a block needs and that fail here."""
    programs = (_missing(x) for x in asked.get("needs", "").split(",") if x)
    modules = (x for x in asked.get("modules", "").split(",") if x and not find_spec(x))
    return [*filter(None, programs), *(f"{x} was not there" for x in modules)]


@cache
def _missing(program: str) -> str:
    """What is to be said of a program that cannot be used; empty if it can.

    A toolchain may be a name only: rustc of rustup, in a home without a default, ends with an
    error whatever it is asked.
    """
    if not shutil.which(program):
        return f"{program} was not there"
    try:
        asked = subprocess.run(
            [program, "--version"], stdin=subprocess.DEVNULL, capture_output=True, text=True,
            errors="replace", timeout=60, check=False,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as e:
        return f"{program} does not run ({type(e).__name__})"
    if asked.returncode == 0:
        return ""
    said = (asked.stderr or asked.stdout).strip().partition("\n")[0]
    return f"{program} does not run{f' ({said})' if said else ''}"


def committed(page: str, source: str) -> str | None:
    """The output that stands below a block with the option ``shown``; None if there is none."""
    for found in BLOCK.finditer(page):
        if "shown" in options(found["asked"]) and found["source"].strip() == source.strip():
            return found["output"] and found["output"].rstrip("\n")
    return None


def picture(page: str, source: str) -> str:
    """Where the picture below a block is, as seen from the page; empty without one."""
    for found in BLOCK.finditer(page):
        if found["source"].strip() == source.strip():
            return (re.search(r"!\[[^\n]*\]\(([^\n]*)\)", found["below"] or "") or ["", ""])[1]
    return ""


def without_outputs(page: str) -> str:
    """The page without the outputs below blocks with the option ``shown``."""

    def block(found: re.Match[str]) -> str:
        is_shown = found["below"] and "shown" in options(found["asked"])
        return page[found.start() : found.start("below") if is_shown else found.end()]

    return BLOCK.sub(block, page)


def fill(folder: Path, repository: Path = REPOSITORY) -> None:
    """Make the folder of a page, with copies of what its commands may use."""
    for name in _COPIED:
        shutil.copytree(repository / name, folder / name)


def result(
    source: str, asked: Mapping[str, str], folder: Path, seconds: float = SECONDS
) -> tuple[int, str]:
    """Exit code and output of a block, as at a terminal of a fixed width.

    This environment's programs come first, and the output is shortened as the block asks.
    """
    kept = {k: v for k, v in os.environ.items() if k not in ("CI", "FORCE_COLOR", "PYTEST_ADDOPTS")}
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = kept | {"PATH": path, "COLUMNS": _WIDTH, "NO_COLOR": "1"}
    shell = ["bash", "-e", "-o", "pipefail", "-s"]
    program = [sys.executable, "-"] if "python" in asked else shell
    code, output = carry_out(program, source, folder, environment, seconds)
    return code, _shortened(output, int(asked.get("lines", 0)))


def _shortened(text: str, lines: int) -> str:
    found = [line.rstrip() for line in text.rstrip().splitlines()]
    return "\n".join([*found[:lines], "..."] if 0 < lines < len(found) else found)


def carry_out(
    program: Sequence[str], block: str, folder: Path, environment: Mapping[str, str], seconds: float
) -> tuple[int, str]:
    """Exit code and output of a block that a program reads.

    The block has a process group of its own. Whatever is left of the group is killed when the
    block ends, hangs or is interrupted: a program in the background would hold the output open.

    Raises
    ------
    HangError
        The block, or something that it started, still writes after so many seconds.
    """
    with subprocess.Popen(
        program, cwd=folder, env=dict(environment), text=True, errors="replace",
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        start_new_session=True,
    ) as process:  # fmt: skip
        try:
            output, _ = process.communicate(block, timeout=seconds)
        except subprocess.TimeoutExpired as late:
            # Bytes, though the pipe is one of text.
            text = (late.output or b"").decode(errors="replace")
            raise HangError(f"no end after {seconds:g} s; killed. It wrote:\n{text}") from None
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    return process.returncode, output
