"""Writing of files: whole or not at all."""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from secrets import token_hex

from heyoka_bike.errors import InputError

UNFINISHED = ".part"
"""Suffix of files that are not yet in their place; their names begin with a dot."""


def write_output(path: Path, data: bytes) -> None:
    """Write what a user asked for; folders on the way are made, devices written to.

    Raises
    ------
    InputError
        The file cannot be written; an old one is left as it was.
    """
    write_outputs({path: data})


def write_outputs(files: Mapping[Path, bytes]) -> None:
    """Write files that belong together: none takes its place before all are on the disk.

    Raises
    ------
    InputError
        One cannot be written; old ones are left as they were.
    """
    parts: dict[Path, Path] = {}
    try:
        for path, data in files.items():
            if path.exists() and not path.is_file():
                path.write_bytes(data)
            else:
                path.parent.mkdir(parents=True, exist_ok=True)
                parts[path] = _write_beside(path, data)
        for path, part in parts.items():
            part.replace(path)
    except OSError as e:
        raise InputError(f"cannot be written: {e.strerror or e}", file=path) from None
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)


def refuse_overwriting(files: Iterable[str], outputs: Iterable[Path]) -> None:
    """Raise `InputError` if an output is one of the result files, by the name it was given."""
    for path in outputs:
        for file in files:
            if os.path.exists(path) and os.path.exists(file) and os.path.samefile(path, file):
                raise InputError(
                    "is a result file to be scored, expected another file to write", file=path
                )


def replace_file(path: Path, data: bytes) -> None:
    """Write a file beside its place, make it durable, and rename it into place."""
    part = _write_beside(path, data)
    try:
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _write_beside(path: Path, data: bytes) -> Path:
    """Write a file and make it durable, beside its place; nothing is left if it fails.

    Its name is nobody's: whoever writes the same output has another, and no link is followed.
    """
    part = path.with_name(f".{token_hex(8)}{UNFINISHED}")
    file = part.open("xb")
    try:
        with file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    return part
