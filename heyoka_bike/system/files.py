"""Files of a user: only regular ones are read, and each is written completely or not at all."""

import errno
import os
import stat
from collections.abc import Iterable, Mapping
from io import BufferedReader
from os import PathLike
from pathlib import Path
from secrets import token_hex

from heyoka_bike.errors import InputError

UNFINISHED = ".part"
"""Suffix of files that are still being written; their names begin with a dot."""


def open_regular(path: str | PathLike[str]) -> BufferedReader:
    """Open a file for reading if it is a regular one.

    A pipe would wait for a writer, a device may have no end, and merely opening some devices has
    effects.

    Raises
    ------
    OSError
        The file cannot be opened, or is a folder, a pipe, a socket or a device.
    """
    _refuse_irregular(os.stat(path).st_mode, path)
    # Open the file without waiting, and check again that it is regular, because it may have been
    # replaced since the first check.
    number = os.open(path, os.O_RDONLY | _WITHOUT_WAITING)
    try:
        _refuse_irregular(os.fstat(number).st_mode, path)
        return os.fdopen(number, "rb")
    except BaseException:
        os.close(number)
        raise


def read_regular(path: str | PathLike[str], most: int) -> bytes:
    """Return the contents of a regular file of at most `most` bytes.

    Raises
    ------
    OSError
        As for `open_regular`, or the file is longer.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        # Limit the number of bytes that are read, too, because files of the kernel, such as those
        # in /proc, report a size of zero.
        data = file.read(most + 1) if size <= most else b""
    if max(size, len(data)) > most:
        raise OSError(errno.EFBIG, f"it is longer than {most} bytes", str(path))
    return data


def path_inside(folder: Path, name: str | PathLike[str]) -> Path:
    """Return the path of a file below a folder, unless a link leads out of the folder.

    Raises
    ------
    ValueError
        The file is outside of the folder.
    """
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise ValueError("it is a link to a file outside the folder")
    return path


_WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_IRREGULAR = ((stat.S_ISDIR, "folder"), (stat.S_ISFIFO, "pipe"), (stat.S_ISSOCK, "socket"))


def _refuse_irregular(mode: int, path: str | PathLike[str]) -> None:
    if stat.S_ISREG(mode):
        return
    kind = next((name for is_kind, name in _IRREGULAR if is_kind(mode)), "device")
    number = errno.EISDIR if kind == "folder" else errno.EINVAL
    raise OSError(number, f"it is a {kind}, expected a regular file", str(path))


def write_output(path: Path, data: bytes) -> None:
    """Write an output file of a user; create missing folders, and write to devices too.

    Raises
    ------
    InputError
        The file cannot be written; an existing file is unchanged.
    """
    write_outputs({path: data})


def write_outputs(files: Mapping[Path, bytes]) -> None:
    """Write files that belong together: all are on the disk before the first is renamed.

    Raises
    ------
    InputError
        A file cannot be written; existing files are unchanged.
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
    """Raise `InputError` if an output would overwrite one of the result files."""
    for path in outputs:
        for file in files:
            if os.path.exists(path) and os.path.exists(file) and os.path.samefile(path, file):
                raise InputError(
                    "is a result file to be scored, expected another file to write", file=path
                )


def replace_file(path: Path, data: bytes) -> None:
    """Write a file under a temporary name, make it durable, and rename it."""
    part = _write_beside(path, data)
    try:
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _write_beside(path: Path, data: bytes) -> Path:
    """Write a durable file under a temporary name; remove it if anything fails.

    The name is unique, so that other writers of the same output use another one, and no link is
    followed.
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
