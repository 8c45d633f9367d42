"""Finished parts of an unfinished run, in a folder next to the one that the run writes.

A result is a file of JSON, in which arrays are NumPy's ``.npy`` in base 64. The file never contains
code: reading it creates only arrays, numbers and the listed classes.
"""

from __future__ import annotations

import hashlib
import json
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields, is_dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.system.files import replace_file
from heyoka_bike.system.machine import versions

SUFFIX = ".unfinished"
_LOCK = "lock"
_HASH = hashlib.sha256


@contextmanager
def unfinished(folder: Path, classes: tuple[type, ...] = ()) -> Iterator[Unfinished]:
    """Store results next to a folder, while no other process does.

    Parameters
    ----------
    folder
    classes
        Dataclasses that results may contain.

    Raises
    ------
    InputError
        Another run writes the folder, or the results cannot be stored next to it.
    """
    # The package is installed with the extra for generating datasets.
    from filelock import FileLock, Timeout

    place = folder.absolute()
    place = place.with_name(place.name + SUFFIX)
    try:
        place.mkdir(parents=True, exist_ok=True)
        try:
            with FileLock(place / _LOCK, timeout=0):
                results = Unfinished(place, classes)
                try:
                    yield results
                finally:
                    if not len(results):
                        # Windows cannot remove an open file; there the lock removes it.
                        with suppress(PermissionError):
                            (place / _LOCK).unlink()
        finally:
            with suppress(OSError):
                place.rmdir()
    except Timeout:
        raise InputError(
            f"{folder}: found another run that writes it, expected one at a time"
        ) from None
    except PermissionError as e:
        raise InputError(f"{place}: cannot be written: {e.strerror}") from None


class Unfinished:
    """Results by key, each in a file."""

    def __init__(self, place: Path, classes: tuple[type, ...] = ()) -> None:
        self.place, self.classes = place, classes

    def at(self, *parts: Any) -> KeptResult:
        """Return the place of a result that depends on these parts, which must be JSON values."""
        # The result also depends on the versions.
        text = json.dumps([versions(), *parts], sort_keys=True)
        return KeptResult(self.place / _HASH(text.encode()).hexdigest(), self.classes)

    def clear(self) -> None:
        """Remove all results, including those of other inputs or versions."""
        for file in self.place.iterdir():
            if file.name != _LOCK:
                with suppress(OSError):
                    file.unlink()

    def __len__(self) -> int:
        """Return the number of results."""
        return sum(file.name != _LOCK for file in self.place.iterdir())


@dataclass(frozen=True, slots=True)
class KeptResult:
    """A result in a file, which starts with the hash of its other bytes.

    Attributes
    ----------
    file : Path
    classes : tuple of type
        Dataclasses that the result may contain.
    """

    file: Path
    classes: tuple[type, ...]

    def load(self) -> Any:
        """Return the result; None if the file is missing or damaged."""
        size = _HASH().digest_size
        # A damaged result is computed again.
        with suppress(Exception):
            data = self.file.read_bytes()
            if _HASH(data[size:]).digest() == data[:size]:
                return _made(
                    json.loads(data[size:]),
                    _READERS_OF_KINDS | {c.__name__: c for c in self.classes},
                )
        return None

    def store(self, result: Any) -> None:
        """Store a result; without room for it on the disk, it is computed again later."""
        data = json.dumps(_plain(result)).encode()
        with suppress(OSError):
            replace_file(self.file, _HASH(data).digest() + data)


def _plain(x: Any) -> Any:
    """Return a value for JSON; other types become an object with the kind as its key."""
    if isinstance(x, np.ndarray):
        file = BytesIO()
        np.save(file, x, allow_pickle=False)
        return {"array": {"npy": b64encode(file.getvalue()).decode()}}
    if isinstance(x, Fraction):
        return {"fraction": {"numerator": x.numerator, "denominator": x.denominator}}
    if is_dataclass(x):
        return {type(x).__name__: {f.name: _plain(getattr(x, f.name)) for f in fields(x) if f.init}}
    if isinstance(x, Mapping):
        return {"mapping": {key: _plain(y) for key, y in x.items()}}
    return [_plain(y) for y in x] if isinstance(x, tuple | list) else x


def _made(x: Any, kinds: Mapping[str, Callable[..., Any]]) -> Any:
    """Return the value that `_plain` was given, with lists as tuples."""
    if isinstance(x, dict):
        ((kind, arguments),) = x.items()
        return kinds[kind](**{key: _made(y, kinds) for key, y in arguments.items()})
    return tuple(_made(y, kinds) for y in x) if isinstance(x, list) else x


def _array(npy: str) -> Any:
    return np.load(BytesIO(b64decode(npy)), allow_pickle=False)


_READERS_OF_KINDS: dict[str, Callable[..., Any]] = {
    "array": _array,
    "fraction": Fraction,
    "mapping": dict,
}
