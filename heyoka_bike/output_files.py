"""Writing of files: whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from heyoka_bike.errors import InputError


def write_output(path: Path, data: bytes) -> None:
    """Write what a user asked for; folders on the way are made, devices written to.

    Raises
    ------
    InputError
        The file cannot be written; an old one is left as it was.
    """
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(data)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            replace_file(path, data)
    except OSError as e:
        raise InputError(f"cannot be written: {e.strerror or e}", file=path) from None


def replace_file(path: Path, data: bytes) -> None:
    """Write a file beside its place, make it durable, and rename it into place."""
    beside = path.with_name(path.name + ".part")
    try:
        with beside.open("wb") as f:
            f.write(data)
            f.flush()
            os.fsync(f.fileno())
        beside.replace(path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
