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
