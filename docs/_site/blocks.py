"""A block of commands is carried out, and all that it started is ended with it."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path


class HangError(Exception):
    """A block that did not end in its time; the text says what it had written."""


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
    process = subprocess.Popen(
        program, cwd=folder, env=dict(environment), text=True, errors="replace",
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        start_new_session=True,
    )  # fmt: skip
    try:
        output, _ = process.communicate(block, timeout=seconds)
    except subprocess.TimeoutExpired:
        _kill(process)
        written, _ = process.communicate()
        raise HangError(f"no end after {seconds:g} s; killed. It wrote:\n{written}") from None
    finally:
        _kill(process)
    return process.returncode, output


def _kill(process: subprocess.Popen[str]) -> None:
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
